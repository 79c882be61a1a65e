//! Equilibria along a path of loads, rising pressures and dead forces: natural-parameter continuation with steps that shorten where a wall buckles.
//!
//! A wall that buckles turns a shape within a few per cent of the pressure, so that the levels of a sweep lie too far apart there for Newton's
//! method. A step that is too long fails within [`ITERATIONS`], and is halved at once; load stepping from rest would repeat the whole path.

use si::{Metre, Newton, Pascal};

use super::equilibrium::{Equilibrium, StaticSettings};
use crate::newton::options::NewtonCounts;
use crate::solve_error::SolveError;
use crate::solver::Solver;

/// Newton iterations after which a step is given up. A wall that dents takes up to 20, and half as long a step takes as many: of a thin-walled
/// tail (14 levels to 230 mbar, 300 mbar with contact) a limit of 16 took 66 and 139 factorisations, those of abandoned steps included, this
/// one 53 and 105.
///
/// Also measured on these two paths, 53 and 105 as above: absolute eigenvalues in the place of the positive part of each point's tangent
/// [chen2024] 60 and 93 to 116; the whole tangent's negative modes turned round by an indefinite factor 52 and 110, or, with the step
/// along them limited to a hundredth of the body, 53 and 97 to 110; exact tangents for short steps 81 and 107; no factor used twice once a tangent
/// was indefinite 53 and 109. Guesses along the last line took more than 115, from the last shape alone more than 112 to 214 mbar.
const ITERATIONS: usize = 30;
/// Iterations of the shortest step: a wall that snaps moves far however short the step is.
const SNAPPING: usize = 80;
/// First step along a ramp of which one shape is known, as a fraction of it: nothing can be extrapolated, and from rest to 160 mbar in both
/// sides of a thin tail steps of a sixteenth take one or two factorisations each, where the whole step was given up four times.
const FIRST: f64 = 1.0 / 8.0;
/// Shortest step, as a fraction of the way between two levels.
const SHORTEST: f64 = 1.0 / 16.0;
/// Tolerance of equilibria between levels, relative to the body's size: they serve as initial guesses alone.
const BETWEEN: f64 = 1e-4;
/// Factorisations up to which the next step is longer.
const EASY: usize = 4;
/// Factor of a step after one that was easy.
const GROWTH: f64 = 1.5;
/// Known shapes through which a guess is extrapolated: a parabola.
const THROUGH: usize = 3;

/// A load that changes in proportion from one state to another: pressures (one per chamber, Pa) and dead forces (3 entries per node, N; both
/// empty: none), each at its beginning and at its end.
#[derive(Debug, Clone, Copy)]
pub struct LoadRamp<'a> {
    /// Pa.
    pub pressures: [&'a [Pascal]; 2],
    /// N.
    pub forces: [&'a [Newton]; 2],
}

/// Sets the load of a solver at a place of a path, and returns its pressures (Pa).
type SetLoad<'a> = dyn Fn(&mut Solver, f64) -> Result<Vec<Pascal>, SolveError> + 'a;

impl Solver {
    /// The equilibrium under `pressures` (one per chamber, Pa), from the shapes `known` on the way to it (3 entries per node, m), each with
    /// its sum of pressures (Pa); no two are the same. On the way pressures are in the same proportion; the shape at rest is a good first one.
    /// Its counts are those of all steps on the way, abandoned ones included.
    ///
    /// # Errors
    /// [`SolveError`]; `NoEquilibrium` where the shortest step fails.
    ///
    /// # Panics
    /// When no shape is known.
    pub fn equilibrium_from(
        &mut self,
        known: &[(Pascal, &[Metre])],
        pressures: &[Pascal],
        settings: &StaticSettings,
    ) -> Result<Equilibrium, SolveError> {
        let total: Pascal = pressures.iter().sum();
        let load = |_: &mut Self, sum: Pascal| -> Result<Vec<Pascal>, SolveError> {
            // At the end to the last bit, and without pressures not 0/0.
            Ok(pressures.iter().map(|p| if sum == total { *p } else { sum / total * p }).collect())
        };
        self.follow_path((known, total), 1.0, &load, settings)
    }

    /// The equilibrium at the end of a ramp, from the shapes `known` on it (3 entries per node, m), each with its place (0: its beginning, 1:
    /// its end); no two are at the same place. The shape at the beginning is a good first one. The dead forces of the end remain set.
    ///
    /// # Errors
    /// [`SolveError`]; `NoEquilibrium` where the shortest step fails.
    ///
    /// # Panics
    /// When no shape is known, or both ends differ in length.
    pub fn equilibrium_along(
        &mut self,
        known: &[(f64, &[Metre])],
        ramp: &LoadRamp,
        settings: &StaticSettings,
    ) -> Result<Equilibrium, SolveError> {
        let interpolate = |ends: [&[f64]; 2], coordinate: f64| -> Vec<f64> {
            assert_eq!(ends[0].len(), ends[1].len(), "both ends of a ramp");
            ends[0].iter().zip(ends[1]).map(|(from, to)| (1.0 - coordinate) * from + coordinate * to).collect()
        };
        let load = |solver: &mut Self, coordinate: f64| -> Result<Vec<Pascal>, SolveError> {
            solver.set_forces(&interpolate(ramp.forces, coordinate))?;
            Ok(interpolate(ramp.pressures, coordinate))
        };
        let first = if known.len() > 1 { 1.0 } else { FIRST };
        self.follow_path((known, 1.0), first, &load, settings)
    }

    /// The equilibrium at the place `end` of a path, whose first step is a fraction of the way there.
    fn follow_path(
        &mut self,
        (known, end): (&[(f64, &[Metre])], f64),
        first: f64,
        load: &SetLoad,
        settings: &StaticSettings,
    ) -> Result<Equilibrium, SolveError> {
        let recent = &known[known.len().saturating_sub(THROUGH)..];
        let mut path: Vec<(f64, Vec<Metre>)> =
            recent.iter().map(|(coordinate, shape)| (*coordinate, shape.to_vec())).collect();
        let begin = path.last().expect("a shape is known").0;
        let (mut reached, mut step) = (0.0, first);
        let counts_before = self.state.newton.spent;
        loop {
            // A short rest is taken along: two shapes close to each other would spoil the next extrapolation.
            let part = if reached + step > 1.0 - SHORTEST { 1.0 } else { reached + step };
            let coordinate = if part == 1.0 { end } else { begin + part * (end - begin) };
            let tolerance = if part == 1.0 { settings.tolerance } else { settings.tolerance.max(BETWEEN) };
            let max_iterations = if step > SHORTEST { ITERATIONS.min(settings.max_iterations) } else { SNAPPING };
            let statics = StaticSettings { tolerance, max_iterations, ..*settings };
            let pressures = load(self, coordinate)?;
            let shapes: Vec<(f64, &[Metre])> =
                path.iter().map(|(coordinate, shape)| (*coordinate, shape.as_slice())).collect();
            let last = shapes.last().map_or(&[][..], |last| last.1);
            match self.equilibrium_near(&pressures, last, &extrapolated(&shapes, coordinate), &statics) {
                Ok(found) if part == 1.0 => {
                    let NewtonCounts { iterations, factorisations, .. } =
                        self.state.newton.spent.counted_since(counts_before);
                    return Ok(Equilibrium { iterations, factorisations, ..found });
                }
                Ok(Equilibrium { displacement, factorisations, .. }) => {
                    path.push((coordinate, displacement));
                    (reached, step) = (part, if factorisations <= EASY { GROWTH * step } else { step });
                }
                Err(_) if step > SHORTEST => step *= 0.5,
                Err(cause) => return Err(cause),
            }
        }
    }
}

/// The polynomial through the last three of the `known` shapes, each with its place on a path, at the place `to`. There is at least one shape.
pub fn extrapolated(known: &[(f64, &[Metre])], to: f64) -> Vec<Metre> {
    let last = &known[known.len().saturating_sub(THROUGH)..];
    let mut sum = vec![0.0; last.first().map_or(0, |(_, shape)| shape.len())];
    for (i, (at, shape)) in last.iter().enumerate() {
        let other_shapes = last.iter().enumerate().filter(|(j, _)| *j != i);
        let weight: f64 = other_shapes.map(|(_, (other, _))| (to - other) / (at - other)).product();
        sum.iter_mut().zip(*shape).for_each(|(sum, u)| *sum += weight * u);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_parabola_is_extrapolated_exactly_and_older_shapes_do_not_count() {
        let at = |t: f64| [1.0 + t * t, 2.0 - t];
        let shapes: Vec<(f64, [f64; 2])> = [0.1, 0.5, 0.6].map(|t| (t, at(t))).to_vec();
        let known: Vec<(f64, &[f64])> = shapes.iter().map(|(t, shape)| (*t, shape.as_slice())).collect();
        let with_older: Vec<(f64, &[f64])> = std::iter::once((0.0, [9.0; 2].as_slice())).chain(known.clone()).collect();
        for known in [&known, &with_older] {
            let found = extrapolated(known, 0.9);
            assert!(found.iter().zip(at(0.9)).all(|(a, b)| (a - b).abs() < 1e-12), "{found:?}");
        }
        assert_eq!(extrapolated(&known[..1], 0.9), at(0.1));
    }
}
