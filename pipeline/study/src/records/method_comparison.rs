//! Method comparison: every method of `optimize` on one loss, the loss between the grid's points, and profile likelihoods.

use serde::{Deserialize, Serialize};
use si::{MILLIBAR, MILLIMETRE, Metre, Pascal, Second};

use crate::records::{Moduli, Profile};
use crate::subject::Specimen;
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

/// The comparison on one specimen; empty where none was asked for.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MethodComparison {
    /// The solids' names, the softest first.
    pub solids: Vec<String>,
    /// Target length of an edge of the mesh, m; nothing where the body came as a mesh file, on which the methods are then compared.
    pub edge: Option<Metre>,
    /// The highest pressure of the levels, Pa.
    pub highest: Pascal,
    /// The methods, in the order of `optimisers`.
    pub searches: Vec<Search>,
    /// The landscape.
    pub surface: Surface,
    /// Profile likelihoods of both moduli; empty where the grid has gaps.
    pub profiles: Vec<Profile>,
    /// Largest difference of the adjoint gradient from central differences, over the gradient.
    pub gradient_difference: Option<f64>,
}

#[derive(Serialize, Deserialize)]
struct Scalars {
    solids: Vec<String>,
    edge_m: Option<Metre>,
    highest_pa: Pascal,
    methods: Vec<String>,
    profiles: Vec<Profile>,
    gradient_difference: Option<f64>,
}

#[derive(Serialize, Deserialize)]
struct Durations {
    seconds: Vec<f64>,
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

impl MethodComparison {
    /// The search of one method.
    pub(crate) fn by(&self, method: &str) -> Option<&Search> {
        self.searches.iter().find(|search| search.method == method)
    }

    /// Whether the methods were run.
    pub(crate) fn is_made(&self) -> bool {
        !self.searches.is_empty()
    }
}

impl Record for MethodComparison {
    type Of = Specimen;
    const STAGE: &'static str = "method_comparison";

    fn pack(&self) -> Result<RecordFiles, RecordError> {
        let scalars = Scalars {
            solids: self.solids.clone(),
            edge_m: self.edge,
            highest_pa: self.highest,
            methods: self.searches.iter().map(|s| s.method.clone()).collect(),
            profiles: self.profiles.clone(),
            gradient_difference: self.gradient_difference,
        };
        let durations = Durations { seconds: self.searches.iter().map(|s| s.seconds).collect() };
        RecordFiles::default()
            .scalars("method_comparison.json", &scalars)?
            .durations("durations.json", &durations)?
            .table("searches.parquet", &tried_columns(&self.solids, &self.searches))?
            .table("landscape.parquet", &surface_columns(&self.surface))
    }

    fn unpack(files: &RecordFiles) -> Result<Self, RecordError> {
        let s: Scalars = files.read_scalars("method_comparison.json")?;
        let d: Durations = files.read_scalars("durations.json")?;
        Ok(Self {
            searches: read_searches(&files.read_table("searches.parquet")?, &s, &d.seconds)?,
            surface: read_surface(&files.read_table("landscape.parquet")?)?,
            solids: s.solids,
            edge: s.edge_m,
            highest: s.highest_pa,
            profiles: s.profiles,
            gradient_difference: s.gradient_difference,
        })
    }

    fn metrics(&self, subject: &str) -> Vec<Metric> {
        if !self.is_made() {
            return Vec::new();
        }
        // named after what the methods do: they identify
        let id = |what: &str| format!("identify.{subject}.{what}");
        let mut metrics: Vec<Metric> = self.searches.iter().flat_map(|s| s.metrics(&id(&s.method))).collect();
        metrics.extend(self.edge.map(|edge| Metric::new(id("compared_edge_mm"), edge / MILLIMETRE, "mm")));
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
    if scalars.methods.len() != seconds.len() {
        return Err(super::unfit(
            "durations.json",
            format!("{} durations of {} methods", seconds.len(), scalars.methods.len()),
        ));
    }
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
    // length: a row ends where the height changes; the grid is held to it below
    let width = up.iter().take_while(|&&s| Some(&s) == up.first()).count().max(1);
    if !up.len().is_multiple_of(width) || across.iter().zip(across.iter().skip(width)).any(|(own, next)| own != next) {
        return Err(super::unfit("landscape.parquet", "its rows are no grid"));
    }
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
    fn a_comparison_survives_its_record() {
        let at = |b: f64| vec![b, 3e9];
        let tried = vec![EvaluatedPoint { at: at(2e5), loss: 0.1 }, EvaluatedPoint { at: at(1e5), loss: 0.2 }];
        let surface = Surface {
            across: vec![1e5, 2e5],
            up: vec![1e9, 2e9, 3e9],
            loss: (0..6).map(f64::from).collect(),
            critical: vec![0.0, 1.8e4, 0.0, 1.9e4, 2e4, 2.1e4],
        };
        let whole = MethodComparison {
            solids: vec!["body".into(), "spine".into()],
            edge: Some(4e-3),
            highest: 2.1e4,
            searches: vec![Search { method: "adam".into(), tried, seconds: 2.0 }],
            surface,
            profiles: vec![Profile { parameter: "body_e".into(), value: vec![1e5], chi_square: vec![0.0] }],
            gradient_difference: Some(1e-7),
        };
        for one in [whole, MethodComparison::default()] {
            assert_eq!(MethodComparison::unpack(&one.pack().unwrap()).unwrap(), one);
        }
    }
}
