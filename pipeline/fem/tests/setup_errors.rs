//! Invalid meshes and properties are refused with the element, node or region at fault.

#![allow(clippy::unwrap_used)] // a test may fail where it stands

use fem::{Chamber, Clamps, Elements, Faces, Mesh, RegionProperties, SetupError, System, box_mesh, materials};

fn rubber() -> RegionProperties {
    let material = materials::by_name("neo_hookean").unwrap();
    RegionProperties::elastic(material, 2e5, 0.45, 1070.0)
}

fn hollow() -> Mesh {
    box_mesh::grid([3, 3, 3], false, |at| at.map(|x| 0.03 * x), |cell| (cell != [1, 1, 1]).then_some(0))
}

fn refused(mesh: Mesh) -> SetupError {
    let clamps = Clamps::below_x(&mesh, 1e-9);
    let refusal = System::new(mesh, vec![rubber()], clamps).expect_err("this cannot be solved");
    let text = refusal.to_string();
    assert!(text.contains("\n  why: ") && text.contains("\n  do:  "), "{text}");
    refusal
}

fn linear_faces(mesh: &mut Mesh) -> &mut Vec<[u32; 3]> {
    match &mut mesh.chambers[0].faces {
        Faces::Linear(faces) => faces,
        Faces::Quadratic(_) | Faces::QuadraticQuadrilaterals(_) => unreachable!(),
    }
}

#[test]
fn a_hollow_box_is_accepted() {
    let mesh = hollow();
    let clamps = Clamps::below_x(&mesh, 1e-9);
    let system = System::new(mesh, vec![rubber()], clamps).unwrap();
    let volume = system.chamber_volume(0, &vec![0.0; 3 * system.mesh().nodes.len()]);
    assert!((volume - 1e-6).abs() < 1e-18);
    assert!((system.volume() - 26e-6).abs() < 1e-17);
}

#[test]
fn a_mesh_in_millimetres_is_refused() {
    let mut mesh = hollow();
    mesh.nodes.iter_mut().flatten().for_each(|x| *x *= 1000.0);
    assert!(matches!(refused(mesh), SetupError::Size { size } if (size - 30.0).abs() < 1e-9));
}

#[test]
fn an_inverted_element_is_refused_by_its_number() {
    let mut mesh = hollow();
    let Elements::Linear(tets) = &mut mesh.elements else { unreachable!() };
    tets[17].swap(0, 1);
    assert!(matches!(refused(mesh), SetupError::InvertedElement { element: 17, volume } if volume < 0.0));
}

#[test]
fn a_degenerate_element_is_refused_by_its_number() {
    let mut mesh = hollow();
    let Elements::Linear(tets) = &mut mesh.elements else { unreachable!() };
    tets[5][3] = tets[5][2];
    assert!(matches!(refused(mesh), SetupError::DegenerateElement { element: 5, .. }));
}

#[test]
fn a_node_that_is_not_a_number_is_refused_by_its_number() {
    let mut mesh = hollow();
    mesh.nodes[9][1] = f64::NAN;
    assert!(matches!(refused(mesh), SetupError::NodeNotFinite { node: 9, .. }));
}

#[test]
fn a_node_number_beyond_the_list_is_refused() {
    let mut mesh = hollow();
    let Elements::Linear(tets) = &mut mesh.elements else { unreachable!() };
    tets[3][0] = 4000;
    assert!(matches!(refused(mesh), SetupError::NoSuchNode { part: "element", index: 3, node: 4000, .. }));
}

#[test]
fn an_unused_node_is_refused() {
    let mut mesh = hollow();
    mesh.nodes.push([0.01; 3]);
    assert!(matches!(refused(mesh), SetupError::UnusedNode { node } if node == 64));
}

#[test]
fn a_region_without_properties_is_refused() {
    let mut mesh = hollow();
    mesh.regions[40] = 3;
    assert!(matches!(refused(mesh), SetupError::RegionWithoutProperties { element: 40, region: 3, given: 1 }));
}

#[test]
fn constants_out_of_range_are_refused() {
    let bad = [
        RegionProperties { poissons_ratio: 0.5, ..rubber() },
        RegionProperties { poissons_ratio: -1.0, ..rubber() },
        RegionProperties { poissons_ratio: f64::NAN, ..rubber() },
        RegionProperties { youngs_modulus: 0.2, ..rubber() },
        RegionProperties { density: 0.0, ..rubber() },
    ];
    for properties in bad {
        let mesh = hollow();
        let clamps = Clamps::below_x(&mesh, 1e-9);
        let refusal = System::new(mesh, vec![properties], clamps).unwrap_err();
        assert!(matches!(refusal, SetupError::Property { region: 0, .. }), "{refusal}");
    }
    let mesh = hollow();
    let mut solver = System::new(mesh.clone(), vec![rubber()], Clamps::below_x(&mesh, 1e-9)).unwrap().solver();
    assert!(solver.set_elastic(0, 2e5, 0.5).is_err() && solver.set_elastic(1, 2e5, 0.4).is_err());
}

#[test]
fn a_body_with_a_rigid_motion_is_refused() {
    let mesh = hollow();
    assert!(matches!(
        System::new(mesh.clone(), vec![rubber()], Clamps::none()),
        Err(SetupError::RigidMotion { node: 0 })
    ));
    // nodes in one line leave a turn about that line
    let hinge = Clamps::where_nodes(&mesh, [true; 3], |at| at[0] < 1e-9 && at[1] < 1e-9);
    assert!(matches!(System::new(mesh, vec![rubber()], hinge), Err(SetupError::RigidMotion { .. })));
}

#[test]
fn an_unconstrained_part_beside_a_clamped_one_is_refused() {
    let mut mesh = hollow();
    let other = box_mesh::linear([0.01; 3], [1, 1, 1]);
    let first = mesh.nodes.len() as u32;
    mesh.nodes.extend(other.nodes.iter().map(|at| [at[0] + 0.05, at[1], at[2]]));
    let (Elements::Linear(tets), Elements::Linear(more)) = (&mut mesh.elements, &other.elements) else {
        unreachable!()
    };
    tets.extend(more.iter().map(|tet| tet.map(|node| node + first)));
    mesh.regions.extend(&other.regions);
    assert!(matches!(refused(mesh), SetupError::RigidMotion { node } if node == first as usize));
}

#[test]
fn an_open_chamber_is_refused_with_the_open_edge() {
    let mut mesh = hollow();
    linear_faces(&mut mesh).pop();
    assert!(matches!(refused(mesh), SetupError::OpenChamber { chamber: 0, .. }));
}

#[test]
fn a_chamber_with_inward_normals_is_refused() {
    let mut mesh = hollow();
    linear_faces(&mut mesh).iter_mut().for_each(|face| face.swap(0, 1));
    assert!(matches!(refused(mesh), SetupError::InvertedChamber { volume, .. } if volume < 0.0));
}

#[test]
fn chamber_faces_that_are_not_sides_of_elements_are_refused() {
    let mut mesh = hollow();
    // a closed surface over four far corners of the box
    let at = |x: f64, y: f64, z: f64| {
        mesh.nodes.iter().position(|p| (p[0] - x).abs() + (p[1] - y).abs() + (p[2] - z).abs() < 1e-9).unwrap() as u32
    };
    let [o, x, y, z] = [at(0.0, 0.0, 0.0), at(0.03, 0.0, 0.0), at(0.0, 0.03, 0.0), at(0.0, 0.0, 0.03)];
    mesh.chambers = vec![Chamber { faces: Faces::Linear(vec![[o, x, y], [o, z, x], [o, y, z], [x, z, y]]) }];
    assert!(matches!(refused(mesh), SetupError::UnattachedFace { chamber: 0, .. }));
}

#[test]
fn faces_of_another_order_than_the_elements_are_refused() {
    let mut mesh = hollow();
    mesh.chambers = box_mesh::to_quadratic(&mesh).chambers;
    let refusal = refused(mesh);
    assert!(matches!(refusal, SetupError::MixedOrders { .. } | SetupError::NoSuchNode { .. }), "{refusal}");
}

#[test]
fn a_half_model_below_its_plane_is_refused() {
    let mut mesh = hollow();
    mesh.nodes.iter_mut().for_each(|at| at[2] -= 0.001);
    mesh.symmetry_plane_z = true;
    assert!(matches!(refused(mesh), SetupError::BelowSymmetryPlane { .. }));
}

#[test]
fn a_box_of_too_many_cells_or_without_a_side_is_told_before_memory_is_taken() {
    assert_eq!(box_mesh::check([0.1, 0.02, 0.03], [100, 100, 100]), Ok(()));
    for (size, cells) in [
        ([0.1; 3], [100, 100, 101]),
        ([0.1; 3], [usize::MAX, 2, 1]),
        ([0.1; 3], [1, 0, 1]),
        ([0.1, 0.0, 0.1], [1; 3]),
        ([0.1, f64::NAN, 0.1], [1; 3]),
    ] {
        let error = box_mesh::check(size, cells).unwrap_err();
        assert!(
            matches!(error, SetupError::Box { .. }) && error.to_string().contains("at most 1000000 cells"),
            "{error}"
        );
    }
}
