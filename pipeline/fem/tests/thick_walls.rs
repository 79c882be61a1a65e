//! Thick walls under pressure: spheres and tubes, at small strain and inflated to one and a half times their bore.
//!
//! The exact answer at large strain is that of the very same compressible law: with the stretches r' and r/R of a radial
//! motion r(R), (Pᵣ)' + n (Pᵣ − Pₜ)/R = 0, n = 1 for a tube and 2 for a sphere, Pᵣ = 0 outside and p = −Pᵣ (R/r)ⁿ
//! inside, is integrated from the inner wall to the outer one.

#![allow(clippy::unwrap_used)] // a test may fail where it stands

use fem::material::Moduli;
use fem::{Clamps, Elements, Mesh, RegionProperties, StaticSettings, System, box_mesh, materials};

/// Inner and outer radius, m.
const INNER: f64 = 0.01;
const OUTER: f64 = 0.02;
const HEIGHT: f64 = 0.004;
const E: f64 = 2e5;
/// Cells from the middle of the cavity to its wall, and through the wall.
const HALF: usize = 2;
const LAYERS: usize = 3;

/// The elements of the wall.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Family {
    Tetrahedra,
    Hexahedra,
}

const FAMILIES: [Family; 2] = [Family::Tetrahedra, Family::Hexahedra];

/// The inflated body.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Body {
    /// About z, its ends held along z; a lid of negligible stiffness closes its upper end.
    Tube,
    Sphere,
}

impl Body {
    /// Axes around which it is round, less one.
    fn n(self) -> i32 {
        if self == Self::Tube { 1 } else { 2 }
    }

    fn radius(self, at: [f64; 3]) -> f64 {
        let z = if self == Self::Tube { 0.0 } else { at[2] };
        (at[0] * at[0] + at[1] * at[1] + z * z).sqrt()
    }

    /// From a place in the unit cube, counted in cells from the middle, to the round body, m.
    fn place(self, cube: [f64; 3]) -> [f64; 3] {
        let size = self.radius(cube);
        let round = if self == Self::Tube { &cube[..2] } else { &cube[..] };
        let most = round.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        let (half, layers) = (HALF as f64, LAYERS as f64);
        let wall = (most - half) / layers;
        // in geometric steps: the strain falls with the distance from the axis
        let radius = if wall < 0.0 { INNER * most / half } else { INNER * (OUTER / INNER).powf(wall) };
        let scale = if size > 0.0 { radius / size } else { 0.0 };
        let z = if self == Self::Tube { HEIGHT * cube[2] } else { scale * cube[2] };
        [scale * cube[0], scale * cube[1], z]
    }

    /// Half of the body, z ≥ 0.
    fn mesh(self, family: Family) -> Mesh {
        let wide = 2 * (HALF + LAYERS);
        let high = if self == Self::Tube { 2 } else { HALF + LAYERS };
        let inside = |at: usize| (LAYERS..LAYERS + 2 * HALF).contains(&at);
        let region = move |cell: [usize; 3]| {
            let bore = inside(cell[0]) && inside(cell[1]);
            match self {
                Self::Tube if cell[2] == 1 => bore.then_some(1),
                Self::Tube => (!bore).then_some(0),
                Self::Sphere => (!(bore && cell[2] < HALF)).then_some(0),
            }
        };
        let place = |at: [f64; 3]| {
            let middle = (HALF + LAYERS) as f64;
            self.place([(2.0 * at[0] - 1.0) * middle, (2.0 * at[1] - 1.0) * middle, high as f64 * at[2]])
        };
        let cells = [wide, wide, high];
        match family {
            Family::Tetrahedra => self.rounded(box_mesh::to_quadratic(&box_mesh::grid(cells, true, place, region))),
            Family::Hexahedra => box_mesh::quadratic_hexahedra(cells, true, place, region),
        }
    }

    /// Middle nodes go out to the radius that the two ends of their edge share, if they do.
    fn rounded(self, mut mesh: Mesh) -> Mesh {
        let Elements::Quadratic(tets) = mesh.elements.clone() else { unreachable!("it has middle nodes") };
        let edges = [(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)];
        let straight = mesh.nodes.clone();
        for tet in tets {
            for (middle, (a, b)) in edges.into_iter().enumerate() {
                let [a, b, middle] = [a, b, 4 + middle].map(|n| tet[n] as usize);
                let [one, other, at] = [a, b, middle].map(|n| self.radius(straight[n]));
                if (one - other).abs() < 1e-9 && one > INNER - 1e-9 {
                    (0..self.n() as usize + 1)
                        .for_each(|axis| mesh.nodes[middle][axis] = straight[middle][axis] / at * one);
                }
            }
        }
        mesh
    }

    /// Radii of the inner and the outer wall under `pressure`, over those at rest, as means over their nodes.
    fn blown(self, family: Family, (law, nu): (&str, f64), pressure: f64) -> [f64; 2] {
        let mesh = self.mesh(family);
        let material = materials::by_name(law).unwrap();
        let wall = RegionProperties::elastic(material, E, nu, 1070.0);
        let lid = RegionProperties { youngs_modulus: 1e-5 * E, poissons_ratio: 0.0, ..wall.clone() };
        let regions = if self == Self::Tube { vec![wall, lid] } else { vec![wall] };
        let mut clamps = Clamps::where_nodes(&mesh, [true, false, false], |at| at[0].abs() < 1e-9)
            .and(&Clamps::where_nodes(&mesh, [false, true, false], |at| at[1].abs() < 1e-9));
        if self == Self::Tube {
            clamps = clamps.and(&Clamps::where_nodes(&mesh, [false, false, true], |at| at[2] > HEIGHT - 1e-9));
        }
        let system = System::new(mesh, regions, clamps).unwrap();
        let found = system.solver().equilibrium(&[pressure], None, &StaticSettings::default()).unwrap();
        [INNER, OUTER].map(|wall| {
            let on = |at: &[f64; 3]| (self.radius(*at) - wall).abs() < 1e-9 && at[2] < HEIGHT + 1e-9;
            let moved = system.mesh().nodes.iter().zip(found.displacement.chunks_exact(3)).filter(|(at, _)| on(at));
            let radii: Vec<f64> =
                moved.map(|(at, u)| self.radius([at[0] + u[0], at[1] + u[1], at[2] + u[2]]) / wall).collect();
            radii.iter().sum::<f64>() / radii.len() as f64
        })
    }

    /// Pᵣ and Pₜ of compressible neo-Hookean rubber at the stretches along and across the radius, Pa.
    fn stress(self, moduli: Moduli, along: f64, across: f64) -> (f64, f64) {
        let swell = moduli.lambda * (along * across.powi(self.n())).ln();
        let of = |stretch: f64| moduli.mu * (stretch - 1.0 / stretch) + swell / stretch;
        (of(along), of(across))
    }

    /// The stretch along the radius at which Pᵣ is `wanted`, by bisection: Pᵣ rises with it.
    fn along(self, moduli: Moduli, across: f64, wanted: f64) -> f64 {
        let (mut low, mut high) = (1e-2, 4.0);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if self.stress(moduli, middle, across).0 < wanted { low = middle } else { high = middle }
        }
        0.5 * (low + high)
    }

    /// From the inner wall, stretched by `bore` under `pressure`, outwards by Runge and Kutta's method: the stretch of
    /// the outer wall, and Pᵣ there, Pa.
    fn outwards(self, moduli: Moduli, bore: f64, pressure: f64) -> (f64, f64) {
        let rate = |radius: f64, [r, p]: [f64; 2]| {
            let along = self.along(moduli, r / radius, p);
            let (radial, around) = self.stress(moduli, along, r / radius);
            [along, -f64::from(self.n()) * (radial - around) / radius]
        };
        let steps = 200;
        let h = (OUTER - INNER) / f64::from(steps);
        let mut at = [bore * INNER, -pressure * bore.powi(self.n())];
        for step in 0..steps {
            let radius = INNER + h * f64::from(step);
            let extrapolated = |slope: [f64; 2], part: f64| [at[0] + part * h * slope[0], at[1] + part * h * slope[1]];
            let first = rate(radius, at);
            let second = rate(radius + 0.5 * h, extrapolated(first, 0.5));
            let third = rate(radius + 0.5 * h, extrapolated(second, 0.5));
            let fourth = rate(radius + h, extrapolated(third, 1.0));
            at = std::array::from_fn(|k| at[k] + h / 6.0 * (first[k] + 2.0 * (second[k] + third[k]) + fourth[k]));
        }
        (at[0] / OUTER, at[1])
    }

    /// The pressure (Pa) that stretches the inner wall by `bore`, and the stretch of the outer wall then.
    fn exact(self, moduli: Moduli, bore: f64) -> (f64, f64) {
        let (mut low, mut high) = (0.0, 2.0 * moduli.mu);
        for _ in 0..50 {
            let middle = 0.5 * (low + high);
            // too much pressure inside leaves the outer wall pressed
            if self.outwards(moduli, bore, middle).1 > 0.0 { low = middle } else { high = middle }
        }
        (low, self.outwards(moduli, bore, low).0)
    }
}

#[test]
fn thick_walls_at_large_strain_agree_with_the_radial_solution_of_their_law() {
    for (body, bore) in [(Body::Tube, 1.6), (Body::Sphere, 1.5)] {
        for (nu, family) in [0.45, 0.499].into_iter().flat_map(|nu| FAMILIES.map(|family| (nu, family))) {
            let (pressure, outer) = body.exact(Moduli::of(E, nu), bore);
            let blown = body.blown(family, ("neo_hookean", nu), pressure);
            let errors = [blown[0] / bore - 1.0, blown[1] / outer - 1.0];
            assert!(errors.iter().all(|error| error.abs() < 0.01), "{body:?} {family:?} ν {nu}: {errors:?}");
        }
    }
}

#[test]
fn a_nearly_incompressible_wall_agrees_with_the_closed_forms_of_rubber() {
    // p/μ = ln(a/b) + ½ (b⁻² − a⁻²) of a tube, ½ b⁻⁴ + 2 b⁻¹ − ½ a⁻⁴ − 2 a⁻¹ of a sphere; a, b: stretches inside, outside
    let moduli = Moduli::of(E, 0.499_999);
    let thick = OUTER / INNER;
    let of = |body: Body, bore: f64| {
        let n = body.n() + 1;
        (1.0 + (bore.powi(n) - 1.0) / thick.powi(n)).powf(1.0 / f64::from(n))
    };
    let (a, b) = (1.6f64, of(Body::Tube, 1.6));
    let tube = (a / b).ln() + 0.5 * (b.powi(-2) - a.powi(-2));
    let (a, b) = (1.5f64, of(Body::Sphere, 1.5));
    let sphere = 0.5 * b.powi(-4) + 2.0 / b - 0.5 * a.powi(-4) - 2.0 / a;
    for (body, bore, exact) in [(Body::Tube, 1.6, tube), (Body::Sphere, 1.5, sphere)] {
        let ratio = body.exact(moduli, bore).0 / moduli.mu / exact;
        assert!((ratio - 1.0).abs() < 1e-4, "{body:?} {ratio}");
    }
}

#[test]
fn thick_walls_at_small_strain_agree_with_lames_solution() {
    let (nu, pressure) = (0.45, 100.0);
    let (a, b) = (INNER, OUTER);
    let tube = |r: f64| (1.0 + nu) * pressure * a * a / (E * (b * b - a * a)) * ((1.0 - 2.0 * nu) * r + b * b / r);
    let sphere = |r: f64| {
        let scale = pressure * a.powi(3) / (E * (b.powi(3) - a.powi(3)));
        scale * ((1.0 - 2.0 * nu) * r + (1.0 + nu) * b.powi(3) / (2.0 * r * r))
    };
    for (body, exact) in [(Body::Tube, [tube(a), tube(b)]), (Body::Sphere, [sphere(a), sphere(b)])] {
        for family in FAMILIES {
            let blown = body.blown(family, ("linear", nu), pressure);
            for (wall, rest) in [a, b].into_iter().enumerate() {
                let ratio = (blown[wall] - 1.0) * rest / exact[wall];
                assert!((ratio - 1.0).abs() < 0.01, "{body:?} {family:?}, wall {wall}: {ratio}");
            }
        }
    }
}
