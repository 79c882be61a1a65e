//! Points of a path: equilibria with their stability, and critical points.

use crate::subspace::Eigenpair;

/// An equilibrium on a path.
#[derive(Debug, Clone, PartialEq)]
pub struct PathPoint {
    /// λ
    pub load_factor: f64,
    /// u, one entry per dof, m.
    pub displacement: Vec<f64>,
    /// Number of negative eigenvalues of the tangent: 0 where the equilibrium is stable.
    pub negative_eigenvalues: usize,
    /// The eigenvalue of the tangent that is nearest to zero, N/m.
    pub eigenvalue: f64,
    /// Newton iterations, each with one factorisation.
    pub iterations: usize,
    /// Whether it was solved for at a load factor of [`crate::PathSettings::levels`], rather than reached by a step.
    pub is_level: bool,
}

/// What happens at a critical point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CriticalKind {
    /// λ has an extremum along the path: under a load that is held the body snaps through.
    LimitPoint,
    /// Another path crosses: φᵀ ∂r/∂λ = 0.
    Bifurcation,
}

/// A point at which the tangent is singular.
#[derive(Debug, Clone, PartialEq)]
pub struct CriticalPoint {
    /// What happens there.
    pub kind: CriticalKind,
    /// λ
    pub load_factor: f64,
    /// u, one entry per dof, m.
    pub displacement: Vec<f64>,
    /// φ, one entry per dof, with φᵀφ = 1; its entry of largest amplitude is positive.
    pub mode: Vec<f64>,
    /// Number of eigenvalues that vanish together; `mode` is then one of their modes.
    pub multiplicity: usize,
    /// |φᵀ ∂r/∂λ| over ‖∂r/∂λ‖: the load's part along the mode, 0 at a bifurcation.
    pub load_along_mode: f64,
    /// Negative eigenvalues of the tangent before and after it.
    pub negative_eigenvalues: [usize; 2],
}

/// What a path comes to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PathEvent<'a> {
    /// An equilibrium.
    Point(&'a PathPoint),
    /// A critical point, before the point that follows it.
    Critical(&'a CriticalPoint),
}

/// Why a path ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PathEnd {
    /// It reached its last load factor.
    LoadFactor,
    /// It took as many steps as it may.
    StepLimit,
}

/// A path that was followed.
#[derive(Debug, Clone, PartialEq)]
pub struct Path {
    /// Its critical points, in the order in which they were passed.
    pub critical: Vec<CriticalPoint>,
    /// Steps along it.
    pub steps: usize,
    /// Factorisations, those of steps that failed and of the location of critical points among them.
    pub factorisations: usize,
    /// Why it ended.
    pub end: PathEnd,
}

/// A converged point with what the next step needs.
#[derive(Debug, Clone)]
pub(crate) struct Sample {
    pub u: Vec<f64>,
    pub load_factor: f64,
    /// K⁻¹ q = du/dλ.
    pub by_load: Vec<f64>,
    /// Negative eigenvalues of K.
    pub negative: usize,
    /// Eigenvalues nearest to zero first.
    pub pairs: Vec<Eigenpair>,
    pub iterations: usize,
}

impl Sample {
    /// The eigenvalue of that `number` in ascending order; none when it is not among those known.
    pub fn eigenvalue(&self, number: usize) -> Option<f64> {
        let mut same: Vec<f64> = self.pairs.iter().map(|pair| pair.value).collect();
        same.retain(|value| (*value < 0.0) == (number < self.negative));
        same.sort_by(|a, b| a.abs().total_cmp(&b.abs()));
        let from_zero = if number < self.negative { self.negative - 1 - number } else { number - self.negative };
        same.get(from_zero).copied()
    }

    /// The eigenvalue nearest to zero, N/m.
    pub(crate) fn nearest_eigenvalue(&self) -> f64 {
        self.pairs.first().map_or(f64::NAN, |pair| pair.value)
    }

    /// As it is reported.
    pub fn point(&self, is_level: bool) -> PathPoint {
        PathPoint {
            load_factor: self.load_factor,
            displacement: self.u.clone(),
            negative_eigenvalues: self.negative,
            eigenvalue: self.nearest_eigenvalue(),
            iterations: self.iterations,
            is_level,
        }
    }
}
