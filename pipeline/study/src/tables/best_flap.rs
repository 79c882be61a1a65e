//! Table `best_flap`: the square wave of the most thrust in the simulator, under the highest pressure that was weighed and identified by.
//!
//! Limits are what was weighed and, of pressures, what moduli were identified by. Swing over filmed is against the largest swing of any
//! filmed run; swing off is of the simulated tail beside the filmed one under the pressures measured in one run.
//!
//! Stands on: plot. Never knows: how a number was computed.

use plot::Column;

use crate::fault::{Fault, Outcome};
use crate::needs::Every;
use crate::records;
use crate::subject::{Scope, Study};
use crate::table::Table;

/// The table.
pub struct BestFlap;

impl Table for BestFlap {
    type Needs = Every<records::BestFlap>;
    const NAME: &'static str = "best_flap";
    const SHOWS: &'static str = "which flap gives the most thrust in the simulator";
    const EDITION: u32 = 1;

    fn is_made_for(study: &Study) -> bool {
        Every::<records::BestFlap>::any(study)
    }

    fn fill(Every(all): Self::Needs) -> Outcome<plot::Table> {
        let columns = vec![
            Column::words("specimen"),
            Column::words("told by"),
            Column::numbers("limit", "mbar"),
            Column::words("between, Hz"),
            Column::numbers("pressure", "mbar"),
            Column::numbers("frequency", "Hz"),
            Column::numbers("thrust", "mN"),
            Column::numbers("swing over filmed", ""),
            Column::numbers("motions", ""),
            Column::numbers("swing off", "%"),
        ];
        let rows = all.iter().flat_map(|(s, found)| found.best.iter().map(|best| row(&s.name(), found, best)));
        let table = plot::Table::new(columns, rows.collect()).map_err(Fault::from_tool)?;
        Ok(table.noted(
            "A prediction of learnt models. Swing over filmed: beyond 1 they guess. Swing off: simulated over filmed, same pressures.",
        ))
    }
}

fn row(specimen: &str, found: &records::BestFlap, best: &records::Best) -> Vec<String> {
    let [slow, fast] = found.frequencies_hz;
    let mbar = |p: f64| format!("{:.0}", p / si::MILLIBAR);
    let wave = best.wave();
    let told =
        |of: fn(&records::Flap) -> f64, digits: usize| wave.map_or(String::new(), |w| format!("{:.digits$}", of(w)));
    vec![
        specimen.to_owned(),
        best.model.clone(),
        mbar(found.highest_pa),
        format!("{slow:.1} to {fast:.1}"),
        wave.map_or(String::new(), |w| mbar(w.amplitude_pa)),
        told(|w| w.frequency_hz, 2),
        told(|w| 1e3 * w.thrust_n[0], 0),
        format!("{:.1}", best.swing_over_filmed),
        format!("{}", best.marches),
        format!("{:+.0}", found.check.swing_off_percent()),
    ]
}
