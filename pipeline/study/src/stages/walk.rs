//! Walk: in which order the points of a batch are simulated, so that each begins near a known shape.
//!
//! Stands on: nothing. Never knows: what a point is.

/// An order of points in which each is the nearest of those left to the one before.
pub fn near_to_near(points: &[Vec<f64>]) -> Vec<usize> {
    let distance = |a: usize, b: usize| -> f64 { points[a].iter().zip(&points[b]).map(|(x, y)| (x - y).powi(2)).sum() };
    let mut left: Vec<usize> = (0..points.len()).rev().collect();
    let mut order: Vec<usize> = left.pop().into_iter().collect();
    while let Some(&here) = order.last() {
        let Some(next) = (0..left.len()).min_by(|&a, &b| distance(here, left[a]).total_cmp(&distance(here, left[b])))
        else {
            break;
        };
        order.push(left.remove(next));
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_batch_is_walked_without_leaps() {
        let grid: Vec<Vec<f64>> = (0..5).flat_map(|i| (0..5).map(move |j| vec![f64::from(i), f64::from(j)])).collect();
        let order = near_to_near(&grid);
        let leap = |w: &[usize]| (0..2).map(|k| (grid[w[0]][k] - grid[w[1]][k]).powi(2)).sum::<f64>();
        assert!(order.windows(2).all(|w| leap(w) <= 1.0), "{order:?}");
    }
}
