//! Settings of a path, and the rule by which a branch is chosen at a bifurcation.

use crate::error::ContinuationError;

/// Which branch is followed from the bifurcation at which the path first loses stability. Limit points have one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Branch {
    /// The path on which the bifurcation was found, unstable beyond it.
    Primary,
    /// The secondary path that leaves along the mode, oriented so that its entry of largest amplitude (the first one of
    /// several equal ones) is positive: where a small imperfection of that shape leads.
    #[default]
    AlongMode,
    /// The secondary path that leaves in the opposite direction.
    AgainstMode,
}

/// How a path is followed.
#[derive(Debug, Clone, PartialEq)]
pub struct PathSettings {
    /// Load factors at which the path begins and ends; it ends where it first reaches the second.
    pub load_factors: [f64; 2],
    /// Load factors at which equilibria are solved for each time the path crosses them.
    pub levels: Vec<f64>,
    /// First step, as a fraction of the way between the two load factors.
    pub first_step: f64,
    /// Longest step: root mean square displacement of the dofs over the body's size.
    pub max_step: f64,
    /// Shortest step as a fraction of the longest one.
    pub min_step: f64,
    /// Steps at most.
    pub max_steps: usize,
    /// The last Newton step moves no dof further than this fraction of the body's size.
    pub tolerance: f64,
    /// Which branch is followed from a bifurcation.
    pub branch: Branch,
    /// Largest displacement along the mode with which a secondary branch begins, over the body's size.
    pub branch_amplitude: f64,
}

impl Default for PathSettings {
    fn default() -> Self {
        Self {
            load_factors: [0.0, 1.0],
            levels: Vec::new(),
            first_step: 0.1,
            max_step: 0.05,
            min_step: 1e-5,
            max_steps: 200,
            tolerance: 1e-8,
            branch: Branch::default(),
            branch_amplitude: 2e-3,
        }
    }
}

impl PathSettings {
    /// # Errors
    /// [`ContinuationError::Setting`]
    pub(crate) fn check_ranges(&self) -> Result<(), ContinuationError> {
        let [from, to] = self.load_factors;
        check_range("the first step", self.first_step, 1e-9, 1.0)?;
        check_range("the longest step", self.max_step, 1e-9, 1.0)?;
        check_range("the shortest step", self.min_step, 1e-12, 1.0)?;
        check_range("the tolerance", self.tolerance, 1e-13, 1e-2)?;
        check_range("the amplitude of a branch", self.branch_amplitude, 1e-9, 1.0)?;
        check_range("the number of steps", self.max_steps as f64, 1.0, 1e6)?;
        check_range("the distance of the load factors", (to - from).abs(), f64::MIN_POSITIVE, f64::MAX)
    }

    /// The load factors at which equilibria are wanted between `from` (left out) and `to`, in the order of the path.
    pub(crate) fn levels_between(&self, from: f64, to: f64) -> Vec<f64> {
        let is_between = |level: &f64| (*level > from && *level <= to) || (*level < from && *level >= to);
        let mut wanted: Vec<f64> = self.levels.iter().copied().filter(is_between).collect();
        wanted.sort_by(|a, b| if to > from { a.total_cmp(b) } else { b.total_cmp(a) });
        wanted
    }
}

fn check_range(what: &'static str, value: f64, least: f64, most: f64) -> Result<(), ContinuationError> {
    if value >= least && value <= most {
        return Ok(());
    }
    Err(ContinuationError::Setting { what, value, least, most })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_come_in_the_order_of_the_path() {
        let settings = PathSettings { levels: vec![0.7, 0.2, 0.5], ..Default::default() };
        assert_eq!(settings.levels_between(0.2, 0.7), [0.5, 0.7]);
        assert_eq!(settings.levels_between(0.7, 0.1), [0.5, 0.2]);
        assert!(settings.levels_between(0.3, 0.4).is_empty());
    }

    #[test]
    fn a_setting_out_of_range_is_refused_with_its_range() {
        let refused = PathSettings { tolerance: 0.5, ..Default::default() }.check_ranges().unwrap_err().to_string();
        assert!(refused.contains("the tolerance is 5e-1") && refused.contains("do:"), "{refused}");
        assert!(PathSettings { load_factors: [1.0, 1.0], ..Default::default() }.check_ranges().is_err());
        assert!(PathSettings { max_steps: 0, ..Default::default() }.check_ranges().is_err());
        assert!(PathSettings::default().check_ranges().is_ok());
    }
}
