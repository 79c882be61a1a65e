//! The tank: its standing waves, identified in water at rest.

use lab::card::{Fixture, FixtureOf, Medium};
use serde::{Deserialize, Serialize};
use si::{Hertz, Metre, Newton};
use signal::wave::{Evidence, Wave};

use crate::subject::Specimen;
use workflow::metric::Metric;
use workflow::record::{Record, RecordError, RecordFiles};

/// The waves of a tank.
#[derive(Debug, Clone, PartialEq)]
pub struct Tank {
    /// Those that rise over the noise, slowest first.
    pub waves: Vec<Wave>,
    /// The evidence for each mode that was looked for, slowest first.
    pub evidence: Vec<Evidence>,
    /// Level of significance at which any wave is reported.
    pub level: f64,
    /// Standard deviation of the residual without waves and drift, N.
    pub noise: Newton,
    /// Suppression of the waves by the fit, dB.
    pub suppression_db: f64,
    /// Length along the tail and depth of the water, from the card, m.
    pub size_m: [Metre; 2],
    /// How the log was sampled, and what was made of it.
    pub sampling: lab::Sampling,
}

#[derive(Serialize, Deserialize)]
struct Scalars {
    noise_n: f64,
    suppression_db: f64,
    size_m: [Metre; 2],
    waves: Vec<WaveScalars>,
    level: f64,
    evidence: Vec<Tested>,
    sampling: lab::Sampling,
}

/// A mode that was looked for.
#[derive(Serialize, Deserialize)]
struct Tested {
    band_hz: [Hertz; 2],
    frequency_hz: Hertz,
    amplitude_n: Newton,
    power_ratio: f64,
    p_value: f64,
    quantisation_n: Newton,
}

impl From<&Evidence> for Tested {
    fn from(e: &Evidence) -> Self {
        Self {
            band_hz: e.band,
            frequency_hz: e.frequency,
            amplitude_n: e.amplitude,
            power_ratio: e.ratio,
            p_value: e.p_value,
            quantisation_n: e.quantisation,
        }
    }
}

impl From<Tested> for Evidence {
    fn from(t: Tested) -> Self {
        Self {
            band: t.band_hz,
            frequency: t.frequency_hz,
            amplitude: t.amplitude_n,
            ratio: t.power_ratio,
            p_value: t.p_value,
            quantisation: t.quantisation_n,
        }
    }
}

#[derive(Serialize, Deserialize)]
struct WaveScalars {
    frequency_hz: [Hertz; 2],
    decay: [f64; 2],
    amplitude_n: Newton,
    phase: f64,
}

impl Tank {
    /// The frequency of the wave in the band of a mode, Hz; none where it does not rise over the noise.
    pub fn wave_of(&self, mode: usize) -> Option<Hertz> {
        let [low, high] = self.evidence.get(mode)?.band;
        self.waves.iter().map(|wave| wave.frequency).find(|frequency| (low..=high).contains(frequency))
    }
}

/// Whether a recording shows water at rest: in air nothing can stand.
pub fn is_still_water(fixture: &Fixture) -> bool {
    fixture.of == FixtureOf::StillWater && fixture.medium == Medium::Water
}

impl Record for Tank {
    type Of = Specimen;
    const STAGE: &'static str = "tank";

    fn is_made_for(specimen: &Specimen) -> bool {
        specimen.card.fixture.iter().any(is_still_water)
    }

    fn to_files(&self) -> Result<RecordFiles, RecordError> {
        let wave_scalars = |w: &Wave| WaveScalars {
            frequency_hz: [w.frequency, w.frequency_sigma],
            decay: [w.decay, w.decay_sigma],
            amplitude_n: w.amplitude,
            phase: w.phase,
        };
        let waves = self.waves.iter().map(wave_scalars).collect();
        let scalars = Scalars {
            noise_n: self.noise,
            suppression_db: self.suppression_db,
            size_m: self.size_m,
            waves,
            level: self.level,
            evidence: self.evidence.iter().map(Tested::from).collect(),
            sampling: self.sampling.clone(),
        };
        RecordFiles::default().scalars("tank.json", &scalars)
    }

    fn from_files(files: &RecordFiles) -> Result<Self, RecordError> {
        let s: Scalars = files.read_scalars("tank.json")?;
        let wave = |w: WaveScalars| Wave {
            frequency: w.frequency_hz[0],
            frequency_sigma: w.frequency_hz[1],
            decay: w.decay[0],
            decay_sigma: w.decay[1],
            amplitude: w.amplitude_n,
            phase: w.phase,
        };
        let waves = s.waves.into_iter().map(wave).collect();
        Ok(Self {
            waves,
            evidence: s.evidence.into_iter().map(Evidence::from).collect(),
            level: s.level,
            noise: s.noise_n,
            suppression_db: s.suppression_db,
            size_m: s.size_m,
            sampling: s.sampling,
        })
    }

    fn metrics(&self, subject: &str) -> Vec<Metric> {
        let name = subject;
        let p_value =
            |(i, e): (usize, &Evidence)| Metric::new(format!("wave.{name}.mode{}_p_value", i + 1), e.p_value, "");
        let mut metrics: Vec<Metric> = self.evidence.iter().enumerate().map(p_value).collect();
        if !self.waves.is_empty() {
            metrics.push(Metric::new(format!("wave.{name}.suppression_db"), self.suppression_db, "dB"));
            metrics.push(Metric::new("wave.suppression_db", self.suppression_db, "dB"));
        }
        for (i, wave) in self.waves.iter().enumerate() {
            metrics.push(Metric::new(format!("wave.{name}.mode{}_frequency_hz", i + 1), wave.frequency, "Hz"));
            metrics.push(Metric::new(
                format!("wave.{name}.mode{}_frequency_sigma_hz", i + 1),
                wave.frequency_sigma,
                "Hz",
            ));
        }
        metrics.extend(self.waves.first().map(|w| Metric::new("wave.frequency_hz", w.frequency, "Hz")));
        metrics
    }

    fn summary(&self) -> String {
        let p_values: Vec<String> = self.evidence.iter().map(|e| format!("{:.1e}", e.p_value)).collect();
        let p_values = format!("p = {} at a level of {}", p_values.join(", "), self.level);
        if self.waves.is_empty() {
            return format!("no standing wave rises over the noise of {:.2} mN: {p_values}", 1e3 * self.noise);
        }
        let waves: Vec<String> =
            self.waves.iter().map(|w| format!("{:.3} ± {:.3} Hz", w.frequency, w.frequency_sigma)).collect();
        format!("standing waves at {}, suppressed by {:.0} dB; {p_values}", waves.join(" and "), self.suppression_db)
    }
}
