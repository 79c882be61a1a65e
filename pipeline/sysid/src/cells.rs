//! Number of cells a side of a meshed tail: wide sections of its first chamber along the tail, separated by the narrow channel.

use mesh::{QuadraticMesh, Skin};

/// Slices along the chamber; a cell of the shortest tail is eight of them long.
const SLICES: usize = 240;
/// A neck is narrower than this share of the wider of two neighbouring cells.
const NECK: f64 = 0.5;

/// Cells of a chamber, by its number on the skin.
pub fn count_cells(solid: &QuadraticMesh, chamber: u16) -> usize {
    count_swellings(&area_profile(solid, Skin::Chamber(chamber)))
}

/// Extent in y × extent in z of the chamber's skin, m², slice by slice along x; 0 between.
fn area_profile(solid: &QuadraticMesh, skin: Skin) -> Vec<f64> {
    let faces: Vec<[[f64; 3]; 3]> = solid
        .skin
        .iter()
        .filter(|face| face.on == skin)
        .flat_map(|face| face.corner_triangles())
        .map(|corners| corners.map(|node| solid.nodes[node as usize]))
        .collect();
    let extreme = |choose: fn(f64, f64) -> f64, initial| faces.iter().flatten().map(|p| p[0]).fold(initial, choose);
    let (first, last) = (extreme(f64::min, f64::INFINITY), extreme(f64::max, f64::NEG_INFINITY));
    let station = |i: usize| first + (last - first) * (i as f64 + 0.5) / SLICES as f64;
    (0..SLICES).map(|i| section_area(&faces, station(i))).collect()
}

/// Of the cut through triangles at `x`, extent in y × extent in z, m².
fn section_area(faces: &[[[f64; 3]; 3]], x: f64) -> f64 {
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for [a, b] in faces.iter().flat_map(|[a, b, c]| [[a, b], [b, c], [c, a]]) {
        if (a[0] < x) != (b[0] < x) {
            let t = (x - a[0]) / (b[0] - a[0]);
            for k in 0..2 {
                let cut = a[k + 1] + t * (b[k + 1] - a[k + 1]);
                (low[k], high[k]) = (low[k].min(cut), high[k].max(cut));
            }
        }
    }
    if low[0].is_finite() { (high[0] - low[0]) * (high[1] - low[1]) } else { 0.0 }
}

/// Peaks that are separated from the one before by a neck.
fn count_swellings(profile: &[f64]) -> usize {
    let (mut count, mut peak, mut neck) = (0, None, 0.0_f64);
    for &width in profile {
        match peak {
            // By a factor and not by extrema: sections of a mesh ripple along it, and every ripple has a maximum.
            Some(widest) if width < NECK * widest => (peak, neck) = (None, width),
            Some(widest) => peak = Some(width.max(widest)),
            None if neck < NECK * width => (peak, count) = (Some(width), count + 1),
            None => neck = neck.min(width),
        }
    }
    count
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn swellings_that_taper_are_counted_and_necks_are_not() {
        let cells = (0..9).flat_map(|k| [vec![20.0 - 1.5 * f64::from(k); 20], vec![2.0; 6]].concat());
        assert_eq!(count_swellings(&cells.collect::<Vec<_>>()), 9);
        assert_eq!(count_swellings(&[0.0, 0.0]), 0);
    }

    #[test]
    fn a_section_of_a_triangle_is_as_wide_as_its_cut() {
        let faces = [[[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 2.0, 4.0]]];
        assert!((section_area(&faces, 1.0) - 2.0).abs() < 1e-12);
        assert!(section_area(&faces, 3.0).abs() < 1e-12);
    }
}
