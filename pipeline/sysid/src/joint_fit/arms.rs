//! An inflation test in a joint fit: the place of the tip soon after the step of pressure and at the end of the hold.

use std::path::{Path, PathBuf};

use super::parameters::Parameter;
use super::test::{Condition, Memory, Place, Predicted, Quantity, Test};
use crate::inflation_test::inflated::{Inflated, PRESSURE, Point};
use crate::inflation_test::page::{Page, Recording};
use crate::inflation_test::recorded::Recorded;
use diagnostics::{Diagnostic, Result};
use simulate::case::{Case, History, read};

/// By so much of itself a good model misses a displacement.
const SIGMA: f64 = 0.04;
/// Standard deviation of the logarithm of the modulus over that of other bodies of the same laboratory.
const BATCH_SIGMA: f64 = 0.1;
const BATCH: [f64; 2] = [0.4, 2.5];
/// Offsets of the walls that the mesh allows, m.
const WALLS: [f64; 2] = [-5e-4, 9e-4];
/// What is missing of the pressure of a step at first, kPa.
const MISSING: f64 = 1.0;
const MISSINGS: [f64; 2] = [0.0, 6.0];
// Of formulae alone, about one equilibrium and its slopes: no solver's tolerance enters.
const STEP: f64 = 1e-6;

/// The recordings of a page, with the body of each law.
pub(super) struct Arms {
    page: Page,
    conditions: Vec<Condition>,
    recordings: Vec<Recording>,
    bodies: Vec<(&'static str, Inflated)>,
}

impl Arms {
    /// Of the page in the file `path`, for these laws of `materials`; the page of the joint fit gives the edge of the mesh and further pressures
    /// that were not recorded.
    ///
    /// # Errors
    /// A [`Diagnostic`] when the page, a recording, the case or its mesh is refused.
    pub fn new(path: &Path, root: &Path, materials: &[&'static str], joint: &super::Page) -> Result<Self> {
        let page = Page::read(path)?;
        let folder = path.parent().unwrap_or(Path::new("."));
        let mut case = read(&folder.join(&page.case))?;
        if case.mesh.body.is_some() {
            case.mesh.edge = Some(joint.edge);
        }
        let surface_folder = mesh_folder(&page, &case, [root, folder])?;
        let loaded = simulate::load(&case, &surface_folder)?;
        let body = |material: &&'static str| {
            let mut case = case.clone();
            case.region[0].material = (*material).to_owned();
            (case.region[0].springpot, case.region[0].modulus_time) = (None, None);
            Ok((*material, Inflated::new(&page, &case, &loaded)?))
        };
        let bodies = materials.iter().map(body).collect::<Result<_>>()?;
        let mut conditions = Vec::new();
        let mut recordings = page.recording.clone();
        for recording in &page.recording {
            let features = Recorded::read(&page, recording, root)?.features;
            conditions.push(hold_condition(recording, Some([features.early, features.late]))?);
        }
        for pressure in &joint.pressures {
            let mut further = page.recording[0].clone();
            further.name = format!("{:.0}mbar", 1e-2 * pressure);
            further.pressure = History::Constant(*pressure);
            conditions.push(hold_condition(&further, None)?);
            recordings.push(further);
        }
        Ok(Self { page, conditions, recordings, bodies })
    }

    /// Where the body is soon after the step and at the end of the hold.
    fn hold_points(&self, at: &Place, recording: &Recording) -> Result<[Point; 2]> {
        let constants = at.law.constants(at.shared)?;
        let [batch, wall, missing] = [at.own[0].exp(), 1e-3 * at.own[1], 1e3 * at.own[2]];
        let settling = self.page.settling.unwrap_or(f64::INFINITY);
        let [early, late] = self.page.feature_times(recording);
        let point = |time: f64| {
            let (modulus, [c20, c30]) = constants.creep_elasticity(self.page.supply(0.0).time_since_rise(time));
            let lost = if self.page.settling.is_some() { missing * (-time / settling).exp() } else { 0.0 };
            [batch * modulus, c20, c30, wall, held_pressure(recording).unwrap_or(0.0) - lost]
        };
        Ok([point(early), point(late)])
    }
}

/// The folder that holds the surface or mesh of the case: one of the page's, below `root`, or that of the page.
fn mesh_folder(page: &Page, case: &Case, [root, beside]: [&Path; 2]) -> Result<PathBuf> {
    let mut folders = page.folders.iter().map(|folder| root.join(folder)).chain([beside.to_owned()]);
    folders.find(|folder| folder.join(case.mesh.name()).is_file()).ok_or_else(|| {
        let message = format!("the surface {} is not there", case.mesh.name());
        Diagnostic::new(message, "none of the page's folders has it", "put it into one of the page's folders")
    })
}

fn held_pressure(recording: &Recording) -> Option<f64> {
    match recording.pressure {
        History::Constant(pressure) => Some(pressure),
        _ => None,
    }
}

fn hold_condition(recording: &Recording, measured: Option<[f64; 2]>) -> Result<Condition> {
    let level = held_pressure(recording).ok_or_else(|| {
        let message = format!("`{}` has a history of its pressure", recording.name);
        Diagnostic::new(message, "a joint fit compares steps of the pressure that are held", "give one pressure")
    })?;
    let quantity = |(n, name): (usize, &str)| Quantity {
        name: name.to_owned(),
        unit: "mm",
        measured: measured.map(|measured| 1e3 * measured[n]),
        sigma: SIGMA,
    };
    let quantities = ["tip", "tip at the end of the hold"].into_iter().enumerate().map(quantity).collect();
    Ok(Condition { name: recording.name.clone(), level, fitted: measured.is_some(), quantities })
}

impl Test for Arms {
    fn name(&self) -> &str {
        &self.page.name
    }

    fn parameters(&self) -> Vec<Parameter> {
        let wall = Parameter::linear("wall offset", "mm", 0.0, WALLS.map(|wall| 1e3 * wall));
        vec![
            Parameter::logarithmic("batch", "", 1.0, BATCH).known_to(BATCH_SIGMA),
            // Held to a micrometre and not left out: every page has the same parameters.
            wall.known_to(1e3 * self.page.wall_sigma.unwrap_or(1e-6)),
            Parameter::linear("missing pressure", "kPa", MISSING, MISSINGS).known_to(MISSING),
        ]
    }

    fn conditions(&self) -> &[Condition] {
        &self.conditions
    }

    /// One equilibrium serves both times: between them modulus and pressure change by a few per cent, to first order.
    fn predict_condition(&self, at: &Place, condition: usize, memory: &mut Memory) -> Result<Vec<Predicted>> {
        let recording = &self.recordings[condition];
        let body = self.bodies.iter().find(|(name, _)| *name == at.law.material).map(|(_, body)| body);
        let body = body.ok_or_else(|| Diagnostic::new("a law has no body", at.law.name, "report this as a bug"))?;
        let points = self.hold_points(at, recording)?;
        let mut ambient = points[0];
        ambient[PRESSURE] = 0.0;
        let ambient_shape = body.remembered(&ambient, memory)?;
        let shape = body.remembered(&points[0], memory)?;
        // Displacements count from the place at ambient pressure, which moves with the constants, and not with the
        // pressure.
        let slopes: Point = std::array::from_fn(|k| {
            if k == PRESSURE { shape.slopes[k] } else { shape.slopes[k] - ambient_shape.slopes[k] }
        });
        let tip = |points: [Point; 2]| {
            points.map(|point| {
                let change: f64 = (0..5).map(|k| slopes[k] * (point[k] - shape.at[k])).sum();
                1e3 * (shape.tip - ambient_shape.tip + change)
            })
        };
        let values = tip(points);
        let mut gradients = [Vec::new(), Vec::new()];
        for p in 0..at.shared.len() + at.own.len() {
            let (mut shared, mut own) = (at.shared.to_vec(), at.own.to_vec());
            let parameter = if p < shared.len() { &mut shared[p] } else { &mut own[p - at.shared.len()] };
            *parameter += STEP;
            let perturbed = tip(self.hold_points(&Place { law: at.law, shared: &shared, own: &own }, recording)?);
            (0..2).for_each(|n| gradients[n].push((perturbed[n] - values[n]) / STEP));
        }
        let [early, late] = gradients;
        Ok(vec![Predicted { value: values[0], gradient: early }, Predicted { value: values[1], gradient: late }])
    }
}
