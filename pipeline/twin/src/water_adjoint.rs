//! Adjoint of the water: derivatives of λ · (γ Π − force) + ζ · Π by q, by q̇ and by the water's two numbers.

use crate::lanes::{Lanes, add_reduced, gather, scatter, splat};
use crate::water::{Motion, Pair, Water};

/// The derivatives, r each.
pub(crate) struct WaterGradient {
    pub by_coordinates: Vec<f64>,
    pub by_velocity: Vec<f64>,
    /// By a factor of added mass and one of drag, at 1.
    pub by_factors: [f64; 2],
}

/// λ and ζ at the sections of a block: λ along displacement and along slope, ζ along displacement.
struct Adjoints {
    along: Pair,
    turned: Pair,
    momentum: Pair,
}

impl WaterGradient {
    /// Of no water.
    pub fn zero(r: usize) -> Self {
        Self { by_coordinates: vec![0.0; r], by_velocity: vec![0.0; r], by_factors: [0.0; 2] }
    }
}

impl Water {
    /// The derivatives at q and q̇, with the adjoints λ of the force and ζ of the momentum.
    pub(crate) fn adjoint(
        &self,
        (q, v): (&[f64], &[f64]),
        gamma: f64,
        [force, momentum]: [&[f64]; 2],
    ) -> WaterGradient {
        let mut sums = [vec![Lanes::ZERO; q.len()], vec![Lanes::ZERO; q.len()]];
        let mut by_factors = [Lanes::ZERO; 2];
        for block in 0..self.by.len() {
            let (slope, value) = (self.slope.block(block), self.value.block(block));
            let adjoints = Adjoints {
                along: gather(value, force),
                turned: gather(slope, force),
                momentum: gather(value, momentum),
            };
            let [by_tangent, by_velocity, factors] =
                self.section_motion(block, q, v).section_adjoint(&adjoints, &self.by[block], gamma);
            scatter(slope, &by_tangent, &mut sums[0]);
            scatter(value, &by_velocity, &mut sums[1]);
            (0..2).for_each(|k| by_factors[k] = by_factors[k] + factors[k]);
        }
        let [by_coordinates, by_velocity] = sums.map(|sums| {
            let mut reduced = vec![0.0; sums.len()];
            add_reduced(&sums, &mut reduced);
            reduced
        });
        WaterGradient { by_coordinates, by_velocity, by_factors: by_factors.map(Lanes::sum) }
    }
}

impl Motion {
    /// Derivatives by the tangent, the velocity and the two factors of φ = w e·n + c |w| w a·n + u w k·n − ½ w² k·t, a the adjoint along
    /// displacement, e = m (γ a + ζ), k = h (the adjoint along slope) − l a.
    #[inline(always)]
    fn section_adjoint(&self, adjoints: &Adjoints, [mass, drag, sheds, leaves]: &[Lanes; 4], gamma: f64) -> [Pair; 3] {
        let ([w, u], n, t, v) = (self.speeds(), self.normal(), self.tangent, self.velocity);
        let dot = |a: &Pair, b: &Pair| a[0] * b[0] + a[1] * b[1];
        let momentum_adjoint =
            [0, 1].map(|k: usize| *mass * (adjoints.momentum[k].plus(splat(gamma), adjoints.along[k])));
        let shed = [0, 1].map(|k: usize| *sheds * adjoints.turned[k] - *leaves * adjoints.along[k]);
        let (held_n, along_n, shed_n, shed_t) =
            (dot(&momentum_adjoint, &n), dot(&adjoints.along, &n), dot(&shed, &n), dot(&shed, &t));
        let resists = *drag * w.abs();
        let by_w = held_n + splat(2.0) * resists * along_n + u * shed_n - w * shed_t;
        let (by_u, half) = (w * shed_n, splat(0.5) * w * w);
        let by_n =
            [0, 1].map(|k: usize| w * (momentum_adjoint[k] + resists * adjoints.along[k] + u * shed[k]) + by_w * v[k]);
        // n = (−t_y, t_x)
        let turned = [by_n[1], Lanes::ZERO - by_n[0]];
        let by_t = [0, 1].map(|k: usize| by_u * v[k] - half * shed[k] + turned[k]);
        let by_v = [0, 1].map(|k: usize| by_w * n[k] + by_u * t[k]);
        [by_t, by_v, [w * held_n + u * w * shed_n - half * shed_t, resists * w * along_n]]
    }
}
