//! Paths of equilibria between two loads, in steps short enough for Newton's method.
//!
//! A wall that buckles turns a shape within a few per cent of the pressure: levels of a staircase lie too far apart there to start from one
//! another, and so do bodies whose moduli differ by a tenth. A step that is too long is given up after a few iterations and shortened.

use fem::{Equilibrium, Solver, StaticSettings, extrapolated};
use si::Pascal;

use crate::model::{BODY, Elastic};
use crate::surrogate::Load;
use diagnostics::Result;

/// Factorisations up to which the next step is longer, and from which it is shorter.
const EASY: usize = 3;
const HARD: usize = 6;
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
    /// The same steps of a path that is shorter by this factor.
    pub fn over(self, part: f64) -> Self {
        let longer = |step: f64| (step / part.max(f64::MIN_POSITIVE)).min(0.5);
        Self { first: longer(self.first), longest: longer(self.longest), shortest: longer(self.shortest) }
    }
}

/// A path.
pub(crate) struct LoadPath<'a> {
    /// Where it begins, with the shape there (3 a node, m).
    pub from: (&'a Load, &'a [f64]),
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
    /// Its shape, m, 3 a node.
    pub shape: Vec<f64>,
}

impl LoadPath<'_> {
    /// The points on the way, and the equilibrium at the end with `settings`.
    pub fn follow(&self, solver: &mut Solver, settings: &StaticSettings) -> (Vec<Point>, Result<Equilibrium>) {
        let Steps { first, longest, shortest } = self.steps;
        let (mut points, mut reached, mut step): (Vec<Point>, f64, f64) = (Vec::new(), 0.0, first);
        loop {
            let target = if reached + step > 1.0 - shortest { 1.0 } else { reached + step };
            let iterations = if step > shortest { settings.max_iterations } else { SNAPPING };
            let settings = StaticSettings { max_iterations: iterations, ..*settings };
            match self.equilibrium(target, &points, solver, &settings) {
                Ok(end) if target == 1.0 => return (points, Ok(end)),
                Ok(Equilibrium { displacement, factorisations, .. }) => {
                    step = (step * growth(factorisations)).clamp(shortest, longest);
                    reached = target;
                    points.push(Point { part: target, load: self.load(target), shape: displacement });
                }
                Err(_) if step > shortest => step = (0.5 * step).max(shortest),
                Err(cause) => return (points, Err(cause)),
            }
        }
    }

    /// The equilibrium at `part` of the path.
    fn equilibrium(
        &self,
        part: f64,
        points: &[Point],
        solver: &mut Solver,
        settings: &StaticSettings,
    ) -> Result<Equilibrium> {
        let pressures = self.set(part, solver)?;
        let nearby = points.last().map_or(self.from.1, |last| &last.shape);
        let tolerance = if part == 1.0 { settings.tolerance } else { settings.tolerance.max(TOLERANCE) };
        let settings = StaticSettings { tolerance, ..*settings };
        Ok(solver.equilibrium_near(&pressures, nearby, &self.extrapolated(part, points), &settings)?)
    }

    fn load(&self, part: f64) -> Load {
        self.from.0.towards(self.to, part)
    }

    /// Sets the constants at `part` of the path in `solver` and returns the pressures there, Pa.
    fn set(&self, part: f64, solver: &mut Solver) -> Result<Vec<Pascal>> {
        if part == 1.0 {
            self.elastic.apply(solver)?;
            return Ok(self.pressures.to_vec());
        }
        let constants = |load: &Load| load.constants(self.elastic.youngs_moduli[BODY], self.unit);
        let ((pressure, elastic), (whole, _)) = (constants(&self.load(part)), constants(self.to));
        elastic.apply(solver)?;
        Ok(self.pressures.iter().map(|at_the_end| pressure / whole * at_the_end).collect())
    }

    /// The polynomial through the last three points, of which the beginning of the path is one, at `part`.
    fn extrapolated(&self, part: f64, points: &[Point]) -> Vec<f64> {
        let known = points.iter().map(|point| (point.part, point.shape.as_slice()));
        extrapolated(&std::iter::once((0.0, self.from.1)).chain(known).collect::<Vec<_>>(), part)
    }
}

/// Factor of the next step after one with this many factorisations.
fn growth(factorisations: usize) -> f64 {
    match factorisations {
        ..=EASY => 1.5,
        HARD.. => 0.6,
        _ => 1.0,
    }
}
