//! Hyper-reduction: POD of the shapes under the chambers' pressures and under lateral loads like those of inertia and of water, with empirical
//! cubature. Long motions are integrated in these coordinates; the error is measured against the full model.

use std::sync::Arc;

use fem::{
    Actuation, DynamicSettings, ExternalForce, NoForce, ReducedModel, ReducedModelData, ReducedMotion,
    ReductionSettings, Relaxation, Solver, StaticSettings,
};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use si::{Metre, Pascal, Point2, Second, vec3};

use crate::model::{BODY, Elastic, Model, Viscoelastic};
use diagnostics::{Diagnostic, Result};

/// Number of even steps in which each chamber is filled alone.
const STEPS: usize = 6;
/// Of the highest pressure: levels of a single filled chamber under lateral loads.
const HELD: [(f64, Lateral); 2] = [(0.4, Lateral::Water), (0.8, Lateral::Inertia)];
/// Of the highest pressures: two chambers filled at once.
const BOTH: [[f64; 2]; 3] = [[0.3, 0.3], [0.6, 0.3], [0.3, 0.6]];
/// Displacement of the tip by a lateral load over the length: with the bending by pressure, and against it.
const PULLS: [f64; 2] = [0.1, 0.2];
/// Coordinates for each shape that is given.
const KEPT: f64 = 0.8;

/// A model with its moduli in reduced coordinates.
pub struct ReducedBody {
    reduced: Arc<ReducedModel>,
    /// Moduli over those that the system was made with.
    scale: Vec<f64>,
    /// Of body and spine.
    relaxation: Vec<Relaxation>,
    /// Ratios of stiffening by region.
    stiffening: Vec<[f64; 2]>,
    /// Displacement of each marker in the plane by coordinate, m: markers × 2 × coordinates.
    rows: Vec<[Vec<f64>; 2]>,
}

/// A lateral load, growing with the square of the distance from the clamp.
// Without the load of water the fin is rigid: a release in water was 3 ms late at first, and drag came out 9.5 % too high in the mean of twelve tails.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Lateral {
    /// On every node by its mass, as inertia acts.
    Inertia,
    /// On the plate that the body encloses by its area, as water acts, which bends a fin that is light but deep; on every node where there is
    /// none.
    Water,
}

/// A snapshot: pressures, and displacements by a lateral load over the length; none where empty.
struct Wish {
    pressures: Vec<Pascal>,
    load: Lateral,
    pulls: Vec<f64>,
}

/// The model to be reduced, and the range of its snapshots.
#[derive(Clone, Copy)]
pub struct Snapshots<'a> {
    /// The full model.
    pub model: &'a Model,
    /// Its constants.
    pub elastic: &'a Elastic,
    /// Highest pressure of each chamber, Pa; 0 of one that stays at ambient pressure, of which there is no snapshot.
    pub top: &'a [Pascal],
    /// Length of the specimen, m.
    pub length: Metre,
}

impl Snapshots<'_> {
    /// The reduced model of the equilibria up to the highest pressures; `tolerance` is the relative error of the forces at the cubature
    /// points.
    ///
    /// # Errors
    /// A [`Diagnostic`] when an equilibrium is not found.
    pub fn reduce(&self, tolerance: f64) -> Result<ReducedModelData> {
        let Self { model, elastic, top, .. } = *self;
        let [inertia, water] = [Lateral::Inertia, Lateral::Water].map(|load| pull(model, elastic, load));
        let (inertia, water) = (inertia?, water?);
        let filled: Vec<Vec<Vec<f64>>> =
            (0..top.len()).into_par_iter().map(|k| self.solve(k)).collect::<Result<_>>()?;
        let bends: Vec<f64> =
            filled.iter().map(|shapes| shapes.last().map_or(0.0, |last| bend(last, &inertia))).collect();
        let load = |wish: &Wish| if wish.load == Lateral::Water { &water } else { &inertia };
        let find = |wish: &Wish| self.shape(wish, nearest(&filled, top, &wish.pressures), load(wish));
        let others: Vec<Vec<Vec<f64>>> = wishes(top, &bends).par_iter().map(find).collect::<Result<_>>()?;
        let shapes: Vec<&[f64]> = filled.iter().chain(&others).flatten().map(Vec::as_slice).collect();
        let coordinates = (KEPT * shapes.len() as f64) as usize;
        let by = ReductionSettings { coordinates, tolerance, ..ReductionSettings::default() };
        Ok(model.system.reduce(&shapes, &by)?.data())
    }

    /// Chamber `filled` alone up to its highest pressure, each equilibrium started from the last; none where it is never filled.
    fn solve(&self, filled: usize) -> Result<Vec<Vec<f64>>> {
        if self.top[filled] == 0.0 {
            return Ok(Vec::new());
        }
        let mut solver = ready(self.model, self.elastic)?;
        let mut known = vec![(0.0, vec![0.0; 3 * self.model.system.mesh().nodes.len()])];
        for step in 1..=STEPS {
            let pressures = alone(self.top, filled, step as f64 / STEPS as f64);
            let shapes: Vec<(Pascal, &[f64])> = known.iter().map(|(p, shape)| (*p, shape.as_slice())).collect();
            let found = solver.equilibrium_from(&shapes, &pressures, &settings())?;
            known.push((pressures[filled], found.displacement));
        }
        Ok(known.into_iter().skip(1).map(|(_, shape)| shape).collect())
    }

    /// The shapes on the way to a wish, begun `near` it: with half of each pull and the whole; from the pressures alone where nothing pulls.
    fn shape(&self, wish: &Wish, near: Option<&[f64]>, pull: &[f64]) -> Result<Vec<Vec<f64>>> {
        let mut solver = ready(self.model, self.elastic)?;
        let held = solver.equilibrium(&wish.pressures, near, &settings())?.displacement;
        if wish.pulls.is_empty() {
            return Ok(vec![held]);
        }
        let mut shapes: Vec<Vec<f64>> = Vec::new();
        for far in &wish.pulls {
            let mut last = held.clone();
            for part in [0.5, 1.0] {
                let forces: Vec<f64> = pull.iter().map(|f| part * far * self.length * f).collect();
                solver.set_forces(&forces)?;
                let found = solver.equilibrium(&wish.pressures, Some(&last), &settings());
                last = found?.displacement;
                shapes.push(last.clone());
            }
        }
        Ok(shapes)
    }
}

/// A motion from rest forced by the chambers' pressures.
#[derive(Clone, Copy)]
pub struct ForcedMotion<'a> {
    /// Settings of the time integration.
    pub settings: &'a DynamicSettings,
    /// One pressure a chamber (Pa) at a time (s from the start).
    pub pressures: &'a dyn Fn(Second) -> Vec<Pascal>,
    /// Ends of the time steps, rising, s from the start.
    pub times: &'a [Second],
}

/// Ends of `steps` equal time steps, s.
pub fn even_times(step: Second, steps: usize) -> Vec<Second> {
    (1..=steps).map(|i| i as f64 * step).collect()
}

impl ReducedBody {
    /// Restores a reduced `model` from its data, with the `silicone`'s constants and the model's markers.
    ///
    /// # Errors
    /// A [`Diagnostic`] when the data are of another mesh.
    pub fn of(model: &Model, silicone: &Viscoelastic, data: &ReducedModelData) -> Result<Self> {
        let reduced = Arc::new(model.system.restore(data)?);
        let rows = model.markers.iter().map(|spot| rows(&reduced, spot)).collect();
        let made = Self { reduced, scale: Vec::new(), relaxation: Vec::new(), stiffening: Vec::new(), rows };
        Ok(made.with(model, silicone))
    }

    /// Displacement of a marker in the plane (m) after each step of a motion.
    ///
    /// # Errors
    /// A [`Diagnostic`] when a step finds no motion.
    // By its twin, where there is one: the same equations to the same tolerance in a third to a fifth of the time.
    pub fn integrate(&self, motion: &ForcedMotion, marker: usize) -> Result<Vec<Point2>> {
        let along = |row: &[f64], q: &DVector<f64>| row.iter().zip(q.as_slice()).map(|(r, q)| r * q).sum::<f64>();
        let place = |q: &DVector<f64>| self.rows[marker].each_ref().map(|row| along(row, q));
        // A twin takes whole steps. Where a wall buckles none may be found, and the line search of the reduced model finds one.
        if motion.suits_a_twin()
            && self.has_twin()
            && let Ok(states) = motion.twin_states(self.twin_data(&[])?)
        {
            return Ok(states.iter().map(|(q, _)| place(q)).collect());
        }
        let mut path = Vec::with_capacity(motion.times.len());
        self.integrate_in_fluid(motion, &mut NoForce, &mut |q, _| path.push(place(q)))?;
        Ok(path)
    }

    /// Integrates a motion under the external force `around`; `see` receives each new q and q̇.
    ///
    /// # Errors
    /// A [`Diagnostic`] when a step finds no motion.
    pub fn integrate_in_fluid(
        &self,
        motion: &ForcedMotion,
        around: &mut dyn ExternalForce,
        see: &mut dyn FnMut(&DVector<f64>, &DVector<f64>),
    ) -> Result<()> {
        let actuation = |t: Second| Actuation { pressures: (motion.pressures)(t) };
        let reduced = ReducedMotion {
            settings: motion.settings,
            modulus_scale: &self.scale,
            relaxation: &self.relaxation,
            stiffening: &self.stiffening,
            actuation: &actuation,
        };
        let mut shown = |_: Second, q: &DVector<f64>, v: &DVector<f64>| see(q, v);
        self.reduced.integrate_at(&reduced, around, motion.times, &mut shown).map_err(Diagnostic::from)
    }

    /// Displacement of the markers along x and y by each coordinate, m: (markers × 2) × coordinates, in the order of `markers`.
    pub fn rows(&self, markers: &[usize]) -> DMatrix<f64> {
        DMatrix::from_fn(2 * markers.len(), self.coordinates(), |i, j| self.rows[markers[i / 2]][i % 2][j])
    }

    /// The reduced model.
    pub fn model(&self) -> &ReducedModel {
        &self.reduced
    }

    /// By region: the factor of its moduli, its relaxation, its ratios of stiffening.
    pub fn constants(&self) -> impl Iterator<Item = (f64, &Relaxation, [f64; 2])> {
        let all = self.scale.iter().zip(&self.relaxation).zip(&self.stiffening);
        all.map(|((scale, relaxation), stiffening)| (*scale, relaxation, *stiffening))
    }

    /// The same reduced model with other constants of the silicone; `model` is the one that was reduced.
    #[must_use]
    pub fn with(&self, model: &Model, silicone: &Viscoelastic) -> Self {
        let made = model.system.regions();
        let scale = made.iter().zip(&silicone.elastic.youngs_moduli).map(|(r, e)| e / r.youngs_modulus).collect();
        let mut relaxation = vec![Relaxation::default(); made.len()];
        relaxation[BODY] = silicone.relaxation.clone();
        let mut stiffening: Vec<[f64; 2]> = made.iter().map(|region| region.stiffening).collect();
        stiffening[BODY] = silicone.elastic.stiffening;
        Self { reduced: Arc::clone(&self.reduced), scale, relaxation, stiffening, rows: self.rows.clone() }
    }

    /// Number of markers and further points.
    pub fn markers(&self) -> usize {
        self.rows.len()
    }

    /// Number of coordinates.
    pub fn coordinates(&self) -> usize {
        self.reduced.coordinates()
    }
}

fn rows(reduced: &ReducedModel, spot: &mesh::Spot) -> [Vec<f64>; 2] {
    [0, 1].map(|axis| {
        let mut row = vec![0.0; reduced.coordinates()];
        for &(node, weight) in &spot.weights {
            let here = reduced.row(3 * node as usize + axis);
            row.iter_mut().zip(here).for_each(|(sum, part)| *sum += weight * part);
        }
        row
    })
}

fn alone(top: &[Pascal], filled: usize, share: f64) -> Vec<Pascal> {
    (0..top.len()).map(|k| if k == filled { share * top[k] } else { 0.0 }).collect()
}

/// The side to which a shape bends: that of positive work of the lateral load.
fn bend(shape: &[f64], pull: &[f64]) -> f64 {
    shape.iter().zip(pull).map(|(u, f)| u * f).sum::<f64>().signum()
}

/// Of the shapes with one chamber `filled`, the nearest to `pressures`; none where another is filled as much.
fn nearest<'a>(filled: &'a [Vec<Vec<f64>>], top: &[Pascal], pressures: &[Pascal]) -> Option<&'a [f64]> {
    let share = |(p, top): (&Pascal, &Pascal)| if *top > 0.0 { p / top } else { 0.0 };
    let shares: Vec<f64> = pressures.iter().zip(top).map(share).collect();
    let most = (0..shares.len()).max_by(|a, b| shares[*a].total_cmp(&shares[*b]))?;
    let alone = shares.iter().enumerate().all(|(k, share)| k == most || *share < shares[most]);
    let step = ((shares[most] * STEPS as f64).round() as usize).clamp(1, STEPS);
    filled[most].get(step - 1).filter(|_| alone).map(Vec::as_slice)
}

/// Snapshots under lateral loads to both sides, at rest and with each chamber filled; and with neighbouring chambers filled together. A
/// chamber that is never filled has none.
fn wishes(top: &[Pascal], bends: &[f64]) -> Vec<Wish> {
    let [with, against] = PULLS;
    let driven: Vec<usize> = (0..top.len()).filter(|k| top[*k] > 0.0).collect();
    let rest = Wish { pressures: vec![0.0; top.len()], load: Lateral::Water, pulls: vec![with, -with] };
    let held = driven.iter().flat_map(|&k| {
        HELD.map(|(share, load)| Wish {
            pressures: alone(top, k, share),
            load,
            pulls: vec![with * bends[k], -against * bends[k]],
        })
    });
    let pairs = driven.windows(2).flat_map(|pair| {
        BOTH.map(|[a, b]| {
            let mut pressures = alone(top, pair[1], b);
            pressures[pair[0]] = a * top[pair[0]];
            Wish { pressures, load: Lateral::Inertia, pulls: Vec::new() }
        })
    });
    std::iter::once(rest).chain(held).chain(pairs).collect()
}

/// Lateral forces (3 a node, N/m) scaled to a unit displacement of the farthest node by the stiffness at rest.
fn pull(model: &Model, elastic: &Elastic, load: Lateral) -> Result<Vec<f64>> {
    let system = &model.system;
    let far = system.mesh().nodes.iter().map(|n| n[0]).fold(f64::MIN, f64::max);
    let mut forces = vec![0.0; 3 * system.mesh().nodes.len()];
    let by = match load {
        Lateral::Inertia => system.node_masses().to_vec(),
        Lateral::Water => plate(system.mesh()).unwrap_or_else(|| system.node_masses().to_vec()),
    };
    for (i, (node, by)) in system.mesh().nodes.iter().zip(&by).enumerate() {
        forces[3 * i + 1] = by * (node[0].max(0.0) / far).powi(2);
    }
    let mut solver = ready(model, elastic)?;
    let rest = vec![0.0; system.mesh().chambers.len()];
    let rest = solver.equilibrium(&rest, None, &settings())?;
    solver.assemble(&rest)?;
    solver.factorise(&rest)?;
    let moved = solver.solve(&forces)?;
    let most = moved.iter().skip(1).step_by(3).fold(0.0, |most: f64, y| most.max(y.abs()));
    forces.iter_mut().for_each(|f| *f /= most);
    Ok(forces)
}

/// Of the solids beside the body, the volume around each node, m³: of a plate of one thickness the area, but for a factor; none of a body alone.
fn plate(mesh: &fem::Mesh) -> Option<Vec<f64>> {
    let mut around = vec![0.0; mesh.nodes.len()];
    for element in (0..mesh.elements.len()).filter(|&e| mesh.regions[e] != BODY as u16) {
        let nodes = mesh.elements.nodes(element);
        let [a, b, c, d] = [0, 1, 2, 3].map(|k| mesh.nodes[nodes[k] as usize]);
        let volume = vec3::dot(vec3::sub(b, a), vec3::cross(vec3::sub(c, a), vec3::sub(d, a))).abs() / 6.0;
        nodes.iter().for_each(|&node| around[node as usize] += volume / nodes.len() as f64);
    }
    around.iter().any(|volume| *volume > 0.0).then_some(around)
}

fn ready(model: &Model, elastic: &Elastic) -> Result<Solver> {
    let mut solver = model.system.solver();
    elastic.apply(&mut solver)?;
    Ok(solver)
}

fn settings() -> StaticSettings {
    StaticSettings { tolerance: 1e-6, ..StaticSettings::default() }
}
