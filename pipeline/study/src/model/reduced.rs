//! Reduced: the model in the few dozen coordinates of shapes that it takes under its chambers' pressures and under sideways pulls
//! like those of its own inertia. Long motions are marched in them; how far that is off is measured against the whole model.
//!
//! Stands on: the model, fem. Never knows: a trial, a measurement.

use fem::{Around, Drive, Kept, March, Reduced, Reduction, Solver, StaticSettings, Still};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use si::{Metre, Pascal, Point2, Second};

use super::{Elastic, Model};
use crate::fault::{Fault, Outcome};

/// Even steps in which each chamber is filled alone.
const STEPS: usize = 6;
/// Of the highest pressure: where a single chamber is filled while the body is pulled.
const HELD: [f64; 2] = [0.4, 0.8];
/// Of the highest pressures: two chambers filled at once.
const BOTH: [[f64; 2]; 3] = [[0.3, 0.3], [0.6, 0.3], [0.3, 0.6]];
/// How far a pull moves the farthest point of a body at rest, over its length: with the bend of the pressure, against it.
const PULLS: [f64; 2] = [0.1, 0.2];
/// Coordinates for each shape that is given.
const KEPT: f64 = 0.8;

/// A model with its moduli, in the coordinates of its shapes.
pub struct Small {
    reduced: Reduced,
    /// Moduli over those that the system was made with.
    scale: Vec<f64>,
    /// Displacement of each marker in the plane by coordinate, m: markers × 2 × coordinates.
    rows: Vec<[Vec<f64>; 2]>,
}

/// Shapes to be found: pressures, and how far the body is then pulled to one side over its length; by nothing where empty.
struct Wish {
    pressures: Vec<Pascal>,
    pulls: Vec<f64>,
}

/// Reduces `model` with `elastic` by equilibria up to the pressures `top` (one a chamber, Pa); `length` is the specimen's, m,
/// `tolerance` how far the forces of the points that are chosen may be off, relative.
///
/// # Errors
/// A [`Fault`] when an equilibrium is not found.
pub fn reduce(model: &Model, elastic: &Elastic, top: &[Pascal], length: Metre, tolerance: f64) -> Outcome<Kept> {
    let pull = pull(model, elastic)?;
    let filled: Vec<Vec<Vec<f64>>> =
        (0..top.len()).into_par_iter().map(|k| climb(model, elastic, top, k)).collect::<Outcome<_>>()?;
    let bends: Vec<f64> = filled.iter().map(|shapes| bend(&shapes[STEPS - 1], &pull)).collect();
    let find = |wish: &Wish| shape(model, elastic, wish, nearest(&filled, top, &wish.pressures), &pull, length);
    let others: Vec<Vec<Vec<f64>>> = wishes(top, &bends).par_iter().map(find).collect::<Outcome<_>>()?;
    let shapes: Vec<&[f64]> = filled.iter().chain(&others).flatten().map(Vec::as_slice).collect();
    let coordinates = (KEPT * shapes.len() as f64) as usize;
    let by = Reduction { coordinates, tolerance, ..Reduction::default() };
    Ok(model.system.reduce(&shapes, &by).map_err(Fault::from_tool)?.kept())
}

impl Small {
    /// What was kept of a reduced `model`, with `elastic` and the model's own markers.
    ///
    /// # Errors
    /// A [`Fault`] when it was kept of another mesh.
    pub fn of(model: &Model, elastic: &Elastic, kept: &Kept) -> Outcome<Self> {
        let reduced = model.system.restore(kept).map_err(Fault::from_tool)?;
        let made = model.system.regions();
        let scale = made.iter().zip(elastic.youngs_moduli).map(|(r, e)| e / r.youngs_modulus).collect();
        let rows = model.markers.iter().map(|spot| rows(&reduced, spot)).collect();
        Ok(Self { reduced, scale, rows })
    }

    /// Displacement of a marker in the plane (m) after each of `steps` steps from rest, `pressures` at a time (s) from then.
    ///
    /// # Errors
    /// A [`Fault`] when a step finds no motion.
    pub fn march(
        &self,
        march: &March,
        marker: usize,
        pressures: &dyn Fn(Second) -> Vec<Pascal>,
        steps: usize,
    ) -> Outcome<Vec<Point2>> {
        let [x, y] = &self.rows[marker];
        let along = |row: &[f64], q: &[f64]| row.iter().zip(q).map(|(r, q)| r * q).sum::<f64>();
        let mut path = Vec::with_capacity(steps);
        let drive = |t: Second| Drive { pressures: pressures(t) };
        self.reduced
            .march(march, &self.scale, &drive, &mut Still, steps, &mut |_, q, _| {
                path.push([along(x, q.as_slice()), along(y, q.as_slice())]);
            })
            .map_err(Fault::from_tool)?;
        Ok(path)
    }

    /// Moves from rest through `steps` steps in what is `around`, `pressures` at a time (s); `see` is shown each new q and q̇.
    ///
    /// # Errors
    /// A [`Fault`] when a step finds no motion.
    pub fn swim(
        &self,
        march: &March,
        around: &mut dyn Around,
        pressures: &dyn Fn(Second) -> Vec<Pascal>,
        steps: usize,
        see: &mut dyn FnMut(&DVector<f64>, &DVector<f64>),
    ) -> Outcome<()> {
        let drive = |t: Second| Drive { pressures: pressures(t) };
        let mut shown = |_: Second, q: &DVector<f64>, v: &DVector<f64>| see(q, v);
        self.reduced.march(march, &self.scale, &drive, around, steps, &mut shown).map_err(Fault::from_tool)
    }

    /// How far each coordinate moves markers along x and y, m: (markers × 2) × coordinates, in the order of `markers`.
    pub fn rows(&self, markers: &[usize]) -> DMatrix<f64> {
        DMatrix::from_fn(2 * markers.len(), self.coordinates(), |i, j| self.rows[markers[i / 2]][i % 2][j])
    }

    /// How many markers and further places it knows.
    pub fn markers(&self) -> usize {
        self.rows.len()
    }

    /// How many coordinates there are.
    pub fn coordinates(&self) -> usize {
        self.reduced.coordinates()
    }
}

fn rows(reduced: &Reduced, spot: &shape::Spot) -> [Vec<f64>; 2] {
    [0, 1].map(|axis| {
        let mut row = vec![0.0; reduced.coordinates()];
        for &(node, weight) in &spot.weights {
            let here = reduced.row(3 * node as usize + axis);
            row.iter_mut().zip(here).for_each(|(sum, part)| *sum += weight * part);
        }
        row
    })
}

/// Chamber `filled` alone, up to its highest pressure, each shape begun from the last.
fn climb(model: &Model, elastic: &Elastic, top: &[Pascal], filled: usize) -> Outcome<Vec<Vec<f64>>> {
    let mut solver = ready(model, elastic)?;
    let mut shapes: Vec<Vec<f64>> = Vec::new();
    for step in 1..=STEPS {
        let pressures = alone(top, filled, step as f64 / STEPS as f64);
        let found = solver.equilibrium(&pressures, shapes.last().map(Vec::as_slice), &settings());
        shapes.push(found.map_err(Fault::from_tool)?.displacement);
    }
    Ok(shapes)
}

fn alone(top: &[Pascal], filled: usize, share: f64) -> Vec<Pascal> {
    (0..top.len()).map(|k| if k == filled { share * top[k] } else { 0.0 }).collect()
}

/// To which side a shape bends: that to which the pull would do work on it.
fn bend(shape: &[f64], pull: &[f64]) -> f64 {
    shape.iter().zip(pull).map(|(u, f)| u * f).sum::<f64>().signum()
}

/// Of the shapes of each chamber `filled` alone, the one nearest to `pressures`; none where another is filled as much.
fn nearest<'a>(filled: &'a [Vec<Vec<f64>>], top: &[Pascal], pressures: &[Pascal]) -> Option<&'a [f64]> {
    let shares: Vec<f64> = pressures.iter().zip(top).map(|(p, top)| p / top).collect();
    let most = (0..shares.len()).max_by(|a, b| shares[*a].total_cmp(&shares[*b]))?;
    let alone = shares.iter().enumerate().all(|(k, share)| k == most || *share < shares[most]);
    let step = ((shares[most] * STEPS as f64).round() as usize).clamp(1, STEPS);
    alone.then(|| filled[most][step - 1].as_slice())
}

/// Pulled to both sides at rest and with each chamber held, which `bends` it to one; neighbouring chambers filled at once.
fn wishes(top: &[Pascal], bends: &[f64]) -> Vec<Wish> {
    let [with, against] = PULLS;
    let rest = Wish { pressures: vec![0.0; top.len()], pulls: vec![with, -with] };
    let held = bends.iter().enumerate().flat_map(|(k, bend)| {
        HELD.map(|share| Wish { pressures: alone(top, k, share), pulls: vec![with * bend, -against * bend] })
    });
    let pairs = (1..top.len()).flat_map(|k| {
        BOTH.map(|[a, b]| {
            let mut pressures = alone(top, k, b);
            pressures[k - 1] = a * top[k - 1];
            Wish { pressures, pulls: Vec::new() }
        })
    });
    std::iter::once(rest).chain(held).chain(pairs).collect()
}

/// The shapes on the way to a wish, begun `near` it: with half of each pull and the whole; from the pressures alone where nothing pulls.
fn shape(
    model: &Model,
    elastic: &Elastic,
    wish: &Wish,
    near: Option<&[f64]>,
    pull: &[f64],
    length: Metre,
) -> Outcome<Vec<Vec<f64>>> {
    let mut solver = ready(model, elastic)?;
    let held = solver.equilibrium(&wish.pressures, near, &settings()).map_err(Fault::from_tool)?.displacement;
    if wish.pulls.is_empty() {
        return Ok(vec![held]);
    }
    let mut shapes: Vec<Vec<f64>> = Vec::new();
    for far in &wish.pulls {
        let mut last = held.clone();
        for part in [0.5, 1.0] {
            let forces: Vec<f64> = pull.iter().map(|f| part * far * length * f).collect();
            solver.set_forces(&forces).map_err(Fault::from_tool)?;
            let found = solver.equilibrium(&wish.pressures, Some(&last), &settings());
            last = found.map_err(Fault::from_tool)?.displacement;
            shapes.push(last.clone());
        }
    }
    Ok(shapes)
}

/// Sideways forces (3 a node, N a metre) like those of a swing about the clamp, which move the farthest node by one metre for
/// each metre asked for, were the body as stiff as at rest.
fn pull(model: &Model, elastic: &Elastic) -> Outcome<Vec<f64>> {
    let system = &model.system;
    let far = system.mesh().nodes.iter().map(|n| n[0]).fold(f64::MIN, f64::max);
    let mut forces = vec![0.0; 3 * system.mesh().nodes.len()];
    for (i, (node, mass)) in system.mesh().nodes.iter().zip(system.node_masses()).enumerate() {
        forces[3 * i + 1] = mass * (node[0].max(0.0) / far).powi(2);
    }
    let mut solver = ready(model, elastic)?;
    let rest = vec![0.0; system.mesh().chambers.len()];
    let rest = solver.equilibrium(&rest, None, &settings()).map_err(Fault::from_tool)?;
    solver.assemble(&rest).map_err(Fault::from_tool)?;
    solver.factorise(&rest).map_err(Fault::from_tool)?;
    let moved = solver.solve(&forces).map_err(Fault::from_tool)?;
    let most = moved.iter().skip(1).step_by(3).fold(0.0, |most: f64, y| most.max(y.abs()));
    forces.iter_mut().for_each(|f| *f /= most);
    Ok(forces)
}

fn ready(model: &Model, elastic: &Elastic) -> Outcome<Solver> {
    let mut solver = model.system.solver();
    elastic.give(&mut solver)?;
    Ok(solver)
}

fn settings() -> StaticSettings {
    StaticSettings { tolerance: 1e-6, ..StaticSettings::default() }
}
