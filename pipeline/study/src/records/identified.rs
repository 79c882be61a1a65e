//! Identified: the Young's moduli that minimise the quasi-static misfit, with their uncertainty and the searches.

use serde::{Deserialize, Serialize};
use si::{Metre, Pascal, Point3, Second};

use crate::records::{Profile, Uncertainty};
use crate::subject::Specimen;
use sysid::{Discrepancy, Elastic, Level, Model, NoiseModel};
use workflow::columns::Columns;
use workflow::metric::Metric;
use workflow::record::{Record, RecordError, RecordFiles};

/// Young's moduli of the solids, Pa, the softest first.
pub type Moduli = Vec<Pascal>;

/// One simulation of all levels at one point.
#[derive(Debug, Clone, PartialEq)]
pub struct EvaluatedPoint {
    /// The point.
    pub at: Moduli,
    /// Mean distance of simulated from measured displacement over the specimen's length.
    pub loss: f64,
}

/// The evaluations of one method.
#[derive(Debug, Clone, PartialEq)]
pub struct Search {
    /// "grid", "cma_es", "adam", "gauss_newton".
    pub method: String,
    /// Every simulation, in order.
    pub tried: Vec<EvaluatedPoint>,
    /// How long it took.
    pub seconds: Second,
}

/// The loss over the plane of two moduli, between the grid's points.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Surface {
    /// Columns: modulus of the softest solid, Pa.
    pub across: Vec<Pascal>,
    /// Rows: modulus of the other, Pa.
    pub up: Vec<Pascal>,
    /// Rows × columns, row after row.
    pub loss: Vec<f64>,
    /// The pressures at which the slack walls buckle, in the same order, Pa; 0 where they do not, or an equilibrium is missing.
    pub critical: Vec<Pascal>,
}

/// The whole identification of one specimen.
#[derive(Debug, Clone, PartialEq)]
pub struct Identified {
    /// The solids' names, the softest first.
    pub solids: Vec<String>,
    /// The moduli found.
    pub best: Moduli,
    /// Their standard deviations, Pa.
    pub sigma: Moduli,
    /// Stiffening of the softest solid; none where its law does not stiffen.
    pub stiffening: Option<Stiffening>,
    /// Time after loading to which they belong, s: the mean over the holds.
    pub modulus_time: Second,
    /// The loss there.
    pub loss: f64,
    /// Largest difference of the adjoint gradient from central differences, over the gradient; of compared specimens.
    pub gradient_difference: Option<f64>,
    /// Time of a loss with its gradient over the time of the loss alone.
    pub gradient_over_forward: f64,
    /// The methods, in the order of `optimisers`: all of them, or Gauss-Newton alone.
    pub searches: Vec<Search>,
    /// The landscape; empty where no grid was searched.
    pub surface: Surface,
    /// The levels.
    pub levels: Vec<Level>,
    /// Displacement of every node at the highest level, m.
    pub inflated: Vec<Point3>,
    /// The specimen's length, m.
    pub length: Metre,
    /// Noise model beside the markers' covariance, by which the search weighed the levels.
    pub noise: NoiseModel,
    /// The discrepancy that its residuals show.
    pub discrepancy: Discrepancy,
    /// Uncertainty of the moduli.
    pub uncertainty: Uncertainty,
    /// Profile likelihoods of both moduli.
    pub profiles: Vec<Profile>,
}

/// Identified stiffening of the softest solid.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Stiffening {
    /// C₂₀/C₁₀ and C₃₀/C₁₀.
    pub ratios: [f64; 2],
    /// Their standard deviations.
    pub sigma: [f64; 2],
}

#[derive(Serialize, Deserialize)]
struct Scalars {
    solids: Vec<String>,
    best: Moduli,
    sigma: Moduli,
    stiffening: Option<Stiffening>,
    modulus_time_s: f64,
    loss: f64,
    gradient_difference: Option<f64>,
    length_m: f64,
    levels: Vec<Level>,
    methods: Vec<String>,
    noise: NoiseModel,
    discrepancy: Discrepancy,
    uncertainty: Uncertainty,
    profiles: Vec<Profile>,
}

#[derive(Serialize, Deserialize)]
struct Durations {
    seconds: Vec<f64>,
    gradient_over_forward: f64,
}

impl Search {
    /// How many times all levels were simulated, as the paper counts iterations.
    pub fn iterations(&self) -> usize {
        self.tried.len()
    }

    /// The lowest loss of all.
    pub fn loss(&self) -> f64 {
        self.loss_after(usize::MAX)
    }

    /// The lowest loss among the first simulations, the start included.
    pub(crate) fn loss_after(&self, simulations: usize) -> f64 {
        self.tried.iter().take(simulations).map(|t| t.loss).fold(f64::INFINITY, f64::min)
    }
}

impl Record for Identified {
    type Of = Specimen;
    const STAGE: &'static str = "identify";

    fn pack(&self) -> Result<RecordFiles, RecordError> {
        let scalars = Scalars {
            solids: self.solids.clone(),
            best: self.best.clone(),
            sigma: self.sigma.clone(),
            stiffening: self.stiffening,
            modulus_time_s: self.modulus_time,
            loss: self.loss,
            gradient_difference: self.gradient_difference,
            length_m: self.length,
            levels: self.levels.clone(),
            methods: self.searches.iter().map(|s| s.method.clone()).collect(),
            noise: self.noise,
            discrepancy: self.discrepancy,
            uncertainty: self.uncertainty.clone(),
            profiles: self.profiles.clone(),
        };
        let durations = Durations {
            seconds: self.searches.iter().map(|s| s.seconds).collect(),
            gradient_over_forward: self.gradient_over_forward,
        };
        let axis = |k: usize| self.inflated.iter().map(|u| u[k]).collect();
        let inflated = Columns::default().numbers("x_m", axis(0)).numbers("y_m", axis(1)).numbers("z_m", axis(2));
        RecordFiles::default()
            .scalars("identified.json", &scalars)?
            .durations("durations.json", &durations)?
            .table("searches.parquet", &tried_columns(&self.solids, &self.searches))?
            .table("landscape.parquet", &surface_columns(&self.surface))?
            .table("inflated.parquet", &inflated)
    }

    fn unpack(files: &RecordFiles) -> Result<Self, RecordError> {
        let s: Scalars = files.read_scalars("identified.json")?;
        let d: Durations = files.read_scalars("durations.json")?;
        let searches = read_searches(&files.read_table("searches.parquet")?, &s, &d.seconds)?;
        let inflated = files.read_table("inflated.parquet")?;
        let (x, y, z) = (inflated.f64("x_m")?, inflated.f64("y_m")?, inflated.f64("z_m")?);
        Ok(Self {
            solids: s.solids,
            best: s.best,
            sigma: s.sigma,
            stiffening: s.stiffening,
            modulus_time: s.modulus_time_s,
            loss: s.loss,
            gradient_difference: s.gradient_difference,
            gradient_over_forward: d.gradient_over_forward,
            searches,
            surface: read_surface(&files.read_table("landscape.parquet")?)?,
            levels: s.levels,
            inflated: x.into_iter().zip(y).zip(z).map(|((x, y), z)| [x, y, z]).collect(),
            length: s.length_m,
            noise: s.noise,
            discrepancy: s.discrepancy,
            uncertainty: s.uncertainty,
            profiles: s.profiles,
        })
    }

    fn metrics(&self, subject: &str) -> Vec<Metric> {
        let id = |what: &str| format!("identify.{subject}.{what}");
        let moduli = self.moduli().flat_map(|one| {
            let name = format!("{}_e_{}", one.solid, one.unit.to_lowercase());
            [Metric::new(id(&name), one.best, one.unit), Metric::new(id(&format!("{name}.sigma")), one.sigma, one.unit)]
        });
        let mut metrics: Vec<Metric> = moduli.collect();
        metrics.extend(self.stiffening.iter().flat_map(|found| {
            let named = ["c20", "c30"].into_iter().zip(found.ratios).zip(found.sigma);
            named.flat_map(|((name, ratio), sigma)| {
                [Metric::new(id(name), ratio, ""), Metric::new(id(&format!("{name}.sigma")), sigma, "")]
            })
        }));
        metrics.extend([
            Metric::new(id("modulus_time_s"), self.modulus_time, "s"),
            Metric::new(id("loss"), self.loss, ""),
            Metric::new(id("gradient_over_forward"), self.gradient_over_forward, ""),
            Metric::new(id("chi_square"), self.uncertainty.chi_square, ""),
        ]);
        metrics.extend(self.solids.iter().zip(&self.uncertainty.discretisation).map(|(solid, shift)| {
            Metric::new(id(&format!("{solid}_e.discretisation_percent")), 100.0 * shift.exp_m1(), "%")
        }));
        metrics.extend(self.uncertainty.first_correlation().map(|c| Metric::new(id("correlation"), c, "")));
        metrics.extend(self.gradient_difference.map(|g| Metric::new(id("gradient_difference"), g, "")));
        metrics.extend(self.searches.iter().flat_map(|s| s.metrics(&id(&s.method))));
        let largest = self.levels.iter().map(Level::largest_error).fold(0.0, f64::max);
        metrics.push(Metric::new(format!("static.{subject}.max_error_mm"), 1e3 * largest, "mm"));
        metrics
    }

    fn summary(&self) -> String {
        let one = |m: DisplayModulus<'_>| format!("{} {:.4} {}", m.solid, m.best, m.unit);
        let moduli: Vec<String> = self.moduli().map(one).collect();
        let advice: String = self.uncertainty.advice.iter().map(|a| format!("; {a}")).collect();
        format!(
            "loss {:.1e}, {} {:.1} s after loading; {}{advice}",
            self.loss,
            moduli.join(", "),
            self.modulus_time,
            self.uncertainty.words
        )
    }
}

/// A modulus in the unit in which it is printed.
pub(crate) struct DisplayModulus<'a> {
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

/// Moduli from here on are printed in GPa: elastomers lie below, plastics above.
const STIFF: Pascal = 1e8;

/// The unit in which a modulus is printed.
pub(crate) struct DisplayUnit {
    /// One Pa in it.
    pub scale: f64,
    /// "MPa" or "GPa".
    pub unit: &'static str,
}

impl DisplayUnit {
    /// Of a modulus.
    pub(crate) fn of(modulus: Pascal) -> Self {
        if modulus < STIFF { Self { scale: 1e-6, unit: "MPa" } } else { Self { scale: 1e-9, unit: "GPa" } }
    }
}

impl Identified {
    /// The identified constants of a model, at the time to which they belong.
    pub(crate) fn elastic(&self, model: &Model) -> Elastic {
        let Elastic { poissons_ratios, stiffening, .. } = model.nominal.clone();
        let stiffening = self.stiffening.map_or(stiffening, |found| found.ratios);
        Elastic { youngs_moduli: self.best.clone(), poissons_ratios, stiffening }
    }

    /// The moduli in the units in which they are printed.
    pub(crate) fn moduli(&self) -> impl Iterator<Item = DisplayModulus<'_>> {
        self.solids.iter().zip(&self.best).zip(&self.sigma).map(|((solid, best), sigma)| {
            let DisplayUnit { scale, unit } = DisplayUnit::of(*best);
            DisplayModulus { solid, best: scale * best, sigma: scale * sigma, unit, scale }
        })
    }
}

impl Search {
    fn metrics(&self, id: &str) -> Vec<Metric> {
        let iterations = self.iterations() as f64;
        vec![
            Metric::new(format!("{id}.loss"), self.loss(), ""),
            Metric::new(format!("{id}.loss_after_4"), self.loss_after(5), ""),
            Metric::new(format!("{id}.iterations"), iterations, ""),
            Metric::new(format!("{id}.seconds"), self.seconds, "s"),
            Metric::new(format!("{id}.seconds_per_iteration"), self.seconds / iterations.max(1.0), "s"),
        ]
    }
}

/// The column of a solid's modulus.
fn column(solid: &str) -> String {
    format!("{solid}_e_pa")
}

fn tried_columns(solids: &[String], searches: &[Search]) -> Columns {
    let all = || searches.iter().flat_map(|s| s.tried.iter().map(move |t| (s, t)));
    let methods = Columns::default().words("method", all().map(|(s, _)| s.method.clone()).collect());
    let moduli = solids.iter().enumerate();
    let columns = moduli.fold(methods, |c, (k, s)| c.numbers(&column(s), all().map(|(_, t)| t.at[k]).collect()));
    columns.numbers("loss", all().map(|(_, t)| t.loss).collect())
}

fn read_searches(columns: &Columns, scalars: &Scalars, seconds: &[f64]) -> Result<Vec<Search>, RecordError> {
    let (names, loss) = (columns.text("method")?, columns.f64("loss")?);
    let moduli = scalars.solids.iter().map(|s| columns.f64(&column(s))).collect::<Result<Vec<_>, _>>()?;
    let tried = |i: usize| EvaluatedPoint { at: moduli.iter().map(|values| values[i]).collect(), loss: loss[i] };
    let search = |(method, &seconds): (&String, &f64)| Search {
        method: method.clone(),
        tried: (0..names.len()).filter(|&i| names[i] == *method).map(tried).collect(),
        seconds,
    };
    Ok(scalars.methods.iter().zip(seconds).map(search).collect())
}

fn surface_columns(surface: &Surface) -> Columns {
    let columns = surface.across.len().max(1);
    let place = |i: usize| (surface.across[i % columns], surface.up[i / columns]);
    let all = 0..surface.loss.len();
    Columns::default()
        .numbers("across_pa", all.clone().map(|i| place(i).0).collect())
        .numbers("up_pa", all.map(|i| place(i).1).collect())
        .numbers("loss", surface.loss.clone())
        .numbers("critical_pa", surface.critical.clone())
}

fn read_surface(columns: &Columns) -> Result<Surface, RecordError> {
    let (across, up) = (columns.f64("across_pa")?, columns.f64("up_pa")?);
    let width = up.iter().take_while(|&&s| Some(&s) == up.first()).count().max(1);
    Ok(Surface {
        across: across.iter().take(width).copied().collect(),
        up: up.iter().step_by(width).copied().collect(),
        loss: columns.f64("loss")?,
        critical: columns.f64("critical_pa")?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_identification_survives_its_record() {
        let at = |b: f64| vec![b, 3e9];
        let tried = vec![EvaluatedPoint { at: at(2e5), loss: 0.1 }, EvaluatedPoint { at: at(1e5), loss: 0.2 }];
        let surface = Surface {
            across: vec![1e5, 2e5],
            up: vec![1e9, 2e9, 3e9],
            loss: (0..6).map(f64::from).collect(),
            critical: vec![0.0, 1.8e4, 0.0, 1.9e4, 2e4, 2.1e4],
        };
        let whole = Identified {
            solids: vec!["body".into(), "spine".into()],
            best: at(2e5),
            sigma: at(1e3),
            stiffening: Some(Stiffening { ratios: [0.02, 0.1], sigma: [0.01, 0.05] }),
            modulus_time: 4.0,
            loss: 0.1,
            gradient_difference: Some(1e-7),
            gradient_over_forward: 1.1,
            searches: vec![Search { method: "adam".into(), tried, seconds: 2.0 }],
            surface,
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
            profiles: vec![Profile { parameter: "body_e".into(), value: vec![1e5], chi_square: vec![0.0] }],
        };
        assert_eq!(Identified::unpack(&whole.pack().unwrap()).unwrap(), whole);
    }
}
