//! Paths of equilibria between two loads, in steps short enough for Newton's method.
//!
//! A wall that buckles turns a shape within a few per cent of the pressure: levels of a staircase lie too far apart there to start from one
//! another, and so do bodies whose moduli differ by a tenth. A step that is too long is given up after a few iterations and shortened.

use fem::{StaticSettings, extrapolated};
use si::Pascal;

use crate::levels::statics::{EquilibriumShape, Statics};
use crate::model::{BODY, Elastic};
use crate::surrogate::{KnownShape, Load};
use diagnostics::Result;

/// Factorisations up to which the next step is longer, and from which it is shorter.
const EASY: usize = 3;
const HARD: usize = 6;
/// Factor of a step after one that was easy.
const LONGER: f64 = 1.5;
/// Tolerance on the way.
const TOLERANCE: f64 = 1e-4;
/// Newton iterations of the shortest step: a wall that snaps moves far however short the step is.
const SNAPPING: usize = 80;

/// Lengths of the steps, as fractions of the path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Steps {
    pub first: f64,
    pub longest: f64,
    pub shortest: f64,
}

impl Steps {
    /// Along a path from rest, to the highest pressure or beyond it.
    pub(crate) const FROM_REST: Self = Self { first: 0.1, longest: 0.12, shortest: 1.0 / 64.0 };
    /// From the nearest equilibrium that is known.
    pub(crate) const FROM_NEARBY: Self = Self { first: 0.5, longest: 0.5, shortest: 1.0 / 16.0 };

    /// The same steps of a path that is shorter by this factor.
    pub fn over(self, part: f64) -> Self {
        let longer = |step: f64| (step / part.max(f64::MIN_POSITIVE)).min(0.5);
        Self { first: longer(self.first), longest: longer(self.longest), shortest: longer(self.shortest) }
    }

    /// The same steps of a path that goes on after one whose last step had this length.
    pub fn after(self, last: f64) -> Self {
        Self { first: (LONGER * last).clamp(self.shortest, self.longest), ..self }
    }
}

/// The equilibrium at which a path begins, and those of the same body before it.
pub(crate) struct Beginning<'a> {
    load: &'a Load,
    /// Parts of the path and shapes, by rising pressure; those before the beginning are negative, the last is zero.
    known: Vec<(f64, &'a [f64])>,
}

impl<'a> Beginning<'a> {
    /// At an equilibrium of which none before is known.
    pub fn at(equilibrium: &'a KnownShape) -> Self {
        Self { load: &equilibrium.load, known: vec![(0.0, &equilibrium.shape)] }
    }

    /// At the last of the equilibria of one body `below` the end of its path, by rising pressure; none where there is none. Those before it count
    /// in the extrapolation: from the last shape alone, first steps beyond a buckle failed.
    pub fn on_the_way(below: &[&'a KnownShape], target: &Load) -> Option<Self> {
        let load = &below.last()?.load;
        let begin = load.part_of(target);
        let part = |load: &Load| (load.part_of(target) - begin) / (1.0 - begin);
        Some(Self { load, known: below.iter().map(|shape| (part(&shape.load), shape.shape.as_slice())).collect() })
    }

    /// Length of the step that led here, as a part of the path.
    pub fn last_step(&self) -> Option<f64> {
        self.known.len().checked_sub(2).map(|previous| -self.known[previous].0)
    }

    fn initial_shape(&self) -> &'a [f64] {
        self.known.last().map_or(&[], |(_, shape)| shape)
    }
}

/// A path.
pub(crate) struct LoadPath<'a> {
    /// Where it begins.
    pub from: Beginning<'a>,
    /// Where it ends.
    pub to: &'a Load,
    /// The pressures of all chambers there, Pa.
    pub pressures: &'a [Pascal],
    /// The constants there.
    pub elastic: &'a Elastic,
    /// See [`Load::new`].
    pub unit: f64,
    /// Its steps.
    pub steps: Steps,
}

/// An equilibrium on the way.
pub(crate) struct Point {
    /// The part of the path that leads to it, 0 to 1.
    pub part: f64,
    /// Its load.
    pub load: Load,
    /// Its shape, in the unknowns of what found it.
    pub shape: Vec<f64>,
}

impl LoadPath<'_> {
    /// The points on the way, and the equilibrium at the end with `settings`.
    pub fn follow(
        &self,
        solver: &mut dyn Statics,
        settings: &StaticSettings,
    ) -> (Vec<Point>, Result<EquilibriumShape>) {
        let Steps { first, longest, shortest } = self.steps;
        let (mut points, mut reached, mut step): (Vec<Point>, f64, f64) = (Vec::new(), 0.0, first);
        loop {
            let target = if reached + step > 1.0 - shortest { 1.0 } else { reached + step };
            let iterations = if step > shortest { settings.max_iterations } else { SNAPPING };
            let settings = StaticSettings { max_iterations: iterations, ..*settings };
            match self.equilibrium_at(target, &points, solver, &settings) {
                Ok(end) if target == 1.0 => return (points, Ok(end)),
                Ok(EquilibriumShape { unknowns, factorisations }) => {
                    step = (step * step_growth(factorisations)).clamp(shortest, longest);
                    reached = target;
                    points.push(Point { part: target, load: self.load_at(target), shape: unknowns });
                }
                Err(_) if step > shortest => step = (0.5 * step).max(shortest),
                Err(cause) => return (points, Err(cause)),
            }
        }
    }

    /// The equilibrium at `part` of the path.
    fn equilibrium_at(
        &self,
        part: f64,
        points: &[Point],
        solver: &mut dyn Statics,
        settings: &StaticSettings,
    ) -> Result<EquilibriumShape> {
        let pressures = self.apply_constants(part, solver)?;
        let nearby = points.last().map_or(self.from.initial_shape(), |last| &last.shape);
        let tolerance = if part == 1.0 { settings.tolerance } else { settings.tolerance.max(TOLERANCE) };
        let settings = StaticSettings { tolerance, ..*settings };
        solver.equilibrium_near(&pressures, nearby, &self.extrapolated_shape(part, points), &settings)
    }

    fn load_at(&self, part: f64) -> Load {
        self.from.load.towards(self.to, part)
    }

    /// Sets the constants at `part` of the path in `solver` and returns the pressures there, Pa.
    fn apply_constants(&self, part: f64, solver: &mut dyn Statics) -> Result<Vec<Pascal>> {
        // At the end the constants as they were given: those of a load come back from logarithms, with their rounding.
        if part == 1.0 {
            solver.set_constants(self.elastic)?;
            return Ok(self.pressures.to_vec());
        }
        let constants = |load: &Load| load.constants(self.elastic.youngs_moduli[BODY], self.unit);
        let ((pressure, elastic), (top_pressure, _)) = (constants(&self.load_at(part)), constants(self.to));
        solver.set_constants(&elastic)?;
        Ok(self.pressures.iter().map(|at_the_end| pressure / top_pressure * at_the_end).collect())
    }

    /// The polynomial through the last three equilibria, of which the beginning of the path may be one, at `part`.
    fn extrapolated_shape(&self, part: f64, points: &[Point]) -> Vec<f64> {
        let points = points.iter().map(|point| (point.part, point.shape.as_slice()));
        extrapolated(&self.from.known.iter().copied().chain(points).collect::<Vec<_>>(), part)
    }
}

/// Factor of the next step after one with this many factorisations.
fn step_growth(factorisations: usize) -> f64 {
    match factorisations {
        ..=EASY => LONGER,
        HARD.. => 0.6,
        _ => 1.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn known(pressure: Pascal) -> KnownShape {
        let elastic =
            Elastic { youngs_moduli: vec![1e5, 2e9], poissons_ratios: vec![0.49, 0.38], stiffening: [0.0; 2] };
        KnownShape::new(Load::new(0, pressure, &elastic, 0.1), vec![pressure * pressure])
    }

    #[test]
    fn a_path_goes_on_along_the_parabola_and_with_the_step_of_the_equilibria_below_it() {
        let (shapes, to) = ([2e3, 6e3, 8e3].map(known), known(1.2e4));
        let from = Beginning::on_the_way(&shapes.each_ref(), &to.load).expect("three are below");
        let parts: Vec<f64> = from.known.iter().map(|(part, _)| *part).collect();
        assert!(parts.iter().zip([-1.5, -0.5, 0.0]).all(|(a, b)| (a - b).abs() < 1e-12), "{parts:?}");
        let shape = extrapolated(&from.known, 1.0)[0];
        assert!((shape / to.shape[0] - 1.0).abs() < 1e-9, "{shape}");
        let steps = Steps { first: 0.1, longest: 0.8, shortest: 0.01 };
        let first = |last: f64| steps.after(last).first;
        assert!(from.last_step().is_some_and(|last| (first(last) - 0.75).abs() < 1e-12));
        assert_eq!([first(0.6), first(1e-3)], [0.8, 0.01]);
    }

    #[test]
    fn one_equilibrium_is_a_beginning_without_a_last_step() {
        let (one, to) = (known(8e3), known(1.2e4));
        let on_the_way = Beginning::on_the_way(&[&one], &to.load).expect("one is below");
        assert_eq!([on_the_way.last_step(), Beginning::at(&one).last_step()], [None, None]);
        assert_eq!(Beginning::at(&one).initial_shape(), one.shape);
        assert!(Beginning::on_the_way(&[], &to.load).is_none());
    }
}
