//! Measures of a mesh against the surfaces that it was made from: angles, Jacobians, volumes, distances, shells and interfaces.

use crate::quality::{dihedral_angles, dihedral_quantile, dihedral_range, scaled_jacobian};
use crate::validate::{face_area, faces_between_regions, hausdorff_distances};
use crate::{Assembly, Skin, TetMesh};
use si::{CubicMetre, Metre, SquareMetre};
use std::collections::BTreeMap;

/// Classes of a histogram.
const CLASSES: usize = 10;
/// The least angle of an element is 70.5° where it is regular.
const LARGEST_LEAST_ANGLE: f64 = 70.6;

/// Elements and volume of a region.
#[derive(Debug, Clone, PartialEq)]
pub struct RegionMeasures {
    /// Number of elements.
    pub elements: usize,
    /// Volume of the elements, m³.
    pub volume: CubicMetre,
    /// Volume between the surfaces, m³; none where a surface is open or parts overlap.
    pub expected: Option<CubicMetre>,
}

/// Faces between two regions.
#[derive(Debug, Clone, PartialEq)]
pub struct Interface {
    /// The regions.
    pub regions: [u16; 2],
    /// Number of faces.
    pub faces: usize,
    /// Their area, m².
    pub area: SquareMetre,
}

/// Measures of a mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct Measures {
    /// Smallest and largest dihedral angle, degrees.
    pub dihedral_range_deg: [f64; 2],
    /// The smallest angle of all elements but one in a thousand, degrees.
    pub dihedral_quantile_deg: f64,
    /// Elements by their smallest dihedral angle, in ten classes from 0 to 70.6° (a regular one has 70.5°).
    pub dihedral_histogram: [usize; CLASSES],
    /// Smallest scaled Jacobian, without unit.
    pub least_jacobian: f64,
    /// Elements by their scaled Jacobian, in ten classes from 0 to 1.
    pub jacobian_histogram: [usize; CLASSES],
    /// Largest distance of the surfaces from the mesh, m.
    pub surfaces_to_mesh: Metre,
    /// Largest distance of the mesh's skin and interfaces from the surfaces, m.
    pub mesh_to_surfaces: Metre,
    /// Connected parts of the skin that are no chambers.
    pub shells: usize,
    /// By region.
    pub regions: Vec<RegionMeasures>,
    /// By pair of regions.
    pub interfaces: Vec<Interface>,
}

impl Measures {
    /// Measures a mesh of an assembly with edges of a length, m.
    pub fn new(mesh: &TetMesh, assembly: &Assembly, edge: Metre) -> Self {
        let interface_sides = faces_between_regions(mesh);
        let faces: Vec<[u32; 3]> = interface_sides.iter().map(|(face, _)| *face).collect();
        let [there, back] = hausdorff_distances(mesh, &faces, &assembly.surfaces(), assembly.visibility(edge).as_ref());
        let angles = (0..mesh.tets.len()).map(|tet| dihedral_angles(&mesh.corners(tet)).0 / LARGEST_LEAST_ANGLE);
        let jacobians: Vec<f64> = (0..mesh.tets.len()).map(|tet| scaled_jacobian(&mesh.corners(tet))).collect();
        Self {
            dihedral_range_deg: dihedral_range(mesh).into(),
            dihedral_quantile_deg: dihedral_quantile(mesh, 1e-3),
            dihedral_histogram: share_histogram(angles),
            least_jacobian: jacobians.iter().copied().fold(f64::INFINITY, f64::min),
            jacobian_histogram: share_histogram(jacobians.into_iter()),
            surfaces_to_mesh: there.0,
            mesh_to_surfaces: back.0,
            shells: count_shells(mesh),
            regions: region_measures(mesh, assembly),
            interfaces: joined_interfaces(mesh, &interface_sides),
        }
    }
}

fn share_histogram(shares: impl Iterator<Item = f64>) -> [usize; CLASSES] {
    let mut counts = [0; CLASSES];
    shares.for_each(|share| counts[((share * CLASSES as f64).max(0.0) as usize).min(CLASSES - 1)] += 1);
    counts
}

fn region_measures(mesh: &TetMesh, assembly: &Assembly) -> Vec<RegionMeasures> {
    let measures_of_region = |(region, expected): (u16, Option<f64>)| RegionMeasures {
        elements: mesh.regions.iter().filter(|r| **r == region).count(),
        volume: mesh.region_volume(region),
        expected,
    };
    (0..).zip(assembly.expected_volumes()).map(measures_of_region).collect()
}

fn joined_interfaces(mesh: &TetMesh, between: &[([u32; 3], [u16; 2])]) -> Vec<Interface> {
    let mut sums: BTreeMap<[u16; 2], (usize, f64)> = BTreeMap::new();
    for (face, pair) in between {
        let sum = sums.entry(*pair).or_default();
        *sum = (sum.0 + 1, sum.1 + face_area(mesh, face));
    }
    sums.into_iter().map(|(regions, (faces, area))| Interface { regions, faces, area }).collect()
}

/// Connected parts of the outer skin.
fn count_shells(mesh: &TetMesh) -> usize {
    let mut root: Vec<u32> = (0..mesh.nodes.len() as u32).collect();
    let outer = || mesh.skin.iter().filter(|face| face.on == Skin::Outer).map(|face| face.nodes);
    for [a, b, c] in outer() {
        let lowest = [a, b, c].map(|n| find_root(&mut root, n)).into_iter().min().unwrap_or(a);
        for node in [a, b, c] {
            let top = find_root(&mut root, node);
            root[top as usize] = lowest;
        }
    }
    let mut tops: Vec<u32> = outer().flatten().map(|n| find_root(&mut root, n)).collect();
    tops.sort_unstable();
    tops.dedup();
    tops.len()
}

fn find_root(root: &mut [u32], mut member: u32) -> u32 {
    while root[member as usize] != member {
        root[member as usize] = root[root[member as usize] as usize];
        member = root[member as usize];
    }
    member
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::tests::{block, with_cavity};
    use crate::{Settings, mesh_assembly};

    #[test]
    fn a_box_with_a_cavity_of_its_own_surface_is_measured() {
        let (body, cavity) = (block([0.0; 3], [0.03, 0.02, 0.02]), block([0.005; 3], [0.02, 0.015, 0.015]));
        let solid = Assembly { body: &body, inserts: Vec::new(), cavities: vec![&cavity] };
        let set = Settings { method: crate::Method::Auto, use_symmetry: false, ..Settings::new(4e-3) };
        let chosen = mesh_assembly(&solid, &set, &|_| ()).unwrap();
        let mesh = chosen.solid.into_corners();
        let measures = Measures::new(&mesh, &solid, 4e-3);
        assert!(chosen.not_columns.is_some());
        assert_eq!((measures.shells, mesh.chambers(), measures.interfaces.len()), (1, 1, 0));
        assert!((measures.regions[0].volume / measures.regions[0].expected.unwrap() - 1.0).abs() < 1e-3);
        assert_eq!(measures.dihedral_histogram.iter().sum::<usize>(), mesh.tets.len());
        assert_eq!(measures.jacobian_histogram.iter().sum::<usize>(), mesh.tets.len());
        assert!(measures.mesh_to_surfaces.max(measures.surfaces_to_mesh) < 8e-5);
    }

    #[test]
    fn the_area_between_two_regions_is_that_of_the_insert() {
        let sheet = [[0.005, 0.008, 0.004], [0.025, 0.012, 0.016]];
        let body = with_cavity(block([0.0; 3], [0.03, 0.02, 0.02]), sheet[0], sheet[1]);
        let insert = block(sheet[0], sheet[1]);
        let solid = Assembly { body: &body, inserts: vec![&insert], cavities: Vec::new() };
        let set = Settings { method: crate::Method::General, ..Settings::new(4e-3) };
        let mesh = mesh_assembly(&solid, &set, &|_| ()).unwrap().solid.into_corners();
        let measures = Measures::new(&mesh, &solid, 4e-3);
        let [interface] = measures.interfaces.as_slice() else { panic!("{:?}", measures.interfaces) };
        assert_eq!(interface.regions, [0, 1]);
        assert!((interface.area / 7.36e-4 - 1.0).abs() < 1e-3);
    }
}
