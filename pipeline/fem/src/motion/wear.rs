//! Wear: when a factor that serves many steps has paid for itself.
//!
//! Stands on: nothing. Never knows: what a step is.

/// The cost of all steps since the last factor.
#[derive(Debug, Clone)]
pub(crate) struct Wear {
    /// What a factor costs, in uses of it.
    factor: f64,
    steps: f64,
    spent: f64,
    /// Whether the next step should begin with a new factor.
    pub renew: bool,
}

impl Wear {
    /// No factor yet; one costs as much as `factor` uses of it.
    pub fn new(factor: f64) -> Self {
        Self { factor, steps: 0.0, spent: 0.0, renew: true }
    }

    /// After a step of so many `uses`: renew when it cost more than the average since the last factor, its own cost
    /// counted in.
    pub fn count(&mut self, uses: usize, made: bool) {
        if made {
            *self = Self { factor: self.factor, steps: 0.0, spent: self.factor, renew: false };
        }
        self.steps += 1.0;
        self.spent += uses as f64;
        self.renew = uses as f64 > self.spent / self.steps;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_factor_is_kept_while_steps_are_cheaper_than_its_share() {
        let mut wear = Wear::new(8.0);
        wear.count(3, true);
        assert!(!wear.renew);
        (0..3).for_each(|_| wear.count(3, false));
        assert!(!wear.renew, "twenty over four steps");
        wear.count(9, false);
        assert!(wear.renew, "nine are more than twenty-nine over five");
    }
}
