//! Drag: added mass and normal drag of a specimen in water.

use hydro::Coefficients;
use serde::{Deserialize, Serialize};
use si::{KilogramPerCubicMetre, Metre, Pascal};

use crate::subject::Specimen;
use workflow::metric::Metric;
use workflow::record::{Record, RecordError, RecordFiles};

/// Hydrodynamic coefficients of a specimen, from a release in water.
#[derive(Debug, Clone, PartialEq)]
pub struct Drag {
    /// Added mass ratio and normal drag coefficient, no unit.
    pub by: Coefficients,
    /// Standard deviations of both, no unit.
    pub sigma: Coefficients,
    /// The pressure that was released, Pa.
    pub released: Pascal,
    /// Root mean square error of the free vibration, m.
    pub rmse: Metre,
    /// Amplitude of the marker in it: root mean square about its mean, m.
    pub moved: Metre,
    /// Simulations.
    pub simulations: usize,
    /// Density of the water, kg/m³.
    pub density: KilogramPerCubicMetre,
    /// Sections of the tail.
    pub sections: usize,
}

#[derive(Serialize, Deserialize)]
struct Scalars {
    added: f64,
    drag: f64,
    sigma_added: f64,
    sigma_drag: f64,
    released_pa: Pascal,
    rmse_m: Metre,
    moved_m: Metre,
    simulations: usize,
    density_kg_m3: KilogramPerCubicMetre,
    sections: usize,
}

impl Record for Drag {
    type Of = Specimen;
    const STAGE: &'static str = "drag";

    fn is_made_for(specimen: &Specimen) -> bool {
        specimen.trials().iter().any(crate::subject::Trial::is_staircase_in_water)
    }

    fn to_files(&self) -> Result<RecordFiles, RecordError> {
        let scalars = Scalars {
            added: self.by.added,
            drag: self.by.drag,
            sigma_added: self.sigma.added,
            sigma_drag: self.sigma.drag,
            released_pa: self.released,
            rmse_m: self.rmse,
            moved_m: self.moved,
            simulations: self.simulations,
            density_kg_m3: self.density,
            sections: self.sections,
        };
        RecordFiles::default().scalars("drag.json", &scalars)
    }

    fn from_files(files: &RecordFiles) -> Result<Self, RecordError> {
        let s: Scalars = files.read_scalars("drag.json")?;
        Ok(Self {
            by: Coefficients { added: s.added, drag: s.drag },
            sigma: Coefficients { added: s.sigma_added, drag: s.sigma_drag },
            released: s.released_pa,
            rmse: s.rmse_m,
            moved: s.moved_m,
            simulations: s.simulations,
            density: s.density_kg_m3,
            sections: s.sections,
        })
    }

    fn metrics(&self, subject: &str) -> Vec<Metric> {
        let id = |quantity: &str| format!("drag.{subject}.{quantity}");
        vec![
            Metric::new(id("added_mass_ratio"), self.by.added, ""),
            Metric::new(id("normal_drag_coefficient"), self.by.drag, ""),
            Metric::new(id("rmse_mm"), 1e3 * self.rmse, "mm"),
            Metric::new(id("rmse_over_amplitude"), self.rmse / self.moved, ""),
        ]
    }

    fn summary(&self) -> String {
        format!(
            "added mass ratio {:.2} ± {:.2}, normal drag {:.1} ± {:.1}; RMSE {:.2} mm at {:.2} mm amplitude, release from {:.0} mbar, {} simulations",
            self.by.added,
            self.sigma.added,
            self.by.drag,
            self.sigma.drag,
            1e3 * self.rmse,
            1e3 * self.moved,
            self.released / si::MILLIBAR,
            self.simulations,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_drag_survives_its_record() {
        let drag = Drag {
            by: Coefficients { added: 0.8, drag: 3.0 },
            sigma: Coefficients { added: 0.1, drag: 0.2 },
            released: 2e4,
            rmse: 1e-4,
            moved: 8e-3,
            simulations: 12,
            density: 998.0,
            sections: 30,
        };
        assert_eq!(Drag::from_files(&drag.to_files().unwrap()).unwrap(), drag);
    }
}
