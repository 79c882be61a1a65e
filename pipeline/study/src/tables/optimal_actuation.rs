//! Table `optimal_actuation`: the square wave of greatest mean thrust in the simulator.
//!
//! Limits are the ranges of the force measurements and, for pressures, of identification. The amplitude ratio is against the largest
//! amplitude of any filmed run; the amplitude error is of the simulated tail against the filmed one under the measured pressures of one run.

use plot::Column;

use ::thrust::square_wave_search::{ActuationPoint, Best};
use diagnostics::Result;
use records::subject::{Specimen, Study};
use workflow::needs::Every;
use workflow::subject::Subject;
use workflow::table::Table;

/// The table.
pub struct OptimalActuation;

impl Table for OptimalActuation {
    type Of = Study;
    type Needs = Every<records::OptimalActuation, Specimen>;
    const NAME: &'static str = "optimal_actuation";
    const CAPTION: &'static str = "the actuation of greatest mean thrust in the simulator";
    const VERSION: u32 = 1;

    fn is_made_for(study: &Study) -> bool {
        Every::<records::OptimalActuation>::any(study)
    }

    fn fill(Every(actuations): Self::Needs) -> Result<plot::Table> {
        let columns = vec![
            Column::text("specimen"),
            Column::text("thrust model"),
            Column::numbers("limit", "mbar"),
            Column::text("frequency range (Hz)"),
            Column::numbers("pressure", "mbar"),
            Column::numbers("frequency", "Hz"),
            Column::numbers("thrust", "mN"),
            Column::numbers("amplitude ratio", ""),
            Column::numbers("simulations", ""),
            Column::numbers("amplitude error", "%"),
        ];
        let rows = actuations
            .iter()
            .flat_map(|(s, actuation)| actuation.best.iter().map(|best| actuation_row(&s.name(), actuation, best)));
        let table = plot::Table::new(columns, rows.collect())?;
        Ok(table.noted( "Predictions. Amplitude ratio: over the largest filmed amplitude; above 1 is extrapolation. Amplitude error: simulated against filmed, same pressures.", ))
    }
}

fn actuation_row(specimen: &str, actuation: &records::OptimalActuation, best: &Best) -> Vec<String> {
    let [slow, fast] = actuation.frequencies_hz;
    let mbar = |p: f64| format!("{:.0}", p / si::MILLIBAR);
    let wave = best.wave();
    let evaluated = |value: fn(&ActuationPoint) -> f64, digits: usize| {
        wave.map_or(String::new(), |w| format!("{:.digits$}", value(w)))
    };
    vec![
        specimen.to_owned(),
        best.model.clone(),
        mbar(actuation.highest_pa),
        format!("{slow:.1} to {fast:.1}"),
        wave.map_or(String::new(), |w| mbar(w.amplitude_pa)),
        evaluated(|w| w.frequency_hz, 2),
        evaluated(|w| 1e3 * w.thrust_n[0], 0),
        format!("{:.1}", best.amplitude_ratio),
        format!("{}", best.simulations),
        format!("{:+.0}", actuation.check.amplitude_error_percent()),
    ]
}
