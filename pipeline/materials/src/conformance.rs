//! Properties that every law must have, tested on each law of `ALL`.

use crate::material::{Material, Moduli};
use crate::{ALL, by_name};
use nalgebra::{Matrix3, Rotation3, SMatrix, Vector3};

const E: f64 = 2.3e5;
const NU: f64 = 0.42;
/// C₂₀ and C₃₀ over C₁₀.
const STIFFENING: [f64; 2] = [-0.06, 0.03];

fn moduli() -> Moduli {
    Moduli::of(E, NU).with_stiffening(STIFFENING)
}

/// Three states: a small strain, a large one, and a large one with a rotation; written out, so that they never change.
fn states() -> [Matrix3<f64>; 3] {
    let small = Matrix3::new(0.01, 0.02, -0.01, 0.0, -0.03, 0.02, 0.015, 0.01, 0.02);
    let large = Matrix3::new(0.3, 0.2, -0.1, 0.1, -0.25, 0.2, 0.15, 0.1, 0.2);
    let rotation = Rotation3::from_scaled_axis(Vector3::new(0.7, -0.4, 1.2)).into_inner();
    [Matrix3::identity() + small, Matrix3::identity() + large, rotation * (Matrix3::identity() + large.transpose())]
}

fn each(check: impl Fn(&dyn Material, Matrix3<f64>)) {
    for law in ALL {
        states().into_iter().for_each(|state| check(*law, state));
    }
}

/// Central difference of `value` along entry (i, j) of `at`; step 1e-6, so about 1e-9 relative for smooth laws.
fn difference<T>(at: Matrix3<f64>, i: usize, j: usize, value: impl Fn(&Matrix3<f64>) -> T) -> T
where
    T: std::ops::Sub<Output = T> + std::ops::Mul<f64, Output = T>,
{
    const H: f64 = 1e-6;
    let (mut above, mut below) = (at, at);
    above[(i, j)] += H;
    below[(i, j)] -= H;
    (value(&above) - value(&below)) * (0.5 / H)
}

#[test]
fn stress_is_the_gradient_of_energy_for_every_material() {
    let moduli = moduli();
    each(|law, at| {
        let stress = law.energy_and_stress(&at, moduli).1;
        for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
            let difference = difference(at, i, j, |x| law.energy_and_stress(x, moduli).0);
            assert!((stress[(i, j)] - difference).abs() < 1e-8 * E, "{}", law.name());
        }
    });
}

#[test]
fn stress_is_linear_in_all_moduli_for_every_material() {
    each(|law, at| {
        let parts = law.stress_by_moduli(&at).into_iter().zip(moduli().to_array());
        let sum: Matrix3<f64> = parts.map(|(by, modulus)| by * modulus).sum();
        assert!((law.energy_and_stress(&at, moduli()).1 - sum).norm() < 1e-12 * E, "{}", law.name());
    });
}

#[test]
fn only_the_laws_that_say_so_stiffen() {
    each(|law, at| {
        let differs = law.energy_and_stress(&at, moduli()) != law.energy_and_stress(&at, Moduli::of(E, NU));
        assert_eq!(differs, law.is_stiffening(), "{}", law.name());
    });
}

#[test]
fn tangent_is_the_gradient_of_stress_for_every_material() {
    let moduli = moduli();
    each(|law, at| {
        let tangent = law.constitutive_response(&at, moduli).tangent;
        for (k, l) in (0..3).flat_map(|k| (0..3).map(move |l| (k, l))) {
            let column = difference(at, k, l, |x| law.energy_and_stress(x, moduli).1);
            let difference = SMatrix::<f64, 9, 1>::from_column_slice(column.as_slice());
            assert!((tangent.column(k + 3 * l) - difference).norm() < 1e-7 * E, "{}", law.name());
        }
    });
}

#[test]
fn response_repeats_energy_and_stress_and_its_tangent_is_symmetric() {
    let moduli = moduli();
    each(|law, at| {
        let (energy, stress) = law.energy_and_stress(&at, moduli);
        let response = law.constitutive_response(&at, moduli);
        assert_eq!((energy, stress), (response.energy, response.stress), "{}", law.name());
        assert!((response.tangent - response.tangent.transpose()).norm() < 1e-11 * response.tangent.norm());
    });
}

#[test]
fn a_rigid_rotation_has_no_energy() {
    let moduli = moduli();
    for law in ALL {
        let angle = if law.is_objective() { 1.3 } else { 1e-5 };
        let rotation = Rotation3::from_scaled_axis(Vector3::new(0.6, -0.64, 0.48) * angle).into_inner();
        let (energy, stress) = law.energy_and_stress(&rotation, moduli);
        assert!(energy.abs() < 1e-12 * E, "{}: {energy}", law.name());
        assert!(stress.norm() < 1e-9 * E, "{}", law.name());
    }
}

#[test]
fn a_rotation_after_a_stretch_leaves_the_energy_and_rotates_the_stress() {
    let moduli = moduli();
    let rotation = Rotation3::from_scaled_axis(Vector3::new(0.2, 0.9, -1.4)).into_inner();
    for law in ALL.iter().filter(|law| law.is_objective()) {
        for at in states() {
            let (before, after) = (law.energy_and_stress(&at, moduli), law.energy_and_stress(&(rotation * at), moduli));
            assert!((before.0 - after.0).abs() < 1e-11 * E, "{}", law.name());
            assert!((rotation * before.1 - after.1).norm() < 1e-10 * E, "{}", law.name());
        }
    }
}

#[test]
fn every_material_is_linear_elasticity_at_rest() {
    let moduli = moduli();
    let expected = by_name("linear").unwrap().constitutive_response(&Matrix3::identity(), moduli).tangent;
    for law in ALL {
        let tangent = law.constitutive_response(&Matrix3::identity(), moduli).tangent;
        assert!((tangent - expected).norm() < 1e-9 * E, "{}", law.name());
    }
}

#[test]
fn stress_at_the_derivatives_of_lames_constants_is_the_derivative_by_both_elastic_constants() {
    each(|law, at| {
        let stress = |e, nu| law.energy_and_stress(&at, Moduli::of(e, nu)).1;
        let (step_e, step_nu) = (1e-4 * E, 1e-6);
        let by_e = (stress(E + step_e, NU) - stress(E - step_e, NU)) / (2.0 * step_e);
        let by_nu = (stress(E, NU + step_nu) - stress(E, NU - step_nu)) / (2.0 * step_nu);
        let exact_e = law.energy_and_stress(&at, Moduli::by_youngs_modulus(E, NU)).1;
        let exact_nu = law.energy_and_stress(&at, Moduli::by_poissons_ratio(E, NU)).1;
        assert!((by_e - exact_e).norm() < 1e-8 * (1.0 + exact_e.norm()), "{}", law.name());
        assert!((by_nu - exact_nu).norm() < 1e-7 * (E + exact_nu.norm()), "{}", law.name());
    });
}

#[test]
fn every_material_is_found_by_its_name() {
    assert!(ALL.iter().all(|law| by_name(law.name()).is_some_and(|found| found.name() == law.name())));
    assert!(by_name("steel").is_none());
}
