//! Paths of problems of one and two dofs with closed forms: the von Mises truss, through its limit points and from its
//! bifurcation.

#![allow(clippy::unwrap_used)] // a test may fail where it stands

use continuation::{
    Branch, ContinuationError, CriticalKind, CriticalPoint, Path, PathEnd, PathEvent, PathPoint, PathSettings, Problem,
    follow,
};

/// Two bars from (±1, 0) to an apex at rest at (0, h), each with the energy ½ ε² of its strain ε = ½ (l² − l₀²), under a
/// force λ downwards at the apex, which moves to (u, y).
///
/// With e = ½ (u² + y² − h²) the residual is 2u (e + 1) along u and 2 e y + λ along y. The path u = 0 has
/// λ = y (h² − y²), the circle u² + y² = h² − 2 has λ = 2 y; they cross where y² = h² − 2.
struct Truss {
    rise: f64,
    tangent: [[f64; 2]; 2],
}

impl Truss {
    fn new(rise: f64) -> Self {
        Self { rise, tangent: [[0.0; 2]; 2] }
    }

    /// Strain of the bar from (side, 0) to the apex, and its derivative by (u, v).
    fn bar(&self, side: f64, u: &[f64]) -> (f64, [f64; 2]) {
        let (x, y) = (u[0] - side, self.rise + u[1]);
        (0.5 * (x * x + y * y - 1.0 - self.rise * self.rise), [x, y])
    }
}

impl Problem for Truss {
    fn dofs(&self) -> usize {
        2
    }

    fn size(&self) -> f64 {
        2.0
    }

    fn start(&self) -> Vec<f64> {
        vec![0.0; 2]
    }

    fn residual(&mut self, u: &[f64], load_factor: f64) -> Option<Vec<f64>> {
        let mut r = vec![0.0, load_factor];
        for (strain, by) in [self.bar(-1.0, u), self.bar(1.0, u)] {
            (0..2).for_each(|i| r[i] += strain * by[i]);
        }
        Some(r)
    }

    fn load(&mut self, _: &[f64], _: f64) -> Vec<f64> {
        vec![0.0, -1.0]
    }

    fn factorise(&mut self, u: &[f64], _: f64, _: Option<&[f64]>) -> Option<usize> {
        let mut k = [[0.0; 2]; 2];
        for (strain, by) in [self.bar(-1.0, u), self.bar(1.0, u)] {
            for (i, row) in k.iter_mut().enumerate() {
                (0..2).for_each(|j| row[j] += by[i] * by[j] + if i == j { strain } else { 0.0 });
            }
        }
        self.tangent = k;
        let (determinant, trace) = (k[0][0] * k[1][1] - k[0][1] * k[0][1], k[0][0] + k[1][1]);
        (determinant != 0.0).then(|| if determinant < 0.0 { 1 } else { 2 * usize::from(trace < 0.0) })
    }

    fn solve(&mut self, x: &mut [f64]) {
        let [[a, b], [_, d]] = self.tangent;
        let determinant = a * d - b * b;
        let y = [(d * x[0] - b * x[1]) / determinant, (a * x[1] - b * x[0]) / determinant];
        x.copy_from_slice(&y);
    }
}

/// λ of the path u = 0 where the apex is at the height y.
fn symmetric_load(rise: f64, y: f64) -> f64 {
    y * (rise * rise - y * y)
}

fn followed(rise: f64, settings: &PathSettings) -> (Path, Vec<PathPoint>, Vec<CriticalPoint>) {
    let (mut points, mut critical) = (Vec::new(), Vec::new());
    let path = follow(&mut Truss::new(rise), settings, &mut |event| match event {
        PathEvent::Point(point) => points.push(point.clone()),
        PathEvent::Critical(point) => critical.push(point.clone()),
    });
    (path.unwrap(), points, critical)
}

#[test]
fn a_shallow_truss_snaps_through_at_its_limit_points_and_every_point_lies_on_its_path() {
    let rise = 0.5;
    let (path, points, critical) = followed(rise, &PathSettings { load_factors: [0.0, 0.4], ..Default::default() });
    assert_eq!((path.end, &path.critical), (PathEnd::LoadFactor, &critical));
    // dλ/dy = h² − 3y² = 0
    let height = rise / 3.0_f64.sqrt();
    let exact = symmetric_load(rise, height);
    let kinds: Vec<CriticalKind> = critical.iter().map(|point| point.kind).collect();
    assert_eq!(kinds, [CriticalKind::LimitPoint; 2]);
    for (point, sign) in critical.iter().zip([1.0, -1.0]) {
        assert!((point.load_factor / (sign * exact) - 1.0).abs() < 1e-8, "{}", point.load_factor);
        assert!((rise + point.displacement[1] - sign * height).abs() < 1e-7);
        assert!(point.load_along_mode > 1.0 - 1e-9 && point.multiplicity == 1);
        assert!((point.mode[1].abs() - 1.0).abs() < 1e-9);
    }
    for point in &points {
        let (y, negative) = (rise + point.displacement[1], point.negative_eigenvalues);
        assert!((point.load_factor - symmetric_load(rise, y)).abs() < 1e-9 && point.displacement[0].abs() < 1e-9);
        assert_eq!(negative, usize::from(3.0 * y * y < rise * rise), "{y}");
        let vertical = 3.0 * y * y - rise * rise;
        assert!((point.eigenvalue - vertical).abs() < 1e-9 || point.eigenvalue > vertical);
    }
    assert!(points.iter().any(|point| point.negative_eigenvalues == 1), "the unstable part is followed");
    let last = points.last().unwrap();
    assert!(last.is_level && last.load_factor == 0.4 && last.displacement[1] < -2.0 * rise);
}

#[test]
fn a_steep_truss_bifurcates_before_its_limit_point_and_both_branches_are_followed() {
    // Sideways stiffness 2 (1 + ε) = 0 at y² = h² − 2, before the limit point y² = h²/3 where h² > 3.
    let rise = 2.5_f64;
    let height = (rise * rise - 2.0).sqrt();
    let exact = symmetric_load(rise, height);
    let settings = |branch| PathSettings { load_factors: [0.0, 30.0], branch, max_steps: 400, ..Default::default() };
    let (_, points, critical) = followed(rise, &settings(Branch::Primary));
    let kinds: Vec<CriticalKind> = critical.iter().map(|point| point.kind).collect();
    use CriticalKind::{Bifurcation, LimitPoint};
    assert_eq!(kinds, [Bifurcation, LimitPoint, LimitPoint, Bifurcation]);
    assert!((critical[0].load_factor / exact - 1.0).abs() < 1e-8);
    assert!((critical[1].load_factor / symmetric_load(rise, rise / 3.0_f64.sqrt()) - 1.0).abs() < 1e-8);
    assert!(critical[0].load_along_mode < 1e-6 && critical[1].load_along_mode > 0.999);
    assert!(points.iter().all(|point| point.displacement[0].abs() < 1e-9), "the primary path is symmetric");
    assert_eq!(critical[0].negative_eigenvalues, [0, 1]);
    assert_eq!(critical[1].negative_eigenvalues, [1, 2]);

    for (branch, side) in [(Branch::AlongMode, 1.0), (Branch::AgainstMode, -1.0)] {
        let (path, points, critical) = followed(rise, &PathSettings { max_steps: 40, ..settings(branch) });
        assert_eq!((critical[0].kind, critical[0].negative_eigenvalues), (Bifurcation, [0, 1]));
        let away: Vec<&PathPoint> = points.iter().filter(|point| point.displacement[0].abs() > 1e-3).collect();
        assert!(away.len() > 20 && side * away[0].displacement[0] > 0.0, "{branch:?} {}", away.len());
        for point in away {
            let (u, y) = (point.displacement[0], rise + point.displacement[1]);
            assert!((u * u + y * y - (rise * rise - 2.0)).abs() < 1e-8, "{u} {y}");
            assert!((point.load_factor - 2.0 * y).abs() < 1e-8);
        }
        assert_eq!(path.end, PathEnd::StepLimit, "the circle is closed: it never reaches the last load factor");
    }
}

#[test]
fn levels_are_solved_each_time_the_path_crosses_them() {
    let rise = 0.5;
    let settings = PathSettings { load_factors: [0.0, 0.4], levels: vec![0.02, 0.04], ..Default::default() };
    let (_, points, _) = followed(rise, &settings);
    let levels: Vec<f64> = points.iter().filter(|point| point.is_level).map(|point| point.load_factor).collect();
    // Up to the limit load 0.048, down past −0.048, up again.
    assert_eq!(levels, [0.02, 0.04, 0.04, 0.02, 0.02, 0.04, 0.4]);
    let heights: Vec<f64> = points.iter().filter(|point| point.is_level).map(|point| point.displacement[1]).collect();
    assert!(heights.is_sorted_by(|a, b| a > b), "{heights:?}");
}

#[test]
fn a_path_that_may_not_take_enough_steps_says_so_and_a_wrong_setting_is_refused() {
    let (path, ..) = followed(0.5, &PathSettings { max_steps: 3, load_factors: [0.0, 0.4], ..Default::default() });
    assert_eq!((path.end, path.steps), (PathEnd::StepLimit, 3));
    let refused = follow(&mut Truss::new(0.5), &PathSettings { first_step: 0.0, ..Default::default() }, &mut |_| {});
    assert!(matches!(refused, Err(ContinuationError::Setting { .. })));
}
