//! Loads of a case at a level or a time. The command line and the Python package both take them from here, so that a case means the same to
//! either.

use diagnostics::Result;
use fem::Solver;
use si::{Metre, Pascal, Second};

use crate::case::History;

/// Dead forces, and the pressures of all chambers of the mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct Loads {
    /// At level 1, 3 a node, N; they do not change with time.
    pub forces: Vec<f64>,
    /// Displacements of clamps at level 1, 3 a node, m; empty where none moves.
    pub prescribed: Vec<Metre>,
    /// By chamber of the case: its number in the mesh, and its pressure.
    pub(super) histories: Vec<(usize, History)>,
    /// Number of chambers of the mesh.
    pub(super) chambers: usize,
}

impl Loads {
    /// Dead forces at a level of a static case, 3 a node, N.
    pub fn forces_at_level(&self, level: f64) -> Vec<f64> {
        self.forces.iter().map(|force| level * force).collect()
    }

    /// Moves the clamps of a `solver` to a level of a static case; one whose clamps stay at rest keeps its factor.
    ///
    /// # Errors
    /// A [`diagnostics::Diagnostic`] when the solver is of another body.
    pub fn move_clamps(&self, solver: &mut Solver, level: f64) -> Result<()> {
        if self.prescribed.is_empty() {
            return Ok(());
        }
        Ok(solver.prescribe(&self.prescribed.iter().map(|displacement| level * displacement).collect::<Vec<_>>())?)
    }

    /// Pressures at a level of a static case, one a chamber of the mesh, Pa; 0 where the case names none.
    pub fn pressures_at_level(&self, level: f64) -> Vec<Pascal> {
        self.chamber_pressures(|history| history.at_level(level))
    }

    /// Pressures at a time, one a chamber of the mesh, Pa.
    pub fn pressures_at(&self, time: Second) -> Vec<Pascal> {
        self.chamber_pressures(|history| history.value_at(time))
    }

    fn chamber_pressures(&self, value: impl Fn(&History) -> Pascal) -> Vec<Pascal> {
        let mut pressures = vec![0.0; self.chambers];
        for (number, history) in &self.histories {
            pressures[*number] = value(history);
        }
        pressures
    }
}
