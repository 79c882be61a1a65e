//! Foreign meshes: one hollow ball in every format, and what is refused.
//!
//! The ball of `data/` has radii of 10 and 6 mm, 140 curved elements of ten nodes, the group 7 "soft" where x < 0 and the group
//! 3 "stiff" where x > 0. gmsh 4.15 wrote the files `.msh` (the legacy ones in version 2.2) and `ball.mesh`, VTK 9.7 the grids; `ball.node` and
//! `ball.ele` have the order of nodes that TetGen 1.6 writes with `-o2`.

#![allow(clippy::unwrap_used)]

use mesh::foreign::{self, ForeignMesh, MeshDefect, MeshFileError, RawMesh, gmsh, medit, tetgen, vtu};
use mesh::{QuadraticFace, Skin, Solid};
use std::f64::consts::PI;
use std::path::Path;

fn bytes(name: &str) -> Vec<u8> {
    std::fs::read(format!("{}/tests/data/{name}", env!("CARGO_MANIFEST_DIR"))).unwrap()
}

fn text(name: &str) -> String {
    String::from_utf8(bytes(name)).unwrap()
}

fn ball(name: &str) -> ForeignMesh {
    let result = match name.rsplit_once('.').unwrap().1 {
        "msh" => gmsh(&bytes(name)),
        "mesh" => medit(&bytes(name)),
        "vtu" => vtu(&bytes(name)),
        _ => tetgen(&bytes("ball.node"), &bytes(name)),
    };
    result.unwrap_or_else(|fault| panic!("{name}: {fault}")).check(1.0, false).unwrap_or_else(|e| panic!("{name}: {e}"))
}

const BALLS: [&str; 12] = [
    "ball.msh",
    "ball_binary.msh",
    "ball_legacy.msh",
    "ball_legacy_binary.msh",
    "ball.mesh",
    "ball.ele",
    "ball_ascii.vtu",
    "ball_inline.vtu",
    "ball_inline_zlib.vtu",
    "ball_raw.vtu",
    "ball_appended.vtu",
    "ball_zlib.vtu",
];

/// Places of all nodes of all elements, with the tag: the same for the same mesh, whatever its numbers.
fn elements(foreign: &ForeignMesh) -> Vec<(i64, Vec<[f64; 3]>)> {
    let solid = &foreign.solid;
    let places = |element| solid.element(element).iter().map(|&n| solid.nodes()[n as usize]).collect();
    (0..solid.len()).map(|e| (foreign.regions[usize::from(solid.regions()[e])].tag, places(e))).collect()
}

#[test]
fn every_format_gives_the_same_ball() {
    let reference = elements(&ball(BALLS[0]));
    for name in BALLS {
        let ball_elements = elements(&ball(name));
        assert_eq!(ball_elements.len(), reference.len(), "{name}");
        for (number, (a, b)) in ball_elements.iter().zip(&reference).enumerate() {
            let distance =
                a.1.iter().flatten().zip(b.1.iter().flatten()).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
            // MEDIT's file has 14 digits
            assert!(a.0 == b.0 && distance < 1e-15, "{name}, element {number}: {distance:e} m distance");
        }
    }
}

#[test]
fn curved_elements_fill_the_ball_better_than_straight_ones() {
    let foreign = ball("ball.msh");
    let ball_volume = 4.0 / 3.0 * PI * (1e-6 - 0.216e-6);
    let curved: f64 = foreign.regions.iter().map(|region| region.volume).sum();
    let straight: f64 = {
        let mesh = foreign.solid.clone().to_linear();
        (0..mesh.tets.len()).map(|tet| mesh.volume(tet)).sum()
    };
    // edges of 70 degrees: chords lose a sixth of the volume, parabolas a hundredth
    assert!((curved / ball_volume - 1.0).abs() < 0.02, "{curved:e} of {ball_volume:e}");
    assert!((straight / ball_volume - 1.0).abs() > 0.1, "{straight:e} of {ball_volume:e}");
}

#[test]
fn the_skin_encloses_the_volume_of_the_elements() {
    let foreign = ball("ball.msh");
    let inner = foreign.cavities[0].volume;
    let elements: f64 = foreign.regions.iter().map(|region| region.volume).sum();
    let (nodes, faces) = (foreign.solid.nodes(), foreign.solid.faces());
    let outer: Vec<_> = faces.iter().filter(|face| face.1 == Skin::Outer).collect();
    assert!(outer.iter().all(|face| face.0.len() == 6));
    let centre = |face: &[u32]| face[..3].iter().map(|&n| nodes[n as usize][0]).sum::<f64>();
    assert!(outer.iter().any(|face| centre(face.0) > 0.0) && outer.iter().any(|face| centre(face.0) < 0.0));
    // Gauss: what the outer shell encloses is the solid and the cavity; the ball's is known through its mirror, the chamber
    let shell = outside_volume(&foreign);
    assert!((shell - inner - elements).abs() < 1e-12 * shell, "{shell:e} {inner:e} {elements:e}");
}

/// The volume inside the outer faces: the cavity of the same mesh when its faces are turned and named a chamber.
fn outside_volume(foreign: &ForeignMesh) -> f64 {
    let Solid::Quadratic(mut mesh) = foreign.solid.clone() else { panic!("ten nodes were read") };
    mesh.skin.retain(|face| face.on == Skin::Outer);
    for face in &mut mesh.skin {
        let [a, b, c, ab, bc, ca] = *face.nodes() else { panic!("a triangle") };
        *face = QuadraticFace::triangle([a, c, b, ca, bc, ab], Skin::Chamber(0));
    }
    mesh::cavities(&Solid::Quadratic(mesh))[0].volume
}

#[test]
fn the_chamber_lies_in_the_middle_and_the_regions_keep_tag_and_name() {
    let foreign = ball("ball_binary.msh");
    assert_eq!(foreign.cavities.len(), 1);
    let cavity = &foreign.cavities[0];
    assert!((cavity.volume / (4.0 / 3.0 * PI * 0.216e-6) - 1.0).abs() < 0.03, "{:e}", cavity.volume);
    assert!(cavity.centroid.iter().all(|x| x.abs() < 2e-5), "{:?}", cavity.centroid);
    let tags_and_names: Vec<_> = foreign.regions.iter().map(|r| (r.tag, r.name.as_deref())).collect();
    assert_eq!(tags_and_names, [(3, Some("stiff")), (7, Some("soft"))]);
    assert_eq!(foreign.solid.regions().iter().filter(|r| **r == 0).count(), foreign.regions[0].elements);
}

/// A cube of side `size` about the origin in twelve tetrahedra around its centre, in MEDIT's format.
fn cube(size: f64) -> String {
    let corner = |i: usize| (0..3).map(move |k| if i >> k & 1 == 1 { size / 2.0 } else { -size / 2.0 });
    let row = |i: usize| format!("{} 0\n", corner(i).map(|x| x.to_string()).collect::<Vec<_>>().join(" "));
    let nodes: String = (0..8).map(row).collect();
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let faces = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
    let tets: String = faces.map(|[a, b, c]| format!("{} {} {} 9 1\n", a + 1, c + 1, b + 1)).collect();
    format!("MeshVersionFormatted 2\nDimension 3\nVertices 9\n{nodes}0 0 0 0\nTetrahedra 12\n{tets}End\n")
}

fn refusal(text: &str) -> MeshDefect {
    medit(text.as_bytes()).unwrap().check(1.0, false).unwrap_err()
}

fn fault(read: Result<RawMesh, MeshFileError>) -> String {
    read.unwrap_err().to_string()
}

#[test]
fn a_cube_is_accepted_in_millimetres_and_refused_in_metres() {
    let raw = medit(cube(20.0).as_bytes()).unwrap();
    let foreign = raw.clone().check(1e-3, false).unwrap();
    assert!((foreign.regions[0].volume - 8e-6).abs() < 1e-18);
    assert!(foreign.notes.iter().any(|note| note.contains("symmetric about z = 0")));
    let message = raw.check(1.0, false).unwrap_err().to_string();
    assert!(message.contains("2.000e1 m long") && message.contains("unit = \"mm\""), "{message}");
}

#[test]
fn left_handed_elements_are_reordered_and_a_single_one_is_refused() {
    let right_handed = cube(0.02);
    let swap = |line: &str| match line.split_whitespace().collect::<Vec<_>>()[..] {
        [a, b, c, "9", "1"] => format!("{b} {a} {c} 9 1"),
        _ => line.to_owned(),
    };
    let left_handed: String = right_handed.lines().map(|line| swap(line) + "\n").collect();
    let foreign = medit(left_handed.as_bytes()).unwrap().check(1.0, false).unwrap();
    assert!(foreign.notes.iter().any(|note| note.contains("left-handed")), "{:?}", foreign.notes);
    let last_line = right_handed.lines().rev().nth(1).unwrap();
    let one_inverted = right_handed.replace(last_line, &swap(last_line));
    assert!(matches!(refusal(&one_inverted), MeshDefect::InvertedElement { element: 12, .. }));
}

#[test]
fn a_flat_element_a_double_one_and_doubled_nodes_are_named() {
    let flat = cube(0.02).replace("\n0 0 0 0\n", "\n0 0 -0.01 0\n");
    assert!(matches!(refusal(&flat), MeshDefect::DegenerateElement { element: 1, .. }));
    let last_line = cube(0.02).lines().rev().nth(1).unwrap().to_owned();
    let double = cube(0.02).replace("Tetrahedra 12", "Tetrahedra 13").replace("End", &format!("{last_line}\nEnd"));
    assert_eq!(refusal(&double), MeshDefect::DuplicateElement { first: 12, second: 13 });
    // the last element gets a centre of its own
    let torn = cube(0.02)
        .replace("Vertices 9", "Vertices 10")
        .replace("\n0 0 0 0\n", "\n0 0 0 0\n0 0 0 0\n")
        .replace(&last_line, &last_line.replace(" 9 1", " 10 1"));
    assert_eq!(refusal(&torn), MeshDefect::CoincidentNodes { first: 9, second: 10, count: 1 });
}

#[test]
fn a_node_that_nothing_uses_is_dropped_with_a_note_and_one_that_is_no_number_is_refused() {
    let extra_node = cube(0.02).replace("Vertices 9", "Vertices 10").replace("\n0 0 0 0\n", "\n0 0 0 0\n5 5 5 0\n");
    let foreign = medit(extra_node.as_bytes()).unwrap().check(1.0, false).unwrap();
    assert_eq!(foreign.solid.nodes().len(), 9);
    assert!(foreign.notes[0].contains("first of them node 10"), "{:?}", foreign.notes);
    let nan = cube(0.02).replace("\n0 0 0 0\n", "\nnan 0 0 0\n");
    assert!(matches!(refusal(&nan), MeshDefect::NotFinite { node: 9, .. }));
}

#[test]
fn parts_that_touch_along_an_edge_alone_leave_the_skin_open() {
    let sharing_edge = "MeshVersionFormatted 2\nDimension 3\nVertices 6\n0 0 0 0\n0.01 0 0 0\n0 0.01 0 0\n0 0 0.01 0\n\
               0.01 -0.01 -0.01 0\n0.02 0 -0.01 0\nTetrahedra 2\n1 2 3 4 1\n1 2 5 6 1\nEnd\n";
    let defect = refusal(sharing_edge);
    assert_eq!(defect, MeshDefect::NonManifoldEdge { edge: [1, 2], count: 4 }, "{defect}");
}

#[test]
fn a_face_of_three_elements_is_refused() {
    let sharing_face = "MeshVersionFormatted 2\nDimension 3\nVertices 6\n0 0 0 0\n0.01 0 0 0\n0 0.01 0 0\n0 0 0.01 0\n\
                 0 0 -0.01 0\n0.001 0 0.02 0\nTetrahedra 3\n1 2 3 4 1\n1 3 2 5 1\n1 2 3 6 1\nEnd\n";
    assert!(matches!(refusal(sharing_face), MeshDefect::NonManifoldFace { face: [1, 2, 3], count: 3, .. }));
}

#[test]
fn a_half_model_has_faces_on_its_plane_and_nothing_below() {
    let cube_mesh = medit(cube(0.02).as_bytes()).unwrap();
    assert!(matches!(cube_mesh.clone().check(1.0, true), Err(MeshDefect::BelowPlane { .. })));
    let mut above = cube_mesh;
    above.nodes.iter_mut().for_each(|at| at[2] += 0.01 + 1e-10);
    let foreign = above.clone().check(1.0, true).unwrap();
    assert_eq!(foreign.solid.faces().iter().filter(|face| face.1 == Skin::Symmetry).count(), 2);
    above.nodes.iter_mut().for_each(|at| at[2] += 0.001);
    assert_eq!(above.check(1.0, true).unwrap_err(), MeshDefect::NoSymmetryPlane);
}

#[test]
fn a_truncated_file_is_refused_with_its_line() {
    for name in BALLS {
        let file_bytes = bytes(name);
        for part in [1, 3, 7, 9] {
            let cut = &file_bytes[..file_bytes.len() * part / 10];
            let result = match name.rsplit_once('.').unwrap().1 {
                "msh" => gmsh(cut),
                "mesh" => medit(cut),
                "vtu" => vtu(cut),
                _ => tetgen(&bytes("ball.node"), cut),
            };
            let complete = |raw: &RawMesh| raw.len() == 140;
            assert!(!result.as_ref().is_ok_and(complete), "{name} at {part}0 % is read whole");
            if let Err(fault) = result {
                let message = fault.to_string();
                assert!(message.contains("why: ") && message.contains("do:  "), "{name}: {message}");
            }
        }
    }
}

#[test]
fn a_file_with_broken_bytes_is_refused_or_read_but_never_a_panic() {
    let mut seed = 20_u64;
    let mut chance = |below: usize| {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 33) as usize % below
    };
    let mut refused = 0;
    for (round, name) in BALLS.iter().cycle().take(3000).enumerate() {
        let mut broken = bytes(name);
        for _ in 0..1 + round % 4 {
            let offset = chance(broken.len());
            // the heads hold the counts
            let offset = if round % 2 == 0 { offset } else { offset % 400 };
            broken[offset] = [0, 255, b'-', b'9', b' ', b'e', b'"', b'<'][chance(8)];
        }
        let result = match name.rsplit_once('.').unwrap().1 {
            "msh" => gmsh(&broken),
            "mesh" => medit(&broken),
            "vtu" => vtu(&broken),
            _ => tetgen(&bytes("ball.node"), &broken),
        };
        refused += usize::from(result.map_or(true, |raw| raw.check(1.0, false).is_err()));
    }
    assert!(refused > 1000, "{refused} of 3000");
}

#[test]
fn text_in_place_of_a_number_is_refused_with_its_line() {
    let message = fault(gmsh(text("ball.msh").replacen("0.006 0 \n", "O.006 0 \n", 1).as_bytes()));
    assert!(message.starts_with("line 11: `O.006` stands for the bounds of an entity"), "{message}");
    let message = fault(medit(cube(0.02).replace("\n0 0 0 0\n", "\n0 x 0 0\n").as_bytes()));
    assert!(message.starts_with("line 12: `x` stands for Vertices"), "{message}");
    let node = text("ball.node").replacen("265 3", "265 2", 1);
    let message = fault(tetgen(node.as_bytes(), &bytes("ball.ele")));
    assert!(message.starts_with(".node file, line 2: the nodes have 2 coordinates"), "{message}");
    let message = fault(foreign::read(Path::new("of/ball.ele"), &bytes("ball.ele"), Some(node.as_bytes())));
    assert!(message.starts_with("ball.node, line 2: the nodes have 2 coordinates"), "{message}");
    let message = fault(vtu(text("ball_ascii.vtu").replacen("0.006", "0,006", 1).as_bytes()));
    assert!(message.starts_with("line ") && message.contains("`0,006` stands in an array"), "{message}");
}

#[test]
fn another_version_another_solid_and_another_compression_are_refused() {
    let message = fault(gmsh(text("ball.msh").replacen("4.1 0 8", "4.0 0 8", 1).as_bytes()));
    assert!(message.contains("version 4.0") && message.contains("-format msh41"), "{message}");
    let message = fault(medit(cube(0.02).replace("End", "Hexahedra 1\n1 2 3 4 5 6 7 8 1\nEnd").as_bytes()));
    assert!(message.contains("hexahedra") && message.contains("line "), "{message}");
    let message = fault(vtu(text("ball_inline_zlib.vtu").replace("vtkZLib", "vtkLZ4").as_bytes()));
    assert!(message.contains("vtkLZ4DataCompressor"), "{message}");
}

#[test]
fn an_element_that_names_a_node_which_is_not_there_is_named() {
    let message = fault(tetgen(&bytes("ball.node"), text("ball.ele").replacen("\n1 ", "\n1 9", 1).as_bytes()));
    assert!(message.contains(".ele file, line 2: element 1 names the node at place"), "{message}");
}

/// A grid whose points are one block of zlib, with `declared` bytes in its header and `held` in the block.
fn packed(declared: u32, held: usize) -> String {
    use base64::Engine;
    use std::io::Write;
    let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::best());
    encoder.write_all(&vec![0; held]).unwrap();
    let block = encoder.finish().unwrap();
    let header: Vec<u8> = [1, declared, 0, block.len() as u32].iter().flat_map(|count| count.to_le_bytes()).collect();
    let encode = |bytes: &[u8]| base64::engine::general_purpose::STANDARD.encode(bytes);
    let array = encode(&header) + &encode(&block);
    format!(
        "<VTKFile type=\"UnstructuredGrid\" compressor=\"vtkZLibDataCompressor\"><UnstructuredGrid><Piece><Points>\
         <DataArray type=\"Float64\" format=\"binary\">{array}</DataArray></Points></Piece></UnstructuredGrid></VTKFile>"
    )
}

#[test]
fn a_block_that_swells_beyond_its_declared_size_is_refused_before_it_has() {
    let refusal_of = |declared, held| vtu(packed(declared, held).as_bytes()).unwrap_err().to_string();
    assert!(refusal_of(2400, 64 << 20).contains("holds more than 2400 bytes"), "{}", refusal_of(2400, 64 << 20));
    assert!(refusal_of(2400, 240).contains("holds less than 2400 bytes"), "{}", refusal_of(2400, 240));
    assert!(refusal_of(1 << 31, 240).contains("the limit is 134217728"), "{}", refusal_of(1 << 31, 240));
}

#[test]
fn an_element_with_countless_attributes_is_refused_with_its_line() {
    let attributes: String = (0..200_000).map(|i| format!(" a{i}=\"1\"")).collect();
    let refused = vtu(format!("<VTKFile type=\"UnstructuredGrid\">\n<Piece{attributes}/></VTKFile>").as_bytes());
    let message = refused.unwrap_err().to_string();
    assert!(
        message.starts_with("line 2: an element has 200000 attributes") && message.contains("limit is 256"),
        "{message}"
    );
}

#[test]
fn elements_within_elements_without_end_are_refused() {
    let deep = "<a>".repeat(200_000);
    assert!(vtu(deep.as_bytes()).is_err());
}

#[test]
fn points_lines_and_triangles_are_counted_and_make_no_solid() {
    let nodes = "$Nodes\n1 4 1 4\n3 1 0 4\n1\n2\n3\n4\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n$EndNodes\n";
    let elements = "$Elements\n3 3 1 3\n0 1 15 1\n1 1\n1 1 1 1\n2 1 2\n2 1 2 1\n3 1 2 3\n$EndElements\n";
    let file = format!("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n{nodes}{elements}");
    let refused = gmsh(file.as_bytes()).unwrap().check(1.0, false).unwrap_err();
    assert!(matches!(refused, MeshDefect::Empty { ignored: 3 }), "{refused}");
}

/// dolfinx writes Lagrange's tetrahedra (71), whose ten nodes are those of the quadratic one (24).
#[test]
fn tetrahedra_of_lagrange_are_those_of_their_order() {
    let quadratic = text("ball_ascii.vtu");
    let (first, rest) = quadratic.split_once("Name=\"types\"").unwrap();
    let (types, rest) = rest.split_once("</DataArray>").unwrap();
    let lagrange = format!("{first}Name=\"types\"{}</DataArray>{rest}", types.replace("24", "71"));
    assert_ne!(lagrange, quadratic);
    let mesh = vtu(lagrange.as_bytes()).unwrap().check(1.0, false).unwrap();
    assert_eq!(elements(&mesh), elements(&ball("ball_ascii.vtu")));
}
