//! Best flap: the square wave of pressure that gives the most thrust in the simulator, as each model of thrust tells it.

use serde::{Deserialize, Serialize};
use si::{Hertz, Metre, Newton, Pascal};

use super::Thrust;
use crate::metric::Metric;
use crate::record::{Parcel, Record, RecordError};
use crate::subject::Specimen;

/// What was found for a specimen.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BestFlap {
    /// The highest pressure that was both weighed and identified by, Pa: the limit.
    pub highest_pa: Pascal,
    /// The lowest and highest frequency that were ever weighed, Hz: the limits.
    pub frequencies_hz: [Hertz; 2],
    /// One a model of thrust.
    pub best: Vec<Best>,
    /// The waves that were tried before any was climbed from.
    pub scan: Vec<Flap>,
    /// How the simulator swims under pressures that were measured.
    pub check: Check,
    /// Coordinates of the reduced model.
    pub coordinates: usize,
}

/// The best wave by one model of thrust.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Best {
    /// The rung's name.
    pub model: String,
    /// Every wave on the way up, the best last.
    pub way: Vec<Flap>,
    /// What every model tells of the best, N, in the order of the scan.
    pub told_n: Vec<Newton>,
    /// Half the way of the last mark sideways in the best, over the most that was filmed, no unit: beyond 1 the models guess.
    pub swing_over_filmed: f64,
    /// Motions simulated, those of the scan among them.
    pub marches: usize,
}

/// A wave and its mean thrust.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Flap {
    /// Pa.
    pub amplitude_pa: Pascal,
    /// Hz.
    pub frequency_hz: Hertz,
    /// One a model that was asked, N.
    pub thrust_n: Vec<Newton>,
}

/// A weighed run beside its simulation under the pressures that were measured in it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Check {
    /// The run's id: of those within the limit the one of the most mean force.
    pub run: String,
    /// Half the way of the last mark sideways, simulated and measured, m.
    pub swing_m: [Metre; 2],
    /// Mean force that tuned theory tells of the simulated motion and of the measured one, and the measured force, N.
    pub mean_n: [Newton; 3],
}

impl Best {
    /// The wave itself.
    pub fn wave(&self) -> Option<&Flap> {
        self.way.last()
    }
}

impl Check {
    /// By how much more the simulated tail swings, %.
    pub fn swing_off_percent(&self) -> f64 {
        100.0 * (self.swing_m[0] / self.swing_m[1] - 1.0)
    }
}

impl Record for BestFlap {
    type Of = Specimen;
    const STAGE: &'static str = "best_flap";

    fn is_made_for(of: &Specimen) -> bool {
        Thrust::is_made_for(of)
    }

    fn pack(&self) -> Result<Parcel, RecordError> {
        Parcel::default().scalars("best_flap.json", self)
    }

    fn unpack(parcel: &Parcel) -> Result<Self, RecordError> {
        parcel.read_scalars("best_flap.json")
    }

    fn metrics(&self, of: &Specimen) -> Vec<Metric> {
        let name = format!("best_flap.{}", of.card.name);
        let mut all = vec![Metric::new(format!("{name}.swing_off_percent"), self.check.swing_off_percent(), "%")];
        for (best, wave) in self.best.iter().filter_map(|b| Some((b, b.wave()?))) {
            let id = |what: &str| format!("{name}.{}.{what}", best.model);
            all.push(Metric::new(id("amplitude_mbar"), wave.amplitude_pa / si::MILLIBAR, "mbar"));
            all.push(Metric::new(id("frequency_hz"), wave.frequency_hz, "Hz"));
            all.push(Metric::new(id("thrust_mn"), 1e3 * wave.thrust_n[0], "mN"));
            all.push(Metric::new(id("swing_over_filmed"), best.swing_over_filmed, ""));
            all.push(Metric::new(id("marches"), best.marches as f64, ""));
        }
        all
    }

    fn telling(&self) -> String {
        let said = |(best, wave): (&Best, &Flap)| {
            let (mbar, mn) = (wave.amplitude_pa / si::MILLIBAR, 1e3 * wave.thrust_n[0]);
            format!(
                "{}: {mbar:.0} mbar at {:.2} Hz, {mn:.0} mN, {} marches",
                best.model, wave.frequency_hz, best.marches
            )
        };
        let mut all: Vec<String> = self.best.iter().filter_map(|b| Some(said((b, b.wave()?)))).collect();
        all.push(format!(
            "the simulated tail swings {:+.0} % beside {}",
            self.check.swing_off_percent(),
            self.check.run
        ));
        all.join("; ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_best_flap_survives_its_record() {
        let flap = Flap { amplitude_pa: 2e4, frequency_hz: 2.5, thrust_n: vec![0.1] };
        let best = Best {
            model: "theory".into(),
            way: vec![flap.clone()],
            told_n: vec![0.1, 0.2],
            swing_over_filmed: 1.5,
            marches: 30,
        };
        let check = Check { run: "a".into(), swing_m: [0.011, 0.01], mean_n: [0.1, 0.2, 0.3] };
        let whole = BestFlap {
            highest_pa: 3e4,
            frequencies_hz: [1.0, 3.0],
            best: vec![best],
            scan: vec![Flap { thrust_n: vec![0.1, 0.2], ..flap }],
            check,
            coordinates: 20,
        };
        assert_eq!(BestFlap::unpack(&whole.pack().unwrap()).unwrap(), whole);
        assert!((whole.check.swing_off_percent() - 10.0).abs() < 1e-9);
    }
}
