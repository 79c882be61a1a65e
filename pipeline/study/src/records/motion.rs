//! Motion: displacements of the markers and pressures of the chambers on one clock, the video's.

use serde::{Deserialize, Serialize};
use si::{Pascal, Point2, Second};

use super::paths::{self, Path};
use crate::columns::Columns;
use crate::metric::Metric;
use crate::record::{Parcel, Record, RecordError};
use crate::subject::Trial;

/// What moved, and what moved it.
#[derive(Debug, Clone, PartialEq)]
pub struct Motion {
    /// Time of each frame on the video's clock, s: frames.
    pub time: Vec<Second>,
    /// Displacements from rest, m: frames × markers.
    pub markers: Vec<Path>,
    /// Where the markers are at rest, m: markers.
    pub rest: Vec<Point2>,
    /// The pressures, in the order of the card's chambers.
    pub gauges: Vec<Gauge>,
    /// Time of each sample of the log, brought to the video's clock, s: samples.
    pub log_time: Vec<Second>,
    /// How the log's clock runs.
    pub clock: Clock,
}

/// The pressure in one chamber: samples of the log.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Gauge {
    /// The chamber's name.
    pub chamber: String,
    /// What the valve was asked for, Pa.
    pub command: Vec<Pascal>,
    /// What was measured, Pa.
    pub measured: Vec<Pascal>,
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
    /// How well log times are known over the film, the largest standard deviation, s.
    pub sigma: Second,
}

#[derive(Serialize, Deserialize)]
struct Scalars {
    markers: Vec<String>,
    rest_m: Vec<Point2>,
    chambers: Vec<String>,
    clock: Clock,
}

impl Record for Motion {
    type Of = Trial;
    const STAGE: &'static str = "clock";

    fn pack(&self) -> Result<Parcel, RecordError> {
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
        };
        Parcel::default()
            .table("motion.parquet", &paths::pack(motion, &self.markers, "m"))?
            .table("pressure.parquet", &log)?
            .scalars("motion.json", &scalars)
    }

    fn unpack(parcel: &Parcel) -> Result<Self, RecordError> {
        let scalars: Scalars = parcel.read_scalars("motion.json")?;
        let (motion, log) = (parcel.read_table("motion.parquet")?, parcel.read_table("pressure.parquet")?);
        let gauge = |chamber: &String| -> Result<Gauge, RecordError> {
            let command = log.f64(&format!("{chamber}_command_pa"))?;
            Ok(Gauge { chamber: chamber.clone(), command, measured: log.f64(&format!("{chamber}_pa"))? })
        };
        Ok(Self {
            time: motion.f64("time_s")?,
            markers: paths::unpack(&motion, &scalars.markers, "m")?,
            rest: scalars.rest_m,
            gauges: scalars.chambers.iter().map(gauge).collect::<Result<_, _>>()?,
            log_time: log.f64("time_s")?,
            clock: scalars.clock,
        })
    }

    fn metrics(&self, of: &Trial) -> Vec<Metric> {
        let id = format!("clock.{}_{}.offset_s", of.card.name, of.trial.id);
        let sigma = format!("clock.{}_{}.sigma_ms", of.card.name, of.trial.id);
        vec![Metric::new(id, self.clock.offset, "s"), Metric::new(sigma, 1e3 * self.clock.sigma, "ms")]
    }

    fn telling(&self) -> String {
        format!("the log runs {:+.1} ± {:.2} ms from the video", 1e3 * self.clock.offset, 1e3 * self.clock.sigma)
    }
}
