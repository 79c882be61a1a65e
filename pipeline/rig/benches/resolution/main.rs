//! What a thin wall costs to resolve: angle, bulge and the pressure of a dent of Nemo's half body under pressure on one side, for several
//! discretisations of one structured grid, beside the size of their factor.
//!
//! Without channel, fin, deviations of the casting and, but for one row, contact; Lopez-Pamies' law of 0.2305 MPa (0.1, 0.3, ν 0.4845), acetal
//! of 4.15 GPa. The reference is the finer mesh of hexahedra. With `--all` every row is solved, without it those that the ratios need.
//!
//! Times are compared with what made the bench's equilibria before: 10-node tetrahedra with edges of 2.8 mm, and steps that are given up after
//! 16 iterations. They are those of 14 levels on one side; the other side is its mirror image.

mod grid;
mod path;

use ::mesh::Solid;
use fem::{Clamps, Contact, Mesh, Options, RegionProperties, StaticSettings, System, materials};
use grid::{Cuts, Family};
use path::{COMPARED, Outcome};
use tail_cad::{Resolution, Tail};

/// Two even cells along a chamber, three along its depth.
const EVEN: Cuts = Cuts { chamber: &[0.5], depth: &[1.0 / 3.0, 2.0 / 3.0], heights: [3, 2, 1], wall: 1 };
/// Cells short beside ribs and beside the wall, long along the height: a second cell up to the slots' end moves the angle at 160 mbar by 0.6 % and
/// costs half of the work again.
// Of ten grids within 2 % at a quarter of the flops or less this takes the fewest factorisations. How hard the walls that buckle in turn are for
// Newton's method depends on the grid, without order in cuts or share: 25 grids took 4.1 to 8.0 in the mean, 8 to 44 at worst.
const GRADED: Cuts =
    Cuts { chamber: &[0.1, 0.34, 0.66, 0.9], depth: &[0.3, 0.6, 0.8, 0.92, 0.975], heights: [1, 1, 1], wall: 1 };
const FINE: Cuts =
    Cuts { chamber: &[0.1, 0.3, 0.5, 0.7, 0.9], depth: &[0.3, 0.6, 0.8, 0.92, 0.975], heights: [3, 1, 1], wall: 1 };

/// Against which [`FINE`] is 0.4 % stiff at 160 mbar.
const FINEST: Cuts = Cuts {
    chamber: &[0.06, 0.18, 0.39, 0.61, 0.82, 0.94],
    depth: &[0.3, 0.6, 0.8, 0.92, 0.975],
    heights: [3, 2, 1],
    wall: 2,
};

/// A row of the table.
struct Discretisation {
    name: &'static str,
    cuts: Cuts,
    family: Family,
    mean_dilatation: bool,
    shear_share: f64,
    contact: bool,
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
        contact: false,
        always: true,
    },
    Discretisation {
        name: "20-node hexahedra, fine",
        cuts: FINE,
        family: Family::Hexahedra,
        mean_dilatation: false,
        shear_share: 0.1,
        contact: false,
        always: true,
    },
    Discretisation {
        name: "20-node hexahedra, graded, contact",
        cuts: GRADED,
        family: Family::Hexahedra,
        mean_dilatation: false,
        shear_share: 0.25,
        contact: true,
        always: true,
    },
    Discretisation {
        name: "20-node hexahedra, finest",
        cuts: FINEST,
        family: Family::Hexahedra,
        mean_dilatation: false,
        shear_share: 0.1,
        contact: false,
        always: false,
    },
    Discretisation {
        name: "20-node hexahedra, graded, a share of 0.1",
        cuts: GRADED,
        family: Family::Hexahedra,
        mean_dilatation: false,
        shear_share: 0.1,
        contact: false,
        always: false,
    },
    Discretisation {
        name: "10-node tetrahedra, even",
        cuts: EVEN,
        family: Family::Tetrahedra,
        mean_dilatation: false,
        shear_share: 0.0,
        contact: false,
        always: false,
    },
    Discretisation {
        name: "10-node tetrahedra, graded, mean dilatation",
        cuts: GRADED,
        family: Family::Tetrahedra,
        mean_dilatation: true,
        shear_share: 0.0,
        contact: false,
        always: false,
    },
];

/// Young's modulus of the silicone, Pa.
const SILICONE: f64 = 0.2305e6;
/// Iterations after which steps were given up before.
const FORMER_ITERATIONS: usize = 16;
/// Flops of the factor before: of [`former`] in the elimination order of before, which looked at seven planes an axis. In today's order it takes
/// 15.8 Gflop, of which the graded grid takes 0.253.
const FORMER_FLOPS: f64 = 24.8e9;

fn nemo() -> Tail {
    let specimen = rig::specimens::ALL.iter().find(|specimen| specimen.name == "nemo").expect("the bench has Nemo");
    (specimen.tail)()
}

fn system(mesh: Mesh, options: Options) -> System {
    let law = |name: &str| materials::by_name(name).expect("a law of the project");
    let silicone = RegionProperties {
        stiffening: [0.1, 0.3],
        ..RegionProperties::elastic(law("lopez_pamies"), SILICONE, 0.4845, 1070.0)
    };
    let acetal = RegionProperties::elastic(law("neo_hookean"), 4.15e9, 0.37, 1410.0);
    let clamps = Clamps::below_x(&mesh, 1e-9);
    System::with(mesh, vec![silicone, acetal], clamps, options).expect("a mesh of a tail")
}

fn discretised(row: &Discretisation) -> System {
    let mesh = grid::mesh(&nemo(), row.cuts, row.family);
    let options = Options {
        mean_dilatation: vec![row.mean_dilatation, false],
        shear_share: Some(row.shear_share),
        contact: row.contact.then_some(Contact { range: 0.5e-3, pressure: 0.1 * SILICONE }),
        ..Options::default()
    };
    system(mesh, options)
}

/// The mesh that the bench had before grids were graded: edges of 2.8 mm, with channel and fin.
fn former() -> System {
    let resolution = Resolution { edge: 0.0028, per_chamber: 2, per_rib: 1 };
    let tetrahedra = nemo().mesh(&resolution).expect("Nemo's own shape");
    let solid = Solid::Quadratic(::mesh::quadratic(&tetrahedra));
    system(simulate::fem_mesh(&solid, &[0, 1]), Options::default())
}

/// Follows the path on `system` and prints its row of the table.
fn measured(name: &str, system: &System, max_iterations: usize) -> Outcome {
    let outcome = path::follow(system, max_iterations);
    println!("{name:44} {:>7} {:>7.1} {outcome}", system.dofs(), 1e-9 * system.factor_flops());
    outcome
}

fn main() {
    let show_all = std::env::args().any(|argument| argument == "--all");
    println!("{:44} {:>7} {:>7} factorisations, angle ° at {COMPARED:?} mbar", "discretisation", "dofs", "Gflop");
    let default = StaticSettings::default().max_iterations;
    let solve = |row: &Discretisation| {
        let system = discretised(row);
        (system.factor_flops(), measured(row.name, &system, default))
    };
    let solved: Vec<(f64, Outcome)> = ROWS.iter().filter(|row| show_all || row.always).map(solve).collect();
    let former = former();
    let former_outcome = measured("10-node tetrahedra, 2.8 mm, as before", &former, FORMER_ITERATIONS);
    let [(flops, graded), (_, fine), (_, touching)] = &solved[..3] else {
        unreachable!("three rows are always solved")
    };
    let errors = graded.angles.iter().zip(&fine.angles).map(|(graded, fine)| 100.0 * (graded / fine - 1.0).abs());
    println!("resolution_angle_error_percent = {:.2}", errors.fold(0.0, f64::max));
    println!("resolution_flops_ratio = {:.3}", flops / FORMER_FLOPS);
    println!("factorisations_per_equilibrium = {:.2}", graded.factorisations_per_equilibrium());
    println!("factorisations_per_equilibrium_in_contact = {:.2}", touching.factorisations_per_equilibrium());
    println!(
        "thin_equilibria_time_ratio = {:.3}",
        graded.seconds_per_equilibrium() / former_outcome.seconds_per_equilibrium()
    );
}
