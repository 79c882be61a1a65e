//! Drag: what a specimen's water weighs and how it resists.

use hydro::Coefficients;
use serde::{Deserialize, Serialize};
use si::{KilogramPerCubicMetre, Metre, Pascal};

use crate::metric::Metric;
use crate::record::{Parcel, Record, RecordError};
use crate::subject::Specimen;

/// The water around a specimen, from a release in it.
#[derive(Debug, Clone, PartialEq)]
pub struct Drag {
    /// Of added mass and of drag across the flow, no unit.
    pub by: Coefficients,
    /// Standard deviations of both, no unit.
    pub sigma: Coefficients,
    /// The pressure that was released, Pa.
    pub released: Pascal,
    /// What is left of the release, m.
    pub rmse: Metre,
    /// How far the marker moved in it, root of the mean square about its mean, m.
    pub moved: Metre,
    /// Simulations.
    pub marches: usize,
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
    marches: usize,
    density_kg_m3: KilogramPerCubicMetre,
    sections: usize,
}

impl Record for Drag {
    type Of = Specimen;
    const STAGE: &'static str = "drag";

    fn is_made_for(of: &Specimen) -> bool {
        of.trials().iter().any(crate::subject::Trial::is_staircase_in_water)
    }

    fn pack(&self) -> Result<Parcel, RecordError> {
        let scalars = Scalars {
            added: self.by.added,
            drag: self.by.drag,
            sigma_added: self.sigma.added,
            sigma_drag: self.sigma.drag,
            released_pa: self.released,
            rmse_m: self.rmse,
            moved_m: self.moved,
            marches: self.marches,
            density_kg_m3: self.density,
            sections: self.sections,
        };
        Parcel::default().scalars("drag.json", &scalars)
    }

    fn unpack(parcel: &Parcel) -> Result<Self, RecordError> {
        let s: Scalars = parcel.read_scalars("drag.json")?;
        Ok(Self {
            by: Coefficients { added: s.added, drag: s.drag },
            sigma: Coefficients { added: s.sigma_added, drag: s.sigma_drag },
            released: s.released_pa,
            rmse: s.rmse_m,
            moved: s.moved_m,
            marches: s.marches,
            density: s.density_kg_m3,
            sections: s.sections,
        })
    }

    fn metrics(&self, of: &Specimen) -> Vec<Metric> {
        let id = |what: &str| format!("drag.{}.{what}", of.card.name);
        vec![
            Metric::new(id("added"), self.by.added, ""),
            Metric::new(id("across"), self.by.drag, ""),
            Metric::new(id("rmse_mm"), 1e3 * self.rmse, "mm"),
            Metric::new(id("rmse_over_moved"), self.rmse / self.moved, ""),
        ]
    }

    fn telling(&self) -> String {
        format!(
            "added mass {:.2} ± {:.2} of theory's, drag {:.1} ± {:.1}; {:.2} of {:.2} mm are left of the release from {:.0} mbar, {} marches",
            self.by.added,
            self.sigma.added,
            self.by.drag,
            self.sigma.drag,
            1e3 * self.rmse,
            1e3 * self.moved,
            self.released / si::MILLIBAR,
            self.marches,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_drag_survives_its_record() {
        let whole = Drag {
            by: Coefficients { added: 0.8, drag: 3.0 },
            sigma: Coefficients { added: 0.1, drag: 0.2 },
            released: 2e4,
            rmse: 1e-4,
            moved: 8e-3,
            marches: 12,
            density: 998.0,
            sections: 30,
        };
        assert_eq!(Drag::unpack(&whole.pack().unwrap()).unwrap(), whole);
    }
}
