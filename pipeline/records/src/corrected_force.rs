//! CorrectedForce: the measured force of a trial on the film's clock, with the tank's waves and the drift of the zero separated.

use serde::{Deserialize, Serialize};
use si::{Newton, Second, Series};

use crate::subject::Trial;
use workflow::columns::Columns;
use workflow::metric::Metric;
use workflow::record::{Record, RecordError, RecordFiles};

/// The force of one trial: samples of the log, evenly spaced.
#[derive(Debug, Clone, PartialEq)]
pub struct CorrectedForce {
    /// On the film's clock, s.
    pub time: Vec<Second>,
    /// As logged, N.
    pub raw: Vec<Newton>,
    /// Standing waves in it, N.
    pub waves: Vec<Newton>,
    /// Drift of the zero: a line through the intervals at rest before and after, N.
    pub zero: Vec<Newton>,
    /// log time = offset + film time, s.
    pub offset: Second,
    /// First and last command of pressure, s.
    pub commanded: [Second; 2],
    /// The load cell's own lag on the card and its standard deviation, s, by which `time` is earlier than stamped; 0 where the card has none.
    pub lag: [Second; 2],
    /// How the log was sampled, and what was made of it.
    pub sampling: lab::Sampling,
    /// Warnings: a harmonic of the actuation coincides with a standing wave.
    pub warnings: Vec<String>,
}

#[derive(Serialize, Deserialize)]
struct Scalars {
    offset_s: Second,
    commanded_s: [Second; 2],
    lag_s: [Second; 2],
    sampling: lab::Sampling,
    warnings: Vec<String>,
}

impl CorrectedForce {
    /// The log without waves and zero, N.
    pub fn force(&self) -> Series {
        let values = self.raw.iter().zip(&self.waves).zip(&self.zero).map(|((r, w), z)| r - w - z).collect();
        let last = self.time.len() - 1;
        let rate = last as f64 / (self.time[last] - self.time[0]);
        Series::new(self.time[0], rate, values).expect("a log holds finite samples over rising time")
    }
}

impl Record for CorrectedForce {
    type Of = Trial;
    const STAGE: &'static str = "wave";

    fn is_made_for(trial: &Trial) -> bool {
        trial.has_force_in_water()
    }

    fn to_files(&self) -> Result<RecordFiles, RecordError> {
        let columns = Columns::default()
            .numbers("time_s", self.time.clone())
            .numbers("raw_n", self.raw.clone())
            .numbers("waves_n", self.waves.clone())
            .numbers("zero_n", self.zero.clone());
        let (offset_s, commanded_s, lag_s) = (self.offset, self.commanded, self.lag);
        let (sampling, warnings) = (self.sampling.clone(), self.warnings.clone());
        RecordFiles::default()
            .table("force.parquet", &columns)?
            .scalars("force.json", &Scalars { offset_s, commanded_s, lag_s, sampling, warnings })
    }

    fn from_files(files: &RecordFiles) -> Result<Self, RecordError> {
        let (s, columns): (Scalars, _) = (files.read_scalars("force.json")?, files.read_table("force.parquet")?);
        Ok(Self {
            time: columns.f64("time_s")?,
            raw: columns.f64("raw_n")?,
            waves: columns.f64("waves_n")?,
            zero: columns.f64("zero_n")?,
            offset: s.offset_s,
            commanded: s.commanded_s,
            lag: s.lag_s,
            sampling: s.sampling,
            warnings: s.warnings,
        })
    }

    fn metrics(&self, subject: &str) -> Vec<Metric> {
        let id = format!("wave.{}.max_amplitude_mn", super::subject_id(subject));
        vec![Metric::new(id, 1e3 * self.waves.iter().fold(0.0, |m: f64, w| m.max(w.abs())), "mN")]
    }

    fn summary(&self) -> String {
        let peak = |list: &[f64]| 1e3 * list.iter().fold(0.0, |m: f64, w| m.max(w.abs()));
        let warnings = if self.warnings.is_empty() { String::new() } else { format!("; {}", self.warnings.join("; ")) };
        format!("waves up to {:.1} mN, zero up to {:.0} mN{warnings}", peak(&self.waves), peak(&self.zero))
    }
}
