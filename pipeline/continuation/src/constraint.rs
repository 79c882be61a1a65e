//! Constraints that make one point of a path out of all: g(u, λ) = 0, linearised as g + a · du + b dλ = 0.
//!
//! Along the path Crisfield's cylinder [crisfield1981] is used, ‖u − u₀‖ = s without a term in λ, in its consistently
//! linearised form [schweizerhof1986]: it needs no choice between the two roots of a quadratic.
//!
//! The plane normal to the predictor [riks1979] takes about as many factorisations (69 to 71 against 72 to 76 on the arch
//! of `tests/arch.rs`, 102 against 108 on the column beside it). The cylinder is taken because it bounds the length of the
//! step where the path turns sharply.

/// A constraint.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Constraint<'a> {
    /// ‖u − u₀‖ = s.
    Cylinder { centre: &'a [f64], radius: f64 },
    /// n · (u − u₀) = s, with |n| = 1.
    Plane { centre: &'a [f64], normal: &'a [f64], distance: f64 },
    /// λ = λ₁.
    LoadFactor(f64),
}

/// g, a and b of a constraint.
pub(crate) struct Linearised {
    pub value: f64,
    /// Empty: 0.
    pub by_u: Vec<f64>,
    pub by_load_factor: f64,
}

impl Constraint<'_> {
    pub(crate) fn linearise_at(&self, u: &[f64], load_factor: f64) -> Linearised {
        let offset_from = |centre: &[f64]| -> Vec<f64> { u.iter().zip(centre).map(|(u, centre)| u - centre).collect() };
        match *self {
            Self::Cylinder { centre, radius } => {
                let by_u = offset_from(centre);
                let value = 0.5 * (sparse::dot(&by_u, &by_u) - radius * radius);
                Linearised { value, by_u, by_load_factor: 0.0 }
            }
            Self::Plane { centre, normal, distance } => {
                let value = sparse::dot(normal, &offset_from(centre)) - distance;
                Linearised { value, by_u: normal.to_vec(), by_load_factor: 0.0 }
            }
            Self::LoadFactor(goal) => Linearised { value: load_factor - goal, by_u: Vec::new(), by_load_factor: 1.0 },
        }
    }
}

impl Linearised {
    /// dλ of the bordered system [K −q; a b] (du, dλ) = (−r, −g) by block elimination, from K⁻¹(−r) and K⁻¹ q.
    pub fn load_step(&self, by_residual: &[f64], by_load: &[f64]) -> f64 {
        let along_constraint = |x: &[f64]| sparse::dot(&self.by_u, x);
        -(self.value + along_constraint(by_residual)) / (self.by_load_factor + along_constraint(by_load))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_derivative_of_every_constraint_is_the_difference_of_its_value() {
        let (centre, normal, u, v) = ([0.1, -0.2, 0.3], [0.6, 0.0, 0.8], [0.5, 0.4, -0.3], [0.3, -0.7, 0.2]);
        let all = [
            Constraint::Cylinder { centre: &centre, radius: 0.4 },
            Constraint::Plane { centre: &centre, normal: &normal, distance: 0.2 },
            Constraint::LoadFactor(0.3),
        ];
        for constraint in all {
            let along = |step: f64| {
                let moved: Vec<f64> = u.iter().zip(v).map(|(u, v)| u + step * v).collect();
                constraint.linearise_at(&moved, 0.7 + step).value
            };
            let exact = constraint.linearise_at(&u, 0.7);
            let exact = sparse::dot(&exact.by_u, &v) + exact.by_load_factor;
            assert!(((along(1e-5) - along(-1e-5)) / 2e-5 - exact).abs() < 1e-9, "{constraint:?}");
        }
    }
}
