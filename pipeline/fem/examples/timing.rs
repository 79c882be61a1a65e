//! Seconds of one core for each part of a solve, on a hollow beam with ribs and a stiff sheet in its middle plane.
//!
//! `cargo run --release -p fem --example timing [CELLS_A_PITCH]`; 3 cells a pitch give about 40 thousand freedoms.
//!
//! Stands on: `fem` as its users see it. Never knows: a specimen.

use fem::{Clamps, March, Mesh, Parameter, RegionProperties, Scheme, State, StaticSettings, System, boxes, materials};

const PITCHES: usize = 9;
/// Boundaries of the layers across, m: wall, chamber, silicone, sheet, silicone, chamber, wall.
const ACROSS: [f64; 10] = [-0.010, -0.008, -0.0045, -0.001, -0.00025, 0.00025, 0.001, 0.0045, 0.008, 0.010];
/// Boundaries upwards from the middle, m: channel, chamber, wall.
const UP: [f64; 6] = [0.0, 0.002, 0.006, 0.010, 0.014, 0.016];

fn beam(cells: usize) -> Mesh {
    let along = PITCHES * cells + 1;
    let air = move |cell: [usize; 3]| {
        let side = (1..3).contains(&cell[1]) || (6..8).contains(&cell[1]);
        let rib = cell[0].is_multiple_of(cells);
        side && cell[2] < 4 && cell[0] > 0 && cell[0] + 1 < along && (!rib || cell[2] < 1)
    };
    let place = move |at: [f64; 3]| {
        let x = at[0] * along as f64;
        let (pitch, step) = ((x / cells as f64).floor(), x % cells as f64);
        let inside = if step <= 1.0 { 0.0025 * step } else { 0.0025 + 0.0075 * (step - 1.0) / (cells as f64 - 1.0) };
        [0.010 * pitch + inside, ACROSS[(9.0 * at[1]).round() as usize], UP[(5.0 * at[2]).round() as usize]]
    };
    let region = move |cell: [usize; 3]| if air(cell) { None } else { Some(u16::from(cell[1] == 4)) };
    boxes::with_middles(&boxes::grid([along, 9, 5], true, place, region))
}

/// Seconds that this thread has run, from the kernel where it tells, else from the wall clock.
fn seconds(start: std::time::Instant) -> f64 {
    let told = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
    let nanoseconds = told.and_then(|line| line.split(' ').next().and_then(|word| word.parse::<f64>().ok()));
    nanoseconds.map_or_else(|| start.elapsed().as_secs_f64(), |ns| 1e-9 * ns)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let clock = std::time::Instant::now();
    let mut last = 0.0;
    let mut say = |what: &str| {
        let now = seconds(clock);
        println!("{:8.3} s  {what}", now - last);
        last = seconds(clock);
    };
    let cells = std::env::args().nth(1).map_or(Ok(3), |word| word.parse())?;
    let mesh = beam(cells);
    say(&format!("mesh: {} nodes, {} elements", mesh.nodes.len(), mesh.elements.len()));
    let material = materials::by_name("corotated").ok_or("no such material")?;
    let silicone = RegionProperties { material, youngs_modulus: 2e5, poissons_ratio: 0.47, density: 1070.0 };
    let sheet = RegionProperties { material, youngs_modulus: 2.5e9, poissons_ratio: 0.37, density: 1410.0 };
    let clamps = Clamps::below_x(&mesh, 1e-9);
    let tip = (0..mesh.nodes.len()).max_by(|&a, &b| mesh.nodes[a][0].total_cmp(&mesh.nodes[b][0])).ok_or("no node")?;
    let system = System::new(mesh, vec![silicone, sheet], clamps)?;
    say(&format!("system: {system:?}, entries {:?}", system.entries()));
    let mut solver = system.solver();
    let set = StaticSettings::default();
    let mut start: Option<Vec<f64>> = None;
    for pressure in [1e4, 2e4, 2.5e4] {
        let found = solver.equilibrium(&[0.0, pressure], start.as_deref(), &set)?;
        let (tip, counts) = (1e3 * found.displacement[3 * tip + 1], (found.iterations, found.factorisations));
        say(&format!(
            "to {pressure} Pa: tip {tip:.3} mm, {counts:?} directions and factors, residual {:.1e}",
            found.residual
        ));
        start = Some(found.displacement);
    }
    solver.set_elastic(0, 2.1e5, 0.47)?;
    let reuse = StaticSettings { reuse_factor: true, ..set };
    let found = solver.equilibrium(&[0.0, 2.5e4], start.as_deref(), &reuse)?;
    say(&format!("again after E + 5 %: {} directions, {} factors", found.iterations, found.factorisations));
    solver.adjoint(&found, &found.displacement)?;
    say("adjoint");
    solver.sensitivity(&found, Parameter::YoungsModulus(1))?;
    say("sensitivity");
    let march = March {
        step: 1.0 / 240.0,
        scheme: Scheme::Bdf2,
        mass_damping: 1.0,
        stiffness_damping: 1e-3,
        ..March::default()
    };
    let beat = |time: f64| {
        let wave = (2.0 * std::f64::consts::PI * 2.0 * time).sin();
        vec![2e4 * (-wave).max(0.0), 2e4 * wave.max(0.0)]
    };
    let mut most: f64 = 0.0;
    let mut see = |_: f64, state: &State| most = most.max(state.displacement[3 * tip + 1].abs());
    solver.march(&march, &State::rest(system.mesh().nodes.len()), &beat, 60, &mut see)?;
    say(&format!("60 time steps at 2 Hz, tip up to {:.2} mm", 1e3 * most));
    Ok(())
}
