//! The arc-length method [crisfield1981]: predictor along the tangent, corrector on a cylinder around the last point.
//!
//! Of the two directions of the tangent the one that goes on is taken: its product with the last increment is positive,
//! which holds through limit points and bifurcations alike, where signs of determinants or of the load's work fail. The
//! step follows the number of Newton iterations; a step that fails, or that ends far from where the tangent leads, is
//! halved.

use crate::branch::secondary_branch;
use crate::constraint::Constraint;
use crate::corrector::{Corrector, Guess};
use crate::critical::locate_critical_points;
use crate::error::{ContinuationError, StepFailure};
use crate::point::{CriticalKind, CriticalPoint, Path, PathEnd, PathEvent, Sample};
use crate::problem::Problem;
use crate::segment::{Segment, guess_between};
use crate::settings::{Branch, PathSettings};
use crate::subspace::{Accuracy, Subspace};

/// Newton iterations of a step that keeps its length.
const TARGET_ITERATIONS: f64 = 4.0;
/// Least and largest factor of the length from step to step.
const GROWTH: [f64; 2] = [0.5, 2.0];
/// Least cosine of the angle between a step and its tangent: sharper turns need shorter steps, lest they be cut.
const MIN_COSINE: f64 = 0.8;
/// An eigenvalue below this fraction of the largest one watched so far has no certain sign: a converged point is off its
/// path by as much. The step is then repeated longer by this factor, so many times.
const RESOLVED: f64 = 1e-5;
const OTHER_STEP: f64 = 1.5;
const RESOLVING_STEPS: usize = 3;
/// An equilibrium at a given load that is further from the last point than this many steps lies on another branch.
const SAME_BRANCH: f64 = 1.5;

/// Follows the path of `problem` from the first to the last load factor of `settings`, and calls `observe` with each
/// point and each critical point, in the order of the path.
///
/// # Errors
/// [`ContinuationError`]; the points up to then have been observed.
pub fn follow(
    problem: &mut dyn Problem,
    settings: &PathSettings,
    observe: &mut dyn FnMut(PathEvent),
) -> Result<Path, ContinuationError> {
    settings.check_ranges()?;
    Follower::begin_path(problem, settings, observe)?.run_path()
}

/// A path on the way.
struct Follower<'a, 'o> {
    corrector: Corrector<'a>,
    settings: &'a PathSettings,
    observe: &'o mut dyn FnMut(PathEvent),
    /// The last point.
    at: Sample,
    /// The direction of the path there: the last increment of u.
    direction: Vec<f64>,
    /// Length of the next step, and of the longest one.
    step: f64,
    longest: f64,
    /// The largest of the eigenvalues nearest to zero, N/m.
    scale: f64,
    critical: Vec<CriticalPoint>,
    steps: usize,
}

/// What lay between two points.
enum Passed {
    /// The path goes on to the second one.
    On,
    /// It goes on from this first point of a secondary branch.
    Branched(Box<Sample>),
    /// It ends at its last load factor.
    Last,
}

impl<'a, 'o> Follower<'a, 'o> {
    /// At the first point.
    fn begin_path(
        problem: &'a mut dyn Problem,
        settings: &'a PathSettings,
        observe: &'o mut dyn FnMut(PathEvent),
    ) -> Result<Self, ContinuationError> {
        let (size, dofs, u) = (problem.size(), problem.dofs(), problem.start());
        let tolerance = settings.tolerance * size;
        let mut corrector = Corrector { problem, tolerance, subspace: Subspace::new(dofs), factorisations: 0 };
        let [load_factor, last] = settings.load_factors;
        let guess = Guess { u, load_factor, previous: None };
        let sample = corrector.solve(guess, Constraint::LoadFactor(load_factor), Accuracy::Watch);
        let sample = sample.map_err(|cause| ContinuationError::Start { load_factor, cause })?;
        let first = settings.first_step * (last - load_factor);
        let direction: Vec<f64> = sample.by_load.iter().map(|entry| first * entry).collect();
        let longest = settings.max_step * size * (dofs as f64).sqrt();
        let step = norm(&direction).min(longest);
        observe(PathEvent::Point(&sample.point(false)));
        let (scale, critical) = (sample.nearest_eigenvalue().abs(), Vec::new());
        Ok(Self { corrector, settings, observe, at: sample, direction, step, longest, scale, critical, steps: 0 })
    }

    fn run_path(mut self) -> Result<Path, ContinuationError> {
        while self.steps < self.settings.max_steps {
            let next = self.resolved_point()?;
            self.steps += 1;
            match self.pass_segment(&next) {
                Ok(Passed::On) => {
                    (self.observe)(PathEvent::Point(&next.point(false)));
                    self.move_to(next);
                }
                Ok(Passed::Branched(first)) => self.begin_branch(*first),
                Ok(Passed::Last) => return Ok(self.finished_path(PathEnd::LoadFactor)),
                // What lies between two points is found more easily between nearer ones.
                Err(_) if self.step > self.shortest_step() => self.step = 0.25 * self.segment_to(&next).length(),
                Err(cause) => return Err(self.stalled_error(cause)),
            }
        }
        Ok(self.finished_path(PathEnd::StepLimit))
    }

    fn segment_to<'s>(&'s self, next: &'s Sample) -> Segment<'s> {
        Segment { from: &self.at, to: next }
    }

    fn shortest_step(&self) -> f64 {
        self.settings.min_step * self.longest
    }

    fn finished_path(self, end: PathEnd) -> Path {
        let factorisations = self.corrector.factorisations;
        Path { critical: self.critical, steps: self.steps, factorisations, end }
    }

    fn move_to(&mut self, next: Sample) {
        self.direction = Segment { from: &self.at, to: &next }.increment();
        self.at = next;
    }

    /// The next point, not so close to a critical one that the sign of its eigenvalue is open.
    fn resolved_point(&mut self) -> Result<Sample, ContinuationError> {
        for _ in 0..RESOLVING_STEPS {
            let next = self.advance_point()?;
            let nearest = next.nearest_eigenvalue().abs();
            self.scale = self.scale.max(nearest);
            if nearest >= RESOLVED * self.scale {
                return Ok(next);
            }
            self.step = (OTHER_STEP * self.segment_to(&next).length()).min(self.longest);
        }
        // The path is nearly critical over some length: it has not changed sides yet.
        Ok(Sample { negative: self.at.negative, ..self.advance_point()? })
    }

    /// The next point, at the longest distance that succeeds.
    fn advance_point(&mut self) -> Result<Sample, ContinuationError> {
        loop {
            match self.try_step() {
                Ok(next) => {
                    let growth = (TARGET_ITERATIONS / next.iterations as f64).sqrt().clamp(GROWTH[0], GROWTH[1]);
                    self.step = (growth * self.step).min(self.longest);
                    return Ok(next);
                }
                Err(_) if self.step > self.shortest_step() => self.step *= 0.5,
                Err(cause) => return Err(self.stalled_error(cause)),
            }
        }
    }

    fn try_step(&mut self) -> Result<Sample, StepFailure> {
        let projection = sparse::dot(&self.direction, &self.at.by_load);
        let load_step = self.step / norm(&self.at.by_load) * projection.signum();
        let mut u = self.at.u.clone();
        sparse::add(&mut u, load_step, &self.at.by_load);
        let guess = Guess { u, load_factor: self.at.load_factor + load_step, previous: Some(&self.at.u) };
        let cylinder = Constraint::Cylinder { centre: &self.at.u, radius: self.step };
        let next = self.corrector.solve(guess, cylinder, Accuracy::Watch)?;
        let increment = Segment { from: &self.at, to: &next }.increment();
        let cosine = sparse::dot(&increment, &self.at.by_load) * load_step
            / (load_step * norm(&self.at.by_load)).abs()
            / norm(&increment);
        if cosine >= MIN_COSINE { Ok(next) } else { Err(StepFailure::Turned { cosine }) }
    }

    fn stalled_error(&self, cause: StepFailure) -> ContinuationError {
        let dofs = self.at.u.len() as f64;
        let step = self.step / dofs.sqrt() / self.corrector.problem.size();
        ContinuationError::Stalled { load_factor: self.at.load_factor, step, cause }
    }

    /// Solves for all that lies between the last point and `next`, and then reports it.
    fn pass_segment(&mut self, next: &Sample) -> Result<Passed, StepFailure> {
        let segment = Segment { from: &self.at, to: next };
        let changes = next.negative != self.at.negative;
        let critical = if changes { locate_critical_points(&mut self.corrector, segment)? } else { Vec::new() };
        let leaving = critical.iter().position(|point| self.leaves_at(point));
        if let Some(last) = leaving {
            let amplitude = self.settings.branch_amplitude * self.corrector.problem.size();
            let first = secondary_branch(&mut self.corrector, &critical[last], self.settings.branch, amplitude)?;
            critical.into_iter().take(last + 1).for_each(|point| self.report_critical(point));
            return Ok(Passed::Branched(Box::new(first)));
        }
        let (levels, ends) = self.solve_levels(next)?;
        critical.into_iter().for_each(|point| self.report_critical(point));
        levels.iter().for_each(|level| (self.observe)(PathEvent::Point(&level.point(true))));
        Ok(if ends { Passed::Last } else { Passed::On })
    }

    fn report_critical(&mut self, point: CriticalPoint) {
        (self.observe)(PathEvent::Critical(&point));
        self.critical.push(point);
    }

    /// Whether the path goes on along a secondary branch: where the primary one first loses its stability.
    fn leaves_at(&self, point: &CriticalPoint) -> bool {
        let loses = point.negative_eigenvalues[0] == 0 && point.kind == CriticalKind::Bifurcation;
        loses && self.settings.branch != Branch::Primary
    }

    /// Goes on from the `first` point of a secondary branch, away from the bifurcation.
    fn begin_branch(&mut self, first: Sample) {
        (self.observe)(PathEvent::Point(&first.point(false)));
        let bifurcation = &self.critical[self.critical.len() - 1];
        self.direction = first.u.iter().zip(&bifurcation.displacement).map(|(to, from)| to - from).collect();
        self.step = norm(&self.direction).min(self.longest);
        self.at = first;
    }

    /// The equilibria at the levels that are crossed on the way to `next`; whether the last one ends the path.
    fn solve_levels(&mut self, next: &Sample) -> Result<(Vec<Sample>, bool), StepFailure> {
        let [_, last] = self.settings.load_factors;
        let (from, to) = (self.at.load_factor, next.load_factor);
        let ends = (from < last) != (to < last) || to == last;
        let mut levels = self.settings.levels_between(from, to);
        levels.retain(|level| !(ends && *level == last));
        levels.extend(ends.then_some(last));
        let solved: Result<Vec<Sample>, StepFailure> =
            levels.into_iter().map(|level| self.solve_level(next, level)).collect();
        Ok((solved?, ends))
    }

    /// The equilibrium at the load factor `level` between the last point and `next`.
    fn solve_level(&mut self, next: &Sample, level: f64) -> Result<Sample, StepFailure> {
        let segment = Segment { from: &self.at, to: next };
        let part = (level - self.at.load_factor) / (next.load_factor - self.at.load_factor);
        let guess = guess_between(&self.at, next, part);
        let direct = self.corrector.solve(guess, Constraint::LoadFactor(level), Accuracy::Watch);
        let is_near = |found: &Sample| Segment { from: &self.at, to: found }.length() <= SAME_BRANCH * segment.length();
        match direct {
            Ok(found) if is_near(&found) => Ok(found),
            // Near a limit point the load alone does not say which of two equilibria is meant.
            _ => segment.find_root(&mut self.corrector, &|sample| sample.load_factor - level),
        }
    }
}

fn norm(x: &[f64]) -> f64 {
    sparse::dot(x, x).sqrt()
}
