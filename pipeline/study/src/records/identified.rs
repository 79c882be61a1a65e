//! Identified: the Young's moduli with which the simulation follows the quasi-static films best, and how they were found.

use serde::{Deserialize, Serialize};
use si::{Metre, Pascal, Point2, Point3, Second};

use super::Spread;
use crate::columns::Columns;
use crate::metric::Metric;
use crate::record::{Parcel, Record, RecordError};
use crate::subject::Specimen;

/// Young's moduli of the two regions, Pa.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// The soft body's.
    pub body_e_pa: Pascal,
    /// The stiff sheet's.
    pub spine_e_pa: Pascal,
}

/// One simulation of all levels at one point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tried {
    /// Where.
    pub at: Point,
    /// Mean distance of simulated from measured displacement over the specimen's length.
    pub loss: f64,
}

/// How one method went.
#[derive(Debug, Clone, PartialEq)]
pub struct Search {
    /// "grid", "cma_es", "adam", "gauss_newton".
    pub method: String,
    /// Every simulation, in order.
    pub tried: Vec<Tried>,
    /// How long it took.
    pub seconds: Second,
}

/// The loss over the plane of both moduli, between the grid's points.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Surface {
    /// Columns, Pa.
    pub body_e_pa: Vec<Pascal>,
    /// Rows, Pa.
    pub spine_e_pa: Vec<Pascal>,
    /// Rows × columns, row after row.
    pub loss: Vec<f64>,
}

/// One pressure level, measured and simulated with the identified moduli.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Level {
    /// The trial it belongs to.
    pub trial: String,
    /// Measured pressures in the order of the card's chambers, Pa.
    pub pressures_pa: Vec<Pascal>,
    /// Where the markers are at rest, m.
    pub rest_m: Vec<Point2>,
    /// Measured displacements, m.
    pub measured_m: Vec<Point2>,
    /// How well they are known, m².
    pub spread_m2: Vec<Spread>,
    /// Simulated displacements, m.
    pub simulated_m: Vec<Point2>,
}

/// What the covariance of the markers does not know.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Doubt {
    /// Standard deviation of each displacement for what the model leaves out, m.
    pub discrepancy_m: Metre,
    /// Standard deviation of the share by which all displacements of a film are off together, no unit.
    pub share: f64,
}

/// How sure the parameters are.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Certainty {
    /// Standard deviations of the logarithms of the parameters.
    pub sigma: Vec<f64>,
    /// Correlation of the first two.
    pub correlation: f64,
    /// χ² over the freedoms: near 1 when the covariance told the truth.
    pub chi_square: f64,
    /// What is certain and what is not.
    pub words: String,
    /// What would tell more, and what lies outside of what is plausible.
    pub advice: Vec<String>,
}

/// χ² over one parameter, the other at its best for each value.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Profile {
    /// "body_e" or "spine_e".
    pub parameter: String,
    /// Pa.
    pub value: Vec<f64>,
    /// Above the lowest.
    pub chi_square: Vec<f64>,
}

/// The whole identification of one specimen.
#[derive(Debug, Clone, PartialEq)]
pub struct Identified {
    /// The moduli found.
    pub best: Point,
    /// Their standard deviations, Pa.
    pub sigma: Point,
    /// The loss there.
    pub loss: f64,
    /// Largest difference of the adjoint gradient from central differences, over the gradient; of compared specimens.
    pub gradient_difference: Option<f64>,
    /// Time of a loss with gradient over the time of the loss alone.
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
    /// What was taken into account beside the markers' covariance.
    pub doubt: Doubt,
    /// How sure the moduli are.
    pub certainty: Certainty,
    /// Profile likelihoods of both moduli.
    pub profiles: Vec<Profile>,
}

#[derive(Serialize, Deserialize)]
struct Scalars {
    best: Point,
    sigma: Point,
    loss: f64,
    gradient_difference: Option<f64>,
    length_m: f64,
    levels: Vec<Level>,
    methods: Vec<String>,
    doubt: Doubt,
    certainty: Certainty,
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
    pub fn loss_after(&self, simulations: usize) -> f64 {
        self.tried.iter().take(simulations).map(|t| t.loss).fold(f64::INFINITY, f64::min)
    }
}

impl Level {
    /// The largest distance of a simulated from a measured displacement, m.
    pub fn largest_error(&self) -> Metre {
        let off = |(m, s): (&Point2, &Point2)| (m[0] - s[0]).hypot(m[1] - s[1]);
        self.measured_m.iter().zip(&self.simulated_m).map(off).fold(0.0, f64::max)
    }

    /// The highest of its pressures, Pa.
    pub fn pressure(&self) -> Pascal {
        self.pressures_pa.iter().copied().fold(f64::MIN, f64::max)
    }
}

impl Record for Identified {
    type Of = Specimen;
    const STAGE: &'static str = "identify";

    fn pack(&self) -> Result<Parcel, RecordError> {
        let scalars = Scalars {
            best: self.best,
            sigma: self.sigma,
            loss: self.loss,
            gradient_difference: self.gradient_difference,
            length_m: self.length,
            levels: self.levels.clone(),
            methods: self.searches.iter().map(|s| s.method.clone()).collect(),
            doubt: self.doubt,
            certainty: self.certainty.clone(),
            profiles: self.profiles.clone(),
        };
        let durations = Durations {
            seconds: self.searches.iter().map(|s| s.seconds).collect(),
            gradient_over_forward: self.gradient_over_forward,
        };
        let axis = |k: usize| self.inflated.iter().map(|u| u[k]).collect();
        let inflated = Columns::default().numbers("x_m", axis(0)).numbers("y_m", axis(1)).numbers("z_m", axis(2));
        Parcel::default()
            .scalars("identified.json", &scalars)?
            .durations("durations.json", &durations)?
            .table("searches.parquet", &tried_columns(&self.searches))?
            .table("landscape.parquet", &surface_columns(&self.surface))?
            .table("inflated.parquet", &inflated)
    }

    fn unpack(parcel: &Parcel) -> Result<Self, RecordError> {
        let s: Scalars = parcel.read_scalars("identified.json")?;
        let d: Durations = parcel.read_scalars("durations.json")?;
        let inflated = parcel.read_table("inflated.parquet")?;
        let (x, y, z) = (inflated.f64("x_m")?, inflated.f64("y_m")?, inflated.f64("z_m")?);
        Ok(Self {
            best: s.best,
            sigma: s.sigma,
            loss: s.loss,
            gradient_difference: s.gradient_difference,
            gradient_over_forward: d.gradient_over_forward,
            searches: read_searches(&parcel.read_table("searches.parquet")?, &s.methods, &d.seconds)?,
            surface: read_surface(&parcel.read_table("landscape.parquet")?)?,
            levels: s.levels,
            inflated: x.into_iter().zip(y).zip(z).map(|((x, y), z)| [x, y, z]).collect(),
            length: s.length_m,
            doubt: s.doubt,
            certainty: s.certainty,
            profiles: s.profiles,
        })
    }

    fn metrics(&self, of: &Specimen) -> Vec<Metric> {
        let id = |what: &str| format!("identify.{}.{what}", of.card.name);
        let mut metrics = vec![
            Metric::new(id("body_e_mpa"), 1e-6 * self.best.body_e_pa, "MPa"),
            Metric::new(id("body_e_mpa.sigma"), 1e-6 * self.sigma.body_e_pa, "MPa"),
            Metric::new(id("spine_e_gpa"), 1e-9 * self.best.spine_e_pa, "GPa"),
            Metric::new(id("spine_e_gpa.sigma"), 1e-9 * self.sigma.spine_e_pa, "GPa"),
            Metric::new(id("loss"), self.loss, ""),
            Metric::new(id("gradient_over_forward"), self.gradient_over_forward, ""),
            Metric::new(id("correlation"), self.certainty.correlation, ""),
            Metric::new(id("chi_square"), self.certainty.chi_square, ""),
        ];
        metrics.extend(self.gradient_difference.map(|g| Metric::new(id("gradient_difference"), g, "")));
        metrics.extend(self.searches.iter().flat_map(|s| s.metrics(&id(&s.method))));
        let largest = self.levels.iter().map(Level::largest_error).fold(0.0, f64::max);
        metrics.push(Metric::new(format!("static.{}.max_error_mm", of.card.name), 1e3 * largest, "mm"));
        metrics
    }

    fn telling(&self) -> String {
        let (body, spine) = (1e-6 * self.best.body_e_pa, 1e-9 * self.best.spine_e_pa);
        let advice: String = self.certainty.advice.iter().map(|a| format!("; {a}")).collect();
        format!("loss {:.1e}, body {body:.4} MPa, spine {spine:.3} GPa; {}{advice}", self.loss, self.certainty.words)
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

fn tried_columns(searches: &[Search]) -> Columns {
    let all = || searches.iter().flat_map(|s| s.tried.iter().map(move |t| (s, t)));
    Columns::default()
        .words("method", all().map(|(s, _)| s.method.clone()).collect())
        .numbers("body_e_pa", all().map(|(_, t)| t.at.body_e_pa).collect())
        .numbers("spine_e_pa", all().map(|(_, t)| t.at.spine_e_pa).collect())
        .numbers("loss", all().map(|(_, t)| t.loss).collect())
}

fn read_searches(columns: &Columns, methods: &[String], seconds: &[f64]) -> Result<Vec<Search>, RecordError> {
    let names = columns.text("method")?;
    let (body, spine, loss) = (columns.f64("body_e_pa")?, columns.f64("spine_e_pa")?, columns.f64("loss")?);
    let tried = |i: usize| Tried { at: Point { body_e_pa: body[i], spine_e_pa: spine[i] }, loss: loss[i] };
    let search = |(method, &seconds): (&String, &f64)| Search {
        method: method.clone(),
        tried: (0..names.len()).filter(|&i| names[i] == *method).map(tried).collect(),
        seconds,
    };
    Ok(methods.iter().zip(seconds).map(search).collect())
}

fn surface_columns(surface: &Surface) -> Columns {
    let columns = surface.body_e_pa.len().max(1);
    let place = |i: usize| (surface.body_e_pa[i % columns], surface.spine_e_pa[i / columns]);
    let all = 0..surface.loss.len();
    Columns::default()
        .numbers("body_e_pa", all.clone().map(|i| place(i).0).collect())
        .numbers("spine_e_pa", all.map(|i| place(i).1).collect())
        .numbers("loss", surface.loss.clone())
}

fn read_surface(columns: &Columns) -> Result<Surface, RecordError> {
    let (body, spine) = (columns.f64("body_e_pa")?, columns.f64("spine_e_pa")?);
    let width = spine.iter().take_while(|&&s| Some(&s) == spine.first()).count().max(1);
    Ok(Surface {
        body_e_pa: body.iter().take(width).copied().collect(),
        spine_e_pa: spine.iter().step_by(width).copied().collect(),
        loss: columns.f64("loss")?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_identification_survives_its_record() {
        let at = |b: f64| Point { body_e_pa: b, spine_e_pa: 3e9 };
        let tried = vec![Tried { at: at(2e5), loss: 0.1 }, Tried { at: at(1e5), loss: 0.2 }];
        let surface = Surface {
            body_e_pa: vec![1e5, 2e5],
            spine_e_pa: vec![1e9, 2e9, 3e9],
            loss: (0..6).map(f64::from).collect(),
        };
        let whole = Identified {
            best: at(2e5),
            sigma: at(1e3),
            loss: 0.1,
            gradient_difference: Some(1e-7),
            gradient_over_forward: 1.1,
            searches: vec![Search { method: "adam".into(), tried, seconds: 2.0 }],
            surface,
            levels: Vec::new(),
            inflated: vec![[0.0, 1.0, 2.0]],
            length: 0.1,
            doubt: Doubt { discrepancy_m: 1e-4, share: 0.02 },
            certainty: Certainty { sigma: vec![0.01, 0.1], words: "all".into(), ..Certainty::default() },
            profiles: vec![Profile { parameter: "body_e".into(), value: vec![1e5], chi_square: vec![0.0] }],
        };
        assert_eq!(Identified::unpack(&whole.pack().unwrap()).unwrap(), whole);
    }
}
