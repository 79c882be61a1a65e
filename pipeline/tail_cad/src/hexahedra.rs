//! Hexahedra of a tail: its outlines and layers as they are defined, divided by the mesher's rows and levels.

use super::layers::{SheetHeights, TailLayers};
use super::plan::outlines_across;
use super::{Tail, TailError};
use mesh::frame::Frame;
use mesh::{Grading, LayeredBody, QuadraticMesh, Slab, layers_in_hexahedra};
use si::{MILLIMETRE, Metre};

/// Distance of the places at which outlines are sampled, m.
const SAMPLING: Metre = 0.25 * MILLIMETRE;
/// Outlines nearer than this are one, m: a twentieth of the thinnest film.
const TOLERANCE: Metre = 5e-6;

/// Elements of the half z ≥ 0.
pub(crate) fn half_hexahedra(tail: &Tail, grading: &Grading) -> Result<QuadraticMesh, TailError> {
    let slabs: Vec<Slab> =
        outline_stations(tail).windows(2).map(|pair| slab_between(tail, [pair[0], pair[1]])).collect();
    let layers = TailLayers::new(tail);
    let body = LayeredBody {
        frame: Frame { normal: 1 },
        slabs: &slabs,
        layers: &|[z, x]| layers.layers_over(x, z),
        sheets: layers.sheets(),
        height: &|[z, x], sheet| SheetHeights::new(tail, x, z).height(sheet),
        tolerance: TOLERANCE,
        half: true,
    };
    Ok(layers_in_hexahedra(&body, grading)?)
}

/// Places at which an outline begins, ends or has a corner, m, rising.
fn outline_stations(tail: &Tail) -> Vec<Metre> {
    let chambers = (0..tail.chambers).flat_map(|chamber| tail.chamber(chamber));
    let fin = tail.fin.iter().map(|station| station.0);
    let ends = [0.0, tail.fin_start, tail.fin_root(), tail.body_end(), tail.length()];
    let mut stations: Vec<Metre> = chambers.chain(fin).chain(ends).collect();
    stations.sort_by(f64::total_cmp);
    stations.dedup_by(|next, station| *next - *station < TOLERANCE);
    stations
}

fn slab_between(tail: &Tail, ends: [Metre; 2]) -> Slab {
    let samples = ((ends[1] - ends[0]) / SAMPLING).ceil() as usize + 2;
    Slab::sampled(ends, samples, &|x| outlines_across(tail, x))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{FILM, Resolution, Unbonded};
    use mesh::{BODY, SPINE};

    fn cast() -> Tail {
        let unbonded = Some(Unbonded { side: 1, chambers: [3, 4], film: 0.15e-3 });
        Tail { unbonded, sheet_offset: 0.1e-3, wall: [1.9e-3, 2.0e-3], ..Tail::nine_chambers() }
    }

    #[test]
    fn hexahedra_have_the_regions_chambers_and_volumes_of_the_tails_tetrahedra() {
        for tail in [Tail::nine_chambers(), Tail::twelve_chambers(), cast()] {
            let mesh = tail.hexahedra(&Grading::COARSE).unwrap().into_corners();
            let tetrahedra = tail.mesh(&Resolution::even(&tail, 2e-3)).unwrap();
            assert_eq!((mesh.nonconformity(), mesh.half, mesh.chambers()), (None, true, 2));
            for region in [BODY, SPINE, FILM].into_iter().filter(|region| tetrahedra.regions.contains(region)) {
                let ratio = mesh.region_volume(region) / tetrahedra.region_volume(region);
                assert!((ratio - 1.0).abs() < 0.01, "region {region}: {ratio}");
            }
            for chamber in [0, 1] {
                let ratio = mesh.chamber_volume(chamber) / tetrahedra.chamber_volume(chamber);
                assert!((ratio - 1.0).abs() < 0.01, "chamber {chamber}: {ratio}");
            }
        }
    }

    #[test]
    fn both_sides_of_a_tail_without_deviations_mirror_each_other() {
        let mesh = Tail::nine_chambers().hexahedra(&Grading::COARSE).unwrap();
        let key = |at: &[f64; 3]| at.map(|x| (x * 1e9).round() as i64);
        let mut nodes: Vec<_> = mesh.nodes.iter().map(key).collect();
        let mut mirrored: Vec<_> = nodes.iter().map(|[x, y, z]| [*x, -y, *z]).collect();
        nodes.sort_unstable();
        mirrored.sort_unstable();
        assert_eq!(nodes, mirrored);
    }
}
