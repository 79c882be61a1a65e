//! Recovered: errors of the pipeline's estimates against the hidden truth of the virtual bench.

use serde::{Deserialize, Serialize};

use crate::records::REPORTED;
use crate::subject::Study;
use workflow::metric::Metric;
use workflow::record::{Record, RecordError, RecordFiles};

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
    /// Trials in which a marker is off by more than a pixel: swapped or lost.
    #[serde(default)]
    pub track_strayed: Vec<String>,
    /// Root of the mean squared error of displacements in the plane, the worst trial, mm.
    pub marker_rms_mm: f64,
    /// Largest error of a marker's position in a film's first frame, mm.
    #[serde(default)]
    pub marker_place_mm: f64,
    /// Tracked pixels whose 95 % ellipse contains the true one: contained, and all.
    #[serde(default)]
    pub track_coverage: [usize; 2],
    /// Displacements whose 95 % ellipse contains the true one: contained, and all.
    #[serde(default)]
    pub marker_coverage: [usize; 2],
    /// Largest error of the clock within a trial, the worst trial, ms.
    pub clock_error_ms: f64,
    /// Error of the focal length, the worst specimen, %.
    pub focal_error_percent: f64,
    /// Error of the load cell's natural frequency, the worst specimen, %; none where no cell was tapped.
    pub load_cell_frequency_error_percent: Option<f64>,
    /// Residual of the standing waves at the beginning of a log, the worst log, mN; none without a recording of water at rest.
    pub wave_residual_mn: Option<f64>,
}

/// One specimen's parameters, identified and true.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Specimen {
    /// Its name.
    pub name: String,
    /// Identified and true Young's modulus of the body, Pa.
    pub body_e_pa: [f64; 2],
    /// Identified and true Young's modulus of the spine, Pa.
    pub spine_e_pa: [f64; 2],
    /// Identified and true storage modulus over the modulus at its stated time, at each of [`REPORTED`]; empty where no transient was
    /// filmed.
    #[serde(default)]
    pub storage_ratio: Vec<[f64; 2]>,
    /// Identified and true loss factor at the same frequencies.
    #[serde(default)]
    pub loss_factor: Vec<[f64; 2]>,
    /// Identified and true added mass ratio, no unit; none where no release was filmed in water.
    #[serde(default)]
    pub added: Option<[f64; 2]>,
    /// Identified and true normal drag coefficient, no unit; as for `added`.
    #[serde(default)]
    pub drag: Option<[f64; 2]>,
}

impl Specimen {
    /// Absolute errors of body and spine, %.
    pub(crate) fn errors_percent(&self) -> [f64; 2] {
        [self.body_e_pa, self.spine_e_pa].map(off_percent)
    }

    /// Absolute errors of the dynamic parameters that were identified, %, by the names of their metrics.
    fn moving_percent(&self) -> impl Iterator<Item = (String, f64)> {
        let water = [("added", self.added), ("drag", self.drag)].into_iter();
        let water = water.filter_map(|(name, pair)| Some((name.to_owned(), pair?)));
        let silicone = [("storage_ratio", &self.storage_ratio), ("loss_factor", &self.loss_factor)];
        let named = |(name, pairs): (&str, &Vec<[f64; 2]>)| {
            let name = name.to_owned();
            pairs.clone().into_iter().zip(REPORTED).map(move |(pair, f)| (format!("{name}_{f}hz"), pair))
        };
        silicone.into_iter().flat_map(named).chain(water).map(|(name, pair)| (name, off_percent(pair)))
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

    fn pack(&self) -> Result<RecordFiles, RecordError> {
        RecordFiles::default().scalars("recovered.json", self)
    }

    fn unpack(files: &RecordFiles) -> Result<Self, RecordError> {
        files.read_scalars("recovered.json")
    }

    fn metrics(&self, _: &str) -> Vec<Metric> {
        if self.specimens.is_empty() {
            return Vec::new();
        }
        let mut metrics = vec![
            Metric::new("recovery.track_rms_px", self.track_rms_px, "px"),
            Metric::new("recovery.marker_rms_mm", self.marker_rms_mm, "mm"),
            Metric::new("recovery.marker_place_mm", self.marker_place_mm, "mm"),
            Metric::new("recovery.track_coverage_percent", percent(self.track_coverage), "%"),
            Metric::new("recovery.marker_coverage_percent", percent(self.marker_coverage), "%"),
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
            let id = |what: String| format!("recovery.{}.{what}_error_percent", specimen.name);
            metrics.extend(specimen.moving_percent().map(|(what, off)| Metric::new(id(what), off, "%")));
        }
        metrics
    }

    fn summary(&self) -> String {
        let text = self.specimens.iter().map(|s| {
            let [body, spine] = s.errors_percent();
            format!("{}: error of E body {body:.1} %, spine {spine:.1} %", s.name)
        });
        text.collect::<Vec<_>>().join("; ")
    }
}
