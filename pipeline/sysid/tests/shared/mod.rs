//! A small bar that bends, for the tests of identification.

use std::sync::Arc;

use fem::{Clamps, RegionProperties, System, box_mesh, materials};
use mesh::Spot;
use sysid::{Elastic, Model};

/// A bar of 80 × 20 × 20 mm, half of it meshed, with an air chamber on either side of a stiff sheet, seen at its end; its softest
/// solid has the `law`.
pub fn bar(law: &str) -> Model {
    let air = |c: [usize; 3], y: usize| (1..7).contains(&c[0]) && c[1] == y && c[2] == 0;
    let place = |at: [f64; 3]| [0.08 * at[0], 0.02 * (at[1] - 0.5), 0.01 * at[2]];
    let region = move |c: [usize; 3]| if air(c, 1) || air(c, 3) { None } else { Some(u16::from(c[1] == 2)) };
    let mesh = box_mesh::to_quadratic(&box_mesh::grid([8, 5, 2], true, place, region));
    let material = materials::by_name(law).unwrap();
    let soft = RegionProperties::elastic(material, 2e5, 0.45, 1e3);
    let stiff = RegionProperties { youngs_modulus: 5e6, poissons_ratio: 0.35, ..soft.clone() };
    let far = |a: &usize, b: &usize| mesh.nodes[*a][0].total_cmp(&mesh.nodes[*b][0]);
    let end = (0..mesh.nodes.len()).max_by(far).unwrap() as u32;
    let clamps = Clamps::below_x(&mesh, 1e-9);
    let system = Arc::new(System::new(mesh, vec![soft, stiff], clamps).unwrap());
    let nominal = Elastic { youngs_moduli: vec![2e5, 5e6], poissons_ratios: vec![0.45, 0.35], stiffening: [0.0; 2] };
    Model { system, markers: vec![Spot { weights: vec![(end, 1.0)] }], nominal }
}
