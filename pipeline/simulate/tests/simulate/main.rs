//! Simulate, end to end: the examples, closed forms, the results kept after a loss of equilibrium, and refused input.
//!
//! Each test writes into a folder of its own below cargo's folder for tests.

#![allow(clippy::unwrap_used)]

mod budget;
mod certificate;
mod clamps;
mod groups;
mod loads;
mod path;
mod surfaces;

use std::f64::consts::PI;
use std::path::{Path, PathBuf};

use mesh::Surface;
use mesh::foreign::vtu;
use simulate::{Summary, run};

fn here(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

fn example(name: &str) -> String {
    std::fs::read_to_string(here("examples").join(name)).unwrap()
}

/// A folder of one test, empty.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

/// Runs the text of a case in a folder of its own, with its mesh named where it lies.
fn solve(test: &str, case: &str) -> Result<(Summary, Table), String> {
    let folder = folder(test);
    let name = |file: &str| format!("file = \"{}\"", here(file).display());
    let case = case
        .replace("file = \"cantilever.msh\"", &name("examples/cantilever.msh"))
        .replace("file = \"finger.msh\"", &name("examples/finger.msh"))
        .replace("file = \"ball.msh\"", &name("../mesh/tests/data/ball.msh"))
        .replace("file = \"bar_legacy.msh\"", &name("../mesh/tests/data/bar_legacy.msh"));
    std::fs::write(folder.join("case.toml"), case).unwrap();
    let summary = run(&folder.join("case.toml"), None, true, None).map_err(|diagnostic| diagnostic.to_string())?;
    Ok((summary, Table::read(&folder.join("case.out/case.csv"))))
}

/// A table of numbers with names.
struct Table {
    names: Vec<String>,
    rows: Vec<Vec<f64>>,
}

impl Table {
    fn read(path: &Path) -> Self {
        let text = std::fs::read_to_string(path).unwrap();
        let mut lines = text.lines();
        let names = lines.next().unwrap().split(',').map(str::to_owned).collect();
        Self { names, rows: lines.map(|line| line.split(',').map(|word| word.parse().unwrap()).collect()).collect() }
    }

    fn column(&self, name: &str) -> Vec<f64> {
        let index =
            self.names.iter().position(|known| known == name).unwrap_or_else(|| panic!("{name} in {:?}", self.names));
        self.rows.iter().map(|row| row[index]).collect()
    }
}

/// Tip deflection of the example's beam under its whole load, m: P L³/3EI + P L/κGA.
fn timoshenko() -> f64 {
    let (e, nu, length, wide, high) = (1e6, 0.3, 0.1, 0.01, 0.006);
    let (area, force) = (wide * high, 70.0 * wide * high);
    let kappa = 10.0 * (1.0 + nu) / (12.0 + 11.0 * nu);
    force * length * length * length / (3.0 * e * wide * high * high * high / 12.0)
        + force * length / (kappa * e / (2.0 * (1.0 + nu)) * area)
}

#[test]
fn the_cantilever_bends_as_timoshenko_has_it() {
    let (summary, table) = solve("cantilever", &example("cantilever.toml")).unwrap();
    assert_eq!((summary.solved, summary.dofs), (2, 4200));
    let tip = table.column("tip_uz_m");
    // the clamp holds the section's width too, which stiffens it by one per cent
    assert!((tip[0] / (-0.1 * timoshenko()) - 1.0).abs() < 0.015, "{tip:?} and {:e}", timoshenko());
    assert!((tip[1] / -timoshenko() - 1.0).abs() < 0.03, "{tip:?} and {:e}", timoshenko());
    assert_eq!(table.column("level"), [0.1, 1.0]);
    let places = table.column("tip_z_m");
    assert!(
        places.iter().zip(&tip).all(|(place, moved)| (place - moved).abs() < 1e-12),
        "the tip's rest place is z = 0"
    );
}

#[test]
fn frames_and_their_list_can_be_read_back() {
    solve("frames", &example("cantilever.toml")).unwrap();
    let output_folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("frames/case.out");
    let list = std::fs::read_to_string(output_folder.join("case.pvd")).unwrap();
    assert!(list.contains("timestep=\"0.1\"") && list.contains("file=\"frame_0001.vtu\""), "{list}");
    let frame = std::fs::read(output_folder.join("frame_0001.vtu")).unwrap();
    let mesh = vtu(&frame).unwrap().check(1.0, false).unwrap();
    assert_eq!(mesh.solid.element(0).len(), 10);
    assert!((mesh.regions[0].volume - 6e-6).abs() < 1e-15);
    let text = String::from_utf8(frame).unwrap();
    assert!(["displacement_m", "von_mises_pa", "energy_density_j_per_m3"].iter().all(|name| text.contains(name)));
}

#[test]
fn straight_elements_of_four_nodes_are_stiffer() {
    let linear = example("cantilever.toml").replace("order = \"quadratic\"", "order = \"linear\"");
    let (summary, table) = solve("linear", &linear).unwrap();
    assert_eq!(summary.dofs, 3 * 252 - 3 * 12);
    let tip = table.column("tip_uz_m")[0] / (-0.1 * timoshenko());
    assert!(tip > 0.1 && tip < 0.9, "{tip}");
}

#[test]
fn the_finger_curls_and_its_chamber_counts_both_halves() {
    let (_, table) = solve("finger", &example("finger.toml")).unwrap();
    let (volume, tip) = (table.column("air_volume_m3"), table.column("tip_uy_m"));
    assert_eq!(table.column("air_pressure_pa"), [2e3, 4e3, 6e3, 8e3]);
    // 68 × 8 × 10 mm at rest
    assert!(volume.windows(2).all(|pair| pair[0] < pair[1]) && volume[0] > 5.44e-6 && volume[0] < 6.5e-6, "{volume:?}");
    assert!(tip.windows(2).all(|pair| pair[1] < pair[0]) && tip[0] < 0.0, "{tip:?}");
}

#[test]
fn the_same_force_along_an_edge_at_a_point_or_by_weight_bends_the_beam_as_far() {
    let beam = example("cantilever.toml").replace("levels = [0.1, 1.0]", "levels = [1.0]");
    let (_, table) = solve("traction", &beam).unwrap();
    let (force, tip) = (70.0 * 6e-5, table.column("tip_uz_m")[0]);
    let load = "plane = { x = 0.1 }\ntraction = [0.0, 0.0, -70.0]";
    let edge =
        format!("box = {{ low = [0.1, -1, 0.003], high = [0.1, 1, 0.003] }}\nline_force = [0, 0, {:e}]", -force / 0.01);
    let (_, table) = solve("line", &beam.replace(load, &edge)).unwrap();
    // the upper edge goes ahead as the end turns: a longer lever, by half a per cent
    assert_near(table.column("tip_uz_m")[0], tip, 0.01);
    let point = format!("near = [0.1, 0, 0]\nforce = [0, 0, {:e}]", -force);
    let (_, table) = solve("point", &beam.replace(load, &point)).unwrap();
    // the displacement of the loaded node itself is a little larger
    assert_near(table.column("tip_uz_m")[0], tip, 0.01);
    let weight = format!("plane = {{ x = 0.1 }}\narea_density = {:e}", 70.0 / 9.81);
    let heavy =
        beam.replace("[[load]]", "[[mass]]").replace(load, &weight).replace("density = 1070.0", "density = 1.0");
    let (_, table) = solve("weight", &format!("gravity = [0, 0, -9.81]\n{heavy}")).unwrap();
    // the lightest beam allowed has half a per cent of that weight itself
    assert_near(table.column("tip_uz_m")[0], tip, 0.01);
}

#[track_caller]
fn assert_near(found: f64, expected: f64, part: f64) {
    assert!((found / expected - 1.0).abs() < part, "{found:e} where {expected:e} was expected");
}

#[test]
fn a_chamber_follows_its_history() {
    let ramp = "pressure = { ramp = { to = 4e3, start = 0.01, seconds = 0.02 } }";
    let moving = "[dynamic]\nduration = 0.05\nstep = 0.005\nstiffness_damping = 0.01\nlumped_mass = true";
    let case = example("finger.toml").replace("pressure = 8.0e3", ramp).replace("\"quadratic\"", "\"linear\"");
    let case = case.replace("[static]\nlevels = [0.25, 0.5, 0.75, 1.0]", moving);
    let (_, table) = solve("history", &case).unwrap();
    let expected = [0.0, 0.0, 0.0, 1e3, 2e3, 3e3, 4e3, 4e3, 4e3, 4e3, 4e3];
    let gauge = table.column("air_pressure_pa");
    assert!(gauge.iter().zip(expected).all(|(p, e)| (p - e).abs() < 1e-6), "{gauge:?}");
    let volume = table.column("air_volume_m3");
    assert!((volume[0] - 5.44e-6).abs() < 1e-12 && volume[10] > 1.01 * volume[0], "{volume:?}");
}

#[test]
fn a_failed_step_keeps_the_last_state_and_names_the_time() {
    let ramp = "pressure = { ramp = { to = 1e6, seconds = 0.1 } }";
    let moving = "[dynamic]\nduration = 0.1\nstep = 0.005";
    let case = example("finger.toml").replace("pressure = 8.0e3", ramp).replace("\"quadratic\"", "\"linear\"");
    let error =
        solve("lost", &case.replace("[static]\nlevels = [0.25, 0.5, 0.75, 1.0]", moving)).map(|_| ()).unwrap_err();
    assert!(error.contains("no time step is found beyond 0.0") && error.contains("last_converged.vtu"), "{error}");
    let output_folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("lost/case.out");
    assert!(!Table::read(&output_folder.join("case.csv")).rows.is_empty());
    assert!(vtu(&std::fs::read(output_folder.join("last_converged.vtu")).unwrap()).is_ok());
}

/// The hollow ball of `shape`'s tests, held so that it can swell but not move.
const BALL: &str = r#"
[mesh]
file = "ball.msh"
unit = "m"
[[region]]
name = "soft"
material = "neo_hookean"
youngs_modulus = 1.0e6
poissons_ratio = 0.4
density = 1000.0
[[region]]
tag = 3
material = "neo_hookean"
youngs_modulus = 1.0e6
poissons_ratio = 0.4
density = 1000.0
[[clamp]]
box = { low = [0, 0, 0.00999], high = [0, 0, 0.01001] }
[[clamp]]
box = { low = [0, 0, -0.01001], high = [0, 0, -0.00999] }
hold = ["x", "y"]
[[clamp]]
box = { low = [0.00999, -1e-5, -1e-5], high = [0.01001, 1e-5, 1e-5] }
hold = ["y"]
[[chamber]]
number = 0
pressure = 1000.0
[static]
"#;

/// By what share the cavity of a ball between two radii (m) grows under 1 kPa, of 1 MPa and Poisson's ratio 0.4.
fn moduli(a: f64, b: f64) -> f64 {
    let (e, nu, p) = (1e6, 0.4, 1000.0);
    let (a3, b3) = (a.powi(3), b.powi(3));
    let wall = p * a3 / (b3 - a3) / e * ((1.0 - 2.0 * nu) * a + (1.0 + nu) * b3 / (2.0 * a * a));
    3.0 * wall / a
}

#[test]
fn a_hollow_ball_swells_as_lame_has_it() {
    let (_, table) = solve("ball", &BALL.replace("[static]", "[static]\nlevels = [1e-9, 1.0]")).unwrap();
    let volume = table.column("chamber_0_volume_m3");
    let swollen = moduli(0.006, 0.01);
    let growth = volume[1] / volume[0] - 1.0;
    // 140 elements; the ball is not quite round
    assert!((growth / swollen - 1.0).abs() < 0.05, "{growth:e} where {swollen:e} was expected");
}

/// A ball of `radius` (m) about the origin as rings of triangles, its normals inwards when it is a cavity.
fn sphere(radius: f64, cavity: bool) -> Surface {
    let (rings, around) = (25, 48);
    let angles = (0..rings).map(|i| PI * (f64::from(i) + 0.5) / f64::from(rings));
    let ring = |polar: f64| (0..around).map(move |k| (polar, 2.0 * PI * f64::from(k) / f64::from(around)));
    let position = |(p, a): (f64, f64)| [-p.cos(), p.sin() * a.cos(), p.sin() * a.sin()].map(|x| radius * x);
    let mut points: Vec<[f64; 3]> = angles.flat_map(ring).map(position).collect();
    points.extend([[-radius, 0.0, 0.0], [radius, 0.0, 0.0]]);
    let at = |i: u32, k: u32| i * around as u32 + k % around as u32;
    let (last, poles) = (rings as u32 - 1, [rings as u32 * around as u32, rings as u32 * around as u32 + 1]);
    let mut faces = Vec::new();
    for k in 0..around as u32 {
        faces.extend([[poles[0], at(0, k + 1), at(0, k)], [poles[1], at(last, k), at(last, k + 1)]]);
        let quad = |i: u32| [[at(i - 1, k), at(i - 1, k + 1), at(i, k + 1)], [at(i - 1, k), at(i, k + 1), at(i, k)]];
        faces.extend((1..=last).flat_map(quad));
    }
    if cavity {
        faces.iter_mut().for_each(|face| face.swap(1, 2));
    }
    Surface { points, faces }
}

#[test]
fn a_ball_from_its_surface_alone_swells_as_lame_has_it() {
    let cad = folder("ball_cad");
    let (mut ball, hollow) = (sphere(0.02, false), sphere(0.014, true));
    let offset = ball.points.len() as u32;
    ball.points.extend(hollow.points);
    ball.faces.extend(hollow.faces.iter().map(|face| face.map(|p| p + offset)));
    std::fs::write(cad.join("ball.stl"), mesh::stl::write(&ball, 1e-3, "a ball")).unwrap();
    let case = format!(
        "[mesh]\nbody = \"{}\"\nedge = 0.004\nunit = \"mm\"\n[[region]]\nmaterial = \"neo_hookean\"\n\
         youngs_modulus = 1e6\npoissons_ratio = 0.4\ndensity = 1000.0\n[[clamp]]\n\
         box = {{ low = [-0.021, -0.003, -0.003], high = [-0.019, 0.003, 0.003] }}\n\
         [[chamber]]\nnumber = 0\npressure = 1e3\n[static]\nlevels = [1e-9, 1.0]\n",
        cad.join("ball.stl").display(),
    );
    let (_, table) = solve("ball_alone", &case).unwrap();
    let volume = table.column("chamber_0_volume_m3");
    let (growth, swollen) = (volume[1] / volume[0] - 1.0, moduli(0.014, 0.02));
    assert!((growth / swollen - 1.0).abs() < 0.03, "{growth:e} where {swollen:e} was expected");
}

#[test]
fn a_sealed_chamber_keeps_to_its_gas_law() {
    let sealed = BALL.replace("pressure = 1000.0", "name = \"air\"\npressure = 1e5\nsealed_in = 101325.0");
    let (_, table) = solve("sealed", &sealed.replace("[static]", "[static]\nlevels = [1e-9, 1.0]")).unwrap();
    let (volume, gauge) = (table.column("air_volume_m3"), table.column("air_pressure_pa"));
    assert!(gauge[1] < 0.95e5 && gauge[1] > 0.5e5, "{gauge:?}");
    let amount = (gauge[1] + 101_325.0) * volume[1] / ((1e5 + 101_325.0) * volume[0]);
    assert!((amount - 1.0).abs() < 1e-6, "{amount}");
}

#[test]
fn a_motion_is_the_same_with_adaptive_steps() {
    let case = example("swing.toml").replace("duration = 0.5", "duration = 0.2").replace("\"quadratic\"", "\"linear\"");
    let case = case.replace("step = 0.005", "step = 0.002");
    let (summary, table) = solve("swing", &case).unwrap();
    assert_eq!((summary.solved, table.rows.len()), (100, 101));
    assert_eq!(table.column("time_s")[100], 0.2);
    let adaptive = "adaptive = { tolerance = 2e-6, shortest = 1e-4, longest = 0.01 }";
    let (_, chosen) = solve("swing_adaptive", &case.replace("step = 0.002", adaptive)).unwrap();
    let (a, b) = (table.column("tip_uz_m"), chosen.column("tip_uz_m"));
    let (a, b) = (a[a.len() - 1], b[b.len() - 1]);
    assert!(a < -1e-3 && (a / b - 1.0).abs() < 0.03, "{a:e} and {b:e}");
}

#[test]
fn a_motion_that_starts_in_its_equilibrium_stays_there() {
    let equilibrium_start =
        example("swing.toml").replace("\"rest\"", "\"equilibrium\"").replace("duration = 0.5", "duration = 0.1");
    let (_, table) = solve("still", &equilibrium_start.replace("\"quadratic\"", "\"linear\"")).unwrap();
    let tip = table.column("tip_uz_m");
    assert!(tip[0] < -1e-3 && tip.iter().all(|at| (at / tip[0] - 1.0).abs() < 1e-3), "{tip:?}");
}

#[test]
fn a_load_without_equilibrium_keeps_the_last_state_and_names_the_level() {
    let burst =
        BALL.replace("pressure = 1000.0", "pressure = 1e6").replace("[static]", "[static]\nlevels = [0.1, 9.0]");
    let error = solve("burst", &burst).map(|_| ()).unwrap_err();
    assert!(error.contains("case.toml: level 9: no equilibrium is found beyond"), "{error}");
    assert!(error.contains("why: ") && error.contains("last_converged.vtu"), "{error}");
    let output_folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("burst/case.out");
    assert_eq!(Table::read(&output_folder.join("case.csv")).rows.len(), 1);
    assert!(vtu(&std::fs::read(output_folder.join("last_converged.vtu")).unwrap()).is_ok());
    assert!(std::fs::read_to_string(output_folder.join("case.pvd")).unwrap().contains("last_converged.vtu"));
}

#[test]
fn what_does_not_fit_is_refused_with_one_clear_error() {
    let beam = example("cantilever.toml");
    let tries = [
        ("density = 1070.0", "density = nan", "line 13: region.0.density = NaN is not a finite number"),
        ("density = 1070.0", "", "missing field `density`"),
        ("density = 1070.0", "dens = 1070.0", "unknown field `dens`"),
        ("youngs_modulus = 1.0e6", "youngs_modulus = 1.0", "region.0.youngs_modulus = 1 Pa is out of range"),
        ("poissons_ratio = 0.3", "poissons_ratio = 0.5", "`region.0.poissons_ratio` cannot be followed"),
        ("name = \"beam\"", "name = \"bean\"", "region 0 of the case (`bean`) is not in the mesh"),
        ("\"neo_hookean\"", "\"steel\"", "there is no material `steel`"),
        ("unit = \"mm\"", "unit = \"m\"", "the mesh is 1.000e2 m long"),
        ("unit = \"mm\"", "unit = \"foot\"", "unknown variant `foot`"),
        ("file = \"cantilever.msh\"", "file = \"nowhere.msh\"", "nowhere.msh cannot be read"),
        ("file = \"cantilever.msh\"", "file = \"case.toml\"", "is of an unknown kind (.toml)"),
        ("order = \"quadratic\"", "half = true", "of the half model lies at z = -"),
        ("plane = { x = 0.0 }", "plane = { x = 0.5 }", "clamp 0 holds no node"),
        ("plane = { x = 0.0 }", "plane = { x = 0.0, y = 0.0 }", "`clamp.0` cannot be followed"),
        ("[[clamp]]\nplane = { x = 0.0 }", "", "is not sufficiently constrained"),
        ("plane = { x = 0.1 }", "plane = { x = 0.0 }", "load 0 pushes at held nodes alone"),
        ("plane = { x = 0.1 }", "plane = { x = 0.0999 }", "load 0 meets nothing"),
        ("plane = { x = 0.1 }", "near = [0.1, 0, 0]", "`load.0` cannot be followed"),
        ("levels = [0.1, 1.0]", "levels = []", "`static.levels` cannot be followed"),
        ("[static]", "[dynamic]\nduration = 1.0\nstep = 0.3\n[static]", "`static` cannot be followed"),
        ("plane = { x = 0.1 }\ntraction", "near = [0.1, 1, 0]\nforce", "load 0 is 99"),
        ("near = [0.1, 0.0, 0.0]", "near = [0.2, 0.0, 0.0]", "`tip` is 100.000 mm off the body"),
        ("[static]", "[[chamber]]\nnumber = 0\n[static]", "chamber 0 of the case is no chamber of the mesh"),
    ];
    for (number, (old, new, expected)) in tries.into_iter().enumerate() {
        assert!(beam.contains(old), "{old}");
        let error = solve(&format!("refused_{number}"), &beam.replacen(old, new, 1)).map(|_| ()).unwrap_err();
        assert!(error.contains(expected), "{new}: {error}");
        assert!(error.contains("why: ") && error.contains("do:  "), "{error}");
        assert!(error.starts_with('/') && (error.contains("case.toml") || error.contains(".msh")), "no file: {error}");
    }
}

#[test]
fn a_case_and_a_mesh_that_do_not_match_are_both_named() {
    let beam = example("cantilever.toml");
    for (old, new) in [("name = \"beam\"", "name = \"bean\""), ("plane = { x = 0.0 }", "plane = { x = 0.5 }")] {
        let error = solve("both_named", &beam.replacen(old, new, 1)).map(|_| ()).unwrap_err();
        assert!(
            error.contains("case.toml: ") && error.contains("mesh: ") && error.contains("cantilever.msh"),
            "{error}"
        );
    }
}

#[test]
fn a_region_without_material_is_named() {
    let wrong_tag = BALL.replacen("[[region]]\ntag = 3", "[[region]]\ntag = 4", 1);
    let error = solve("other_region", &wrong_tag).map(|_| ()).unwrap_err();
    assert!(
        error.contains("region 1 of the case (tag 4) is not in the mesh") && error.contains("`soft`, tag 7"),
        "{error}"
    );
    let end = BALL.find("[[region]]\ntag = 3").unwrap();
    let begin = BALL.find("[[clamp]]").unwrap();
    let error = solve("no_material", &(BALL[..end].to_owned() + &BALL[begin..])).map(|_| ()).unwrap_err();
    assert!(error.contains("region `stiff`, tag 3 has 0 materials"), "{error}");
}

#[test]
fn a_second_case_is_not_mixed_into_the_frames_of_another() {
    let output_folder = folder("shared-out");
    std::fs::write(output_folder.join("beam.pvd"), "").unwrap();
    let refused = run(&here("examples/cantilever.toml"), Some(&output_folder), true, None).unwrap_err().to_string();
    assert!(refused.contains("another case, beam.pvd") && refused.contains("--out"), "{refused}");
    assert_eq!(std::fs::read_dir(&output_folder).unwrap().count(), 1, "nothing is added");
}

#[test]
fn an_interrupt_ends_a_case() {
    let output_folder = std::env::temp_dir().join(format!("simulate-interrupted-{}", std::process::id()));
    let case = here("examples/cantilever.toml");
    let ended = run(&case, Some(&output_folder), true, Some(std::sync::Arc::new(|| true))).unwrap_err().to_string();
    assert!(ended.contains("interrupt"), "{ended}");
    run(&case, Some(&output_folder), true, Some(std::sync::Arc::new(|| false))).unwrap();
    std::fs::remove_dir_all(&output_folder).unwrap();
}
