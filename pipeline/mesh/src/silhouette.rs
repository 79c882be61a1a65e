//! Silhouette: the outline of a tail as a camera above it sees it, by half widths along normals of its centre line, so that bending does not count.
//!
//! Half widths are measured in the plane at mid height, z = 0, to which a picture and a mesh are both brought by central projection. A wall
//! that dents at mid height alone is hidden by its own higher parts; a mesh is measured as a picture is, so that both hide the same.

use crate::wall::Walls;
use si::{Metre, Point2, Point3};

/// A place on the centre line, m, and a unit normal there.
pub type Normal = [Point2; 2];

/// Half widths by station, m: to the left of the centre line, then to its right; none where no outline was found.
#[derive(Debug, Clone, PartialEq)]
pub struct Silhouette([Vec<Option<Metre>>; 2]);

/// Stations to either side over which the median is taken: a bright line of the ground that ends at the outline misleads one or two.
const NEAR: usize = 2;
/// With fewer stations than this share a silhouette was not seen.
const SEEN: f64 = 0.5;

impl Silhouette {
    /// Across `normals`, which point to the left; `edge` is the distance of the outline along one, m.
    pub fn across(normals: &[Normal], edge: impl Fn(Normal) -> Option<Metre>) -> Self {
        let right = |[origin, [x, y]]: Normal| [origin, [-x, -y]];
        let side = |turned: fn(Normal) -> Normal| {
            running_median(&normals.iter().map(|n| edge(turned(*n))).collect::<Vec<_>>())
        };
        Self([side(|n| n), side(right)])
    }

    /// Deepest dent and highest bulge against the silhouette at rest, by `stations` (m); `filled` says whether the left side is under
    /// pressure. None where either silhouette was not seen.
    pub fn walls(&self, rest: &Self, stations: &[Metre], filled: bool) -> Option<Walls> {
        let (full, empty) = if filled { (0, 1) } else { (1, 0) };
        let (bulge, dent) =
            (self.half_width_change(rest, stations, full)?, self.half_width_change(rest, stations, empty)?);
        let bulge_m = bulge.into_iter().map(|(by, _)| by).fold(0.0, f64::max);
        let deeper = |best: (Metre, Point2), next: (Metre, Point2)| if next.0 < best.0 { next } else { best };
        let (by, [x, width]) = dent.into_iter().fold((0.0, [0.0; 2]), deeper);
        let y = if filled { -width } else { width };
        Some(Walls { dent_m: -by, dent_at: [x, y, 0.0], bulge_m })
    }

    /// Change of the half widths of one side, m, with the station and the half width at rest.
    fn half_width_change(&self, rest: &Self, stations: &[Metre], side: usize) -> Option<Vec<(Metre, Point2)>> {
        let both = self.0[side].iter().zip(&rest.0[side]).zip(stations);
        let changes: Vec<_> = both.filter_map(|((now, rest), x)| Some(((*now)? - (*rest)?, [*x, (*rest)?]))).collect();
        (changes.len() as f64 >= SEEN * stations.len() as f64).then_some(changes)
    }
}

/// The running median of what was found.
fn running_median(widths: &[Option<Metre>]) -> Vec<Option<Metre>> {
    let median_around = |i: usize| {
        let window = &widths[i.saturating_sub(NEAR)..(i + NEAR + 1).min(widths.len())];
        let mut known_widths: Vec<Metre> = window.iter().flatten().copied().collect();
        known_widths.sort_by(f64::total_cmp);
        known_widths.get(known_widths.len() / 2).copied()
    };
    (0..widths.len()).map(median_around).collect()
}

/// A surface projected from an eye onto the plane at mid height: the edges of its faces, m.
pub struct Projected(Vec<[Point2; 2]>);

impl Projected {
    /// Of the faces between points (m), seen from above by an eye (m).
    pub fn new(points: &[Point3], faces: impl IntoIterator<Item = [u32; 3]>, eye: Point3) -> Self {
        let onto = |n: u32| {
            let [x, y, z] = points[n as usize];
            let far = eye[2] / (eye[2] - z);
            [eye[0] + far * (x - eye[0]), eye[1] + far * (y - eye[1])]
        };
        let edges = |[a, b, c]: [u32; 3]| [[a, b], [b, c], [c, a]].map(|edge| edge.map(onto));
        Self(faces.into_iter().flat_map(edges).collect())
    }

    /// The farthest point along a normal that it covers, at most `reach` from the centre line, m.
    pub fn edge(&self, [origin, [x, y]]: Normal, reach: Metre) -> Option<Metre> {
        let ahead = |[u, v]: Point2| (u - origin[0]) * x + (v - origin[1]) * y;
        let aside = |[u, v]: Point2| (v - origin[1]) * x - (u - origin[0]) * y;
        let crossing = |&[a, b]: &[Point2; 2]| {
            let (left, right) = (aside(a), aside(b));
            let part = left / (left - right);
            (left * right <= 0.0 && left != right).then(|| ahead(a) + part * (ahead(b) - ahead(a)))
        };
        self.0.iter().filter_map(crossing).filter(|far| *far > 0.0 && *far < reach).reduce(f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ball of radius 10 mm about the origin.
    fn ball() -> (Vec<Point3>, Vec<[u32; 3]>) {
        let (rows, columns) = (60_u32, 120_u32);
        let at = |i: u32, j: u32| {
            let (t, p) = (f64::from(i) / f64::from(rows), f64::from(j) / f64::from(columns));
            let (t, p) = (std::f64::consts::PI * t, std::f64::consts::TAU * p);
            [0.01 * t.sin() * p.cos(), 0.01 * t.sin() * p.sin(), 0.01 * t.cos()]
        };
        let points = (0..=rows).flat_map(|i| (0..columns).map(move |j| at(i, j))).collect();
        let name = |i: u32, j: u32| i * columns + j % columns;
        let square =
            |i, j| [[name(i, j), name(i + 1, j), name(i, j + 1)], [name(i + 1, j), name(i + 1, j + 1), name(i, j + 1)]];
        (points, (0..rows).flat_map(|i| (0..columns).flat_map(move |j| square(i, j))).collect())
    }

    #[test]
    fn a_ball_is_seen_as_wide_as_the_cone_that_touches_it() {
        let (points, faces) = ball();
        let seen = Projected::new(&points, faces, [0.0, 0.0, 0.05]);
        for direction in [[0.0, 1.0], [0.6, -0.8]] {
            let width = seen.edge([[0.0; 2], direction], 0.04).unwrap();
            // H R / √(H² − R²); facets of 3° cut off R (1 − cos 1.5°)
            assert!((width - 0.05 * 0.01 / (0.05_f64.powi(2) - 0.01_f64.powi(2)).sqrt()).abs() < 1e-5, "{width}");
        }
        assert_eq!(seen.edge([[0.02, 0.0], [0.0, 1.0]], 0.04), None);
    }

    /// Normals of a straight line along x and stations 1 mm apart.
    fn stations() -> (Vec<Normal>, Vec<Metre>) {
        (0..21).map(|i| 1e-3 * f64::from(i)).map(|x| ([[x, 0.0], [0.0, 1.0]], x)).unzip()
    }

    #[test]
    fn the_side_without_pressure_dents_and_a_single_station_off_counts_for_nothing() {
        let (normals, stations) = stations();
        let rest = Silhouette::across(&normals, |_| Some(0.012));
        let hump = |x: f64| (1.0 - ((x - 0.008) / 0.005).powi(2)).max(0.0);
        let now = Silhouette::across(&normals, |[[x, _], [_, side]]| match side > 0.0 {
            true => Some(if x == 0.003 { 0.03 } else { 0.012 + 2e-3 * hump(x) }),
            false => (x != 0.004).then(|| 0.012 - 3e-3 * hump(x)),
        });
        let walls = now.walls(&rest, &stations, true).unwrap();
        // the median of five lowers the vertex of the parabola by what lies 1 mm from it, 4 % of its height
        assert!((walls.dent_m - 0.96 * 3e-3).abs() < 1e-9 && (walls.bulge_m - 0.96 * 2e-3).abs() < 1e-9, "{walls:?}");
        assert!((walls.dent_at[0] - 0.008).abs() < 1.1e-3 && walls.dent_at[1] == -0.012);
        let turned = now.walls(&rest, &stations, false).unwrap();
        assert!(turned.dent_m < 1e-12 && turned.bulge_m < 1e-12, "{turned:?}");
    }

    #[test]
    fn what_is_not_seen_along_half_of_the_line_has_no_dent() {
        let (normals, stations) = stations();
        let rest = Silhouette::across(&normals, |_| Some(0.012));
        let hidden = Silhouette::across(&normals, |[[x, _], _]| (x > 0.012).then_some(0.012));
        assert_eq!(hidden.walls(&rest, &stations, true), None);
    }
}
