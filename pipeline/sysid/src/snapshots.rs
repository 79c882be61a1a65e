//! Hyper-reduction: POD of the shapes under the chambers' pressures and under lateral loads like those of inertia and of water, with empirical
//! cubature.

use fem::{ReducedModelData, ReductionSettings, Solver, StaticSettings};
use rayon::prelude::*;
use si::{Metre, Pascal, vec3};

use crate::model::{BODY, Elastic, Model};
use diagnostics::Result;

/// Number of even steps in which each chamber is filled alone.
const STEPS: usize = 10;
/// Of the highest pressure: levels of a single filled chamber under lateral loads.
const HELD: [(f64, Lateral); 2] = [(0.4, Lateral::Water), (0.8, Lateral::Inertia)];
/// Of the highest pressures: two chambers filled at once.
const BOTH: [[f64; 2]; 3] = [[0.3, 0.3], [0.6, 0.3], [0.3, 0.6]];
/// Displacement of the tip by a lateral load over the length: with the bending by pressure, and against it.
const PULLS: [f64; 2] = [0.1, 0.2];
/// Parts of a step in which walls that touch are looked for.
const FINE: usize = 8;
/// Coordinates for each shape that is given.
const KEPT: f64 = 0.8;

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

/// Snapshots: pressures, and displacements by a lateral load over the length.
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

/// A reduced model, and where it is no longer one of the body.
#[derive(Debug, Clone, PartialEq)]
pub struct Reduction {
    /// Of the equilibria up to the highest pressures.
    pub data: ReducedModelData,
    /// The lowest pressure of a chamber, filled alone, from which walls pass through each other, Pa; none where they do not.
    pub contact: Option<Pascal>,
}

impl Snapshots<'_> {
    /// The reduced model of the equilibria up to the highest pressures; `tolerance` is the relative error of the forces at the cubature
    /// points.
    ///
    /// # Errors
    /// A [`Diagnostic`] when an equilibrium is not found.
    // A reduced model has no contact: reduced from shapes in which walls press on each other, it has no equilibrium near them.
    pub fn reduce(&self, tolerance: f64) -> Result<Reduction> {
        let free = self.model.without_contact();
        let touch = |shape: &[f64]| self.model.system.walls_touch(shape);
        Snapshots { model: &free, ..*self }.reduce_free(tolerance, &touch)
    }

    /// As [`Snapshots::reduce`], of a model without contact; `touch` says whether walls of the body touch in a shape.
    fn reduce_free(&self, tolerance: f64, touch: &dyn Fn(&[f64]) -> bool) -> Result<Reduction> {
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
        let contact = filled.iter().zip(top).filter_map(|(shapes, top)| Some(first_touch(shapes, touch)? * top));
        let contact = contact.min_by(f64::total_cmp);
        Ok(Reduction { data: model.system.reduce(&shapes, &by)?.data(), contact })
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

    /// The shapes on the way to a wish, begun `near` it: with half of each pull and the whole.
    fn shape(&self, wish: &Wish, near: Option<&[f64]>, pull: &[f64]) -> Result<Vec<Vec<f64>>> {
        let mut solver = ready(self.model, self.elastic)?;
        let held = solver.equilibrium(&wish.pressures, near, &settings())?.displacement;
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

fn alone(top: &[Pascal], filled: usize, share: f64) -> Vec<Pascal> {
    (0..top.len()).map(|k| if k == filled { share * top[k] } else { 0.0 }).collect()
}

/// The part (0 to 1) of the pressure of the last of evenly loaded `shapes` from which walls `touch`; between shapes by straight lines.
fn first_touch(shapes: &[Vec<f64>], touch: &dyn Fn(&[f64]) -> bool) -> Option<f64> {
    let rest = vec![0.0; shapes.first()?.len()];
    let between = |part: f64| -> Vec<f64> {
        let (step, along) = ((part.ceil() as usize).max(1), part.ceil() - part);
        let before = if step == 1 { &rest } else { &shapes[step - 2] };
        before.iter().zip(&shapes[step - 1]).map(|(a, b)| along * a + (1.0 - along) * b).collect()
    };
    let parts = (1..=FINE * shapes.len()).map(|k| k as f64 / FINE as f64);
    Some(parts.into_iter().find(|part| touch(&between(*part)))? / shapes.len() as f64)
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

/// Snapshots under lateral loads to both sides: at rest, with each chamber filled, and with neighbouring chambers filled together. A
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
    // While one chamber empties and the next one fills the body swings back. Without loads on these shapes, and with six levels of a chamber filled
    // alone, the reduced model of a tail whose wall buckles was 3.2 % off the whole one at 4 Hz and too stiff, so that the storage modulus of its
    // silicone came out 6 % too low; with ten levels alone, 2.2 %; with both, 0.6 and 1.5 %.
    let pairs = driven.windows(2).flat_map(|pair| {
        BOTH.map(|[a, b]| {
            let mut pressures = alone(top, pair[1], b);
            pressures[pair[0]] = a * top[pair[0]];
            Wish { pressures, load: Lateral::Inertia, pulls: vec![with, -with] }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn walls_touch_from_the_pressure_at_which_the_line_between_two_shapes_does() {
        // three levels; the walls touch from a displacement of 1.5 on, half way from the second level to the third
        let shapes = [vec![0.5], vec![1.0], vec![2.0]];
        let found = |limit: f64| first_touch(&shapes, &|shape: &[f64]| shape[0] >= limit);
        assert_eq!(found(1.5), Some(2.5 / 3.0));
        assert_eq!(found(0.25), Some(0.5 / 3.0));
        assert_eq!(found(2.0), Some(1.0));
        assert_eq!(found(2.1), None);
        assert_eq!(first_touch(&[], &|_: &[f64]| true), None);
    }
}
