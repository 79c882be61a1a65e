//! Motion: displacements of the markers and pressures of the chambers on the video's clock.

use serde::{Deserialize, Serialize};
use si::{Pascal, Point2, Second};

use super::paths::{self, Path};
use crate::subject::Trial;
use workflow::columns::Columns;
use workflow::metric::Metric;
use workflow::record::{Record, RecordError, RecordFiles};

/// Displacements and pressures.
#[derive(Debug, Clone, PartialEq)]
pub struct Motion {
    /// Time of each frame on the video's clock, s: frames.
    pub time: Vec<Second>,
    /// Displacements from rest, m: frames × markers.
    pub markers: Vec<Path>,
    /// Positions of the markers at rest, m: markers.
    pub rest: Vec<Point2>,
    /// The pressures, in the order of the card's chambers.
    pub gauges: Vec<Gauge>,
    /// Time of each sample of the log, brought to the video's clock, s: samples.
    pub log_time: Vec<Second>,
    /// The log's clock against the video's.
    pub clock: Clock,
    /// How the pressure log was sampled, and what was made of it.
    pub sampling: lab::Sampling,
}

/// The pressure in one chamber: samples of the log.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Gauge {
    /// The chamber's name.
    pub chamber: String,
    /// Commanded, Pa.
    pub command: Vec<Pascal>,
    /// Measured, Pa.
    pub measured: Vec<Pascal>,
}

impl Gauge {
    /// Both signals.
    pub fn signals(&self) -> signal::step_response::Gauge<'_> {
        signal::step_response::Gauge { command: &self.command, measured: &self.measured }
    }
}

/// log time = offset + scale × video time.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Clock {
    /// s.
    pub offset: Second,
    /// No unit.
    pub scale: f64,
    /// When the lamp lights, s on the video's clock.
    pub lamp: Second,
    /// Largest standard deviation of log times over the film, s.
    pub sigma: Second,
}

impl Motion {
    /// One marker without noise, and one chamber whose measured pressure is its command, on one clock.
    pub fn of_one_marker(time: Vec<Second>, command: Vec<Pascal>, positions: Vec<Point2>) -> Self {
        let spread = vec![[0.0; 3]; time.len()];
        Self {
            log_time: time.clone(),
            time,
            markers: vec![Path { name: "a".into(), at: positions, spread }],
            rest: vec![[0.0; 2]],
            gauges: vec![Gauge { chamber: "left".into(), measured: command.clone(), command }],
            clock: Clock { offset: 0.0, scale: 1.0, lamp: 0.0, sigma: 0.0 },
            sampling: lab::Sampling::default(),
        }
    }
}

#[derive(Serialize, Deserialize)]
struct Scalars {
    markers: Vec<String>,
    rest_m: Vec<Point2>,
    chambers: Vec<String>,
    clock: Clock,
    sampling: lab::Sampling,
}

impl Record for Motion {
    type Of = Trial;
    const STAGE: &'static str = "clock";

    fn to_files(&self) -> Result<RecordFiles, RecordError> {
        let motion = Columns::default().numbers("time_s", self.time.clone());
        let log = self.gauges.iter().fold(Columns::default().numbers("time_s", self.log_time.clone()), |log, gauge| {
            log.numbers(&format!("{}_command_pa", gauge.chamber), gauge.command.clone())
                .numbers(&format!("{}_pa", gauge.chamber), gauge.measured.clone())
        });
        let scalars = Scalars {
            markers: self.markers.iter().map(|m| m.name.clone()).collect(),
            rest_m: self.rest.clone(),
            chambers: self.gauges.iter().map(|g| g.chamber.clone()).collect(),
            clock: self.clock,
            sampling: self.sampling.clone(),
        };
        RecordFiles::default()
            .table("motion.parquet", &paths::pack_paths(motion, &self.markers, "m"))?
            .table("pressure.parquet", &log)?
            .scalars("motion.json", &scalars)
    }

    fn from_files(files: &RecordFiles) -> Result<Self, RecordError> {
        let scalars: Scalars = files.read_scalars("motion.json")?;
        let (motion, log) = (files.read_table("motion.parquet")?, files.read_table("pressure.parquet")?);
        let gauge = |chamber: &String| -> Result<Gauge, RecordError> {
            let command = log.f64(&format!("{chamber}_command_pa"))?;
            Ok(Gauge { chamber: chamber.clone(), command, measured: log.f64(&format!("{chamber}_pa"))? })
        };
        Ok(Self {
            time: motion.f64("time_s")?,
            markers: paths::unpack_paths(&motion, &scalars.markers, "m")?,
            rest: scalars.rest_m,
            gauges: scalars.chambers.iter().map(gauge).collect::<Result<_, _>>()?,
            log_time: log.f64("time_s")?,
            clock: scalars.clock,
            sampling: scalars.sampling,
        })
    }

    fn metrics(&self, subject: &str) -> Vec<Metric> {
        let id = format!("clock.{}.offset_s", super::subject_id(subject));
        let sigma = format!("clock.{}.sigma_ms", super::subject_id(subject));
        vec![Metric::new(id, self.clock.offset, "s"), Metric::new(sigma, 1e3 * self.clock.sigma, "ms")]
    }

    fn summary(&self) -> String {
        format!("offset of the log {:+.1} ± {:.2} ms", 1e3 * self.clock.offset, 1e3 * self.clock.sigma)
    }
}
