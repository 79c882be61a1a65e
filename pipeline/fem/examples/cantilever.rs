//! A bar of silicone under its own weight: its end against Timoshenko's beam, and the derivative by Young's modulus by the adjoint against a difference.

use fem::{Clamps, RegionProperties, StaticSettings, System, box_mesh, materials};

const LENGTH: f64 = 0.1;
const HEIGHT: f64 = 0.01;
const DENSITY: f64 = 1070.0;
const POISSON: f64 = 0.3;
const GRAVITY: f64 = 9.81;

/// Drop of the end (m), and its derivative by Young's modulus (m/Pa).
fn drop_of_end(youngs_modulus: f64) -> Result<[f64; 2], Box<dyn std::error::Error>> {
    let mesh = box_mesh::quadratic([LENGTH, HEIGHT, HEIGHT], [12, 2, 2]);
    let end =
        mesh.nodes.iter().position(|at| *at == [LENGTH, 0.5 * HEIGHT, 0.5 * HEIGHT]).ok_or("no node at the end")?;
    let clamps = Clamps::below_x(&mesh, 1e-9);
    let law = materials::by_name("neo_hookean").ok_or("no such law")?;
    let silicone = RegionProperties::elastic(law, youngs_modulus, POISSON, DENSITY);
    let system = System::new(mesh, vec![silicone], clamps)?;
    let mut solver = system.solver();
    solver.set_gravity([0.0, 0.0, -GRAVITY])?;
    let equilibrium = solver.equilibrium(&[], None, &StaticSettings::default())?;
    // L = −u_z of the end
    let mut loss_by_displacement = vec![0.0; equilibrium.displacement.len()];
    loss_by_displacement[3 * end + 2] = -1.0;
    let gradient = solver.adjoint(&equilibrium, &loss_by_displacement)?;
    Ok([-equilibrium.displacement[3 * end + 2], gradient[0].youngs_modulus])
}

/// # Errors
/// When the body cannot be solved.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let modulus = 5e6;
    let [drop, derivative] = drop_of_end(modulus)?;
    let load = DENSITY * GRAVITY * HEIGHT.powi(2);
    let bending = load * LENGTH.powi(4) / (8.0 * modulus * HEIGHT.powi(4) / 12.0);
    let shear = 0.5 * load * LENGTH.powi(2) * 2.0 * (1.0 + POISSON) / (5.0 / 6.0 * modulus * HEIGHT.powi(2));
    let difference = (drop_of_end(1.001 * modulus)?[0] - drop_of_end(0.999 * modulus)?[0]) / (0.002 * modulus);
    println!("drop {:.4} mm, beam {:.4} mm", 1e3 * drop, 1e3 * (bending + shear));
    println!("by Young's modulus {derivative:.6e} m/Pa, difference {difference:.6e}");
    // the clamp hinders the contraction across the bar, of which a beam knows nothing: two per cent
    assert!((drop / (bending + shear) - 1.0).abs() < 0.03 && (derivative / difference - 1.0).abs() < 1e-5);
    Ok(())
}
