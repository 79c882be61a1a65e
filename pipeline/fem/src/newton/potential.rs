//! The potential that a body minimises: elastic energy less the work of the loads, in dynamics with inertia.
//!
//! Π(u) = Ψ(u) − Σ p_c V_c(u) − t f · u + W(u) + ½ c (u − û)ᵀ M (u − û) + h · u
//!
//! with the potential W of self-contact. An implicit time step minimises such an incremental potential with its own c, û, h and moduli; in statics c = 0 and
//! h = 0.

use crate::assembly::elastic::{Body, Elastic};
use crate::assembly::mass::Mass;
use crate::loads::gas::Gas;
use crate::loads::{DeadForces, Load};
use crate::system_data::SystemData;
use materials::symmetric::Symmetric;
use materials::tangent::TangentKind;
use si::Pascal;
use sparse::dot;

/// Inertial and history terms of one time step.
#[derive(Debug, Clone, Default)]
pub(crate) struct Inertia {
    /// c, 1/s².
    pub rate: f64,
    /// û, the displacement without forces; in elimination order, m.
    pub centre: Vec<f64>,
    /// h, 3 entries per node, N.
    pub history: Vec<f64>,
}

/// Which second derivative of Π is assembled.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum HessianKind {
    /// All of it.
    Exact,
    /// All of it, with the mixed-integration-point tangent of the elastic part.
    MixedPoint,
    /// The tangent with the stress of the previous displacement.
    FormerStress,
    /// The positive semi-definite part of the elastic tangent at each quadrature point.
    ConvexElastic,
    /// The same without the follower part of pressure: always positive definite.
    Convex,
}

/// Π with all its parameters.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Potential<'a> {
    pub data: &'a SystemData,
    pub elastic: &'a [Elastic],
    /// Factor of the moduli of each element; empty: 1.
    pub factors: &'a [f64],
    /// H of every quadrature point, Pa (see `viscoelastic`); empty: none.
    pub held: &'a [Symmetric],
    pub mass: &'a Mass,
    /// p, one per chamber, Pa.
    pub pressures: &'a [Pascal],
    /// One per chamber: ambient pressure where it is sealed, Pa.
    pub ambient: &'a [Option<Pascal>],
    pub dead: &'a DeadForces,
    /// t, also of H
    pub load_factor: f64,
    pub inertia: Option<&'a Inertia>,
}

/// Π and the sum of the absolute values of its terms: differences below 1e-13 of that sum are rounding.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Energy {
    pub value: f64,
    pub size: f64,
}

impl<'a> Potential<'a> {
    /// The incremental potential of one time step, from the static one.
    pub(crate) fn in_motion(self, inertia: &'a Inertia) -> Self {
        Self { inertia: Some(inertia), ..self }
    }
}

impl Potential<'_> {
    /// Π at `u` (3 entries per node, m), J; `gradient` becomes ∂Π/∂u, 3 entries per node, N.
    pub fn energy(&self, u: &[f64], gradient: &mut [f64]) -> Energy {
        gradient.fill(0.0);
        let elastic = self.body().energy(u, gradient);
        let mut energy = Energy { value: elastic, size: elastic.abs() + self.rounding_size() };
        let mut add = |part: f64| energy = Energy { value: energy.value + part, size: energy.size + part.abs() };
        for gas in self.gases() {
            let part = gas.potential(u);
            add(part);
            if part.is_finite() {
                gas.add_gradient(u, gradient);
            }
        }
        add(self.load_factor * self.dead.potential(u));
        self.dead.add_gradient(u, self.load_factor, gradient);
        if let Some(contact) = &self.data.contact {
            add(contact.add_energy(u, 1.0, gradient));
        }
        if let Some(inertia) = self.inertia {
            self.add_inertia(inertia, u, gradient).into_iter().for_each(add);
        }
        energy
    }

    /// Rounding of the elastic energy, for `Energy::size`: laws that subtract the value at rest (F : F − 3) leave an
    /// error of 1e-15 of moduli times volume, however small the strain.
    fn rounding_size(&self) -> f64 {
        let each = self.elastic.iter().zip(&self.data.volumes);
        // Times the 1e-13 at which the line search takes differences for rounding, this is 1e-15 of moduli and volume.
        1e-2 * each.map(|(is, volume)| volume * (is.moduli.mu + is.moduli.lambda.abs())).sum::<f64>()
    }

    fn add_inertia(&self, inertia: &Inertia, u: &[f64], gradient: &mut [f64]) -> [f64; 2] {
        let pattern = &self.data.pattern;
        let mut away = pattern.gather(u);
        away.iter_mut().zip(&inertia.centre).for_each(|(at, centre)| *at -= centre);
        let mut force = vec![0.0; away.len()];
        self.mass.multiply(pattern, &away, &mut force);
        pattern.scatter(&force, inertia.rate, gradient);
        let kinetic = 0.5 * inertia.rate * dot(&away, &force);
        if inertia.history.is_empty() {
            return [kinetic, 0.0];
        }
        gradient.iter_mut().zip(&inertia.history).for_each(|(entry, force)| *entry += force);
        [kinetic, dot(&inertia.history, u)]
    }

    /// ∂²Π/∂u² at `u` without rank-one terms, lower triangle, N/m.
    /// `previous`: where the last step began, for [`HessianKind::MixedPoint`] and [`HessianKind::FormerStress`].
    pub(crate) fn hessian(&self, u: &[f64], previous: &[f64], kind: HessianKind, values: &mut [f64]) {
        values.fill(0.0);
        let tangent = match kind {
            HessianKind::Exact => TangentKind::Exact,
            HessianKind::MixedPoint => TangentKind::MixedPoint(previous),
            HessianKind::FormerStress => TangentKind::FormerStress(previous),
            HessianKind::ConvexElastic | HessianKind::Convex => TangentKind::Convex,
        };
        self.body().stiffness(u, tangent, values);
        if kind != HessianKind::Convex {
            self.add_gases(u, values);
        }
        self.add_mass(values);
        self.add_contact(u, matches!(kind, HessianKind::Convex | HessianKind::ConvexElastic), values);
    }

    /// The elastic part of ∂²Π/∂u² alone.
    pub(crate) fn elastic_stiffness(&self, u: &[f64], values: &mut [f64]) {
        values.fill(0.0);
        self.body().stiffness(u, TangentKind::Exact, values);
    }

    /// Adds all but the elastic part of ∂²Π/∂u².
    pub(crate) fn add_inertia_and_loads(&self, u: &[f64], values: &mut [f64]) {
        self.add_mass(values);
        self.add_gases(u, values);
        self.add_contact(u, false, values);
    }

    fn add_gases(&self, u: &[f64], values: &mut [f64]) {
        let pattern = &self.data.pattern;
        for gas in self.gases() {
            gas.add_hessian(u, &mut |a, b, block| {
                let position = pattern.block_position(a, b).expect("chamber faces lie on elements");
                pattern.add(values, position, (a, b), block);
            });
        }
    }

    /// `convex`: of the contact's second derivative its convex part alone.
    // Newton's method may bring walls together that were not expected to meet. Their nodes are then not coupled: the direction is still one of
    // descent, and the solve ends with the couplings that it found.
    fn add_contact(&self, u: &[f64], convex: bool, values: &mut [f64]) {
        let Some(contact) = &self.data.contact else { return };
        let pattern = &self.data.pattern;
        let coupled = |a: u32, b: u32| pattern.block_position(a, b).is_some();
        contact.add_stiffness(u, (1.0, convex), &coupled, &mut |a, b, block| {
            let position = pattern.block_position(a, b).expect("blocks of uncoupled faces are their own");
            pattern.add(values, position, (a, b), block);
        });
    }

    /// The largest part of `step` (3 entries per node, m) from `u`, at most 1, by which no wall passes through another.
    pub(crate) fn admissible_part(&self, u: &[f64], step: &[f64]) -> f64 {
        self.data.contact.as_ref().map_or(1.0, |contact| contact.admissible_part(u, step))
    }

    fn add_mass(&self, values: &mut [f64]) {
        if let Some(inertia) = self.inertia {
            self.mass.add_to(inertia.rate, values);
        }
    }

    /// The gas in each chamber; open chambers without pressure are left out.
    pub(crate) fn gases(&self) -> impl Iterator<Item = Gas<'_>> {
        let each = self.data.chambers.iter().zip(self.pressures).zip(self.ambient);
        each.map(|((chamber, &pressure), &ambient)| Gas { chamber, pressure, ambient }).filter(|gas| !gas.is_idle())
    }

    /// The part that `hessian` leaves out: c and v (in elimination order) of each rank-one term c v vᵀ.
    pub(crate) fn rank_one_terms(&self, u: &[f64]) -> Vec<(f64, Vec<f64>)> {
        let terms = self.gases().filter_map(|gas| gas.rank_one_term(u));
        terms.map(|(c, gradient)| (c, self.data.pattern.gather(&gradient))).collect()
    }

    /// The domain of assembly.
    pub(crate) fn body(&self) -> Body<'_> {
        let (factors, held, held_factor) = (self.factors, self.held, self.load_factor);
        Body { factors, held, held_factor, ..self.data.body(self.elastic) }
    }
}
