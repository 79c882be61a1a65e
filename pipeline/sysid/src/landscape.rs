//! The landscape: the loss as a surface over both moduli, between the points of the exhaustive search.
//!
//! Displacements are smooth in the logarithms of the moduli and the loss is not (it has a kink where a simulated marker coincides with the measured one), so
//! the displacements are interpolated, by the tensor polynomial through the grid's points, and the loss is computed from them.

use si::{Metre, Point2};

use crate::levels::PressureLevel;

/// Surfaces over the logarithms of both moduli: row after row, rows along `up`.
pub struct Fine {
    /// Logarithms of the first modulus.
    pub across: Vec<f64>,
    /// Logarithms of the second modulus.
    pub up: Vec<f64>,
    /// The values, each as `up` × `across`.
    pub values: Vec<Vec<f64>>,
}

/// Mean distance of simulated from measured displacements over all levels and markers, over the specimen's length.
pub fn loss(levels: &[PressureLevel], simulated: &[Vec<Point2>], length: Metre) -> f64 {
    let pairs = levels.iter().zip(simulated).flat_map(|(level, s)| level.measured.iter().zip(s));
    let (sum, count) =
        pairs.fold((0.0, 0usize), |(sum, count), (m, s)| (sum + (m[0] - s[0]).hypot(m[1] - s[1]), count + 1));
    sum / (count.max(1) as f64 * length)
}

/// Values on a fine grid from displacements at the points of a full coarse grid (first and second logarithm; levels × markers).
///
/// `judge` turns the displacements at one place (levels × markers) into one or more values.
pub fn between(points: &[(&[f64], &[Vec<Point2>])], fine: usize, judge: &dyn Fn(&[Vec<Point2>]) -> Vec<f64>) -> Fine {
    let axis = |k: usize| {
        let mut values: Vec<f64> = points.iter().map(|p| p.0[k]).collect();
        values.sort_by(f64::total_cmp);
        values.dedup();
        values
    };
    let (x, y) = (axis(0), axis(1));
    let (across, up) = (even_points(&x, fine), even_points(&y, fine));
    let mut judged = Vec::with_capacity(fine * fine);
    for &v in &up {
        let wy = lagrange_weights(&y, v);
        for &u in &across {
            let wx = lagrange_weights(&x, u);
            let weight = |point: &[f64]| wx[node_index(&x, point[0])] * wy[node_index(&y, point[1])];
            judged.push(judge(&weighted_sum(points, &weight)));
        }
    }
    let kinds = judged.first().map_or(0, Vec::len);
    Fine { across, up, values: (0..kinds).map(|k| judged.iter().map(|j| j[k]).collect()).collect() }
}

/// Values at the places of a fine grid, `up` × `across`, linear between those of a coarse one (`y` × `x`, NaN where there is none).
pub fn linear((x, y): (&[f64], &[f64]), value: &dyn Fn(f64, f64) -> f64, (across, up): (&[f64], &[f64])) -> Vec<f64> {
    let brackets = |axis: &[f64], t: f64| {
        let i = axis.partition_point(|&v| v < t).clamp(1, axis.len() - 1);
        let (low, high) = (axis[i - 1], axis[i]);
        let part = ((t - low) / (high - low)).clamp(0.0, 1.0);
        // Corners without a share are left out: zero times NaN is NaN, and a gap would spread into the neighbouring
        // cells.
        [(low, 1.0 - part), (high, part)].into_iter().filter(|(_, part)| *part > 0.0).collect::<Vec<_>>()
    };
    let interpolated = |u: f64, v: f64| {
        let (columns, rows) = (brackets(x, u), brackets(y, v));
        let corners = rows.iter().flat_map(|&(y, q)| columns.iter().map(move |&(x, p)| (x, y, p * q)));
        corners.map(|(x, y, part)| part * value(x, y)).sum()
    };
    up.iter().flat_map(|&v| across.iter().map(move |&u| (u, v))).map(|(u, v)| interpolated(u, v)).collect()
}

/// One place of the grid: both logarithms, and the displacements there (levels × markers).
pub type Place = (Vec<f64>, Vec<Vec<Point2>>);

/// The full grid over `across` and `up`, where a point without equilibrium is extrapolated from its row by the polynomial through the
/// row's others. None where a row lacks more than one of its points, or has fewer than three left.
pub fn completed(points: &[(&[f64], &[Vec<Point2>])], across: &[f64], up: &[f64]) -> Option<Vec<Place>> {
    let row = |v: f64| points.iter().copied().filter(|p| p.0[1] == v).collect::<Vec<_>>();
    let completed_point = |u: f64, v: f64| -> Option<Place> {
        let row = row(v);
        if let Some(sample) = row.iter().find(|p| p.0[0] == u) {
            return Some((sample.0.to_vec(), sample.1.to_vec()));
        }
        let nodes: Vec<f64> = row.iter().map(|p| p.0[0]).collect();
        let weights = lagrange_weights(&nodes, u);
        let weight = |point: &[f64]| weights[node_index(&nodes, point[0])];
        (nodes.len() >= LEAST && nodes.len() + 1 == across.len()).then(|| (vec![u, v], weighted_sum(&row, &weight)))
    };
    up.iter().flat_map(|&v| across.iter().map(move |&u| (u, v))).map(|(u, v)| completed_point(u, v)).collect()
}

/// Least number of points of a row for an extrapolation.
const LEAST: usize = 3;

fn even_points(axis: &[f64], count: usize) -> Vec<f64> {
    let (low, high) = (axis[0], axis[axis.len() - 1]);
    (0..count).map(|i| low + (high - low) * i as f64 / (count - 1).max(1) as f64).collect()
}

fn node_index(axis: &[f64], value: f64) -> usize {
    axis.iter().position(|&v| v == value).unwrap_or(0)
}

/// Values at `t` of the polynomials that are one at one node and zero at the others.
fn lagrange_weights(nodes: &[f64], t: f64) -> Vec<f64> {
    let basis = |i: usize| {
        let other_nodes = nodes.iter().enumerate().filter(|(j, _)| *j != i);
        other_nodes.map(|(_, &n)| (t - n) / (nodes[i] - n)).product()
    };
    (0..nodes.len()).map(basis).collect()
}

fn weighted_sum(points: &[(&[f64], &[Vec<Point2>])], weight: &dyn Fn(&[f64]) -> f64) -> Vec<Vec<Point2>> {
    let mut sum: Vec<Vec<Point2>> = points[0].1.iter().map(|level| vec![[0.0; 2]; level.len()]).collect();
    for (point, levels) in points {
        let w = weight(point);
        for (sum_level, level) in sum.iter_mut().zip(*levels) {
            for (p, q) in sum_level.iter_mut().zip(level) {
                *p = [p[0] + w * q[0], p[1] + w * q[1]];
            }
        }
    }
    sum
}

/// Points of a landscape, row after row of `columns` points, that lie below all their neighbours, corners included; a narrow minimum between
/// grid points gives several.
pub fn lowest_points(columns: usize, loss: &[f64]) -> usize {
    let rows = loss.len() / columns.max(1);
    let neighbours = |index: usize, len: usize| index.saturating_sub(1)..(index + 2).min(len);
    let lowest = |row: usize, column: usize| {
        let mut cells = neighbours(row, rows).flat_map(|r| neighbours(column, columns).map(move |c| (r, c)));
        cells.all(|(r, c)| (r, c) == (row, column) || loss[r * columns + c] > loss[row * columns + column])
    };
    (0..rows).map(|row| (0..columns).filter(|&column| lowest(row, column)).count()).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_polynomial_displacement_is_met_between_the_points() {
        let simulate = |u: f64, v: f64| vec![vec![[u * u - v, u * v * v]]];
        let coarse: Vec<(Vec<f64>, Vec<Vec<Point2>>)> =
            (0..9).map(|i| (f64::from(i % 3), f64::from(i / 3))).map(|(u, v)| (vec![u, v], simulate(u, v))).collect();
        let points: Vec<(&[f64], &[Vec<Point2>])> = coarse.iter().map(|(a, m)| (a.as_slice(), m.as_slice())).collect();
        let measured = simulate(0.5, 1.5)[0].clone();
        let level = [PressureLevel {
            pressures: vec![1.0],
            measured,
            covariance: vec![[0.0; 3]],
            shared: vec![[0.0; 3]],
            rest: vec![[0.0; 2]],
        }];
        let fine = between(&points, 5, &|simulated| vec![loss(&level, simulated, 1.0)]);
        assert_eq!((fine.across[1], fine.up[3]), (0.5, 1.5));
        assert!(fine.values[0][3 * 5 + 1] < 1e-12, "{}", fine.values[0][16]);
    }

    #[test]
    fn a_bilinear_value_is_met_between_the_points_and_missing_beside_a_hole() {
        let (x, y, fine) = ([0.0, 1.0, 2.0], [0.0, 3.0], ([0.0, 0.25, 1.0, 1.5], [0.0, 1.0, 3.0]));
        let value = |u: f64, v: f64| if u == 2.0 { f64::NAN } else { 1.0 + 2.0 * u - v + 0.5 * u * v };
        let found = linear((&x, &y), &value, (&fine.0, &fine.1));
        assert!((found[5] - (1.0 + 0.5 - 1.0 + 0.125)).abs() < 1e-12 && found[10] == value(1.0, 3.0), "{found:?}");
        assert_eq!(found.iter().filter(|v| v.is_nan()).count(), 3);
    }

    #[test]
    fn a_hole_is_carried_on_from_its_row_and_two_in_a_row_are_not() {
        let axis = [0.0, 1.0, 2.0, 3.0];
        let simulate = |u: f64, v: f64| vec![vec![[u * u - v, u * v]]];
        let all: Vec<Place> = axis.iter().flat_map(|&v| axis.map(|u| (vec![u, v], simulate(u, v)))).collect();
        let without = |gone: &[usize]| -> Option<Vec<Place>> {
            let kept = all.iter().enumerate().filter(|(i, _)| !gone.contains(i)).map(|(_, p)| p);
            completed(&kept.map(|(a, m)| (a.as_slice(), m.as_slice())).collect::<Vec<_>>(), &axis, &axis)
        };
        let filled = without(&[0, 7]).unwrap();
        for ((at, found), (wanted, whole)) in filled.iter().zip(&all) {
            assert_eq!(at, wanted);
            assert!((0..2).all(|k| (found[0][0][k] - whole[0][0][k]).abs() < 1e-12));
        }
        assert!(without(&[0, 1]).is_none());
    }

    #[test]
    fn a_landscape_of_one_bowl_has_one_lowest_point_and_of_two_bowls_two() {
        let axis: Vec<f64> = (0..9).map(|i| f64::from(i) / 8.0).collect();
        let count = |f: fn(f64, f64) -> f64| {
            let loss: Vec<f64> = axis.iter().flat_map(|y| axis.iter().map(|x| f(*x, *y)).collect::<Vec<_>>()).collect();
            lowest_points(axis.len(), &loss)
        };
        assert_eq!(count(|x, y| (x - 0.5).powi(2) + (y - 0.25).powi(2)), 1);
        assert_eq!(count(|x, y| (x * (x - 1.0)).powi(2) + (y - 0.25).powi(2)), 2);
    }
}
