//! Recovered: errors of the pipeline's estimates against the hidden truth of the virtual bench.

use serde::{Deserialize, Serialize};
use si::{MILLIMETRE, Metre, Pascal};

use crate::subject::Study;
use crate::{Estimate, QuantityKind};
use mesh::wall::Walls;
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

/// One specimen's quantities, estimated and true.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Specimen {
    /// Its name.
    pub name: String,
    /// Moduli, relaxation, water, predicted motion: what was estimated of them.
    pub estimates: Vec<Estimate>,
    /// Of its inflated walls; none where no wall buckles.
    #[serde(default)]
    pub walls: Option<WallErrors>,
    /// The walls of the true body by pressure, Pa, brought to the time after loading to which the identified moduli belong.
    pub hidden: Vec<(Pascal, Walls)>,
}

/// Errors of an inflated model against the true body at the highest pressure of both.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct WallErrors {
    /// Of the pressure at which the slack wall buckles, Pa.
    pub critical_pressure_pa: Pascal,
    /// That pressure of the true body, Pa.
    pub hidden_critical_pressure_pa: Pascal,
    /// Of its dent, relative.
    pub dent: f64,
    /// Of where along the tail that is, m.
    pub dent_at_m: Metre,
    /// Of the bulge of the other wall, relative.
    pub bulge: f64,
    /// Of the rotation of the end, rad.
    pub rotation: f64,
}

impl WallErrors {
    fn wall_metrics(&self, specimen: &str) -> [Metric; 4] {
        let id = |quantity: &str| format!("recovery.{specimen}.{quantity}");
        [
            Metric::new(id("dent_error_percent"), 100.0 * self.dent.abs(), "%"),
            Metric::new(id("dent_place_error_mm"), self.dent_at_m.abs() / MILLIMETRE, "mm"),
            Metric::new(id("bulge_error_percent"), 100.0 * self.bulge.abs(), "%"),
            Metric::new(id("angle_error_deg"), self.rotation.abs().to_degrees(), "degrees"),
        ]
    }
}

fn coverage_percent([count, total]: [usize; 2]) -> f64 {
    100.0 * count as f64 / total.max(1) as f64
}

impl Record for Recovered {
    type Of = Study;
    const STAGE: &'static str = "recovery";

    fn to_files(&self) -> Result<RecordFiles, RecordError> {
        RecordFiles::default().scalars("recovered.json", self)
    }

    fn from_files(files: &RecordFiles) -> Result<Self, RecordError> {
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
            Metric::new("recovery.track_coverage_percent", coverage_percent(self.track_coverage), "%"),
            Metric::new("recovery.marker_coverage_percent", coverage_percent(self.marker_coverage), "%"),
            Metric::new("recovery.clock_error_ms", self.clock_error_ms, "ms"),
            Metric::new("recovery.focal_error_percent", self.focal_error_percent, "%"),
        ];
        let cell = self.load_cell_frequency_error_percent;
        metrics.extend(cell.map(|e| Metric::new("recovery.load_cell_frequency_error_percent", e, "%")));
        metrics.extend(self.wave_residual_mn.map(|e| Metric::new("recovery.wave_residual_mn", e, "mN")));
        for specimen in &self.specimens {
            let id = |e: &Estimate| format!("recovery.{}.{}_error_percent", specimen.name, e.quantity.id());
            metrics
                .extend(specimen.estimates.iter().map(|e| Metric::new(id(e), 100.0 * e.relative_error().abs(), "%")));
            metrics.extend(specimen.walls.iter().flat_map(|walls| walls.wall_metrics(&specimen.name)));
        }
        metrics
    }

    fn summary(&self) -> String {
        let error = |e: &Estimate| format!("{} {:.1} %", e.quantity.id(), 100.0 * e.relative_error().abs());
        let text = |s: &Specimen| {
            let moduli = s.estimates.iter().filter(|e| e.quantity.kind() == QuantityKind::Moduli);
            format!("{}: error of {}", s.name, moduli.map(error).collect::<Vec<_>>().join(", "))
        };
        self.specimens.iter().map(text).collect::<Vec<_>>().join("; ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_of_the_walls_are_sizes_in_the_units_of_their_names() {
        let walls = WallErrors {
            critical_pressure_pa: -1500.0,
            hidden_critical_pressure_pa: 2e4,
            dent: -0.2,
            dent_at_m: 3e-3,
            bulge: 0.1,
            rotation: -0.1,
        };
        let metrics = walls.wall_metrics("nemo").map(|m| (m.id.rsplit('.').next().unwrap().to_owned(), m.value));
        let expected = [
            ("dent_error_percent", 20.0),
            ("dent_place_error_mm", 3.0),
            ("bulge_error_percent", 10.0),
            ("angle_error_deg", 5.7296),
        ];
        for ((name, value), (id, expected_value)) in metrics.iter().zip(expected) {
            assert!(name == id && (value - expected_value).abs() < 1e-4, "{name}: {value}");
        }
        assert_eq!((coverage_percent([19, 20]), coverage_percent([0, 0])), (95.0, 0.0));
    }
}
