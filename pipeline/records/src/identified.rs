//! Identified: the Young's moduli that minimise the quasi-static misfit, with their uncertainty.

use serde::{Deserialize, Serialize};
use si::{Metre, ModulusUnit, Pascal, Point3, Second};

use crate::Uncertainty;
use crate::subject::Specimen;
use sysid::{Certificate, Discrepancy, Elastic, Level, Model, NoiseModel, SearchDurations};
use workflow::columns::Columns;
use workflow::metric::Metric;
use workflow::record::{Record, RecordError, RecordFiles};

/// Young's moduli of the solids, Pa, the softest first.
pub type Moduli = Vec<Pascal>;

/// The whole identification of one specimen. Durations and the table of nodes are files of their own.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Identified {
    /// The solids' names, the softest first.
    pub solids: Vec<String>,
    /// The moduli found.
    pub best: Moduli,
    /// Their standard deviations, Pa.
    pub sigma: Moduli,
    /// Stiffening of the softest solid; none where its law does not stiffen.
    pub stiffening: Option<Stiffening>,
    /// How well a reduced model served the search; or why the whole body was searched.
    pub certificate: Result<Certificate, String>,
    /// Time after loading to which they belong, s: the mean over the holds.
    #[serde(rename = "modulus_time_s")]
    pub modulus_time: Second,
    /// The loss there.
    pub loss: f64,
    /// The specimen's length, m.
    #[serde(rename = "length_m")]
    pub length: Metre,
    /// The levels.
    pub levels: Vec<Level>,
    /// Noise model beside the markers' covariance, by which the search weighed the levels.
    pub noise: NoiseModel,
    /// The discrepancy that its residuals show.
    pub discrepancy: Discrepancy,
    /// Uncertainty of the moduli.
    pub uncertainty: Uncertainty,
    /// Displacement of every node at the highest level, m.
    #[serde(skip)]
    pub inflated: Vec<Point3>,
    /// How long it took.
    #[serde(skip)]
    pub durations: IdentificationDurations,
}

/// How long an identification took.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct IdentificationDurations {
    /// Time of all simulations of the search by the whole body with their derivatives over that of the equilibria alone.
    pub gradient_over_forward: f64,
    /// Of the search.
    pub search: SearchDurations,
}

/// Identified stiffening of the softest solid.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Stiffening {
    /// C₂₀/C₁₀ and C₃₀/C₁₀.
    pub ratios: [f64; 2],
    /// Their standard deviations.
    pub sigma: [f64; 2],
}

impl Record for Identified {
    type Of = Specimen;
    const STAGE: &'static str = "identify";

    fn to_files(&self) -> Result<RecordFiles, RecordError> {
        let axis = |k: usize| self.inflated.iter().map(|u| u[k]).collect();
        let inflated = Columns::default().numbers("x_m", axis(0)).numbers("y_m", axis(1)).numbers("z_m", axis(2));
        RecordFiles::default()
            .scalars("identified.json", self)?
            .durations("durations.json", &self.durations)?
            .table("inflated.parquet", &inflated)
    }

    fn from_files(files: &RecordFiles) -> Result<Self, RecordError> {
        let inflated = files.read_table("inflated.parquet")?;
        let (x, y, z) = (inflated.f64("x_m")?, inflated.f64("y_m")?, inflated.f64("z_m")?);
        Ok(Self {
            // length: columns of one table are equally long
            inflated: x.into_iter().zip(y).zip(z).map(|((x, y), z)| [x, y, z]).collect(),
            durations: files.read_scalars("durations.json")?,
            ..files.read_scalars("identified.json")?
        })
    }

    fn metrics(&self, subject: &str) -> Vec<Metric> {
        let id = |quantity: &str| format!("identify.{subject}.{quantity}");
        let moduli = self.moduli().flat_map(|modulus| {
            let name = format!("{}_e_{}", modulus.solid, modulus.unit.to_lowercase());
            [
                Metric::new(id(&name), modulus.best, modulus.unit),
                Metric::new(id(&format!("{name}.sigma")), modulus.sigma, modulus.unit),
            ]
        });
        let mut metrics: Vec<Metric> = moduli.collect();
        metrics.extend(self.stiffening_metrics(&id));
        metrics.extend([
            Metric::new(id("modulus_time_s"), self.modulus_time, "s"),
            Metric::new(id("loss"), self.loss, ""),
            Metric::new(id("gradient_over_forward"), self.durations.gradient_over_forward, ""),
            Metric::new(id("chi_square"), self.uncertainty.chi_square, ""),
        ]);
        metrics.extend(self.solids.iter().zip(&self.uncertainty.discretisation).map(|(solid, shift)| {
            Metric::new(id(&format!("{solid}_e.discretisation_percent")), 100.0 * shift.exp_m1(), "%")
        }));
        metrics.extend(self.certificate.iter().flat_map(|certificate| {
            [
                Metric::new(id("certificate_sigma"), certificate.sigma, ""),
                Metric::new(id("certificate_rounds"), certificate.rounds as f64, ""),
                Metric::new(id("whole_equilibria"), certificate.whole_equilibria as f64, ""),
            ]
        }));
        metrics.extend([
            Metric::new(id("training_seconds"), self.durations.search.training, "s"),
            Metric::new(id("search_seconds"), self.durations.search.search, "s"),
        ]);
        metrics.extend(self.uncertainty.mesh_error.map(|error| Metric::new(id("mesh_error_mm"), 1e3 * error, "mm")));
        metrics.extend(self.uncertainty.first_correlation().map(|c| Metric::new(id("correlation"), c, "")));
        let largest = self.levels.iter().map(Level::largest_error).fold(0.0, f64::max);
        metrics.push(Metric::new(format!("static.{subject}.max_error_mm"), 1e3 * largest, "mm"));
        metrics
    }

    fn summary(&self) -> String {
        let text = |m: DisplayModulus<'_>| format!("{} {:.4} {}", m.solid, m.best, m.unit);
        let moduli: Vec<String> = self.moduli().map(text).collect();
        let advice: String = self.uncertainty.advice.iter().map(|a| format!("; {a}")).collect();
        let mesh = self.uncertainty.mesh_error.map(|error| format!(", {:.2} mm from a finer mesh", 1e3 * error));
        let mesh = mesh.unwrap_or_default();
        let doubted = self.certificate.as_ref().ok().filter(|certificate| !certificate.holds());
        let doubt = doubted.map(|of| format!("; the reduced model is {:.1} deviations off there", of.sigma));
        format!(
            "loss {:.1e}, {} {:.1} s after loading{mesh}; {}{advice}{}",
            self.loss,
            moduli.join(", "),
            self.modulus_time,
            self.uncertainty.words,
            doubt.unwrap_or_default()
        )
    }
}

/// A modulus in the unit in which it is printed.
pub struct DisplayModulus<'a> {
    /// The solid.
    pub solid: &'a str,
    /// The modulus.
    pub best: f64,
    /// Its standard deviation.
    pub sigma: f64,
    /// "MPa" or "GPa".
    pub unit: &'static str,
    /// One Pa in it.
    pub scale: f64,
}

impl Identified {
    fn stiffening_metrics(&self, id: &dyn Fn(&str) -> String) -> Vec<Metric> {
        let Some(Stiffening { ratios, sigma }) = self.stiffening else { return Vec::new() };
        let metrics_of_ratio = |((name, ratio), sigma)| {
            [Metric::new(id(name), ratio, ""), Metric::new(id(&format!("{name}.sigma")), sigma, "")]
        };
        ["c20", "c30"].into_iter().zip(ratios).zip(sigma).flat_map(metrics_of_ratio).collect()
    }

    /// The identified constants of a model, at the time to which they belong.
    pub fn elastic(&self, model: &Model) -> Elastic {
        let Elastic { poissons_ratios, stiffening, .. } = model.nominal.clone();
        let stiffening = self.stiffening.map_or(stiffening, |identified| identified.ratios);
        Elastic { youngs_moduli: self.best.clone(), poissons_ratios, stiffening }
    }

    /// With the levels alone whose pressure is at most this `fraction` of the highest.
    pub fn up_to(mut self, fraction: f64) -> Self {
        let top = self.levels.iter().map(Level::pressure).fold(0.0, f64::max);
        self.levels.retain(|level| level.pressure() <= fraction * top);
        self
    }

    /// Moduli of the materials with their standard deviations, Pa: without what makes up for the error of the mesh.
    pub fn materials(&self) -> impl Iterator<Item = [Pascal; 2]> {
        let correction = |k: usize| self.uncertainty.mesh_correction(k);
        self.best
            .iter()
            .zip(&self.sigma)
            .enumerate()
            .map(move |(k, (best, sigma))| [best, sigma].map(|e| e * correction(k)))
    }

    /// The moduli of the materials in the units in which they are printed.
    pub fn moduli(&self) -> impl Iterator<Item = DisplayModulus<'_>> {
        self.solids.iter().zip(self.materials()).map(|(solid, [modulus, sigma])| {
            let ModulusUnit { scale, unit } = ModulusUnit::of(modulus);
            DisplayModulus { solid, best: scale * modulus, sigma: scale * sigma, unit, scale }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn identified() -> Identified {
        let moduli = |b: f64| vec![b, 3e9];
        Identified {
            solids: vec!["body".into(), "spine".into()],
            best: moduli(2e5),
            sigma: moduli(1e3),
            stiffening: Some(Stiffening { ratios: [0.02, 0.1], sigma: [0.01, 0.05] }),
            certificate: Ok(Certificate { sigma: 0.05, rounds: 2, whole_equilibria: 42 }),
            durations: IdentificationDurations {
                gradient_over_forward: 1.1,
                search: SearchDurations { training: 200.0, search: 2.0 },
            },
            modulus_time: 4.0,
            loss: 0.1,
            levels: Vec::new(),
            inflated: vec![[0.0, 1.0, 2.0]],
            length: 0.1,
            noise: NoiseModel { discrepancy_m: 1e-4, scale_sigma: 0.02 },
            discrepancy: Discrepancy {
                scale_sigma: 0.02,
                film_sigma: 0.015,
                shape_sigma: 0.005,
                correlation_length_m: 0.03,
                correlation_log_pressure: 1.0,
            },
            uncertainty: Uncertainty { sigma: vec![0.01, 0.1], words: "all".into(), ..Uncertainty::default() },
        }
    }

    #[test]
    fn an_identification_survives_its_record() {
        let record = identified();
        assert_eq!(Identified::from_files(&record.to_files().unwrap()).unwrap(), record);
    }

    #[test]
    fn levels_above_a_fraction_of_the_highest_pressure_are_left_out() {
        let levels =
            [[10e3, 0.0], [0.0, 19e3], [20e3, 0.0]].map(|p| Level { pressures_pa: p.to_vec(), ..Level::default() });
        let lower = |fraction: f64| Identified { levels: levels.to_vec(), ..identified() }.up_to(fraction).levels;
        assert_eq!(lower(0.96), levels[..2]);
        assert_eq!(lower(1.0), levels);
    }
}
