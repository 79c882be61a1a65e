//! Table `waveform_thrust`: mean thrust and flow of air of the best recorded flap, the best square waves and the optimal waveforms.
//!
//! All by the reduced model and fitted theory, after transients have settled; pressures are those behind the valve.

use plot::Column;

use ::thrust::optimal_waveform::{Flap, OptimalWaveforms};
use diagnostics::Result;
use records::subject::{Specimen, Study};
use workflow::needs::Every;
use workflow::subject::Subject;
use workflow::table::Table;

/// The table.
pub struct WaveformThrust;

impl Table for WaveformThrust {
    type Of = Study;
    type Needs = Every<records::OptimalActuation, Specimen>;
    const NAME: &'static str = "waveform_thrust";
    const CAPTION: &'static str = "thrust and air of the optimal waveforms, of square waves and of a recorded flap";
    const VERSION: u32 = 1;

    fn is_made_for(study: &Study) -> bool {
        Every::<records::OptimalActuation>::any(study)
    }

    fn fill(Every(actuations): Self::Needs) -> Result<plot::Table> {
        let columns = vec![
            Column::text("specimen"),
            Column::text("actuation"),
            Column::numbers("pressure", "mbar"),
            Column::numbers("frequency", "Hz"),
            Column::numbers("thrust", "mN"),
            Column::numbers("air", "ml/s"),
            Column::numbers("thrust per air", "mN s/ml"),
            Column::numbers("tip amplitude", "mm"),
        ];
        let waveforms = actuations.iter().filter_map(|(s, actuation)| Some((s.name(), actuation.waveforms.as_ref()?)));
        let table = plot::Table::new(
            columns,
            waveforms.flat_map(|(name, waveforms)| specimen_rows(&name, waveforms)).collect(),
        )?;
        Ok(table
            .noted("Predictions by theory on the simulated motion, over the thrust of a tail at rest. Pressure: the highest behind the valve. Air: at ambient pressure."))
    }
}

fn specimen_rows(specimen: &str, waveforms: &OptimalWaveforms) -> Vec<Vec<String>> {
    let recorded =
        flap_row(specimen, &format!("recorded, {}", waveforms.recorded.name.replace('_', " ")), &waveforms.recorded);
    let pair = |o: &::thrust::optimal_waveform::OptimalWaveform| {
        let goal = format!("most {}", o.flap.name.replace('_', " "));
        [
            flap_row(specimen, &format!("square wave, {goal}"), &o.square),
            flap_row(specimen, &format!("waveform, {goal}"), &o.flap),
        ]
    };
    std::iter::once(recorded).chain(waveforms.optima.iter().flat_map(pair)).collect()
}

fn flap_row(specimen: &str, name: &str, flap: &Flap) -> Vec<String> {
    let performed = &flap.performed;
    vec![
        specimen.to_owned(),
        name.to_owned(),
        format!("{:.0}", performed.highest_pa / si::MILLIBAR),
        format!("{:.2}", performed.frequency_hz),
        format!("{:.1}", 1e3 * performed.thrust_n),
        format!("{:.1}", 1e6 * performed.air_m3_s),
        format!("{:.2}", 1e-3 * performed.thrust_per_air()),
        format!("{:.1}", 1e3 * performed.amplitude_m),
    ]
}
