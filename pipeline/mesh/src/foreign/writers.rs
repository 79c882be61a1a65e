//! Writers of quadratic tetrahedra for other programs: gmsh's `.msh` of version 2.2 and MEDIT's `.mesh`, as text, lengths in metres.
//!
//! Regions, the outer skin, each chamber's wall and each interface between two regions have numbers of their own, in gmsh's file names, too. So a
//! load or a clamp of another solver finds them.

use std::collections::BTreeMap;
use std::fmt::Write;

use crate::{QuadraticElements, QuadraticMesh};
use si::Point3;

/// gmsh's types of the ten-node tetrahedron and the six-node triangle.
const TETRAHEDRON: u8 = 11;
const TRIANGLE: u8 = 9;
/// gmsh's order of the middles 01, 12, 02, 03, 13, 23 of a tetrahedron.
const GMSH_ORDER: [usize; 10] = [0, 1, 2, 3, 4, 5, 6, 7, 9, 8];

/// A mesh of quadratic tetrahedra as its writers need it.
struct Written<'a> {
    nodes: &'a [Point3],
    tets: &'a [[u32; 10]],
    regions: &'a [u16],
    /// Six nodes a face, with its number.
    faces: Vec<([u32; 6], i64)>,
    /// Names by number.
    surfaces: BTreeMap<i64, String>,
}

impl<'a> Written<'a> {
    /// None of hexahedra.
    fn new(mesh: &'a QuadraticMesh) -> Option<Self> {
        let QuadraticElements::Tetrahedra(tets) = &mesh.elements else { return None };
        let mut surfaces = BTreeMap::new();
        let mut faces: Vec<([u32; 6], i64)> = Vec::new();
        for face in &mesh.skin {
            let number = i64::from(face.on.code()) + 1;
            surfaces.entry(number).or_insert_with(|| surface_name(face.on));
            faces.push((six_nodes(face.nodes()), number));
        }
        let first = surfaces.keys().last().copied().unwrap_or(0) + 1;
        let interfaces = interface_faces(mesh);
        let pairs: BTreeMap<[u16; 2], i64> = interfaces.iter().map(|(_, pair)| (*pair, 0)).collect();
        let pairs: BTreeMap<[u16; 2], i64> = pairs.into_keys().zip(first..).collect();
        surfaces.extend(pairs.iter().map(|([a, b], number)| (*number, format!("interface_{a}_{b}"))));
        faces.extend(interfaces.into_iter().map(|(face, pair)| (face, pairs[&pair])));
        Some(Self { nodes: &mesh.nodes, tets, regions: &mesh.regions, faces, surfaces })
    }
}

fn surface_name(on: crate::Skin) -> String {
    match on {
        crate::Skin::Outer => "outer".to_owned(),
        crate::Skin::Symmetry => "symmetry".to_owned(),
        crate::Skin::Chamber(chamber) => format!("chamber_{chamber}"),
    }
}

fn six_nodes(nodes: &[u32]) -> [u32; 6] {
    std::array::from_fn(|k| nodes[k])
}

/// Faces between unlike regions, once each, normals out of the first, with the regions in rising order.
pub(crate) fn interface_faces(mesh: &QuadraticMesh) -> Vec<([u32; 6], [u16; 2])> {
    let mut sides = Vec::new();
    // length: a mesh has a region for every element
    for (element, region) in mesh.regions.iter().enumerate() {
        for side in mesh.elements.sides(element) {
            let mut key = [side.nodes()[0], side.nodes()[1], side.nodes()[2]];
            key.sort_unstable();
            sides.push((key, *region, six_nodes(side.nodes())));
        }
    }
    sides.sort_unstable();
    let pairs = sides.chunk_by(|a, b| a.0 == b.0).filter(|pair| pair.len() == 2 && pair[0].1 != pair[1].1);
    pairs.map(|pair| (pair[0].2, [pair[0].1, pair[1].1])).collect()
}

/// A mesh as gmsh's `.msh` 2.2; none of hexahedra. `regions` are the names of its regions, whose tags are counted from 1.
pub fn write_gmsh(mesh: &QuadraticMesh, regions: &[String]) -> Option<String> {
    let written = Written::new(mesh)?;
    let mut text = String::from("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n");
    let _ = writeln!(text, "{}", written.surfaces.len() + regions.len());
    for (number, name) in &written.surfaces {
        let _ = writeln!(text, "2 {number} \"{name}\"");
    }
    for (number, name) in regions.iter().enumerate() {
        let _ = writeln!(text, "3 {} \"{name}\"", number + 1);
    }
    let _ = writeln!(text, "$EndPhysicalNames\n$Nodes\n{}", written.nodes.len());
    for (number, [x, y, z]) in written.nodes.iter().enumerate() {
        let _ = writeln!(text, "{} {x:e} {y:e} {z:e}", number + 1);
    }
    let _ = writeln!(text, "$EndNodes\n$Elements\n{}", written.faces.len() + written.tets.len());
    for (label, (nodes, number)) in written.faces.iter().enumerate() {
        let _ = writeln!(text, "{} {TRIANGLE} 2 {number} {number}{}", label + 1, node_row(nodes));
    }
    // length: a mesh has a region for every element
    for (label, (nodes, region)) in written.tets.iter().zip(written.regions).enumerate() {
        let (label, region) = (label + written.faces.len() + 1, region + 1);
        let _ = writeln!(text, "{label} {TETRAHEDRON} 2 {region} {region}{}", node_row(&GMSH_ORDER.map(|k| nodes[k])));
    }
    text += "$EndElements\n";
    Some(text)
}

/// A mesh as MEDIT's `.mesh`; none of hexahedra. References of regions and surfaces are the tags of [`write_gmsh`].
pub fn write_medit(mesh: &QuadraticMesh) -> Option<String> {
    let written = Written::new(mesh)?;
    let mut text = format!("MeshVersionFormatted 2\nDimension 3\nVertices\n{}\n", written.nodes.len());
    for [x, y, z] in written.nodes {
        let _ = writeln!(text, "{x:e} {y:e} {z:e} 0");
    }
    let _ = writeln!(text, "TrianglesP2\n{}", written.faces.len());
    for (nodes, number) in &written.faces {
        let _ = writeln!(text, "{} {number}", node_row(nodes).trim_start());
    }
    let _ = writeln!(text, "TetrahedraP2\n{}", written.tets.len());
    // length: a mesh has a region for every element
    for (nodes, region) in written.tets.iter().zip(written.regions) {
        let _ = writeln!(text, "{} {}", node_row(nodes).trim_start(), region + 1);
    }
    text += "End\n";
    Some(text)
}

/// Nodes counted from 1, each after a space.
fn node_row(nodes: &[u32]) -> String {
    nodes.iter().map(|n| format!(" {}", n + 1)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::foreign::{RawMesh, gmsh, medit};
    use crate::surface::tests::{block, with_cavity};
    use crate::{Assembly, Method, Settings, Solid, mesh_assembly};

    /// A box around an insert, with a cavity.
    fn solid() -> QuadraticMesh {
        let (body, cavity) = (block([0.0; 3], [0.03, 0.02, 0.02]), [[0.002, 0.005, 0.005], [0.008, 0.015, 0.015]]);
        let (body, insert) =
            (with_cavity(body, cavity[0], cavity[1]), block([0.012, 0.005, 0.005], [0.02, 0.015, 0.015]));
        let parts = Assembly { body: &body, inserts: vec![&insert], cavities: Vec::new() };
        let set = Settings { method: Method::General, ..Settings::new(6e-3) };
        mesh_assembly(&parts, &set, &|_| ()).unwrap().solid
    }

    fn read_back(raw: RawMesh, solid: &QuadraticMesh) {
        let read = raw.check(1.0, false).unwrap();
        assert_eq!(Solid::Quadratic(solid.clone()), read.solid);
        assert_eq!((read.cavities.len(), read.regions.len(), read.surfaces.len()), (1, 2, 3));
    }

    #[test]
    fn a_mesh_is_read_back_from_the_file_of_gmsh_with_its_names() {
        let solid = solid();
        let text = write_gmsh(&solid, &["body".to_owned(), "insert".to_owned()]).unwrap();
        let raw = gmsh(text.as_bytes()).unwrap();
        assert_eq!(raw.names.values().map(String::as_str).collect::<Vec<_>>(), ["body", "insert"]);
        let surfaces: Vec<&str> = raw.surface_names.values().map(String::as_str).collect();
        assert_eq!(surfaces, ["outer", "chamber_0", "interface_0_1"]);
        read_back(raw, &solid);
    }

    #[test]
    fn a_mesh_is_read_back_from_the_file_of_medit() {
        let solid = solid();
        read_back(medit(write_medit(&solid).unwrap().as_bytes()).unwrap(), &solid);
    }
}
