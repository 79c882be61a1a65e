//! Drag: added mass and normal drag of a tail, from a release under water. Validation in water uses them.
//!
//! A staircase in water ends each hold by opening the chamber, and the tail vibrates freely in the water. The highest release
//! within the pressures of identification is simulated in reduced coordinates with elongated-body theory's added mass and a normal
//! drag; [`thrust::release`] identifies the ratio of the one and the coefficient of the other. No flapping film is read.

use fem::Scheme;
use hydro::Coefficients;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use si::{KilogramPerCubicMetre, Metre, Pascal, Second};

use super::deviations;
use super::simulation;
use crate::records::{self, Identified, Level, Mesh, Motion, Reduced, Relaxation};
use crate::selections::{OfTrials, UnderwaterStaircases};
use ::thrust::outline::Outline;
use ::thrust::release::{Film, ReleaseSettings, rms};
use ::thrust::underwater::UnderwaterModel;
use diagnostics::{Diagnostic, Result};
use sysid::actuated::{Actuation, MotionSimulation, dynamic_settings};
use sysid::{Body, ReducedBody, Viscoelastic};
use workflow::stage::{Stage, StageContext};

/// The stage.
pub struct Drag;

/// `[drag]` in `study.toml`.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Density of the water, kg/m³.
    density: KilogramPerCubicMetre,
    /// Sections of the tail.
    sections: usize,
    /// Time step of the second-order scheme, s.
    step: Second,
    /// Duration of the pressure ramp before the release, s.
    ramp: Second,
    /// Duration after the release that is compared, s.
    duration: Second,
    /// Least and greatest ratio of theory's added mass.
    added_mass_ratio: [f64; 2],
    /// Least and greatest coefficient of normal drag.
    normal_drag_coefficient: [f64; 2],
    /// How long the shutter is open, of the time between frames.
    exposure: f64,
    /// Standard deviation of a marker's position, m.
    sigma: Metre,
    /// Simulations at most, three an iteration.
    iterations: usize,
    /// Tolerance of a step: converged when no logarithm changes by more.
    step_tolerance: f64,
}

impl Stage for Drag {
    type Settings = Settings;
    type Card = Body;
    type Needs = ((Mesh, Identified, Reduced), Relaxation, OfTrials<Motion, UnderwaterStaircases>);
    type Makes = records::Drag;
    const DESCRIPTION: &'static str = "a release under water gives added mass and drag";
    const VERSION: u32 = 8;

    fn run(card: &Self::Card, set: &Settings, needs: Self::Needs, context: &dyn StageContext) -> Result<records::Drag> {
        let ((mesh, identified, reduced), relaxation, films) = needs;
        let (_, motion) = films.0.first().ok_or_else(no_staircase)?;
        let outline = Outline::new(card, &mesh.solid);
        let (tail, spots) = outline.whole(set.density, set.sections)?;
        let model = mesh.model(card)?.with_markers_at(&mesh.solid, card, &motion.rest).with_spots(spots);
        let simulation = MotionSimulation {
            silicone: relaxation.silicone(&model, &identified)?,
            model: &model,
            marker: card.tip_marker(),
        };
        let known = identified.levels.iter().map(Level::pressure).fold(0.0, f64::max);
        let (begin, released) = release(motion, known)?;
        let gauges = simulation::gauges(motion)?;
        let actuation =
            Actuation { begin: begin - set.ramp, end: begin + set.duration, ramp: set.ramp, gauges: &gauges };
        let reduced_body = ReducedBody::of(&model, &simulation.silicone, &reduced.data)?;
        let settings = dynamic_settings(Scheme::Bdf2, set.step);
        let underwater = UnderwaterModel::new(&reduced_body, &tail, &simulation, card.markers.len());
        let film = Film::of(&motion.time, &motion.markers[simulation.marker].at, [begin, actuation.end]);
        let mut simulations = 0;
        let off = |model: &UnderwaterModel, by| {
            Ok(film.off(&model.path(&settings, by, &actuation)?, set.exposure, set.sigma))
        };
        let mut evaluated = |at: &[Coefficients]| -> Result<Vec<Vec<f64>>> {
            simulations += at.len();
            context.progress(0.2 + 0.8 * (simulations as f64 / (3 * set.iterations) as f64).min(1.0), "releasing");
            at.par_iter().map(|by| off(&underwater, *by)).collect()
        };
        let found = set.release().identify(&mut evaluated)?;
        let others = deviations::of_silicone(&model, &identified, &relaxation)?;
        let other = |silicone: &Viscoelastic| off(&underwater.with(&reduced_body.with(&model, silicone)), found.by);
        let others = others.par_iter().map(other).collect::<Result<Vec<_>>>()?;
        Ok(records::Drag {
            by: found.by,
            sigma: found.sigma(&others)?,
            released,
            rmse: set.sigma * rms(found.residuals()),
            moved: film.moved(),
            simulations: simulations + others.len(),
            density: set.density,
            sections: set.sections,
        })
    }
}

impl Settings {
    fn release(&self) -> ReleaseSettings {
        let Self { added_mass_ratio, normal_drag_coefficient, iterations, step_tolerance, .. } = *self;
        ReleaseSettings { added_mass_ratio, normal_drag_coefficient, iterations, step_tolerance }
    }
}

fn no_staircase() -> Diagnostic {
    Diagnostic::new("there is no staircase in water", "no trial of the card is one", "film one")
}

/// Time of the release of the highest hold that is not above `known` (Pa), s on the film's clock, and its command, Pa.
fn release(motion: &Motion, known: Pascal) -> Result<(Second, Pascal)> {
    let asked = |i: usize| motion.gauges.iter().map(|g| g.command[i]).fold(0.0, f64::max);
    let falls = (1..motion.log_time.len()).filter(|&i| asked(i) == 0.0 && asked(i - 1) > 0.0);
    let within = falls.map(|i| (motion.log_time[i], asked(i - 1))).filter(|(_, p)| *p <= NEAR * known);
    within.max_by(|a, b| a.1.total_cmp(&b.1)).ok_or_else(|| {
        let why = format!("moduli were identified up to {:.0} Pa, and no hold within is released", known);
        Diagnostic::new("drag cannot be identified from the staircase in water", why, "film a lower level in water")
    })
}

/// A hold settles slightly below its command.
const NEAR: f64 = 1.1;
