//! Loads of a case at a level or a time. The command line and the Python package both take them from here, so that a case means the same to
//! either.

use si::{Pascal, Second};

use crate::case::History;

/// Dead forces, and the pressures of all chambers of the mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct Loads {
    /// At level 1, 3 a node, N; they do not change with time.
    pub forces: Vec<f64>,
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
