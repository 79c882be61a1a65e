//! Hyper-reduction: POD of the shapes under the chambers' pressures, under lateral loads like those of inertia and of water, and in the first strokes
//! of a motion, with empirical cubature.

use fem::{LoadRamp, ReducedModelData, ReductionSettings, StaticSettings};
use rayon::prelude::*;
use si::{Metre, Pascal};

use crate::lateral_loads::{Lateral, unit_lateral_load};
use crate::model::{Elastic, Model};
use crate::stroke::Stroke;
use diagnostics::Result;

/// Number of even steps in which each chamber is filled alone.
const STEPS: usize = 10;
/// Of the highest pressure: levels of a single filled chamber under lateral loads.
// Directions in which loads move the body, one solve with the tangent each, in the place of the shapes at the higher level: the loss factor that
// came back from a motion was a fifth off instead of an eighth at most.
const HELD: [(f64, Lateral); 2] = [(0.4, Lateral::Water), (0.8, Lateral::Inertia)];
/// Displacement of the tip by a lateral load over the length: with the bending by pressure, and against it.
const PULLS: [f64; 2] = [0.1, 0.2];
/// Parts of a step in which walls that touch are looked for.
const FINE: usize = 8;
/// Coordinates for each equilibrium, and at most.
// With 24 coordinates a tail of thin walls moves up to twice as fast and is twice as far from the whole body; with 30 it is no nearer.
const KEPT: f64 = 0.8;
const COORDINATES: usize = 28;

/// Snapshots: pressures, and displacements by a lateral load over the length.
struct LoadCase {
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
    /// The motion that is to come; without one the equilibria teach alone.
    pub stroke: Option<Stroke>,
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
    /// The reduced model of the equilibria up to the highest pressures; `tolerance` is the relative error of displacements by the
    /// cubature.
    ///
    /// # Errors
    /// A [`Diagnostic`](diagnostics::Diagnostic) when an equilibrium is not found.
    // Motions of a reduced model have no contact: reduced from shapes in which walls press on each other, it has no equilibrium near them.
    pub fn reduce(&self, tolerance: f64) -> Result<Reduction> {
        let free = self.model.without_contact();
        let touch = |shape: &[f64]| self.model.system.walls_touch(shape);
        Snapshots { model: &free, ..*self }.reduce_free(tolerance, &touch)
    }

    /// As [`Snapshots::reduce`], of a model without contact; `touch` says whether walls of the body touch in a shape.
    fn reduce_free(&self, tolerance: f64, touch: &dyn Fn(&[f64]) -> bool) -> Result<Reduction> {
        let Self { model, elastic, top, .. } = *self;
        let [inertia, water] = [Lateral::Inertia, Lateral::Water].map(|load| unit_lateral_load(model, elastic, load));
        let (inertia, water) = (inertia?, water?);
        let filled: Vec<Vec<Vec<f64>>> =
            (0..top.len()).into_par_iter().map(|k| self.inflate_chamber(k)).collect::<Result<_>>()?;
        let bends: Vec<f64> =
            filled.iter().map(|shapes| shapes.last().map_or(0.0, |last| bending_side(last, &inertia))).collect();
        let load = |case: &LoadCase| if case.load == Lateral::Water { &water } else { &inertia };
        let find =
            |case: &LoadCase| self.lateral_shapes(case, nearest_inflated(&filled, top, &case.pressures), load(case));
        let lateral: Vec<Vec<Vec<f64>>> = load_cases(top, &bends).par_iter().map(find).collect::<Result<_>>()?;
        let strokes = self.stroke.map(|stroke| stroke.shapes(model, elastic, top)).transpose()?.unwrap_or_default();
        let equilibria: Vec<&[f64]> = filled.iter().chain(&lateral).flatten().map(Vec::as_slice).collect();
        let coordinates = ((KEPT * equilibria.len() as f64) as usize).min(COORDINATES);
        let shapes = [equilibria, strokes.iter().map(Vec::as_slice).collect()].concat();
        let reduction_settings = ReductionSettings { coordinates, tolerance, ..ReductionSettings::default() };
        let contact = filled.iter().zip(top).filter_map(|(shapes, top)| Some(first_touch(shapes, touch)? * top));
        let contact = contact.min_by(f64::total_cmp);
        Ok(Reduction { data: model.system.reduce(&shapes, &reduction_settings)?.data(), contact })
    }

    /// Chamber `filled` alone up to its highest pressure, each equilibrium started from the last; none where it is never filled.
    fn inflate_chamber(&self, filled: usize) -> Result<Vec<Vec<f64>>> {
        if self.top[filled] == 0.0 {
            return Ok(Vec::new());
        }
        let mut solver = self.model.solver(self.elastic)?;
        let mut equilibria = vec![(0.0, vec![0.0; 3 * self.model.system.mesh().nodes.len()])];
        for step in 1..=STEPS {
            let pressures = chamber_pressures(self.top, filled, step as f64 / STEPS as f64);
            let path: Vec<(Pascal, &[f64])> = equilibria.iter().map(|(p, shape)| (*p, shape.as_slice())).collect();
            let equilibrium = solver.equilibrium_from(&path, &pressures, &static_settings())?;
            equilibria.push((pressures[filled], equilibrium.displacement));
        }
        Ok(equilibria.into_iter().skip(1).map(|(_, shape)| shape).collect())
    }

    /// The shapes on the way to a load case, begun at the `nearest` shape: with half of each pull and the whole.
    fn lateral_shapes(
        &self,
        case: &LoadCase,
        nearest: Option<(Vec<Pascal>, &[f64])>,
        pull: &[f64],
    ) -> Result<Vec<Vec<f64>>> {
        let mut solver = self.model.solver(self.elastic)?;
        let none = vec![0.0; pull.len()];
        let (begin, nearest) = nearest.unwrap_or_else(|| (vec![0.0; case.pressures.len()], &none));
        let inflation = LoadRamp { pressures: [&begin, &case.pressures], forces: [&none; 2] };
        let inflated = solver.equilibrium_along(&[(0.0, nearest)], &inflation, &static_settings())?.displacement;
        let mut shapes = Vec::new();
        for amplitude in &case.pulls {
            let mut pulled = |part: f64, path: &[(f64, &[f64])]| {
                let forces: Vec<f64> = pull.iter().map(|f| part * amplitude * self.length * f).collect();
                let ramp = LoadRamp { pressures: [&case.pressures; 2], forces: [&none, &forces] };
                solver.equilibrium_along(path, &ramp, &static_settings()).map(|equilibrium| equilibrium.displacement)
            };
            let half = pulled(0.5, &[(0.0, &inflated)])?;
            let full = pulled(1.0, &[(0.0, &inflated), (0.5, &half)])?;
            shapes.extend([half, full]);
        }
        Ok(shapes)
    }
}

fn chamber_pressures(top: &[Pascal], filled: usize, share: f64) -> Vec<Pascal> {
    (0..top.len()).map(|k| if k == filled { share * top[k] } else { 0.0 }).collect()
}

/// The part (0 to 1) of the pressure of the last of evenly loaded `shapes` from which walls `touch`; between shapes by straight lines.
fn first_touch(shapes: &[Vec<f64>], touch: &dyn Fn(&[f64]) -> bool) -> Option<f64> {
    let undeformed = vec![0.0; shapes.first()?.len()];
    let shape = |step: usize| if step == 0 { &undeformed } else { &shapes[step - 1] };
    let interpolated = |part: f64| -> Vec<f64> {
        let (step, fraction) = ((part.ceil() as usize).max(1), part.ceil() - part);
        shape(step - 1).iter().zip(shape(step)).map(|(a, b)| fraction * a + (1.0 - fraction) * b).collect()
    };
    let parts = (1..=FINE * shapes.len()).map(|k| k as f64 / FINE as f64);
    Some(parts.into_iter().find(|part| touch(&interpolated(*part)))? / shapes.len() as f64)
}

/// The side to which a shape bends: that of positive work of the lateral load.
fn bending_side(shape: &[f64], pull: &[f64]) -> f64 {
    shape.iter().zip(pull).map(|(u, f)| u * f).sum::<f64>().signum()
}

/// Of the shapes with one chamber `filled`, the nearest to `pressures` of one chamber, and its own; none where no chamber or several are filled:
/// from rest both sides of a tail are filled past no buckle, from one side alone back through it.
fn nearest_inflated<'a>(
    filled: &'a [Vec<Vec<f64>>],
    top: &[Pascal],
    pressures: &[Pascal],
) -> Option<(Vec<Pascal>, &'a [f64])> {
    let mut each = pressures.iter().enumerate().filter(|(_, pressure)| **pressure > 0.0);
    let (chamber, pressure) = each.next().filter(|_| each.next().is_none())?;
    let step = (pressure / top[chamber] * STEPS as f64).round() as usize;
    let shape = filled[chamber].get(step.checked_sub(1)?)?;
    Some((chamber_pressures(top, chamber, step as f64 / STEPS as f64), shape))
}

/// Snapshots under lateral loads to both sides: at rest, and with each chamber filled. A chamber that is never filled has none.
fn load_cases(top: &[Pascal], bends: &[f64]) -> Vec<LoadCase> {
    let [with, against] = PULLS;
    let driven: Vec<usize> = (0..top.len()).filter(|k| top[*k] > 0.0).collect();
    let undeformed = LoadCase { pressures: vec![0.0; top.len()], load: Lateral::Water, pulls: vec![with, -with] };
    let inflated = driven.iter().flat_map(|&k| {
        HELD.map(|(share, load)| LoadCase {
            pressures: chamber_pressures(top, k, share),
            load,
            pulls: vec![with * bends[k], -against * bends[k]],
        })
    });
    std::iter::once(undeformed).chain(inflated).collect()
}

fn static_settings() -> StaticSettings {
    // A hundred times coarser than usual, and still below the 1e-5 of an amplitude (the root of the least share) that
    // the modes leave out.
    StaticSettings { tolerance: 1e-6, ..StaticSettings::default() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn walls_touch_from_the_pressure_at_which_the_line_between_two_shapes_does() {
        // three levels; the walls touch from a displacement of 1.5 on, half way from the second level to the third
        let shapes = [0.5, 1.0, 2.0].map(|far| vec![far]);
        let found = |limit: f64| first_touch(&shapes, &|shape: &[f64]| shape[0] >= limit);
        assert_eq!(found(1.5), Some(2.5 / 3.0));
        assert_eq!(found(0.25), Some(0.5 / 3.0));
        assert_eq!(found(2.0), Some(1.0));
        assert_eq!(found(2.1), None);
        assert_eq!(first_touch(&[], &|_: &[f64]| true), None);
    }
}
