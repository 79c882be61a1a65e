//! One quadrature point on prescribed paths: harmonic shear, closed cycles, rotation.

use crate::by_name;
use crate::material::Moduli;
use crate::relaxation::{Relaxation, Springpot};
use crate::step::RegionStep;
use crate::symmetric::{Symmetric, add_scaled, full_tensor};
use nalgebra::{Matrix3, Rotation3, Vector3};
use std::f64::consts::TAU;

fn springpot() -> Relaxation {
    Relaxation::springpot(Springpot { strength: 0.06, exponent: 0.27, decades: [-3, 1] }).unwrap()
}

/// P at the end of each deformation gradient, `step` s apart, from a relaxed start at the first; μ = 1.
fn stresses(law: &str, path: &[Matrix3<f64>], step: f64) -> Vec<Matrix3<f64>> {
    let moduli = Moduli { mu: 1.0, lambda: 5.0, stiffening: [-0.04, 0.02] };
    let region = RegionStep::new(by_name(law).unwrap(), moduli, &springpot(), step);
    let mut history: Vec<Symmetric> = vec![region.stress(&path[0])];
    history.extend(region.branches.iter().map(|_| [0.0; 6]));
    let stress = |gradient: &Matrix3<f64>| {
        region.advance_history(&mut history, region.stress(gradient));
        let mut overstress = [0.0; 6];
        history[1..].iter().for_each(|branch| add_scaled(&mut overstress, 1.0, branch));
        region.material.energy_and_stress(gradient, moduli).1 + gradient * full_tensor(&overstress)
    };
    path.iter().map(stress).collect()
}

fn shear(amount: f64) -> Matrix3<f64> {
    let mut gradient = Matrix3::identity();
    gradient[(0, 1)] = amount;
    gradient
}

fn relaxing_laws() -> impl Iterator<Item = &'static str> {
    crate::ALL.iter().filter(|law| law.is_objective()).map(|law| law.name())
}

#[test]
fn harmonic_shear_meets_the_storage_and_loss_modulus_of_the_spectrum() {
    const STEPS: usize = 200;
    for law in relaxing_laws() {
        for frequency in [0.1_f64, 1.0, 7.7, 20.0] {
            // Ten time constants of the slowest branch, at least three cycles.
            let cycles = (100.0 * frequency).ceil().max(3.0) as usize;
            let strain = |n: usize| 1e-5 * (TAU * n as f64 / STEPS as f64).sin();
            let path: Vec<_> = (0..=cycles * STEPS).map(|n| shear(strain(n))).collect();
            let path_stresses = stresses(law, &path, 1.0 / frequency / STEPS as f64);
            let last = (cycles - 1) * STEPS + 1..=cycles * STEPS;
            let part = |phase: fn(f64) -> f64| -> f64 {
                let weighted = |n: usize| path_stresses[n][(0, 1)] / 1e-5 * phase(TAU * n as f64 / STEPS as f64);
                last.clone().map(weighted).sum::<f64>() / (0.5 * STEPS as f64)
            };
            let [storage, loss] = springpot().complex_modulus(TAU * frequency);
            assert!((part(f64::sin) / storage - 1.0).abs() < 0.005, "{law} {frequency}");
            assert!((part(f64::cos) / loss - 1.0).abs() < 0.005, "{law} {frequency}");
        }
    }
}

#[test]
fn a_step_of_strain_relaxes_as_the_spectrum_says() {
    for law in relaxing_laws() {
        let step = 1e-3;
        let path: Vec<_> = (0..4000).map(|n| shear(if n == 0 { 0.0 } else { 1e-5 })).collect();
        for (n, stress) in stresses(law, &path, step).iter().enumerate().skip(20) {
            let exact = springpot().modulus((n as f64 - 0.5) * step);
            assert!((stress[(0, 1)] / 1e-5 / exact - 1.0).abs() < 0.005, "{law} {n}");
        }
    }
}

/// Work done over closed cycles of large strain from a relaxed start is never negative.
#[test]
fn no_closed_cycle_gives_energy() {
    for law in relaxing_laws() {
        for cycle in 0..12 {
            let c = f64::from(cycle);
            let direction = Matrix3::from_fn(|i, k| (1.3 * c + 2.1 * i as f64 + 0.7 * k as f64).sin() * 0.25);
            let second_direction = Matrix3::from_fn(|i, k| (0.4 * c + 0.9 * i as f64 - 1.7 * k as f64).cos() * 0.25);
            let gradient_at = |t: f64| {
                Matrix3::identity()
                    + direction * (TAU * t).sin()
                    + second_direction * (0.5 - 0.5 * (2.0 * TAU * t).cos())
            };
            let path: Vec<_> = (0..=3000).map(|n| gradient_at(f64::from(n) / 1000.0)).collect();
            let path_stresses = stresses(law, &path, 1e-3 * 10f64.powi(cycle % 4 - 2));
            let work: f64 = (1..path.len())
                .map(|n| {
                    let mean = (path_stresses[n] + path_stresses[n - 1]) * 0.5;
                    mean.dot(&(path[n] - path[n - 1]))
                })
                .sum();
            assert!(work > 0.0, "{law}, cycle {cycle}: {work}");
        }
    }
}

#[test]
fn a_rotation_during_relaxation_rotates_the_stress_alone() {
    let rotation =
        |n: usize| Rotation3::from_scaled_axis(Vector3::new(0.3, -0.2, 0.5) * (0.05 * n as f64)).into_inner();
    for law in relaxing_laws() {
        let path: Vec<_> = (0..60).map(|n| shear(0.4 * (0.2 * n as f64).sin())).collect();
        let rotated: Vec<_> = path.iter().enumerate().map(|(n, gradient)| rotation(n) * gradient).collect();
        let (alone, turned) = (stresses(law, &path, 0.02), stresses(law, &rotated, 0.02));
        for n in 0..60 {
            assert!((rotation(n) * alone[n] - turned[n]).norm() < 1e-10, "{law}");
        }
    }
}
