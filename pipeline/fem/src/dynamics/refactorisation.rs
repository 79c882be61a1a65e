//! Refactorisation policy between time steps: when a new factorisation pays.

/// Cost of all steps since the last factorisation, in uses of the factor.
// Minimising the mean cost per step, factorisation included, leads to this rule: replace the factor as soon as a step
// costs more than the mean so far. It needs no model of how a factor ages, only the ratio of the two costs.
#[derive(Debug, Clone)]
pub(crate) struct RefactorisationPolicy {
    factorisation_cost: f64,
    steps: f64,
    spent: f64,
    /// Whether the next step begins with a new factorisation.
    pub refactorise: bool,
}

impl RefactorisationPolicy {
    /// No factor yet; a factorisation costs as much as `factorisation_cost` uses of the factor.
    pub fn new(factorisation_cost: f64) -> Self {
        Self { factorisation_cost, steps: 0.0, spent: 0.0, refactorise: true }
    }

    /// Counts a step of so many `uses` of the factor, and whether it was `factorised` in that step.
    pub(crate) fn count_step(&mut self, uses: usize, factorised: bool) {
        if factorised {
            let cost = self.factorisation_cost;
            *self = Self { factorisation_cost: cost, steps: 0.0, spent: cost, refactorise: false };
        }
        self.steps += 1.0;
        self.spent += uses as f64;
        self.refactorise = uses as f64 > self.spent / self.steps;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_factor_is_kept_while_a_step_costs_less_than_the_mean() {
        let mut policy = RefactorisationPolicy::new(8.0);
        policy.count_step(3, true);
        assert!(!policy.refactorise);
        (0..3).for_each(|_| policy.count_step(3, false));
        assert!(!policy.refactorise, "twenty over four steps");
        policy.count_step(9, false);
        assert!(policy.refactorise, "nine are more than twenty-nine over five");
    }
}
