//! Forward sensitivity of histories: their derivatives by one parameter, forwards in time.

use crate::adjoint::parameter::Parameter;
use crate::properties::RegionProperties;
use crate::system_data::SystemData;
use crate::viscoelastic::history::{HistoryStep, Point, for_each_point};
use materials::step::RegionStep;
use materials::symmetric::{Symmetric, add_scaled, full_tensor};
use si::Pascal;

/// The derivatives of one region's numbers by a parameter.
#[derive(Debug, Clone, Default)]
pub(crate) struct Direction {
    region: usize,
    /// Of μ, Pa per unit.
    mu: Pascal,
    /// Of g and τ of each branch.
    branches: Vec<[f64; 2]>,
}

impl Direction {
    /// Of `parameter`; none when it is not one of a material.
    pub fn of(parameter: Parameter, properties: &[RegionProperties]) -> Option<Self> {
        let none = |region: usize| vec![[0.0; 2]; properties[region].relaxation.branches().len()];
        let only = |region: usize, branch: usize, which: usize| {
            let mut branches = none(region);
            branches[branch][which] = 1.0;
            Self { region, branches, ..Self::default() }
        };
        let springpot = |region: usize, which: usize| {
            let springpot_rates = properties[region].relaxation.springpot_direction(which);
            Self { region, branches: springpot_rates.into_iter().map(|g| [g, 0.0]).collect(), ..Self::default() }
        };
        let elastic = |region: usize, mu: Pascal| Self { region, mu, branches: none(region) };
        Some(match parameter {
            Parameter::YoungsModulus(region) => elastic(region, properties[region].moduli_by_youngs_modulus().mu),
            Parameter::PoissonsRatio(region) => elastic(region, properties[region].moduli_by_poissons_ratio().mu),
            Parameter::RelaxationStrength { region, branch } => only(region, branch, 0),
            Parameter::RelaxationTime { region, branch } => only(region, branch, 1),
            Parameter::SpringpotStrength(region) => springpot(region, 0),
            Parameter::SpringpotExponent(region) => springpot(region, 1),
            _ => return None,
        })
    }

    /// (∂d, ∂a) of a branch.
    fn branch_factors(&self, point: &Point, region: &RegionStep, branch: usize) -> [f64; 2] {
        if point.region != self.region {
            return [0.0; 2];
        }
        let ([strength, time], step) = (self.branches[branch], &region.branches[branch]);
        let [decay, gain] = step.by_time();
        [time * decay, time * gain + strength * step.gain_by_strength()]
    }

    fn mu_at(&self, point: &Point) -> Pascal {
        if point.region == self.region { self.mu } else { 0.0 }
    }
}

/// The derivative of a history, point by point as there.
#[derive(Debug, Clone)]
pub(crate) struct HistorySensitivity {
    tensors: Vec<Symmetric>,
}

impl HistorySensitivity {
    /// Of a body that has been held at `u` for ever, whose derivative is `du`.
    pub(crate) fn relaxed(data: &SystemData, regions: &[RegionStep], (u, du): (&[f64], &[f64])) -> Self {
        let mut tensors = Vec::new();
        for_each_point(data, regions, |point, region| {
            let gradient = point.deformation(u);
            let change = point.displacement_gradient(du);
            tensors.push(region.stress_change(&gradient, &change));
            tensors.extend(region.branches.iter().map(|_| [0.0; 6]));
        });
        Self { tensors }
    }

    /// Adds the derivative of the branches' force at constant displacement to `derivative` (3 entries per node).
    pub(crate) fn add_residual(&self, step: &HistoryStep, direction: Option<&Direction>, derivative: &mut [f64]) {
        for_each_point(step.data, step.regions, |point, region| {
            let (before, now) = (step.before.of_point(point), step.now.of_point(point));
            let gradient = point.deformation(step.displacement);
            let mut held_stress = region.held_stress(&self.tensors[point.own.clone()]);
            for (branch, direction) in
                (0..region.branches.len()).flat_map(|branch| direction.map(|direction| (branch, direction)))
            {
                direction.add_factor(point, (region, branch), (before, now), &mut held_stress);
            }
            held_stress.iter_mut().for_each(|entry| *entry *= region.mu);
            let mu = direction.map_or(0.0, |direction| direction.mu_at(point));
            now[1..].iter().for_each(|overstress| add_scaled(&mut held_stress, mu, overstress));
            point.add_force(&(gradient * full_tensor(&held_stress)), point.weight, derivative);
        });
    }

    /// Advances by one step, at whose end the displacement has the derivative `du`.
    pub(crate) fn advance(&mut self, step: &HistoryStep, du: &[f64], direction: Option<&Direction>) {
        for_each_point(step.data, step.regions, |point, region| {
            let (before, now) = (step.before.of_point(point), step.now.of_point(point));
            let gradient = point.deformation(step.displacement);
            let change = point.displacement_gradient(du);
            let point_tensors = &mut self.tensors[point.own.clone()];
            region.advance_history(point_tensors, region.stress_change(&gradient, &change));
            for (number, overstress) in point_tensors[1..].iter_mut().enumerate() {
                direction
                    .iter()
                    .for_each(|direction| direction.add_factor(point, (region, number), (before, now), overstress));
            }
        });
    }
}

impl Direction {
    /// Adds ∂d q + ∂a Δs of one branch.
    fn add_factor(
        &self,
        point: &Point,
        (region, branch): (&RegionStep, usize),
        (before, now): (&[Symmetric], &[Symmetric]),
        sum: &mut Symmetric,
    ) {
        let [decay, gain] = self.branch_factors(point, region, branch);
        add_scaled(sum, decay, &before[1 + branch]);
        add_scaled(sum, gain, &now[0]);
        add_scaled(sum, -gain, &before[0]);
    }
}
