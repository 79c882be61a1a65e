//! Creeping: pseudo-transient continuation, the last way to a shape when no step of the load is short enough.
//!
//! The body is held back by an inertia that fades, Π + ½ c (u − û)ᵀ M (u − û) with û the shape before and c falling: it
//! moves downhill in small paces however its wall snaps, and the last pace is free.     [kelley1998]
//!
//! Stands on: `descend`, `newton`, `potential`. Never knows: a load step.

use crate::descent::potential::{Inertia, Potential};
use crate::descent::search::{Rule, Stall};
use crate::solver::Solver;
use crate::statics::equilibrium::Equilibrium;
use si::Pascal;

/// c at first and at last, in units of the body's own rate.
const RATES: (f64, f64) = (1e3, 1e-2);
/// By how much c falls after a pace, and rises when one fails.
const FADING: f64 = 0.25;
const RISING: f64 = 16.0;
/// Paces at most, failed ones counted in.
const PACES: usize = 40;

impl Solver {
    /// Moves `at` to an equilibrium under `pressures`; returns the factors made.
    ///
    /// # Errors
    /// [`Stall`] of the last pace.
    pub(crate) fn creep(
        &mut self,
        at: &mut Equilibrium,
        pressures: &[Pascal],
        dead_strength: f64,
        rule: &Rule,
    ) -> Result<usize, Stall> {
        let own = self.own_rate();
        let mut rate = RATES.0 * own;
        let mut factors = 0;
        let mut last = Stall::NoDescent { iterations: 0 };
        for _ in 0..PACES {
            match self.pace(at, pressures, dead_strength, rate, rule) {
                Ok(made) => {
                    factors += made;
                    rate *= FADING;
                }
                Err(stall) => {
                    last = stall;
                    rate *= RISING;
                }
            }
            if rate < RATES.1 * own {
                at.snaps.push(dead_strength);
                return self.descend(at, None, pressures, dead_strength, rule).map(|made| factors + made);
            }
        }
        Err(last)
    }

    /// One pace from the shape of `at`, which stays as it is when the pace fails.
    fn pace(
        &mut self,
        at: &mut Equilibrium,
        pressures: &[Pascal],
        dead_strength: f64,
        rate: f64,
        rule: &Rule,
    ) -> Result<usize, Stall> {
        let mut inertia = Inertia { rate, ..Inertia::default() };
        self.parts.pattern.gather(&at.displacement, &mut inertia.centre);
        let free = self.given.at_rest(&self.parts, pressures, dead_strength);
        let potential = Potential { inertia: Some(&inertia), ..free };
        let mut u = at.displacement.clone();
        let found = self.newton.minimise(&potential, &mut u, None, rule)?;
        at.displacement = u;
        at.iterations += found.iterations;
        at.factorisations += found.factorisations;
        Ok(found.factorisations)
    }

    /// E/ρ over the square of the body's size, of the softest region: the square of a frequency of its own, 1/s².
    fn own_rate(&self) -> f64 {
        let rates = self.given.properties.iter().map(|is| is.youngs_modulus / is.density / self.parts.size.powi(2));
        rates.fold(f64::INFINITY, f64::min)
    }
}

#[cfg(test)]
mod tests {
    use crate::descent::search::{Gait, Rule};
    use crate::{Clamps, RegionProperties, StaticSettings, System, boxes, materials};

    #[test]
    fn creeping_from_rest_to_the_whole_load_ends_where_load_steps_do() {
        let air = |cell: [usize; 3]| (1..5).contains(&cell[0]) && cell[1] == 2 && cell[2] == 0;
        let place = |at: [f64; 3]| [0.06 * at[0], 0.02 * at[1], 0.01 * at[2]];
        let mesh = boxes::with_middles(&boxes::grid([6, 4, 2], true, place, |cell| (!air(cell)).then_some(0)));
        let material = materials::by_name("corotated").expect("a law of this name");
        let is = RegionProperties { material, youngs_modulus: 2e5, poissons_ratio: 0.45, density: 1e3 };
        let clamps = Clamps::below_x(&mesh, 1e-9);
        let system = System::new(mesh, vec![is], clamps).expect("a sound body");
        let mut solver = system.solver();
        let stepped = solver.equilibrium(&[3e4], None, &StaticSettings::default()).expect("a bearable load");
        let mut at = stepped.clone();
        at.displacement.fill(0.0);
        let tolerance = 1e-8 * 0.06;
        let rule = Rule { tolerance, limit: 60, patience: 8.0, trials: 1, fresh: true, gait: Gait::Careful };
        solver.creep(&mut at, &[3e4], 1.0, &rule).expect("a way downhill");
        let apart = at.displacement.iter().zip(&stepped.displacement).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(apart < 1e-8, "{apart:e}");
        assert_eq!(at.snaps, [1.0]);
    }
}
