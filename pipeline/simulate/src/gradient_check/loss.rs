//! The loss of gradient checks: smooth, without symmetry, of order one.
//!
//! L(u) = Σ wᵢ uᵢ/s + ½ Σ (uᵢ/s)²/n over all n components, with wᵢ = sin(0.37 i)/√n and s the size of the reference
//! shape: every component has a weight, and no symmetry makes a derivative vanish.

/// The loss of one shape.
#[derive(Debug, Clone, Copy)]
pub(super) struct Loss {
    /// s, m.
    size: f64,
}

impl Loss {
    /// The loss with a reference shape (3 a node, m).
    pub fn around(shape: &[f64]) -> Self {
        let squares: f64 = shape.iter().map(|u| u * u).sum();
        Self { size: (squares / shape.len().max(1) as f64).sqrt().max(f64::MIN_POSITIVE) }
    }

    /// L, no unit.
    pub fn value(&self, shape: &[f64]) -> f64 {
        let n = shape.len() as f64;
        shape
            .iter()
            .enumerate()
            .map(|(i, u)| node_weight(i, n) * u / self.size + 0.5 * (u / self.size).powi(2) / n)
            .sum()
    }

    /// ∂L/∂u, 1/m.
    pub fn slope(&self, shape: &[f64]) -> Vec<f64> {
        let n = shape.len() as f64;
        let slope_of_entry = |(i, u): (usize, &f64)| (node_weight(i, n) + u / self.size / n) / self.size;
        shape.iter().enumerate().map(slope_of_entry).collect()
    }
}

fn node_weight(i: usize, n: f64) -> f64 {
    (0.37 * i as f64).sin() / n.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_slope_of_the_loss_is_its_difference() {
        let shape: Vec<f64> = (0..9).map(|i| 1e-3 * f64::from(i * i)).collect();
        let loss = Loss::around(&shape);
        for (i, slope) in loss.slope(&shape).iter().enumerate() {
            let at = |step: f64| {
                let mut near = shape.clone();
                near[i] += step;
                loss.value(&near)
            };
            assert!((slope - (at(1e-3) - at(-1e-3)) / 2e-3).abs() < 1e-9 * slope.abs().max(1.0));
        }
    }
}
