//! Eight-node hexahedra against closed forms and against tetrahedra.

#![allow(clippy::unwrap_used)] // a test may fail where it stands

use fem::{Clamps, Elements, Equilibrium, Forces, Mesh, Options, RegionProperties, StaticSettings, System, box_mesh};

fn region(law: &str, poissons_ratio: f64) -> RegionProperties {
    RegionProperties::elastic(fem::materials::by_name(law).unwrap(), 2e5, poissons_ratio, 1e3)
}

/// Faces of `mesh` in the plane x = `at`.
fn end_faces(mesh: &Mesh, at: f64) -> Vec<Vec<u32>> {
    let Elements::Hexahedra(elements) = &mesh.elements else { panic!("hexahedra") };
    let sides = elements.iter().map(|nodes| [1, 2, 6, 5].map(|n| nodes[n]));
    let on = |face: &[u32; 4]| face.iter().all(|&node| (mesh.nodes[node as usize][0] - at).abs() < 1e-12);
    sides.filter(on).map(|face| face.to_vec()).collect()
}

/// A cantilever of 100 × 10 × 10 mm under an end traction, and its largest deflection.
fn deflection(mesh: Mesh, law: &str, poissons_ratio: f64, mean_dilatation: bool) -> f64 {
    let forces = match mesh.elements {
        Elements::Hexahedra(_) => {
            let faces = end_faces(&mesh, 0.1);
            faces
                .iter()
                .fold(Forces::none(&mesh), |sum, face| sum.on_face(face, [0.0, 0.0, 10.0]).unwrap())
                .as_slice()
                .to_vec()
        }
        _ => {
            let end = (0..mesh.nodes.len() as u32).filter(|&node| mesh.nodes[node as usize][0] > 0.1 - 1e-9);
            let end: Vec<u32> = end.collect();
            let each = [0.0, 0.0, 1e-3 / end.len() as f64];
            end.iter().fold(Forces::none(&mesh), |sum, &node| sum.on_node(node, each).unwrap()).as_slice().to_vec()
        }
    };
    let clamps = Clamps::below_x(&mesh, 1e-9);
    let options = Options { mean_dilatation: vec![mean_dilatation], ..Options::default() };
    let system = System::with(mesh, vec![region(law, poissons_ratio)], clamps, options).unwrap();
    let mut solver = system.solver();
    solver.set_forces(&forces).unwrap();
    let Equilibrium { displacement, .. } = solver.equilibrium(&[], None, &StaticSettings::default()).unwrap();
    displacement.iter().fold(0.0, |most: f64, u| most.max(u.abs()))
}

#[test]
fn a_distorted_patch_takes_a_homogeneous_deformation_exactly() {
    let mut mesh = box_mesh::hexahedra([0.03, 0.02, 0.02], [3, 2, 2]);
    let inner = |at: &[f64; 3]| at[0] > 1e-9 && at[0] < 0.03 - 1e-9 && (at[1] - 0.01).abs() < 1e-9;
    for (n, at) in mesh.nodes.iter_mut().enumerate().filter(|(_, at)| inner(at)) {
        (0..3).for_each(|axis| at[axis] += 1e-3 * ((n + axis) as f64).sin() * f64::from(u8::from(axis != 2)));
    }
    let clamps = Clamps::where_nodes(&mesh, [true, false, false], |at| at[0] < 1e-9)
        .and(&Clamps::where_nodes(&mesh, [false, true, false], |at| at[1] < 1e-9))
        .and(&Clamps::where_nodes(&mesh, [false, false, true], |at| at[2] < 1e-9));
    let faces = end_faces(&mesh, 0.03);
    let forces = faces.iter().fold(Forces::none(&mesh), |sum, face| sum.on_face(face, [2e3, 0.0, 0.0]).unwrap());
    let forces = forces.as_slice().to_vec();
    let nodes = mesh.nodes.clone();
    let system = System::new(mesh, vec![region("linear", 0.3)], clamps).unwrap();
    let mut solver = system.solver();
    solver.set_forces(&forces).unwrap();
    let found =
        solver.equilibrium(&[], None, &StaticSettings { tolerance: 1e-12, ..StaticSettings::default() }).unwrap();
    for (at, u) in nodes.iter().zip(found.displacement.chunks_exact(3)) {
        let exact = [0.01 * at[0], -0.003 * at[1], -0.003 * at[2]];
        assert!(u.iter().zip(exact).all(|(u, exact)| (u - exact).abs() < 1e-13), "{at:?}: {u:?}, {exact:?}");
    }
}

#[test]
fn volume_and_mass_of_a_box_are_those_of_the_box() {
    for lumped_mass in [false, true] {
        let mesh = box_mesh::hexahedra([0.1, 0.02, 0.03], [5, 2, 2]);
        let clamps = Clamps::below_x(&mesh, 1e-9);
        let options = Options { lumped_mass, ..Options::default() };
        let system = System::with(mesh, vec![region("neo_hookean", 0.45)], clamps, options).unwrap();
        assert!((system.volume() - 6e-5).abs() < 1e-18 && (system.mass() - 0.06).abs() < 1e-15);
    }
}

#[test]
fn a_bent_beam_converges_to_that_of_quadratic_tetrahedra() {
    let fine = deflection(box_mesh::quadratic([0.1, 0.01, 0.01], [20, 3, 3]), "neo_hookean", 0.3, false);
    let error = |cells: [usize; 3]| {
        deflection(box_mesh::hexahedra([0.1, 0.01, 0.01], cells), "neo_hookean", 0.3, true) / fine - 1.0
    };
    let (coarse, better) = (error([20, 2, 2]), error([40, 4, 4]));
    assert!(coarse.abs() < 0.2 && better.abs() < 0.4 * coarse.abs(), "{coarse} {better}");
}

#[test]
fn mean_dilatation_removes_volumetric_locking() {
    let tip = |nu: f64, mean: bool| deflection(box_mesh::hexahedra([0.1, 0.01, 0.01], [40, 4, 4]), "linear", nu, mean);
    let (compressible, locked, free) = (tip(0.3, true), tip(0.4999, false), tip(0.4999, true));
    assert!(locked < 0.6 * free, "{locked} {free}");
    assert!((free / compressible - 1.0).abs() < 0.05, "{free} {compressible}");
}
