//! Optimal actuation: the square wave of pressure with the greatest mean thrust in the simulator, by each thrust model.

use serde::{Deserialize, Serialize};
use si::{Hertz, Pascal};

use super::Thrust;
use crate::subject::Specimen;
use ::thrust::optimal_waveform::OptimalWaveforms;
use ::thrust::square_wave_search::{ActuationPoint, Best, Check};
use workflow::metric::Metric;
use workflow::record::{Record, RecordError, RecordFiles};

/// The optima of a specimen.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OptimalActuation {
    /// Upper limit: the highest pressure that occurs both in force measurements and in identification, Pa.
    pub highest_pa: Pascal,
    /// Limits: the lowest and highest frequency of the force measurements, Hz.
    pub frequencies_hz: [Hertz; 2],
    /// One a thrust model.
    pub best: Vec<Best>,
    /// The scan that gives the starting points.
    pub scan: Vec<ActuationPoint>,
    /// How many further ones the reduced model could not follow.
    pub unsolved: usize,
    /// Check of the simulator under measured pressures.
    pub check: Check,
    /// The optimal waveforms by fitted theory, over the thrust of a tail at rest; none where no log holds a filling, or where the solid's law is none of the twin's.
    pub waveforms: Option<OptimalWaveforms>,
    /// Coordinates of the reduced model.
    pub coordinates: usize,
}

impl Record for OptimalActuation {
    type Of = Specimen;
    const STAGE: &'static str = "optimal_actuation";

    fn is_made_for(specimen: &Specimen) -> bool {
        Thrust::is_made_for(specimen)
    }

    fn to_files(&self) -> Result<RecordFiles, RecordError> {
        RecordFiles::default().scalars("optimal_actuation.json", self)
    }

    fn from_files(files: &RecordFiles) -> Result<Self, RecordError> {
        files.read_scalars("optimal_actuation.json")
    }

    fn metrics(&self, subject: &str) -> Vec<Metric> {
        let name = format!("optimal_actuation.{subject}");
        let mut metrics =
            vec![Metric::new(format!("{name}.amplitude_error_percent"), self.check.amplitude_error_percent(), "%")];
        for (best, wave) in self.best.iter().filter_map(|b| Some((b, b.wave()?))) {
            let id = |quantity: &str| format!("{name}.{}.{quantity}", best.model);
            metrics.push(Metric::new(id("amplitude_mbar"), wave.amplitude_pa / si::MILLIBAR, "mbar"));
            metrics.push(Metric::new(id("frequency_hz"), wave.frequency_hz, "Hz"));
            metrics.push(Metric::new(id("thrust_mn"), 1e3 * wave.thrust_n[0], "mN"));
            metrics.push(Metric::new(id("amplitude_ratio"), best.amplitude_ratio, ""));
            metrics.push(Metric::new(id("simulations"), best.simulations as f64, ""));
        }
        for optimum in self.waveforms.iter().flat_map(|w| &w.optima) {
            let id = |quantity: &str| format!("{name}.waveform.{}.{quantity}", optimum.flap.name);
            metrics.push(Metric::new(id("gain"), optimum.gain(), ""));
            metrics.push(Metric::new(id("thrust_mn"), 1e3 * optimum.flap.performed.thrust_n, "mN"));
        }
        metrics
    }

    fn summary(&self) -> String {
        let text = |(best, wave): (&Best, &ActuationPoint)| {
            let (mbar, mn) = (wave.amplitude_pa / si::MILLIBAR, 1e3 * wave.thrust_n[0]);
            format!(
                "{}: {mbar:.0} mbar at {:.2} Hz, {mn:.0} mN, {} simulations",
                best.model, wave.frequency_hz, best.simulations
            )
        };
        let mut parts: Vec<String> = self.best.iter().filter_map(|b| Some(text((b, b.wave()?)))).collect();
        let gains = self.waveforms.iter().flat_map(|w| &w.optima);
        parts.extend(gains.map(|o| {
            format!("waveform: {:.2} times the {} of a square wave", o.gain(), o.flap.name.replace('_', " "))
        }));
        parts.push(format!(
            "simulated amplitude {:+.0} % against {}",
            self.check.amplitude_error_percent(),
            self.check.run
        ));
        let unsolved = self.unsolved + self.waveforms.as_ref().map_or(0, |waveforms| waveforms.unsolved);
        if unsolved > 0 {
            parts.push(format!("{unsolved} square waves that the reduced model does not follow"));
        }
        parts.join("; ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_optimum_survives_its_record() {
        let actuation_point = ActuationPoint { amplitude_pa: 2e4, frequency_hz: 2.5, thrust_n: vec![0.1] };
        let best = Best {
            model: "theory".into(),
            iterates: vec![actuation_point.clone()],
            predicted_n: vec![0.1, 0.2],
            amplitude_ratio: 1.5,
            simulations: 30,
        };
        let check = Check { run: "a".into(), amplitude_m: [0.011, 0.01], mean_n: [0.1, 0.2, 0.3] };
        let optimum = OptimalActuation {
            highest_pa: 3e4,
            frequencies_hz: [1.0, 3.0],
            best: vec![best],
            scan: vec![ActuationPoint { thrust_n: vec![0.1, 0.2], ..actuation_point }],
            unsolved: 2,
            check,
            waveforms: None,
            coordinates: 20,
        };
        assert_eq!(OptimalActuation::from_files(&optimum.to_files().unwrap()).unwrap(), optimum);
        assert!(optimum.summary().ends_with("; 2 square waves that the reduced model does not follow"));
        assert!((optimum.check.amplitude_error_percent() - 10.0).abs() < 1e-9);
    }
}
