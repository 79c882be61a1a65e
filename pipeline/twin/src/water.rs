//! Still water around the tail: sections of slender-body theory, eight side by side [lighthill1971], [taylor1952].
//!
//! The rate of the water's momentum is the stencil's: d/dt Π = γ Π + Σ w Π_past, all in generalised coordinates.

use crate::data::Section;
use crate::lanes::{Blocks, LANES, Lanes, add_reduced, gather, per_lane, scatter, splat};

/// Sections laid out for vectors.
#[derive(Debug, Clone)]
pub struct Water {
    pub(crate) slope: Blocks<2>,
    pub(crate) value: Blocks<2>,
    /// m, c, h, l of each block.
    pub(crate) by: Vec<[Lanes; 4]>,
}

/// Sums over sections in lanes, kept from one evaluation to the next.
#[derive(Debug, Clone)]
pub(crate) struct WaterSums {
    forces: Vec<Lanes>,
    momentum: Vec<Lanes>,
    stiffness: Vec<Lanes>,
}

impl WaterSums {
    /// Of `r` coordinates.
    pub(crate) fn new(r: usize) -> Self {
        let zeros = |count: usize| vec![Lanes::ZERO; count];
        Self { forces: zeros(r), momentum: zeros(r), stiffness: zeros(r * r) }
    }
}

/// A pair of lanes: x and y.
pub(crate) type Pair = [Lanes; 2];

/// Tangent and velocity of sections.
pub(crate) struct Motion {
    pub tangent: Pair,
    pub velocity: Pair,
}

impl Water {
    /// Of sections of `r` coordinates.
    pub fn new(sections: &[Section], r: usize) -> Self {
        let count = sections.len();
        let slope = Blocks::new(count, r, |section, m, k| sections[section].slope[k * r + m]);
        let value = Blocks::new(count, r, |section, m, k| sections[section].value[k * r + m]);
        let constant = |section: usize, k: usize| sections.get(section).map_or(0.0, |section| section.by[k]);
        let coefficients = |block: usize| std::array::from_fn(|k| per_lane(|i| constant(LANES * block + i, k)));
        Self { by: (0..slope.block_count()).map(coefficients).collect(), slope, value }
    }

    pub(crate) fn section_motion(&self, block: usize, q: &[f64], v: &[f64]) -> Motion {
        let mut tangent = gather(self.slope.block(block), q);
        tangent[0] = tangent[0] + splat(1.0);
        Motion { tangent, velocity: gather(self.value.block(block), v) }
    }

    /// Adds γ Π less the force (J), and fills Π (J s).
    pub(crate) fn add_forces(
        &self,
        (q, v, gamma): (&[f64], &[f64], f64),
        sums: &mut WaterSums,
        (forces, momentum): (&mut [f64], &mut [f64]),
    ) {
        sums.forces.fill(Lanes::ZERO);
        sums.momentum.fill(Lanes::ZERO);
        for (block, [mass, drag, sheds, leaves]) in self.by.iter().enumerate() {
            let motion = self.section_motion(block, q, v);
            let ([w, _], normal, flux) = (motion.speeds(), motion.normal(), motion.momentum_flux());
            let normal_momentum = *mass * w;
            let resists = splat(gamma) * normal_momentum + *drag * w.abs() * w;
            let push = [0, 1].map(|k| resists * normal[k] - *leaves * flux[k]);
            scatter(self.value.block(block), &push, &mut sums.forces);
            scatter(self.slope.block(block), &flux.map(|flux| *sheds * flux), &mut sums.forces);
            scatter(self.value.block(block), &normal.map(|normal| normal_momentum * normal), &mut sums.momentum);
        }
        momentum.fill(0.0);
        add_reduced(&sums.forces, forces);
        add_reduced(&sums.momentum, momentum);
    }

    /// Adds the derivative of the same by q, where q̇ follows q by γ.
    pub(crate) fn add_stiffness(
        &self,
        (q, v, gamma): (&[f64], &[f64], f64),
        sums: &mut WaterSums,
        stiffness: &mut [f64],
    ) {
        let r = q.len();
        sums.stiffness.fill(Lanes::ZERO);
        for (block, by) in self.by.iter().enumerate() {
            let motion = self.section_motion(block, q, v);
            let (slope, value) = (self.slope.block(block), self.value.block(block));
            for (m, sums) in sums.stiffness.chunks_exact_mut(r).enumerate() {
                let change = Motion { tangent: slope[m], velocity: value[m].map(|speed| splat(gamma) * speed) };
                let [push, turn] = motion.force_change(&change, by, gamma);
                scatter(value, &push, sums);
                scatter(slope, &turn, sums);
            }
        }
        for (entry, lanes) in sums.stiffness.iter().enumerate() {
            stiffness[entry % r * r + entry / r] += lanes.sum();
        }
    }
}

impl Motion {
    /// n
    pub fn normal(&self) -> Pair {
        [splat(0.0) - self.tangent[1], self.tangent[0]]
    }

    /// w and u.
    pub fn speeds(&self) -> [Lanes; 2] {
        let (Self { tangent: [tx, ty], velocity: [vx, vy] }, dot) = (self, |a, b, c, d| a * b + c * d);
        [*vy * *tx - *vx * *ty, dot(*vx, *tx, *vy, *ty)]
    }

    /// u w n − ½ w² t.
    fn momentum_flux(&self) -> Pair {
        let ([w, u], normal) = (self.speeds(), self.normal());
        [0, 1].map(|k| w * (u * normal[k] - splat(0.5) * w * self.tangent[k]))
    }

    /// Changes of what acts along displacement and along slope.
    #[inline(always)]
    fn force_change(&self, direction: &Motion, [mass, drag, sheds, leaves]: &[Lanes; 4], gamma: f64) -> [Pair; 2] {
        let ([w, u], normal, turned) = (self.speeds(), self.normal(), direction.normal());
        let ([tx, ty], [vx, vy], [dtx, dty], [dvx, dvy]) =
            (self.tangent, self.velocity, direction.tangent, direction.velocity);
        let dw = dvy * tx + vy * dtx - dvx * ty - vx * dty;
        let du = dvx * tx + vx * dtx + dvy * ty + vy * dty;
        let inertia_rate = splat(gamma) * *mass;
        let resists = (inertia_rate + *drag * w.abs()) * w;
        let more = (inertia_rate + splat(2.0) * *drag * w.abs()) * dw;
        let flux = [0, 1].map(|k: usize| {
            (du * w + u * dw) * normal[k] + u * w * turned[k]
                - w * dw * self.tangent[k]
                - splat(0.5) * w * w * direction.tangent[k]
        });
        let push = [0, 1].map(|k: usize| more * normal[k] + resists * turned[k] - *leaves * flux[k]);
        [push, flux.map(|flux| *sheds * flux)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const R: usize = 3;

    fn water() -> Water {
        let wave = |by: f64| (0..2 * R).map(|k| 0.3 * (by + 1.7 * k as f64).sin()).collect::<Vec<f64>>();
        let section = |n: usize| Section {
            slope: wave(n as f64),
            value: wave(0.4 * n as f64 + 2.0),
            by: [2.0, 5.0, 1.5, if n == 8 { 3.0 } else { 0.0 }],
        };
        Water::new(&(0..10).map(section).collect::<Vec<_>>(), R)
    }

    #[test]
    fn its_stiffness_is_the_derivative_of_its_forces() {
        let (water, gamma) = (water(), 40.0);
        let (q, v) = ([0.2, -0.5, 0.3], [1.0, -2.0, 4.0]);
        let forces = |along: usize, by: f64| {
            let (mut q, mut v) = (q, v);
            (q[along], v[along]) = (q[along] + by, v[along] + gamma * by);
            let (mut forces, mut momentum) = ([0.0; R], [0.0; R]);
            water.add_forces((&q, &v, gamma), &mut WaterSums::new(R), (&mut forces, &mut momentum));
            forces
        };
        let mut stiffness = [0.0; R * R];
        water.add_stiffness((&q, &v, gamma), &mut WaterSums::new(R), &mut stiffness);
        let h = 1e-6;
        for along in 0..R {
            let (above, below) = (forces(along, h), forces(along, -h));
            for n in 0..R {
                let difference = (above[n] - below[n]) / (2.0 * h);
                assert!(
                    (stiffness[n * R + along] - difference).abs() < 1e-6 * (1.0 + difference.abs()),
                    "{difference}"
                );
            }
        }
    }

    #[test]
    fn its_momentum_has_the_power_of_twice_its_kinetic_energy_and_drag_takes_power() {
        let water = water();
        let (q, v) = ([0.0; R], [1.0, -2.0, 4.0]);
        let power = |forces: &[f64; R]| forces.iter().zip(&v).map(|(f, v)| f * v).sum::<f64>();
        let (mut forces, mut momentum) = ([0.0; R], [0.0; R]);
        water.add_forces((&q, &v, 0.0), &mut WaterSums::new(R), (&mut forces, &mut momentum));
        assert!(power(&momentum) > 0.0 && power(&forces) > 0.0);
    }
}
