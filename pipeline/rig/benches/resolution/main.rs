//! What a thin wall costs to resolve: angle, bulge and the pressure of a dent of Nemo's half body under pressure on one side, for several
//! discretisations of one structured grid, beside the size of their factor.
//!
//! Without channel, fin, contact and deviations of the casting; Lopez-Pamies' law of 0.2305 MPa (0.1, 0.3, ν 0.4845), acetal of 4.15 GPa.
//! The reference is the finest mesh of hexahedra. With `--all` every row is solved, without it those that the ratios need.

mod grid;
mod path;

use fem::{Clamps, Options, RegionProperties, System, materials};
use grid::{Cuts, Family};
use path::{LEVELS, Outcome};
use rig::physics::{Body, BodySettings};
use rig::settings::{Resolution, Settings};
use rig::specimen::HiddenProperties;

/// Two even cells along a chamber, three along its depth.
const EVEN: Cuts = Cuts { chamber: &[0.5], depth: &[1.0 / 3.0, 2.0 / 3.0], heights: [3, 2, 1], wall: 1 };
/// Cells short beside ribs and beside the wall.
const GRADED: Cuts = Cuts { chamber: &[0.15, 0.5, 0.85], depth: &[0.45, 0.8, 0.94], heights: [2, 1, 1], wall: 1 };
const FINE: Cuts =
    Cuts { chamber: &[0.1, 0.3, 0.5, 0.7, 0.9], depth: &[0.3, 0.6, 0.8, 0.92, 0.975], heights: [3, 1, 1], wall: 1 };

/// A row of the table.
struct Discretisation {
    name: &'static str,
    cuts: Cuts,
    family: Family,
    mean_dilatation: bool,
    shear_share: f64,
    /// Whether the ratios need it.
    always: bool,
}

const ROWS: &[Discretisation] = &[
    Discretisation {
        name: "20-node hexahedra, graded",
        cuts: GRADED,
        family: Family::Hexahedra,
        mean_dilatation: false,
        shear_share: 0.25,
        always: true,
    },
    Discretisation {
        name: "20-node hexahedra, fine",
        cuts: FINE,
        family: Family::Hexahedra,
        mean_dilatation: false,
        shear_share: 0.1,
        always: true,
    },
    Discretisation {
        name: "20-node hexahedra, graded, a share of 0.1",
        cuts: GRADED,
        family: Family::Hexahedra,
        mean_dilatation: false,
        shear_share: 0.1,
        always: false,
    },
    Discretisation {
        name: "10-node tetrahedra, even",
        cuts: EVEN,
        family: Family::Tetrahedra,
        mean_dilatation: false,
        shear_share: 0.0,
        always: false,
    },
    Discretisation {
        name: "10-node tetrahedra, graded, mean dilatation",
        cuts: GRADED,
        family: Family::Tetrahedra,
        mean_dilatation: true,
        shear_share: 0.0,
        always: false,
    },
];

fn system(row: &Discretisation) -> System {
    let nemo = rig::specimens::ALL.iter().find(|s| s.name == "nemo").expect("the bench has Nemo");
    let mesh = grid::mesh(&(nemo.tail)(), row.cuts, row.family);
    let law = |name: &str| materials::by_name(name).expect("a law of the project");
    let silicone = RegionProperties {
        stiffening: [0.1, 0.3],
        ..RegionProperties::elastic(law("lopez_pamies"), 0.2305e6, 0.4845, 1070.0)
    };
    let acetal = RegionProperties::elastic(law("neo_hookean"), 4.15e9, 0.37, 1410.0);
    let options = Options {
        mean_dilatation: vec![row.mean_dilatation, false],
        shear_share: Some(row.shear_share),
        ..Options::default()
    };
    let clamps = Clamps::below_x(&mesh, 1e-9);
    System::with(mesh, vec![silicone, acetal], clamps, options).expect("a grid of a tail")
}

/// Multiplications and additions of a factorisation on the mesh of the study before grids were graded: edges of 2.8 mm.
fn former_flops() -> f64 {
    let set = Settings::built_in();
    let nemo = rig::specimens::ALL.iter().find(|s| s.name == "nemo").expect("the bench has Nemo");
    let own = &set.specimen[&*nemo.name];
    let resolution = Resolution { edge: 0.0028, per_chamber: 2, per_rib: 1 };
    let laws = ["lopez_pamies", "neo_hookean"];
    let settings = BodySettings { resolution: &resolution, clamp: own.clamp, laws };
    let body = Body::new(&(nemo.tail)(), &settings, &HiddenProperties::drawn(&set, own)).expect("Nemo's own shape");
    body.system.factor_flops()
}

fn main() {
    let all = std::env::args().any(|argument| argument == "--all");
    let rows: Vec<&Discretisation> = ROWS.iter().filter(|row| all || row.always).collect();
    let former = former_flops();
    println!("{:44} {:>7} {:>7} {:>6}  angle ° at {LEVELS:?} mbar", "discretisation", "dofs", "Gflop", "factors");
    let solve = |row: &&Discretisation| {
        let system = system(row);
        let outcome = path::follow(&system);
        println!("{:44} {:>7} {:>7.1} {outcome}", row.name, system.dofs(), 1e-9 * system.factor_flops());
        (system.factor_flops(), outcome)
    };
    let solved: Vec<(f64, Outcome)> = rows.iter().map(solve).collect();
    println!("edges of 2.8 mm: {:.1} Gflop", 1e-9 * former);
    let ((flops, own), (_, fine)) = (&solved[0], &solved[1]);
    let errors = own.angles.iter().zip(&fine.angles).map(|(own, fine)| 100.0 * (own / fine - 1.0).abs());
    println!("resolution_angle_error_percent = {:.2}", errors.fold(0.0, f64::max));
    println!("resolution_flops_ratio = {:.3}", flops / former);
    println!("factorisations_per_equilibrium = {:.2}", own.factorisations_per_level);
}
