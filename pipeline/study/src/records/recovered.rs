//! Recovered: how close the pipeline came to what the virtual bench hid.

use serde::{Deserialize, Serialize};

use crate::metric::Metric;
use crate::record::{Parcel, Record, RecordError};
use crate::subject::Study;

/// Errors against the truth.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Recovered {
    /// One entry a specimen of the virtual bench.
    pub specimens: Vec<Specimen>,
    /// Root of the mean squared distance of tracked from true pixels, the worst trial, px.
    pub track_rms_px: f64,
    /// That trial, as `specimen/trial`.
    #[serde(default)]
    pub track_worst: String,
    /// Trials in which a marker strays by more than a pixel: it has been swapped or lost.
    #[serde(default)]
    pub track_strayed: Vec<String>,
    /// Root of the mean squared error of displacements in the plane, the worst trial, mm.
    pub marker_rms_mm: f64,
    /// Largest error of a marker's own place in a film's first frame, mm.
    #[serde(default)]
    pub marker_place_mm: f64,
    /// Tracked pixels whose 95 % ellipse holds the true one: held, and all.
    #[serde(default)]
    pub track_covered: [usize; 2],
    /// Displacements whose 95 % ellipse holds the true one: held, and all.
    #[serde(default)]
    pub marker_covered: [usize; 2],
    /// Largest difference of the found from the true clock within a trial, the worst trial, ms.
    pub clock_error_ms: f64,
    /// Error of the focal length, the worst specimen, %.
    pub focal_error_percent: f64,
    /// Error of the load cell's natural frequency, the worst specimen, %; none where no cell was tapped.
    pub load_cell_frequency_error_percent: Option<f64>,
    /// What is left of the standing waves at the begin of a log, the worst log, mN; none where no water was still.
    pub wave_residual_mn: Option<f64>,
}

/// One specimen's materials, found and true.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Specimen {
    /// Its name.
    pub name: String,
    /// Found and true Young's modulus of the body, Pa.
    pub body_e_pa: [f64; 2],
    /// Found and true Young's modulus of the spine, Pa.
    pub spine_e_pa: [f64; 2],
    /// Found and true stiffness damping, s; none where no release was filmed.
    #[serde(default)]
    pub stiffness_damping: Option<[f64; 2]>,
    /// Found and true share of theory's added mass, no unit; none where no release was filmed in water.
    #[serde(default)]
    pub added: Option<[f64; 2]>,
    /// Found and true drag across the flow, no unit; as for `added`.
    #[serde(default)]
    pub drag: Option<[f64; 2]>,
}

impl Specimen {
    /// Errors of body and spine, %, without sign.
    pub fn errors_percent(&self) -> [f64; 2] {
        [self.body_e_pa, self.spine_e_pa].map(off_percent)
    }

    /// Errors of what moves, where it was learnt, by the names of their metrics; %, without sign.
    fn moving_percent(&self) -> impl Iterator<Item = (&'static str, f64)> {
        let all = [("damping", self.stiffness_damping), ("added", self.added), ("drag", self.drag)];
        all.into_iter().filter_map(|(name, pair)| pair.map(|pair| (name, off_percent(pair))))
    }
}

fn off_percent([found, hidden]: [f64; 2]) -> f64 {
    100.0 * (found / hidden - 1.0).abs()
}

fn percent([held, all]: [usize; 2]) -> f64 {
    100.0 * held as f64 / all.max(1) as f64
}

impl Record for Recovered {
    type Of = Study;
    const STAGE: &'static str = "recovery";

    fn pack(&self) -> Result<Parcel, RecordError> {
        Parcel::default().scalars("recovered.json", self)
    }

    fn unpack(parcel: &Parcel) -> Result<Self, RecordError> {
        parcel.read_scalars("recovered.json")
    }

    fn metrics(&self, _: &Study) -> Vec<Metric> {
        if self.specimens.is_empty() {
            return Vec::new();
        }
        let mut metrics = vec![
            Metric::new("recovery.track_rms_px", self.track_rms_px, "px"),
            Metric::new("recovery.marker_rms_mm", self.marker_rms_mm, "mm"),
            Metric::new("recovery.marker_place_mm", self.marker_place_mm, "mm"),
            Metric::new("recovery.track_covered_percent", percent(self.track_covered), "%"),
            Metric::new("recovery.marker_covered_percent", percent(self.marker_covered), "%"),
            Metric::new("recovery.clock_error_ms", self.clock_error_ms, "ms"),
            Metric::new("recovery.focal_error_percent", self.focal_error_percent, "%"),
        ];
        let cell = self.load_cell_frequency_error_percent;
        metrics.extend(cell.map(|e| Metric::new("recovery.load_cell_frequency_error_percent", e, "%")));
        metrics.extend(self.wave_residual_mn.map(|e| Metric::new("recovery.wave_residual_mn", e, "mN")));
        for specimen in &self.specimens {
            let [body, spine] = specimen.errors_percent();
            metrics.push(Metric::new(format!("recovery.{}.body_e_error_percent", specimen.name), body, "%"));
            metrics.push(Metric::new(format!("recovery.{}.spine_e_error_percent", specimen.name), spine, "%"));
            let id = |what| format!("recovery.{}.{what}_error_percent", specimen.name);
            metrics.extend(specimen.moving_percent().map(|(what, off)| Metric::new(id(what), off, "%")));
        }
        metrics
    }

    fn telling(&self) -> String {
        let said = self.specimens.iter().map(|s| {
            let [body, spine] = s.errors_percent();
            format!("{}: body off by {body:.1} %, spine by {spine:.1} %", s.name)
        });
        said.collect::<Vec<_>>().join("; ")
    }
}
