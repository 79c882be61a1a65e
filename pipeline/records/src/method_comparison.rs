//! Method comparison: every method of `optimize` on one loss, the loss between the grid's points, and profile likelihoods.

use serde::{Deserialize, Serialize};
use si::{MILLIBAR, Pascal, Second};

use crate::subject::Specimen;
use crate::{Moduli, Profile};
use sysid::Certificate;
use workflow::columns::Columns;
use workflow::metric::Metric;
use workflow::record::{Record, RecordError, RecordFiles};

/// One simulation of all levels at one point.
#[derive(Debug, Clone, PartialEq)]
pub struct EvaluatedPoint {
    /// The point.
    pub at: Moduli,
    /// Mean distance of simulated from measured displacement over the specimen's length.
    pub loss: f64,
}

/// The evaluations of one method.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Search {
    /// "grid", "cma_es", "adam", "gauss_newton".
    pub method: String,
    /// Every simulation, in order.
    #[serde(skip)]
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

/// The comparison on one specimen; empty where none was asked for. Durations and tables are files of their own.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct MethodComparison {
    /// The solids' names, the softest first.
    pub solids: Vec<String>,
    /// The highest pressure of the levels, Pa.
    #[serde(rename = "highest_pa")]
    pub highest: Pascal,
    /// How far the reduced model in which they searched may be trusted at their ends.
    pub certificate: Certificate,
    /// Profile likelihoods of both moduli; empty where the grid has gaps.
    pub profiles: Vec<Profile>,
    /// Largest difference of the adjoint gradient from central differences, over the gradient.
    pub gradient_difference: Option<f64>,
    /// The methods, in the order of `optimisers`.
    #[serde(skip)]
    pub searches: Vec<Search>,
    /// How long the whole body takes for one simulation there, s of one core.
    #[serde(skip)]
    pub whole_seconds: Second,
    /// The landscape.
    #[serde(skip)]
    pub surface: Surface,
}

#[derive(Serialize, Deserialize)]
struct Durations {
    searches: Vec<Search>,
    whole_seconds: Second,
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

impl MethodComparison {
    /// The search of one method.
    pub fn by(&self, method: &str) -> Option<&Search> {
        self.searches.iter().find(|search| search.method == method)
    }

    /// Whether the methods were run.
    pub fn is_made(&self) -> bool {
        !self.searches.is_empty()
    }
}

impl Record for MethodComparison {
    type Of = Specimen;
    const STAGE: &'static str = "method_comparison";

    fn to_files(&self) -> Result<RecordFiles, RecordError> {
        let durations = Durations { searches: self.searches.clone(), whole_seconds: self.whole_seconds };
        RecordFiles::default()
            .scalars("method_comparison.json", self)?
            .durations("durations.json", &durations)?
            .table("searches.parquet", &tried_columns(&self.solids, &self.searches))?
            .table("landscape.parquet", &surface_columns(&self.surface))
    }

    fn from_files(files: &RecordFiles) -> Result<Self, RecordError> {
        let recorded: Self = files.read_scalars("method_comparison.json")?;
        let Durations { searches, whole_seconds } = files.read_scalars("durations.json")?;
        Ok(Self {
            searches: read_searches(&files.read_table("searches.parquet")?, &recorded.solids, searches)?,
            surface: read_surface(&files.read_table("landscape.parquet")?)?,
            whole_seconds,
            ..recorded
        })
    }

    fn metrics(&self, subject: &str) -> Vec<Metric> {
        if !self.is_made() {
            return Vec::new();
        }
        // named after what the methods do: they identify
        let id = |quantity: &str| format!("identify.{subject}.{quantity}");
        let mut metrics: Vec<Metric> = self.searches.iter().flat_map(|s| s.search_metrics(&id(&s.method))).collect();
        metrics.push(Metric::new(id("compared_certificate_sigma"), self.certificate.sigma, ""));
        metrics.push(Metric::new(id("compared_certificate_rounds"), self.certificate.rounds as f64, ""));
        metrics.push(Metric::new(id("compared_whole_seconds"), self.whole_seconds, "s"));
        metrics.push(Metric::new(id("compared_highest_mbar"), self.highest / MILLIBAR, "mbar"));
        metrics.extend(self.gradient_difference.map(|g| Metric::new(id("gradient_difference"), g, "")));
        metrics
    }

    fn summary(&self) -> String {
        if !self.is_made() {
            return "not among the specimens of [method_comparison]".into();
        }
        let each: Vec<String> =
            self.searches.iter().map(|s| format!("{} {:.1e} in {}", s.method, s.loss(), s.iterations())).collect();
        format!("loss and simulations: {}", each.join(", "))
    }
}

impl Search {
    fn search_metrics(&self, id: &str) -> Vec<Metric> {
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
fn modulus_column(solid: &str) -> String {
    format!("{solid}_e_pa")
}

fn tried_columns(solids: &[String], searches: &[Search]) -> Columns {
    let evaluations = || searches.iter().flat_map(|s| s.tried.iter().map(move |t| (s, t)));
    let methods = Columns::default().words("method", evaluations().map(|(s, _)| s.method.clone()).collect());
    let moduli = solids.iter().enumerate();
    let columns =
        moduli.fold(methods, |c, (k, s)| c.numbers(&modulus_column(s), evaluations().map(|(_, t)| t.at[k]).collect()));
    columns.numbers("loss", evaluations().map(|(_, t)| t.loss).collect())
}

/// The searches with what each tried.
fn read_searches(columns: &Columns, solids: &[String], searches: Vec<Search>) -> Result<Vec<Search>, RecordError> {
    let (names, loss) = (columns.text("method")?, columns.f64("loss")?);
    let moduli = solids.iter().map(|s| columns.f64(&modulus_column(s))).collect::<Result<Vec<_>, _>>()?;
    let tried = |i: usize| EvaluatedPoint { at: moduli.iter().map(|values| values[i]).collect(), loss: loss[i] };
    let of_method = |method: &str| (0..names.len()).filter(|&i| names[i] == method).map(tried).collect();
    Ok(searches.into_iter().map(|search| Search { tried: of_method(&search.method), ..search }).collect())
}

fn surface_columns(surface: &Surface) -> Columns {
    let columns = surface.across.len().max(1);
    let grid_point = |i: usize| (surface.across[i % columns], surface.up[i / columns]);
    let indices = 0..surface.loss.len();
    Columns::default()
        .numbers("across_pa", indices.clone().map(|i| grid_point(i).0).collect())
        .numbers("up_pa", indices.map(|i| grid_point(i).1).collect())
        .numbers("loss", surface.loss.clone())
        .numbers("critical_pa", surface.critical.clone())
}

fn read_surface(columns: &Columns) -> Result<Surface, RecordError> {
    let (x, y) = (columns.f64("across_pa")?, columns.f64("up_pa")?);
    // length: a row ends where the height changes; the grid is held to it below
    let width = y.iter().take_while(|&&s| Some(&s) == y.first()).count().max(1);
    if !y.len().is_multiple_of(width) || x.iter().zip(x.iter().skip(width)).any(|(current, next)| current != next) {
        return Err(super::inconsistent_file("landscape.parquet", "its rows are no grid"));
    }
    Ok(Surface {
        across: x.iter().take(width).copied().collect(),
        up: y.iter().step_by(width).copied().collect(),
        loss: columns.f64("loss")?,
        critical: columns.f64("critical_pa")?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_comparison_survives_its_record() {
        let moduli = |b: f64| vec![b, 3e9];
        let tried = vec![EvaluatedPoint { at: moduli(2e5), loss: 0.1 }, EvaluatedPoint { at: moduli(1e5), loss: 0.2 }];
        let surface = Surface {
            across: vec![1e5, 2e5],
            up: vec![1e9, 2e9, 3e9],
            loss: (0..6).map(f64::from).collect(),
            critical: vec![0.0, 1.8e4, 0.0, 1.9e4, 2e4, 2.1e4],
        };
        let comparison = MethodComparison {
            solids: vec!["body".into(), "spine".into()],
            highest: 2.1e4,
            searches: vec![Search { method: "adam".into(), tried, seconds: 2.0 }],
            certificate: Certificate { sigma: 0.02, rounds: 1, whole_equilibria: 24 },
            whole_seconds: 30.0,
            surface,
            profiles: vec![Profile { parameter: "body_e".into(), value: vec![1e5], chi_square: vec![0.0] }],
            gradient_difference: Some(1e-7),
        };
        for record in [comparison, MethodComparison::default()] {
            assert_eq!(MethodComparison::from_files(&record.to_files().unwrap()).unwrap(), record);
        }
    }
}
