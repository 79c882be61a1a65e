//! The potential that a body minimises: at rest its elastic energy less the work of loads, in motion with inertia too.
//!
//! Π(u) = s Ψ(u) − Σ p_c V_c(u) − t f · u + ½ c (u − û)ᵀ M (u − û) + h · u
//!
//! An implicit time step is such a minimum with its own s, c, û and h (see `dynamics`); in statics s = 1, c = 0, h = 0.
//!
//! Stands on: `assembly`, `loads`, `mass`. Never knows: how the minimum is found.

use crate::algebra::vectors::dot;
use crate::body::assembly::Elastic;
use crate::body::bend::Bend;
use crate::body::mass::Mass;
use crate::gas::Gas;
use crate::load::Load;
use crate::loads::DeadForces;
use crate::parts::Parts;
use si::Pascal;

/// Inertia and history of one time step.
#[derive(Debug, Clone, Default)]
pub(crate) struct Inertia {
    /// c, 1/s².
    pub rate: f64,
    /// û, where the body would be without forces; in elimination order, m.
    pub centre: Vec<f64>,
    /// h, 3 a node, N.
    pub history: Vec<f64>,
}

/// How much of the second derivative is kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Curvature {
    /// All of it: Newton's method.
    Exact,
    /// All of it, at the stress that the linear step from another displacement foresees.
    Foreseen,
    /// The elastic part without negative eigenvalues at any point.
    ConvexElastic,
    /// The same without the follower part of pressure: positive definite always.
    Convex,
}

/// Π, ready to be evaluated.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Potential<'a> {
    pub parts: &'a Parts,
    pub elastic: &'a [Elastic],
    pub mass: &'a Mass,
    /// s
    pub stiffening: f64,
    /// p, one a chamber, Pa.
    pub pressures: &'a [Pascal],
    /// One a chamber: ambient pressure where it is sealed, Pa.
    pub ambient: &'a [Option<Pascal>],
    pub dead: &'a DeadForces,
    /// t
    pub dead_strength: f64,
    pub inertia: Option<&'a Inertia>,
}

/// Π and the size of its parts: differences below 1e-13 of that size are rounding.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Energy {
    pub value: f64,
    pub size: f64,
}

impl Potential<'_> {
    /// Π at `u` (3 a node, m), J; `gradient` becomes ∂Π/∂u, 3 a node, N.
    pub fn energy(&self, u: &[f64], gradient: &mut [f64]) -> Energy {
        gradient.fill(0.0);
        let elastic = self.stiffening * self.parts.body().energy(self.elastic, u, self.stiffening, gradient);
        let mut energy = Energy { value: elastic, size: elastic.abs() + self.rounding() };
        let mut add = |part: f64| energy = Energy { value: energy.value + part, size: energy.size + part.abs() };
        for gas in self.gases() {
            let part = gas.potential(u);
            add(part);
            if part.is_finite() {
                gas.add_gradient(u, gradient);
            }
        }
        add(self.dead_strength * self.dead.potential(u));
        self.dead.add_gradient(u, self.dead_strength, gradient);
        if let Some(inertia) = self.inertia {
            self.add_inertia(inertia, u, gradient).into_iter().for_each(add);
        }
        energy
    }

    /// What the elastic energy adds to the size: laws that subtract what a body at rest has (F : F − 3) leave rounding of
    /// 1e-15 of its moduli times volume, however small the strain.
    fn rounding(&self) -> f64 {
        let each = self.elastic.iter().zip(&self.parts.volumes);
        1e-2 * self.stiffening * each.map(|(is, volume)| volume * (is.lame.mu + is.lame.lambda.abs())).sum::<f64>()
    }

    fn add_inertia(&self, inertia: &Inertia, u: &[f64], gradient: &mut [f64]) -> [f64; 2] {
        let pattern = &self.parts.pattern;
        let mut away = Vec::new();
        pattern.gather(u, &mut away);
        away.iter_mut().zip(&inertia.centre).for_each(|(at, centre)| *at -= centre);
        let mut push = vec![0.0; away.len()];
        self.mass.multiply(pattern, &away, &mut push);
        pattern.spread(&push, inertia.rate, gradient);
        let kinetic = 0.5 * inertia.rate * dot(&away, &push);
        if inertia.history.is_empty() {
            return [kinetic, 0.0];
        }
        gradient.iter_mut().zip(&inertia.history).for_each(|(entry, force)| *entry += force);
        [kinetic, dot(&inertia.history, u)]
    }

    /// ∂²Π/∂u² at `u` but for full blocks, lower triangle, N/m.
    /// `before`: where the last step began, for [`Curvature::Foreseen`].
    pub fn curvature(&self, u: &[f64], before: &[f64], kept: Curvature, values: &mut [f64]) {
        values.fill(0.0);
        let bend = match kept {
            Curvature::Exact => Bend::Straight,
            Curvature::Foreseen => Bend::Foreseen(before),
            Curvature::ConvexElastic | Curvature::Convex => Bend::Convex,
        };
        self.parts.body().stiffness(self.elastic, u, self.stiffening, bend, values);
        if kept == Curvature::Convex {
            self.add_mass(values);
        } else {
            self.add_other_curvature(u, values);
        }
    }

    /// s times the elastic part of ∂²Π/∂u² alone.
    pub fn stiffness(&self, u: &[f64], values: &mut [f64]) {
        values.fill(0.0);
        self.parts.body().stiffness(self.elastic, u, self.stiffening, Bend::Straight, values);
    }

    /// Adds all but the elastic part of ∂²Π/∂u².
    pub fn add_other_curvature(&self, u: &[f64], values: &mut [f64]) {
        self.add_mass(values);
        let pattern = &self.parts.pattern;
        for gas in self.gases() {
            gas.add_hessian(u, &mut |a, b, block| {
                let place = pattern.place(a, b).expect("chamber faces were found on elements");
                pattern.add(values, place, (a, b), block);
            });
        }
    }

    fn add_mass(&self, values: &mut [f64]) {
        if let Some(inertia) = self.inertia {
            self.mass.add_to(inertia.rate, values);
        }
    }

    /// What fills each chamber, idle ones left out.
    pub fn gases(&self) -> impl Iterator<Item = Gas<'_>> {
        let each = self.parts.chambers.iter().zip(self.pressures).zip(self.ambient);
        each.map(|((chamber, &pressure), &ambient)| Gas { chamber, pressure, ambient }).filter(|gas| !gas.is_idle())
    }

    /// What `curvature` leaves out: c and v (in elimination order) of each full block c v vᵀ.
    pub fn full_blocks(&self, u: &[f64]) -> Vec<(f64, Vec<f64>)> {
        let free = |slope: &[f64]| {
            let mut free = Vec::new();
            self.parts.pattern.gather(slope, &mut free);
            free
        };
        self.gases().filter_map(|gas| gas.full_block(u)).map(|(c, slope)| (c, free(&slope))).collect()
    }
}
