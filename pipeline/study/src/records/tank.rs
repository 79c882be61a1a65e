//! The tank: its standing waves, identified in water at rest.

use serde::{Deserialize, Serialize};
use si::{Hertz, Metre, Newton};
use signal::wave::Wave;

use crate::subject::Specimen;
use workflow::metric::Metric;
use workflow::record::{Record, RecordError, RecordFiles};

/// The waves of a tank.
#[derive(Debug, Clone, PartialEq)]
pub struct Tank {
    /// Slowest first.
    pub waves: Vec<Wave>,
    /// Standard deviation of the residual without waves and drift, N.
    pub noise: Newton,
    /// Suppression of the waves by the fit, dB.
    pub suppression_db: f64,
    /// Length along the tail and depth of the water, from the settings, m.
    pub size_m: [Metre; 2],
}

#[derive(Serialize, Deserialize)]
struct Scalars {
    noise_n: f64,
    suppression_db: f64,
    size_m: [Metre; 2],
    waves: Vec<One>,
}

#[derive(Serialize, Deserialize)]
struct One {
    frequency_hz: [Hertz; 2],
    decay: [f64; 2],
    amplitude_n: Newton,
    phase: f64,
}

impl Record for Tank {
    type Of = Specimen;
    const STAGE: &'static str = "tank";

    fn is_made_for(of: &Specimen) -> bool {
        of.card.fixture.iter().any(|f| f.of == lab::card::FixtureOf::StillWater)
    }

    fn pack(&self) -> Result<RecordFiles, RecordError> {
        let one = |w: &Wave| One {
            frequency_hz: [w.frequency, w.frequency_sigma],
            decay: [w.decay, w.decay_sigma],
            amplitude_n: w.amplitude,
            phase: w.phase,
        };
        let waves = self.waves.iter().map(one).collect();
        let scalars = Scalars { noise_n: self.noise, suppression_db: self.suppression_db, size_m: self.size_m, waves };
        RecordFiles::default().scalars("tank.json", &scalars)
    }

    fn unpack(files: &RecordFiles) -> Result<Self, RecordError> {
        let s: Scalars = files.read_scalars("tank.json")?;
        let one = |w: One| Wave {
            frequency: w.frequency_hz[0],
            frequency_sigma: w.frequency_hz[1],
            decay: w.decay[0],
            decay_sigma: w.decay[1],
            amplitude: w.amplitude_n,
            phase: w.phase,
        };
        let waves = s.waves.into_iter().map(one).collect();
        Ok(Self { waves, noise: s.noise_n, suppression_db: s.suppression_db, size_m: s.size_m })
    }

    fn metrics(&self, subject: &str) -> Vec<Metric> {
        let name = subject;
        let mut all = vec![Metric::new(format!("wave.{name}.suppression_db"), self.suppression_db, "dB")];
        all.push(Metric::new("wave.suppression_db", self.suppression_db, "dB"));
        for (i, wave) in self.waves.iter().enumerate() {
            all.push(Metric::new(format!("wave.{name}.mode{}_frequency_hz", i + 1), wave.frequency, "Hz"));
            all.push(Metric::new(format!("wave.{name}.mode{}_frequency_sigma_hz", i + 1), wave.frequency_sigma, "Hz"));
        }
        all.extend(self.waves.first().map(|w| Metric::new("wave.frequency_hz", w.frequency, "Hz")));
        all
    }

    fn summary(&self) -> String {
        let waves: Vec<String> =
            self.waves.iter().map(|w| format!("{:.3} ± {:.3} Hz", w.frequency, w.frequency_sigma)).collect();
        format!("standing waves at {}, suppressed by {:.0} dB", waves.join(" and "), self.suppression_db)
    }
}
