//! Statics with constants of its own: against the whole body between the sets of constants that it was trained on, and against differences.

use std::sync::Arc;

use nalgebra::DVector;

use super::hollow;
use crate::adjoint::parameter::Parameter;
use crate::rom::{ReducedSolver, ReductionSettings, Snapshot};
use crate::{Equilibrium, RegionProperties, Solver, StaticSettings, System};

/// Young's modulus (Pa) and Poisson's ratio.
type Constants = (f64, f64);

const PRESSURES: [f64; 3] = [1e4, 2e4, 3e4];
const PARAMETERS: [Parameter; 2] = [Parameter::YoungsModulus(0), Parameter::PoissonsRatio(0)];

fn equilibrium(system: &System, (e, nu): Constants, pressure: f64) -> (Solver, Equilibrium) {
    let mut solver = system.solver();
    solver.set_elastic(0, e, nu).expect("constants in range");
    let found = solver.equilibrium(&[pressure], None, &StaticSettings::default()).expect("a moderate load");
    (solver, found)
}

/// A shape, the constants under which the body took it, and its changes by them.
type Taught = (Vec<f64>, Vec<RegionProperties>, Vec<Vec<f64>>);

/// Trained at two Poisson's ratios, with the derivatives by both constants.
fn trained(system: &System) -> ReducedSolver {
    let mut taught: Vec<Taught> = Vec::new();
    for nu in [0.42, 0.47] {
        for pressure in PRESSURES {
            let (mut solver, found) = equilibrium(system, (2e5, nu), pressure);
            let by = |(parameter, spread): (Parameter, f64)| -> Vec<f64> {
                let slope = solver.sensitivity(&found, parameter).expect("a stable equilibrium");
                slope.iter().map(|by| spread * by).collect()
            };
            let changes = PARAMETERS.into_iter().zip([2e4, 0.01]).map(by).collect();
            let mut regions = system.regions().to_vec();
            regions[0].poissons_ratio = nu;
            taught.push((found.displacement, regions, changes));
        }
    }
    let snapshots: Vec<Snapshot> =
        taught.iter().map(|(displacement, regions, changes)| Snapshot { displacement, regions, changes }).collect();
    let settings = ReductionSettings { coordinates: 14, tolerance: 1e-4, ..ReductionSettings::default() };
    let model = system.reduce_trained(&snapshots, &settings).expect("snapshots of this system");
    ReducedSolver::new(Arc::new(model), system.regions().to_vec())
}

fn solved(solver: &mut ReducedSolver, (e, nu): Constants, pressure: f64) -> crate::rom::ReducedEquilibrium {
    solver.set_elastic(0, e, nu).expect("constants in range");
    let rest = DVector::zeros(solver.model().coordinates());
    solver.equilibrium_near(&[pressure], &rest, &rest).expect("a moderate load")
}

#[test]
fn between_the_constants_that_trained_it_an_equilibrium_is_that_of_the_whole_body() {
    let system = hollow();
    let mut reduced = trained(&system);
    for (constants, pressure) in [((1.8e5, 0.445), 2.2e4), ((2.3e5, 0.46), 1.4e4)] {
        let whole = equilibrium(&system, constants, pressure).1.displacement;
        let found = solved(&mut reduced, constants, pressure).coordinates;
        let largest = whole.iter().fold(0.0, |most: f64, u| most.max(u.abs()));
        let reduced = reduced.model().displacement(&found);
        let worst = reduced.iter().zip(&whole).fold(0.0, |most: f64, (a, b)| most.max((a - b).abs())) / largest;
        assert!(worst < 5e-3, "{worst} of the largest displacement at {constants:?}");
    }
}

#[test]
fn sensitivities_are_differences_of_equilibria_and_their_work_is_the_adjoint_gradient() {
    let system = hollow();
    let mut reduced = trained(&system);
    let (constants, pressure) = ((1.9e5, 0.45), 2e4);
    let found = solved(&mut reduced, constants, pressure);
    let loss = DVector::from_fn(found.coordinates.len(), |mode, _| (1.0 + 1.7 * mode as f64).sin());
    let gradient = reduced.adjoint(&found, &loss, &PARAMETERS).expect("constants of the only region");
    for ((parameter, step), adjoint) in PARAMETERS.into_iter().zip([20.0, 1e-5]).zip(gradient) {
        let sensitivity = reduced.sensitivity(&found, parameter).expect("a constant of the only region");
        let moved = |by: f64| match parameter {
            Parameter::YoungsModulus(_) => (constants.0 + by, constants.1),
            _ => (constants.0, constants.1 + by),
        };
        let [high, low] = [step, -step].map(|by| solved(&mut reduced, moved(by), pressure).coordinates);
        let difference = (high - low) / (2.0 * step);
        reduced.set_elastic(0, constants.0, constants.1).expect("constants in range");
        assert!((&sensitivity - &difference).norm() < 1e-5 * difference.norm(), "{parameter:?}");
        assert!((sensitivity.dot(&loss) - adjoint).abs() < 1e-10 * adjoint.abs(), "{parameter:?}");
    }
}

#[test]
fn constants_out_of_range_and_parameters_that_it_does_not_have_are_refused() {
    let system = hollow();
    let mut reduced = trained(&system);
    assert!(reduced.set_elastic(1, 2e5, 0.4).is_err() && reduced.set_elastic(0, 2e5, 0.5).is_err());
    assert!(reduced.set_stiffening(1, [0.0; 2]).is_err());
    let found = solved(&mut reduced, (2e5, 0.45), 1e4);
    for parameter in [Parameter::Density(0), Parameter::YoungsModulus(1)] {
        assert!(reduced.sensitivity(&found, parameter).is_err());
    }
}
