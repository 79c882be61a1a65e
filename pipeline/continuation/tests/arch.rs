//! Clamped shallow arches under a uniform radial load, against their closed form [pi2002]: limit load or bifurcation
//! load by slenderness, and both branches through the snap.

#![allow(clippy::unwrap_used)] // a test may fail where it stands

use continuation::{
    BodyLoad, BodyProblem, Branch, CriticalKind, CriticalPoint, PathEvent, PathPoint, PathSettings, follow,
};
use fem::{Clamps, Elements, Forces, Mesh, RegionProperties, System, box_mesh, materials};

/// Half the angle, and the radius of the middle surface, m.
const HALF_ANGLE: f64 = 0.06;
const RADIUS: f64 = 1.0;
const WIDTH: f64 = 0.01;
const YOUNGS_MODULUS: f64 = 2e5;
const POISSONS_RATIO: f64 = 0.3;

/// An arch of the slenderness R Θ² / r with the radius of gyration r; all its nodes keep their z: plane strain.
#[derive(Clone, Copy)]
struct Arch {
    slenderness: f64,
}

impl Arch {
    fn thickness(self) -> f64 {
        12.0_f64.sqrt() * RADIUS * HALF_ANGLE.powi(2) / self.slenderness
    }

    /// E/(1 − ν²) times the second moment of area per width, N m.
    fn bending_stiffness(self) -> f64 {
        YOUNGS_MODULUS / (1.0 - POISSONS_RATIO.powi(2)) * self.thickness().powi(3) / 12.0
    }

    /// Loads (Pa) of the symmetric path at β = Θ R √(N / E I), [pi2002]: q R / N − 1 = P with A P² + B P + C = 0, the
    /// root of smaller |P| first.
    fn loads(self, beta: f64) -> Option<[f64; 2]> {
        let cot = beta.cos() / beta.sin();
        let a = 0.5 * (beta.powi(2) / (2.0 * beta.sin().powi(2)) + 1.5 * beta * cot - 2.0 + beta.powi(2) / 3.0);
        let b = -(1.0 - beta * cot - beta.powi(2) / 3.0);
        let root = (b * b - 4.0 * a * beta.powi(4) / self.slenderness.powi(2)).sqrt();
        let load = |p: f64| self.bending_stiffness() * (beta / (HALF_ANGLE * RADIUS)).powi(2) * (1.0 + p) / RADIUS;
        let sign = if b < 0.0 { 1.0 } else { -1.0 };
        root.is_finite().then(|| [(-b - sign * root) / (2.0 * a), (-b + sign * root) / (2.0 * a)].map(load))
    }

    /// Loads along the symmetric path: the root of smaller |P| comes first, with β rising, then the other one.
    fn symmetric_path(self) -> Vec<f64> {
        // Below β = 0.2 the differences in A, B and C are rounding.
        let exist: Vec<[f64; 2]> = (2_000..60_000).map_while(|n| self.loads(1e-4 * f64::from(n))).collect();
        exist.iter().map(|pair| pair[0]).chain(exist.iter().rev().map(|pair| pair[1])).collect()
    }

    /// The loads of the two limit points; none where the load rises throughout.
    fn limit_loads(self) -> Option<[f64; 2]> {
        let path = self.symmetric_path();
        let most = path.windows(2).position(|pair| pair[1] < pair[0])?;
        let least = path[most..].windows(2).position(|pair| pair[1] > pair[0])?;
        Some([path[most], path[most + least]])
    }

    /// The loads at which the symmetric path crosses the antisymmetric one, tan β = β.
    fn bifurcation_loads(self) -> [f64; 2] {
        self.loads(4.493_409_457_909).unwrap()
    }

    fn mesh(self, elements: usize) -> Mesh {
        let mut mesh = box_mesh::quadratic([1.0, self.thickness(), WIDTH], [elements, 1, 1]);
        for node in &mut mesh.nodes {
            let (angle, radius) = (HALF_ANGLE * (2.0 * node[0] - 1.0), RADIUS + node[1] - 0.5 * self.thickness());
            *node = [radius * angle.sin(), radius * angle.cos(), node[2]];
        }
        mesh
    }

    /// The arch under `pressure` (Pa on the middle surface) at the load factor 1.
    fn problem(self, elements: usize, pressure: f64) -> BodyProblem {
        let mesh = self.mesh(elements);
        let end = RADIUS * HALF_ANGLE.sin();
        let is_end = |at: [f64; 3]| (at[0].abs() / at[1] - HALF_ANGLE.tan()).abs() < 1e-9 && at[0].abs() < 1.1 * end;
        let clamps = Clamps::where_nodes(&mesh, [true; 3], is_end);
        let clamps = clamps.and(&Clamps::where_nodes(&mesh, [false, false, true], |_| true));
        let forces = radial_load(&mesh, RADIUS + 0.5 * self.thickness(), pressure);
        let material = materials::by_name("neo_hookean").unwrap();
        let regions = vec![RegionProperties::elastic(material, YOUNGS_MODULUS, POISSONS_RATIO, 1070.0)];
        let system = System::new(mesh, regions, clamps).unwrap();
        BodyProblem::new(&system, system.solver(), BodyLoad { pressures: Vec::new(), forces }).unwrap()
    }
}

/// Dead forces of a radial traction on the outer side, which lies at `outer`, with the resultant of `pressure` on the
/// middle surface.
fn radial_load(mesh: &Mesh, outer: f64, pressure: f64) -> Vec<f64> {
    let Elements::Quadratic(tets) = &mesh.elements else { unreachable!("the mesh is quadratic") };
    let is_outer =
        |node: &u32| mesh.nodes[*node as usize][0].hypot(mesh.nodes[*node as usize][1]) > outer * (1.0 - 1e-9);
    let mut forces = Forces::none(mesh);
    for tet in tets {
        for sides in [[0, 1, 2, 4, 5, 6], [0, 1, 3, 4, 8, 7], [1, 2, 3, 5, 9, 8], [0, 2, 3, 6, 9, 7]] {
            let face = sides.map(|n| tet[n]);
            if face.iter().all(is_outer) {
                let centre = face[..3]
                    .iter()
                    .fold([0.0; 2], |sum, &node| [0, 1].map(|axis| sum[axis] + mesh.nodes[node as usize][axis] / 3.0));
                let scale = -pressure * RADIUS / outer / centre[0].hypot(centre[1]);
                forces = forces.on_face(&face, [scale * centre[0], scale * centre[1], 0.0]).unwrap();
            }
        }
    }
    forces.as_slice().to_vec()
}

fn followed(problem: &mut BodyProblem, settings: &PathSettings) -> (Vec<PathPoint>, Vec<CriticalPoint>) {
    let (mut points, mut critical) = (Vec::new(), Vec::new());
    let path = follow(problem, settings, &mut |event| match event {
        PathEvent::Point(point) => points.push(point.clone()),
        PathEvent::Critical(point) => critical.push(point.clone()),
    });
    assert_eq!(path.unwrap().critical, critical);
    (points, critical)
}

/// Entry of the displacement (one per dof) that is largest, over the rise of the arch.
fn largest(u: &[f64]) -> f64 {
    u.iter().fold(0.0, |most: f64, entry| most.max(entry.abs())) / (RADIUS * (1.0 - HALF_ANGLE.cos()))
}

#[test]
fn the_slenderness_at_which_arches_snap_and_bifurcate_is_the_published_one() {
    // In terms of the thickness, 2.85 and 5.02 [schreyer1966].
    let bifurcates = |slenderness: f64| Arch { slenderness }.loads(4.493_409_457_909).is_some();
    assert!(!bifurcates(5.01 * 12.0_f64.sqrt()) && bifurcates(5.03 * 12.0_f64.sqrt()));
    let snaps = |slenderness: f64| Arch { slenderness }.limit_loads().is_some();
    assert!(!snaps(2.84 * 12.0_f64.sqrt()) && snaps(2.86 * 12.0_f64.sqrt()));
}

#[test]
fn a_clamped_arch_snaps_at_the_limit_loads_of_its_closed_form_and_the_error_falls_with_the_square_of_the_edge() {
    let arch = Arch { slenderness: 14.0 };
    let exact = arch.limit_loads().unwrap();
    let mut errors = Vec::new();
    for elements in [8, 16, 32] {
        let mut problem = arch.problem(elements, 2.0 * exact[0]);
        let (points, critical) = followed(&mut problem, &PathSettings { max_step: 0.004, ..Default::default() });
        let kinds: Vec<CriticalKind> = critical.iter().map(|point| point.kind).collect();
        assert_eq!(kinds, [CriticalKind::LimitPoint; 2]);
        assert!(critical.iter().all(|point| point.load_along_mode > 0.1));
        let loads: Vec<f64> = critical.iter().map(|point| 2.0 * exact[0] * point.load_factor).collect();
        errors.push([0, 1].map(|n| loads[n] / exact[n] - 1.0));
        let [first, last] = [&points[1], &points[points.len() - 1]];
        assert!(first.negative_eigenvalues == 0 && last.negative_eigenvalues == 0);
        assert!(points.iter().any(|point| point.negative_eigenvalues == 1), "the path between both is followed");
        assert!(last.load_factor == 1.0 && largest(&last.displacement) > 1.5, "the arch hangs below its clamps");
    }
    assert!(errors[1][0].abs() < 0.02 && errors[2].iter().all(|error| error.abs() < 0.02), "{errors:?}");
    assert!(errors.windows(2).all(|pair| pair[0][0] / pair[1][0] > 3.0), "second order: {errors:?}");
}

#[test]
fn a_slender_clamped_arch_bifurcates_and_both_branches_lead_to_the_second_bifurcation() {
    let arch = Arch { slenderness: 24.0 };
    let exact = arch.bifurcation_loads();
    let settings = |branch| PathSettings { branch, max_step: 0.006, max_steps: 45, ..Default::default() };
    let (_, critical) = followed(&mut arch.problem(32, 2.0 * exact[0]), &settings(Branch::Primary));
    use CriticalKind::{Bifurcation, LimitPoint};
    assert_eq!(
        critical.iter().map(|point| point.kind).collect::<Vec<_>>(),
        [Bifurcation, LimitPoint, Bifurcation, LimitPoint]
    );
    for (n, point) in [(0, &critical[0]), (1, &critical[2])] {
        let load = 2.0 * exact[0] * point.load_factor;
        assert!((load / exact[n] - 1.0).abs() < 0.02, "{load} {exact:?}");
        assert!(point.load_along_mode < 1e-3);
    }
    for branch in [Branch::AlongMode, Branch::AgainstMode] {
        let mut problem = arch.problem(32, 2.0 * exact[0]);
        let (points, critical) = followed(&mut problem, &settings(branch));
        assert_eq!((critical.len(), critical[0].kind), (1, Bifurcation), "on the antisymmetric path N does not change");
        let node = problem.dof_map().largest_node(&critical[0].mode);
        let rise = |point: &PathPoint| problem.dof_map().full(&point.displacement)[3 * node + 1];
        // The first point beyond the bifurcation has moved along the mode, to the side that was asked for.
        let beyond = points.iter().position(|point| point.negative_eigenvalues == 1).unwrap();
        let along = rise(&points[beyond]) - rise(&points[beyond - 1]);
        let sign = problem.dof_map().full(&critical[0].mode)[3 * node + 1].signum();
        assert_eq!(along * sign > 0.0, branch == Branch::AlongMode);
        let least = points[beyond..].iter().map(|point| point.load_factor).fold(f64::INFINITY, f64::min);
        assert!((2.0 * exact[0] * least / exact[1] - 1.0).abs() < 0.02, "{least}");
        assert!(points[beyond].load_factor < critical[0].load_factor, "the path falls: the arch snaps sideways");
    }
}
