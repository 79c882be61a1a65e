//! Reduce: the identified model in the few dozen coordinates of shapes that it takes under pressure and under sideways pulls.
//!
//! Every motion that is foretold (a release, flapping in air and in water, a flap that nobody asked for) is marched in them. The
//! shapes reach to the highest pressure that moduli were identified by or that a motion to be foretold is commanded to.
//!
//! Stands on: the model. Never knows: a motion.

use fem::Kept;
use lab::card::Experiment;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use si::Pascal;

use super::swing;
use crate::fault::Outcome;
use crate::model::{self, Model};
use crate::records::{Identified, Level, Mesh, Reduced};
use crate::stage::{Desk, Stage};
use crate::subject::{Specimen, Trial};

/// The stage.
pub struct Reduce;

/// `[reduce]` in `study.toml`.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// How far the forces of the chosen points may be off over all shapes, relative, no unit.
    tolerance: f64,
}

impl Stage for Reduce {
    type Settings = Settings;
    type Needs = (Mesh, Identified);
    type Makes = Reduced;
    const STORY: &'static str = "the identified model becomes one of a few dozen coordinates";
    const EDITION: u32 = 1;

    fn card(of: &Specimen) -> Value {
        let (solid, card) = (&of.card.solid, &of.card);
        let region = |s: &lab::card::Solid| json!([s.material, s.youngs_modulus, s.poissons_ratio, s.density]);
        json!({
            "body": region(&solid.body),
            "spine": region(&solid.spine),
            "clamp": card.clamp.below_x,
            "length": card.length,
            "chambers": card.chamber.len(),
            "commanded": commanded(of),
        })
    }

    fn run(of: &Specimen, set: &Settings, (mesh, identified): Self::Needs, desk: &dyn Desk) -> Outcome<Reduced> {
        let model = Model::new(&mesh, &of.card)?;
        let known = identified.levels.iter().map(Level::pressure).fold(0.0, f64::max);
        let top = known.max(commanded(of));
        desk.progress(0.1, "bending it under pressures and pulls");
        let tops = vec![top; of.card.chamber.len()];
        let elastic = swing::identified(&model, &identified);
        let kept: Kept = model::reduce(&model, &elastic, &tops, of.card.length, set.tolerance)?;
        Ok(Reduced { kept, highest: top })
    }
}

/// The highest pressure that a motion to be foretold is commanded to, Pa; 0 where none is.
fn commanded(of: &Specimen) -> Pascal {
    let asked = |trial: &Trial| match trial.trial.experiment {
        Experiment::Flapping { amplitude, .. } => amplitude,
        Experiment::Staircase { .. } => trial.highest_level().unwrap_or(0.0),
    };
    of.trials().iter().filter(|t| t.is_for_validation()).map(asked).fold(0.0, f64::max)
}
