//! Virtual work of the chambers' pressures: of Σ p V, a cubic polynomial of the coordinates that is summed once a step.

use crate::data::Chamber;

/// Σ p V without its constant.
#[derive(Debug, Clone)]
pub struct PressureWork {
    linear: Vec<f64>,
    quadratic: Vec<f64>,
    cubic: Vec<f64>,
}

impl PressureWork {
    /// Of no pressure, with `r` coordinates.
    pub fn none(r: usize) -> Self {
        let cubic = vec![0.0; r * (r * (r + 1) / 2)];
        Self { linear: vec![0.0; r], quadratic: vec![0.0; r * r], cubic }
    }

    /// Of these `pressures`, Pa.
    pub(crate) fn set_pressures(&mut self, chambers: &[Chamber], pressures: &[f64]) {
        // Summed before the iterations: pressures do not change within a step, and a residual costs as much with nine
        // chambers as with one.
        for part in [&mut self.linear, &mut self.quadratic, &mut self.cubic] {
            part.fill(0.0);
        }
        for (chamber, pressure) in chambers.iter().zip(pressures) {
            add(&mut self.linear, *pressure, &chamber.linear);
            add(&mut self.quadratic, *pressure, &chamber.quadratic);
            add(&mut self.cubic, *pressure, &chamber.cubic);
        }
    }

    /// Subtracts its gradient (J) at q: a + B q + ½ C q q.
    pub(crate) fn subtract_gradient(&self, q: &[f64], forces: &mut [f64]) {
        let r = q.len();
        add(forces, -1.0, &self.linear);
        for (row, q) in self.quadratic.chunks_exact(r).zip(q) {
            add(forces, -q, row);
        }
        for ((i, j), column) in index_pairs(r).zip(self.cubic.chunks_exact(r)) {
            let weight = if i == j { 0.5 } else { 1.0 };
            add(forces, -weight * q[i] * q[j], column);
        }
    }

    /// Subtracts its second derivative (J) at q: B + C q.
    pub(crate) fn subtract_hessian(&self, q: &[f64], stiffness: &mut [f64]) {
        let r = q.len();
        add(stiffness, -1.0, &self.quadratic);
        for ((i, j), column) in index_pairs(r).zip(self.cubic.chunks_exact(r)) {
            add(&mut stiffness[i * r..(i + 1) * r], -q[j], column);
            if i != j {
                add(&mut stiffness[j * r..(j + 1) * r], -q[i], column);
            }
        }
    }
}

impl Chamber {
    /// ∂V/∂q, m³ per unit of q.
    pub fn volume_gradient(&self, q: &[f64]) -> Vec<f64> {
        let (r, mut gradient) = (q.len(), self.linear.clone());
        for (row, q) in self.quadratic.chunks_exact(r).zip(q) {
            add(&mut gradient, *q, row);
        }
        for ((i, j), column) in index_pairs(r).zip(self.cubic.chunks_exact(r)) {
            let weight = if i == j { 0.5 } else { 1.0 };
            add(&mut gradient, weight * q[i] * q[j], column);
        }
        gradient
    }

    /// V(q), m³; of a half model, of the half.
    pub fn volume(&self, q: &[f64]) -> f64 {
        let r = q.len();
        let dot = |a: &[f64]| a.iter().zip(q).map(|(a, q)| a * q).sum::<f64>();
        let quadratic: f64 = self.quadratic.chunks_exact(r).zip(q).map(|(row, q)| 0.5 * q * dot(row)).sum();
        let term = |((i, j), column): ((usize, usize), &[f64])| {
            let weight = if i == j { 1.0 } else { 2.0 };
            weight * q[i] * q[j] * dot(column) / 6.0
        };
        let cubic: f64 = index_pairs(r).zip(self.cubic.chunks_exact(r)).map(term).sum();
        self.at_rest + dot(&self.linear) + quadratic + cubic
    }
}

/// Pairs i ≤ j below `r`.
fn index_pairs(r: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..r).flat_map(move |i| (i..r).map(move |j| (i, j)))
}

/// `sum` += `factor` `term`.
#[inline(always)]
pub fn add(sum: &mut [f64], factor: f64, term: &[f64]) {
    sum.iter_mut().zip(term).for_each(|(sum, term)| *sum += factor * term);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_gradient_and_its_derivative_are_those_of_the_volume() {
        // V = V₀ + a·q + ½ (b·q)² + ⅙ (c·q)³, of which every coefficient is known
        let (a, b, c) = ([1.0, -2.0, 0.5], [0.3, 0.7, -0.2], [0.4, -0.1, 0.6]);
        let column = |(i, j): (usize, usize)| c.map(|k| c[i] * c[j] * k);
        let chamber = Chamber {
            name: "air".into(),
            range: Chamber::UNLIMITED,
            at_rest: 2.0,
            linear: a.to_vec(),
            quadratic: b.iter().flat_map(|x| b.map(|y| x * y)).collect(),
            cubic: index_pairs(3).flat_map(column).collect(),
        };
        let dot = |x: &[f64; 3], q: &[f64]| x.iter().zip(q).map(|(x, q)| x * q).sum::<f64>();
        let q = [0.2, -0.4, 0.9];
        let exact = 2.0 + dot(&a, &q) + 0.5 * dot(&b, &q).powi(2) + dot(&c, &q).powi(3) / 6.0;
        assert!((chamber.volume(&q) - exact).abs() < 1e-14);
        let gradient = chamber.volume_gradient(&q);
        let mut work = PressureWork::none(3);
        work.set_pressures(&[chamber.clone(), chamber], &[3.0, 7.0]);
        let (mut forces, mut stiffness) = ([0.0; 3], [0.0; 9]);
        work.subtract_gradient(&q, &mut forces);
        work.subtract_hessian(&q, &mut stiffness);
        for i in 0..3 {
            let exact = a[i] + dot(&b, &q) * b[i] + 0.5 * dot(&c, &q).powi(2) * c[i];
            assert!((forces[i] + 10.0 * exact).abs() < 1e-13 && (gradient[i] - exact).abs() < 1e-14);
            for j in 0..3 {
                let exact = b[i] * b[j] + dot(&c, &q) * c[i] * c[j];
                assert!((stiffness[3 * i + j] + 10.0 * exact).abs() < 1e-13);
            }
        }
    }
}
