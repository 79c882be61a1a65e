//! Bundle adjustment of a lens and poses by Levenberg–Marquardt on the reprojection errors, and its covariance.

use super::elimination::Eliminated;
use crate::lens::Lens;
use crate::pose::Pose;
use nalgebra::{DMatrix, DVector};
use optimize::levenberg_marquardt::{LeastSquaresProblem, NormalEquations, Options, Scaling, damped_step, minimise};
use si::{Point2, Point3, vec3};

/// Values of the lens: fx fy cx cy and the distortion's five, of which a fisheye leaves the last one out.
pub(super) const OF_LENS: usize = crate::lens::VALUES;
/// Values of a pose: turn and shift.
const OF_POSE: usize = 6;

/// Points of the world (m) and their pixels (px) in one view.
pub(super) struct Seen<'a> {
    pub(super) points: &'a [Point3],
    pub(super) pixels: &'a [Point2],
}

/// What is refined.
#[derive(Clone)]
pub(super) struct Guess {
    pub(super) lens: Lens,
    pub(super) poses: Vec<Pose>,
}

/// Lens and poses as a least-squares problem; the lens is fixed unless `with_lens`.
struct Reprojection<'a> {
    seen: &'a [Seen<'a>],
    with_lens: bool,
}

impl LeastSquaresProblem for Reprojection<'_> {
    type Point = Guess;

    fn linearise(&self, at: &Guess) -> Option<NormalEquations> {
        Some(normal_equations(at, self.seen, self.with_lens))
    }

    fn sum_of_squares(&self, at: &Guess) -> Option<f64> {
        Some(squared_misses(at, self.seen))
    }

    fn after_step(&self, at: &Guess, step: &DVector<f64>) -> Guess {
        apply_step(at, step, self.with_lens)
    }

    fn damped_step(&self, normal: &NormalEquations, damping: f64, scaling: Scaling) -> Option<DVector<f64>> {
        if self.seen.len() <= ELIMINATED_FROM {
            return damped_step(normal.matrix.clone(), &normal.right, damping, scaling);
        }
        let lead = normal.right.len() - OF_POSE * self.seen.len();
        Eliminated::new(normal, lead, |entry| scaling.damped_entry(entry, damping))?.solve()
    }
}

/// Views up to which the whole matrix is factored: it is as fast there, and the last digits of a study's lens stay what they are.
const ELIMINATED_FROM: usize = 60;

/// Of the bundle adjustment.
const OPTIONS: Options = Options {
    damping: 1e-3,
    min_damping: 1e-15,
    max_damping: 1e13,
    // The floor fixes a coefficient on which no point depends.
    scaling: Scaling::Floored(1e-12),
    accept_equal: false,
    gain_tolerance: 1e-14,
    max_steps: usize::MAX,
    // More than any reasonable start needs: each changes the damping, and 28 decades lie between its bounds.
    max_trials: 200,
};

/// Refines `guess` in place; the lens is fixed unless `with_lens`. Returns the sum of squares, px².
pub(super) fn refine(guess: &mut Guess, seen: &[Seen], with_lens: bool) -> f64 {
    let Some((refined, normal)) = minimise(&Reprojection { seen, with_lens }, guess.clone(), &OPTIONS) else {
        return f64::INFINITY;
    };
    *guess = refined;
    normal.squares
}

/// Covariance of the lens's values at the minimum, from the scatter of the misses; 0 where a value does not count.
///
/// The lens's block of σ² (JᵀJ)⁻¹ with σ² = rᵀr / (equations − unknowns). None when the views do not fix the lens.
pub(super) fn lens_covariance(guess: &Guess, seen: &[Seen]) -> Option<[[f64; OF_LENS]; OF_LENS]> {
    let normal = normal_equations(guess, seen, true);
    let count = guess.lens.count();
    let inverse = match seen.len() <= ELIMINATED_FROM {
        true => scaled_inverse(&normal.matrix)?,
        false => scaled_inverse(&Eliminated::new(&normal, count, |entry| entry)?.lens)?,
    };
    let variance = normal.squares / degrees_of_freedom(seen, normal.matrix.nrows());
    let entry = |i: usize, j: usize| if i < count && j < count { variance * inverse[(i, j)] } else { 0.0 };
    Some(std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j))))
}

/// Covariance of a lens and of the one pose that was found with it from `seen`: 15 × 15, the pose's turn and shift last.
///
/// The pose follows the lens, d(pose)/d(lens) = −(JₚᵀJₚ)⁻¹ JₚᵀJₗ, and has the noise of its own points. None when the points
/// do not fix the pose.
#[allow(non_snake_case)]
pub(super) fn joint_covariance(
    lens: &[[f64; OF_LENS]; OF_LENS],
    guess: &Guess,
    seen: &[Seen],
) -> Option<[[f64; OF_LENS + OF_POSE]; OF_LENS + OF_POSE]> {
    let (full, alone) = (normal_equations(guess, seen, true), normal_equations(guess, seen, false));
    let count = guess.lens.count();
    let pose_inverse = scaled_inverse(&alone.matrix)?;
    let follow = -&pose_inverse * full.matrix.view((count, 0), (OF_POSE, count));
    let C = DMatrix::from_fn(count, count, |i, j| lens[i][j]);
    let variance = alone.squares / degrees_of_freedom(seen, OF_POSE);
    let pose = &follow * &C * follow.transpose() + pose_inverse * variance;
    let cross = &follow * &C;
    let entry = |i: usize, j: usize| match (i.checked_sub(OF_LENS), j.checked_sub(OF_LENS)) {
        (Some(a), Some(b)) => pose[(a, b)],
        (Some(a), None) if j < count => cross[(a, j)],
        (None, Some(b)) if i < count => cross[(b, i)],
        (None, None) => lens[i][j],
        _ => 0.0,
    };
    Some(std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j))))
}

/// Equations beyond the unknowns.
fn degrees_of_freedom(seen: &[Seen], unknowns: usize) -> f64 {
    let equations: usize = seen.iter().map(|view| 2 * view.points.len()).sum();
    equations.saturating_sub(unknowns).max(1) as f64
}

/// A⁻¹ of a symmetric matrix, scaled to a unit diagonal in between, so that px and k₃ are held to one measure.
fn scaled_inverse(matrix: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let scale: Vec<f64> = matrix.diagonal().iter().map(|d| d.sqrt()).collect();
    let unit = DMatrix::from_fn(scale.len(), scale.len(), |i, j| matrix[(i, j)] / (scale[i] * scale[j]));
    let mut inverse = unit.cholesky()?.inverse();
    (0..scale.len()).for_each(|i| (0..scale.len()).for_each(|j| inverse[(i, j)] /= scale[i] * scale[j]));
    Some(inverse)
}

/// Misses of one point, seen − projected (px); a large one where it cannot be projected, so that no step goes there.
fn reprojection_miss(lens: &Lens, pose: &Pose, point: Point3, pixel: Point2) -> Point2 {
    lens.project(pose.apply(point)).map_or([1e6; 2], |projected| [pixel[0] - projected[0], pixel[1] - projected[1]])
}

/// The sum of squared misses, px².
pub(super) fn squared_misses(guess: &Guess, seen: &[Seen]) -> f64 {
    let of_view = |(view, pose): (&Seen, &Pose)| {
        let pairs = view.points.iter().zip(view.pixels);
        pairs
            .map(|(&point, &pixel)| reprojection_miss(&guess.lens, pose, point, pixel))
            .map(|[u, v]| u * u + v * v)
            .sum::<f64>()
    };
    seen.iter().zip(&guess.poses).map(of_view).sum()
}

fn normal_equations(guess: &Guess, seen: &[Seen], with_lens: bool) -> NormalEquations {
    let lead = if with_lens { guess.lens.count() } else { 0 };
    let size = lead + OF_POSE * seen.len();
    let mut normal = NormalEquations { matrix: DMatrix::zeros(size, size), right: DVector::zeros(size), squares: 0.0 };
    for (number, (view, pose)) in seen.iter().zip(&guess.poses).enumerate() {
        let pose_start = lead + OF_POSE * number;
        let columns: Vec<usize> = (0..lead).chain(pose_start..pose_start + OF_POSE).collect();
        for (&point, &pixel) in view.points.iter().zip(view.pixels) {
            let miss = reprojection_miss(&guess.lens, pose, point, pixel);
            let rows = pixel_derivatives(&guess.lens, pose, point);
            for (row, miss) in rows.iter().zip(miss) {
                // Accumulated point by point: with 15 views the Jacobian would have thousands of rows that are mostly zero.
                let row = || row[..lead].iter().chain(&row[OF_LENS..]).zip(&columns);
                normal.squares += miss * miss;
                for (a, &i) in row() {
                    normal.right[i] += a * miss;
                    for (b, &j) in row() {
                        normal.matrix[(i, j)] += a * b;
                    }
                }
            }
        }
    }
    normal
}

/// d(pixel)/d(lens, turn, shift) of one point, 2 × 15; the turn acts from the left: R ← exp(ω) R.
fn pixel_derivatives(lens: &Lens, pose: &Pose, point: Point3) -> [[f64; OF_LENS + OF_POSE]; 2] {
    let arm = vec3::sub(pose.apply(point), pose.translation);
    let point_in_camera = vec3::add(arm, pose.translation);
    let [x, y] = [point_in_camera[0] / point_in_camera[2], point_in_camera[1] / point_in_camera[2]];
    let (coefficients, distorted) = (lens.by_coefficients([x, y]), lens.distort([x, y]));
    let by_point = lens.jacobian(point_in_camera);
    [0, 1].map(|i| {
        let focal = [lens.fx, lens.fy][i];
        let turn = vec3::cross(arm, by_point[i]);
        std::array::from_fn(|k| match k {
            0 | 1 => {
                if k == i {
                    distorted[i]
                } else {
                    0.0
                }
            }
            2 | 3 => {
                if k == 2 + i {
                    1.0
                } else {
                    0.0
                }
            }
            4..OF_LENS => focal * coefficients[i][k - 4],
            9..12 => turn[k - 9],
            _ => by_point[i][k - 12],
        })
    })
}

fn apply_step(guess: &Guess, step: &DVector<f64>, with_lens: bool) -> Guess {
    let mut next = guess.clone();
    let lead = if with_lens { guess.lens.count() } else { 0 };
    let mut values = guess.lens.values();
    values.iter_mut().zip(&step.as_slice()[..lead]).for_each(|(value, change)| *value += change);
    next.lens = next.lens.with_values(values);
    for (number, pose) in next.poses.iter_mut().enumerate() {
        let s = &step.as_slice()[lead + OF_POSE * number..][..OF_POSE];
        *pose = pose.rotated_and_shifted([s[0], s[1], s[2]], [s[3], s[4], s[5]]);
    }
    next
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_slopes_are_the_differences_of_the_projection() {
        let lens = Lens::default().with_values([1473.0, 1478.0, 969.0, 541.0, -0.1, 0.05, 2e-3, -1e-3, 0.02]);
        let guess = Guess { lens, poses: vec![Pose::from_vector([2.8, 0.2, -0.3], [0.02, -0.04, 0.4])] };
        let point = [0.11, -0.07, 0.01];
        let rows = pixel_derivatives(&lens, &guess.poses[0], point);
        let scale = [1e-2, 1e-2, 1e-2, 1e-2, 1e-5, 1e-5, 1e-5, 1e-5, 1e-5, 1e-6, 1e-6, 1e-6, 1e-6, 1e-6, 1e-6];
        for k in 0..15 {
            let there = |sign: f64| {
                let step = DVector::from_fn(15, |i, _| if i == k { sign * scale[k] } else { 0.0 });
                let next = apply_step(&guess, &step, true);
                next.lens.project(next.poses[0].apply(point)).unwrap()
            };
            let (up, down) = (there(1.0), there(-1.0));
            for i in 0..2 {
                let difference = (up[i] - down[i]) / (2.0 * scale[k]);
                let size = rows[i][k].abs().max(1.0);
                assert!((rows[i][k] - difference).abs() < 1e-5 * size, "{i} {k}: {} {difference}", rows[i][k]);
            }
        }
    }
}
