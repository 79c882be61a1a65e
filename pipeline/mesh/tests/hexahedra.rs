//! Hexahedra go through the checks of tetrahedra.

#![allow(clippy::unwrap_used)]

use mesh::Skin;
use mesh::foreign::{HexahedralMesh, MeshDefect, RawMesh, gmsh, vtu};

/// Corners of a cell along x, then y, then z, in the order of VTK.
const CORNERS: [[usize; 3]; 8] =
    [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]];

/// So many cells of 10 mm along each axis.
fn grid(cells: [usize; 3]) -> RawMesh {
    let [nx, ny, nz] = cells.map(|count| count + 1);
    let node = |[i, j, k]: [usize; 3]| i + nx * (j + ny * k);
    let mut raw = RawMesh { each: 8, ..RawMesh::default() };
    for number in 0..nx * ny * nz {
        let at = [number % nx, number / nx % ny, number / (nx * ny)];
        raw.nodes.push(at.map(|along| 0.01 * along as f64));
        raw.node_labels.push(number as u64);
    }
    for cell in 0..cells.iter().product() {
        let low = [cell % cells[0], cell / cells[0] % cells[1], cell / (cells[0] * cells[1])];
        let corner = |up: [usize; 3]| node([low[0] + up[0], low[1] + up[1], low[2] + up[2]]) as u32;
        raw.corners.extend(CORNERS.map(corner));
        raw.labels.push(cell as u64);
        raw.tags.push(3 + (cell % 2) as i64);
    }
    raw
}

fn checked(raw: RawMesh) -> Result<HexahedralMesh, MeshDefect> {
    raw.check_hexahedra(1.0, false)
}

#[test]
fn a_grid_has_its_volume_its_skin_and_its_regions() {
    let mesh = checked(grid([4, 2, 2])).unwrap();
    let volume: f64 = mesh.regions.iter().map(|region| region.volume).sum();
    assert!((volume / 16e-6 - 1.0).abs() < 1e-12);
    assert_eq!((mesh.skin.len(), mesh.hexahedra.len()), (2 * (4 * 2 + 2 * 2 + 4 * 2), 16));
    assert_eq!(mesh.regions.iter().map(|region| (region.tag, region.elements)).collect::<Vec<_>>(), [(3, 8), (4, 8)]);
    assert!(mesh.notes.is_empty() && mesh.numbering == (0..45).collect::<Vec<u32>>());
}

#[test]
fn each_defect_is_named() {
    let with = |change: &dyn Fn(&mut RawMesh)| {
        let mut raw = grid([3, 2, 2]);
        change(&mut raw);
        checked(raw)
    };
    let repeated = with(&|raw| raw.corners[9] = raw.corners[10]);
    assert!(matches!(repeated, Err(MeshDefect::RepeatedNode { element: 1, .. })), "{repeated:?}");
    let twice = with(&|raw| {
        raw.corners.extend_from_within(..8);
        raw.labels.push(99);
        raw.tags.push(3);
    });
    assert!(matches!(twice, Err(MeshDefect::DuplicateElement { first: 0, second: 99 })), "{twice:?}");
    let same = with(&|raw| raw.nodes[5] = raw.nodes[6]);
    assert!(same.is_err(), "an element is then flat, or two nodes lie at one place");
    let inverted = with(&|raw| (0..4).for_each(|corner| raw.corners.swap(corner, corner + 4)));
    assert!(matches!(inverted, Err(MeshDefect::InvertedElement { element: 0, .. })), "{inverted:?}");
    let apart = with(&|raw| {
        // the first cell with nodes of its own
        for place in 0..8 {
            raw.nodes.push(raw.nodes[raw.corners[place] as usize]);
            raw.node_labels.push(1000 + place as u64);
            raw.corners[place] = raw.nodes.len() as u32 - 1;
        }
    });
    assert!(matches!(apart, Err(MeshDefect::CoincidentNodes { .. })), "{apart:?}");
    let far = with(&|raw| raw.nodes.iter_mut().for_each(|at| at[0] *= 1e4));
    assert!(matches!(far, Err(MeshDefect::Size { .. })), "{far:?}");
    let named = with(&|raw| raw.names.extend([(3, "a".to_owned()), (4, "a".to_owned())]));
    assert!(matches!(named, Err(MeshDefect::RegionName { first: 3, second: 4, .. })), "{named:?}");
    let many = with(&|raw| raw.tags = (0..12).map(|tag| tag * 70_000).collect());
    assert_eq!(many.unwrap().regions.len(), 12);
}

#[test]
fn left_handed_elements_are_turned_and_unused_nodes_dropped_with_a_map() {
    let mut raw = grid([2, 1, 1]);
    raw.corners.chunks_exact_mut(8).for_each(|nodes| nodes.rotate_left(4));
    raw.nodes.insert(0, [0.005; 3]);
    raw.node_labels.insert(0, 77);
    raw.corners.iter_mut().for_each(|node| *node += 1);
    let mesh = checked(raw).unwrap();
    assert_eq!((mesh.notes.len(), mesh.numbering[0], mesh.numbering[1]), (2, u32::MAX, 0));
    assert_eq!(mesh.hexahedra, checked(grid([2, 1, 1])).unwrap().hexahedra);
}

#[test]
fn a_half_model_begins_on_its_plane_and_has_no_skin_there() {
    let half = grid([2, 1, 1]).check_hexahedra(1.0, true).unwrap();
    assert!(half.half && half.skin.len() == 10 - 2);
    let lifted = |by: f64| {
        let mut raw = grid([2, 1, 1]);
        raw.nodes.iter_mut().for_each(|at| at[2] += by);
        raw.check_hexahedra(1.0, true)
    };
    assert!(matches!(lifted(0.01), Err(MeshDefect::NoSymmetryPlane)));
    assert!(matches!(lifted(-0.01), Err(MeshDefect::BelowPlane { .. })));
}

#[test]
fn a_file_of_hexahedra_is_a_solid_of_twenty_nodes() {
    let grid = "<VTKFile type=\"UnstructuredGrid\"><UnstructuredGrid><Piece><Points><DataArray type=\"Float64\" format=\"ascii\">\
        0 0 0 1 0 0 1 1 0 0 1 0 0 0 1 1 0 1 1 1 1 0 1 1</DataArray></Points><Cells>\
        <DataArray type=\"Int32\" Name=\"connectivity\" format=\"ascii\">0 1 2 3 4 5 6 7</DataArray>\
        <DataArray type=\"Int32\" Name=\"offsets\" format=\"ascii\">8</DataArray>\
        <DataArray type=\"Int32\" Name=\"types\" format=\"ascii\">12</DataArray></Cells></Piece></UnstructuredGrid></VTKFile>";
    let raw = vtu(grid.as_bytes()).unwrap();
    assert_eq!(raw.clone().check_hexahedra(1e-2, false).unwrap().skin.len(), 6);
    let mesh = raw.check(1e-2, false).unwrap();
    assert_eq!((mesh.solid.nodes().len(), mesh.solid.element(0).len(), mesh.numbering.len()), (20, 20, 8));
    assert!(mesh.notes[0].contains("get 20") && mesh.solid.faces().len() == 6, "{:?}", mesh.notes);
}

/// The same with 20 nodes an element, in the order of VTK.
fn quadratic(mut raw: RawMesh) -> RawMesh {
    let mut middles = std::collections::HashMap::new();
    let elements: Vec<[u32; 8]> = raw.corners.as_chunks::<8>().0.to_vec();
    (raw.corners, raw.each) = (Vec::new(), 20);
    for nodes in elements {
        raw.corners.extend(nodes);
        for [a, b] in EDGES.map(|edge| edge.map(|corner| nodes[corner])) {
            let middle = *middles.entry([a.min(b), a.max(b)]).or_insert_with(|| {
                let [from, to] = [a, b].map(|node| raw.nodes[node as usize]);
                raw.nodes.push(std::array::from_fn(|k| 0.5 * (from[k] + to[k])));
                raw.node_labels.push(raw.nodes.len() as u64 - 1);
                raw.nodes.len() as u32 - 1
            });
            raw.corners.push(middle);
        }
    }
    raw
}

/// Edges of an element in the order of VTK.
const EDGES: [[usize; 2]; 12] =
    [[0, 1], [1, 2], [2, 3], [3, 0], [4, 5], [5, 6], [6, 7], [7, 4], [0, 4], [1, 5], [2, 6], [3, 7]];

/// A grid without the cell in its middle.
fn hollow(cells: [usize; 3]) -> RawMesh {
    let mut raw = grid(cells);
    let middle = raw.labels.len() / 2;
    raw.corners.drain(8 * middle..8 * middle + 8);
    raw.labels.remove(middle);
    raw.tags.remove(middle);
    raw
}

#[test]
fn a_cavity_of_quadratic_elements_is_a_chamber_with_the_middles_of_its_walls() {
    let mesh = checked(quadratic(hollow([3, 3, 3]))).unwrap();
    let [chamber] = &mesh.chambers[..] else { panic!("{} chambers", mesh.chambers.len()) };
    assert_eq!((mesh.walls.len(), mesh.walls[0].len(), mesh.skin.len()), (1, 6, 54));
    let all = 27.0 * chamber.cavity.volume;
    let size = mesh.nodes.iter().fold([0.0f64; 3], |most, node| std::array::from_fn(|k| most[k].max(node[k])));
    assert!((all / size.iter().product::<f64>() - 1.0).abs() < 1e-12);
    assert!((0..3).all(|k| (chamber.cavity.centroid[k] / size[k] - 0.5).abs() < 1e-12));
    for wall in mesh.walls.iter().flatten() {
        let place = |node: usize| mesh.nodes[wall[node] as usize];
        for k in 0..4 {
            let (from, to, middle) = (place(k), place((k + 1) % 4), place(4 + k));
            assert!((0..3).all(|axis| (from[axis] + to[axis] - 2.0 * middle[axis]).abs() < 1e-15), "{wall:?}");
        }
    }
    let linear = checked(hollow([3, 3, 3])).unwrap();
    assert!(linear.walls.is_empty() && linear.notes[0].contains("take no pressure"), "{:?}", linear.notes);
}

#[test]
fn a_solid_of_hexahedra_has_its_chamber_its_plane_and_its_volume() {
    for raw in [hollow([3, 3, 3]), quadratic(hollow([3, 3, 3]))] {
        let mesh = raw.check(1.0, false).unwrap();
        let [cavity] = &mesh.cavities[..] else { panic!("{} cavities", mesh.cavities.len()) };
        assert!((cavity.volume / 1e-6 - 1.0).abs() < 1e-9 && mesh.solid.element(0).len() == 20);
        let on = |skin: Skin| mesh.solid.faces().iter().filter(|face| face.1 == skin).count();
        assert_eq!((on(Skin::Outer), on(Skin::Chamber(0)), on(Skin::Symmetry)), (54, 6, 0));
        let tets = mesh.solid.to_linear();
        assert!((tets.region_volume(0) + tets.region_volume(1) - 26e-6).abs() < 1e-15);
    }
    let half = grid([2, 1, 1]).check(1.0, true).unwrap();
    let on_plane = half.solid.faces().iter().filter(|face| face.1 == Skin::Symmetry).count();
    assert_eq!((on_plane, half.solid.faces().len()), (2, 10));
}

/// gmsh's file of two cells of 27 nodes with a side of nine nodes that has a name.
fn gmsh_of_27_nodes() -> String {
    let full = quadratic(grid([2, 1, 1]));
    // the places in VTK's list of gmsh's twelve middles
    const MIDDLES: [usize; 12] = [8, 11, 16, 9, 17, 10, 18, 19, 12, 15, 13, 14];
    let mut nodes = full.nodes.clone();
    let mut elements = Vec::new();
    for (number, of_element) in full.corners.chunks_exact(20).enumerate() {
        // middles of sides and of the element stand anywhere: they are not read
        let seven = (0..7).map(|_| {
            nodes.push([5.0, 5.0, 5.0 + nodes.len() as f64]);
            nodes.len()
        });
        let kept = of_element[..8].iter().copied().chain(MIDDLES.map(|place| of_element[place]));
        let list: Vec<String> = kept.map(|node| node as usize + 1).chain(seven).map(|n| n.to_string()).collect();
        elements.push(format!("{} 12 2 7 1 {}", number + 1, list.join(" ")));
    }
    let first = &full.corners[..20];
    let side: Vec<String> =
        [0, 3, 7, 4, 11, 19, 15, 16, 0].iter().map(|&place| (first[place as usize] + 1).to_string()).collect();
    elements.push(format!("3 10 2 9 1 {}", side.join(" ")));
    let nodes: Vec<String> = nodes.iter().enumerate().map(|(n, [x, y, z])| format!("{} {x} {y} {z}", n + 1)).collect();
    format!(
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n2 9 \"root\"\n3 7 \"silicone\"\n$EndPhysicalNames\n\
         $Nodes\n{}\n{}\n$EndNodes\n$Elements\n{}\n{}\n$EndElements\n",
        nodes.len(),
        nodes.join("\n"),
        elements.len(),
        elements.join("\n")
    )
}

#[test]
fn hexahedra_of_27_nodes_lose_seven_and_their_named_side_has_eight() {
    let mesh = gmsh(gmsh_of_27_nodes().as_bytes()).unwrap().check(1.0, false).unwrap();
    assert_eq!((mesh.solid.len(), mesh.solid.element(1).len(), mesh.solid.nodes().len()), (2, 20, 32));
    assert_eq!(mesh.regions[0].name.as_deref(), Some("silicone"));
    let elements = (0..mesh.solid.len()).map(|element| mesh.solid.element(element));
    let root = mesh.surfaces.iter().find(|surface| surface.name.as_deref() == Some("root")).unwrap();
    let places: Vec<_> = root.nodes(elements).iter().map(|&node| mesh.solid.nodes()[node as usize]).collect();
    assert!(places.len() == 8 && places.iter().all(|place| place[0] == 0.0), "{places:?}");
}

#[test]
fn left_handed_quadratic_elements_are_turned_with_their_middles() {
    let mut mirrored = quadratic(grid([2, 1, 1]));
    mirrored.nodes.iter_mut().for_each(|node| node[0] = -node[0]);
    let mesh = checked(mirrored).unwrap();
    assert!(mesh.notes[0].contains("left-handed"));
    for (corners, middles) in mesh.hexahedra.iter().zip(&mesh.middles) {
        for ([a, b], middle) in EDGES.iter().zip(middles) {
            let [from, to, at] = [corners[*a], corners[*b], *middle].map(|node| mesh.nodes[node as usize]);
            assert!((0..3).all(|axis| (from[axis] + to[axis] - 2.0 * at[axis]).abs() < 1e-15));
        }
    }
}

#[test]
fn two_quadratic_elements_that_share_an_edge_share_its_middle() {
    let mut torn = quadratic(grid([2, 1, 1]));
    let shared = (20..40).find(|&place| place >= 28 && torn.corners[..20].contains(&torn.corners[place])).unwrap();
    let middle = torn.nodes[torn.corners[shared] as usize];
    torn.corners[shared] = torn.nodes.len() as u32;
    torn.node_labels.push(torn.nodes.len() as u64);
    torn.nodes.push([middle[0], middle[1], middle[2] + 1e-4]);
    let refused = checked(torn);
    assert!(matches!(refused, Err(MeshDefect::SplitEdge { .. })), "{refused:?}");
}
