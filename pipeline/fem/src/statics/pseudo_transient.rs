//! Pseudo-transient continuation [kelley1998], the last resort when no load step is short enough.
//!
//! Each pseudo step adds a fading inertia, Π + ½ c (u − û)ᵀ M (u − û) with û the shape before and c falling: the body
//! moves downhill in small steps however its wall snaps through, and the last step is free of inertia.

use crate::inputs::AppliedLoad;
use crate::newton::options::{NewtonOptions, NonConvergence};
use crate::newton::potential::{Inertia, Potential};
use crate::solver_state::SolverState;
use crate::statics::equilibrium::Equilibrium;

/// First and last c, in units of the body's characteristic rate.
const RATES: (f64, f64) = (1e3, 1e-2);
/// Factor of c after a pseudo step, and after a failed one.
const DECREASE: f64 = 0.25;
// Two decreases back: one would only repeat, from its own end, the c that last succeeded.
const INCREASE: f64 = 16.0;
/// Pseudo steps at most, failed ones included.
// Nine lead from the first c to the last, and each failure costs three: ten failures at most.
const MAX_STEPS: usize = 40;

impl SolverState {
    /// Moves `at` to an equilibrium under `load`; returns the number of factorisations.
    ///
    /// # Errors
    /// [`NonConvergence`] of the last pseudo step.
    pub(crate) fn pseudo_transient(
        &mut self,
        at: &mut Equilibrium,
        load: AppliedLoad,
        options: &NewtonOptions,
    ) -> Result<usize, NonConvergence> {
        let characteristic_rate = self.characteristic_rate();
        let mut rate = RATES.0 * characteristic_rate;
        let mut factorisations = 0;
        let mut last = NonConvergence::LineSearchFailed { iterations: 0 };
        for _ in 0..MAX_STEPS {
            match self.pseudo_step(at, load, rate, options) {
                Ok(made) => {
                    factorisations += made;
                    rate *= DECREASE;
                }
                Err(NonConvergence::Interrupted) => return Err(NonConvergence::Interrupted),
                Err(cause) => {
                    last = cause;
                    rate *= INCREASE;
                }
            }
            if rate < RATES.1 * characteristic_rate {
                return self.newton_solve(at, None, load, options).map(|made| factorisations + made);
            }
        }
        Err(last)
    }

    /// One pseudo step from the shape of `at`, which is unchanged when the step fails.
    fn pseudo_step(
        &mut self,
        at: &mut Equilibrium,
        load: AppliedLoad,
        rate: f64,
        options: &NewtonOptions,
    ) -> Result<usize, NonConvergence> {
        self.couple_contact(&at.displacement)?;
        let centre = self.data.pattern.gather(&at.displacement);
        let history = load.added.map_or_else(Vec::new, |force| force.history.clone());
        let inertia = Inertia { rate, centre, history };
        let free = self.inputs.static_potential(&self.data, load);
        let potential = Potential { inertia: Some(&inertia), ..free };
        let mut u = at.displacement.clone();
        let counts = self.newton.minimise(&potential, &mut u, None, options)?;
        at.displacement = u;
        at.iterations += counts.iterations;
        at.factorisations += counts.factorisations;
        // Inertia adds to the tangent: where even the sum is indefinite, the body's own is.
        (counts.indefinite > 0).then(|| at.snap_through.push(load.load_factor));
        Ok(counts.factorisations)
    }

    /// E/ρ over the square of the body's size, of the softest region: the square of a characteristic frequency, 1/s².
    fn characteristic_rate(&self) -> f64 {
        let rates = self.inputs.properties.iter().map(|is| is.youngs_modulus / is.density / self.data.size.powi(2));
        // Of the softest: relative to a stiffer region, the last inertia would still hold the walls that snap.
        rates.fold(f64::INFINITY, f64::min)
    }
}

#[cfg(test)]
mod tests {
    use crate::inputs::AppliedLoad;
    use crate::newton::options::{Globalisation, NewtonOptions};
    use crate::{Clamps, RegionProperties, StaticSettings, System, box_mesh, materials};

    #[test]
    fn pseudo_transient_continuation_from_rest_ends_at_the_equilibrium_of_load_stepping() {
        let air = |cell: [usize; 3]| (1..5).contains(&cell[0]) && cell[1] == 2 && cell[2] == 0;
        let place = |at: [f64; 3]| [0.06 * at[0], 0.02 * at[1], 0.01 * at[2]];
        let mesh = box_mesh::to_quadratic(&box_mesh::grid([6, 4, 2], true, place, |cell| (!air(cell)).then_some(0)));
        let material = materials::by_name("corotated").expect("a law of this name");
        let is = RegionProperties::elastic(material, 2e5, 0.45, 1e3);
        let clamps = Clamps::below_x(&mesh, 1e-9);
        let system = System::new(mesh, vec![is], clamps).expect("a valid body");
        let mut solver = system.solver();
        let load_stepped = solver.equilibrium(&[3e4], None, &StaticSettings::default()).expect("a moderate load");
        let mut at = load_stepped.clone();
        at.displacement.fill(0.0);
        let options = NewtonOptions {
            tolerance: 1e-8 * 0.06,
            max_iterations: 60,
            max_predicted: 8.0,
            min_steps: 1,
            refactorise: true,
            predicted: false,
            globalisation: Globalisation::LineSearch,
        };
        let load = AppliedLoad::whole(&[3e4]);
        solver.state.pseudo_transient(&mut at, load, &options).expect("convergence");
        let difference = at.displacement.iter().zip(&load_stepped.displacement).map(|(a, b)| (a - b).abs());
        let largest = difference.fold(0.0, f64::max);
        assert!(largest < 1e-8, "{largest:e}");
        // the way was slow and stable: nothing snapped
        assert!(at.snap_through.is_empty());
    }
}
