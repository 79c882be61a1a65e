//! A synthetic inflation: a hollow box of known modulus comes back from its own simulated recording.

use std::path::{Path, PathBuf};

use mesh::Surface;
use si::Point3;

use super::body::Meshed;
use super::fits::{End, Prediction, Row};
use super::hold::Course;
use super::recorded::{Features, Recorded};
use super::{Page, Report, run};
use crate::{IdentifiedMaterial, IdentifiedMaterials};

/// A box of 60 × 20 × 20 mm with a cavity beside its axis, m.
pub(crate) fn hollow() -> Surface {
    let block = |low: Point3, high: Point3, outward: bool| {
        let at = |k: usize| [0, 1, 2].map(|axis| if (k >> axis) & 1 == 1 { high[axis] } else { low[axis] });
        let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let faces = sides.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]);
        let turned = faces.map(|[a, b, c]: [u32; 3]| if outward { [a, b, c] } else { [a, c, b] });
        ((0..8).map(at).collect::<Vec<_>>(), turned.collect::<Vec<_>>())
    };
    let (mut points, mut faces) = block([0.0; 3], [0.06, 0.02, 0.02], true);
    let (inner, of_inner) = block([0.01, 0.003, 0.004], [0.05, 0.009, 0.016], false);
    faces.extend(of_inner.into_iter().map(|face| face.map(|k| k + 8)));
    points.extend(inner);
    Surface { points, faces }
}

pub(crate) const PAGE: &str = r#"
test = "inflation"
name = "box"
case = "case.toml"
material = "bar"
folders = ["recordings"]
along = "y"
held = 0.1
rise = 0.05
early = [0.2, 0.3]
late = 0.1
[[recording]]
name = "step"
files = ["step.csv"]
pressure = 6e3
hold = [0.2, 0.8]
fitted = true
[[marker]]
names = ["tip"]
at = [0.06, 0.02, 0.01]
on = [0.06, 0.02, 0.01]
compared = true
[[marker]]
names = ["base_1"]
at = [0.0, 0.0, 0.0]
[[marker]]
names = ["base_2"]
at = [0.0, 0.02, 0.0]
[[marker]]
names = ["base_3"]
at = [0.0, 0.0, 0.02]
"#;

pub(crate) const CASE: &str = r#"
[mesh]
body = "box.stl"
unit = "mm"
edge = 0.01
[[region]]
material = "yeoh"
youngs_modulus = 1e5
poissons_ratio = 0.45
density = 1070.0
[[clamp]]
plane = { x = 0.0 }
[[chamber]]
number = 0
pressure = 6e3
[dynamic]
duration = 1.0
adaptive = { tolerance = 1e-4, shortest = 1e-3, longest = 0.1 }
scheme = "implicit_euler"
"#;

const MATERIALS: &str = r#"
supported = "springpot"
[[law]]
name = "springpot"
youngs_modulus = 2.7e5
stiffening = [0.0, 0.0]
mass_damping = 0.0
stiffness_damping = 1e-3
branch = [[0.2, 0.1]]
"#;

/// Two ramps, each with a hold.
const HISTORY: &str = "pressure = { table = { times = [0.0, 0.05, 0.15, 0.25], values = [1e3, 3e3, 3e3, 6e3] } }";

/// A folder with a page, a case, a surface and the material of the box.
fn folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("inflation-{name}-{}", std::process::id()));
    std::fs::create_dir_all(folder.join("recordings")).unwrap();
    std::fs::write(folder.join("recordings/box.stl"), mesh::stl::write(&hollow(), 1e-3, "box")).unwrap();
    let files = [("page.toml", PAGE), ("case.toml", CASE), ("real_bar_materials.toml", MATERIALS)];
    files.into_iter().for_each(|(file, text)| std::fs::write(folder.join(file), text).unwrap());
    folder
}

/// Records the box of modulus `ratio` × that of the material, in a camera's frame that is turned about x.
fn record(folder: &Path, ratio: f64) {
    record_with(folder, (ratio, 0.0), 0);
}

/// The same of one recording, with so much of the pressure missing at first (Pa).
fn record_with(folder: &Path, (ratio, missing): (f64, f64), recording: usize) {
    let page = Page::read(&folder.join("page.toml")).unwrap();
    let case = simulate::case::read(&folder.join("case.toml")).unwrap();
    let body = Meshed::new(&page, &case, &folder.join("recordings"), (1.0, folder)).unwrap();
    let source = IdentifiedMaterials::read(&folder.join("real_bar_materials.toml")).unwrap();
    let is = source.law(None).unwrap().clone();
    let is = IdentifiedMaterial { youngs_modulus: ratio * is.youngs_modulus, ..is };
    let course = body.motion(&is, (&page.recording[recording], &page.supply(missing)), 0.7).unwrap();
    assert!(course.burst.is_none());
    let (times, tip): (Vec<f64>, Vec<f64>) = course.tip.into_iter().unzip();
    let mut text = "time_s,marker,x_m,y_m,z_m\n".to_owned();
    for frame in 0..90 {
        let time = f64::from(frame) / 100.0;
        // ambient pressure until the hold begins
        let moved =
            if time < 0.2 { 0.0 } else { crate::free_vibration::fitting::interpolate_series(&times, &tip, time - 0.2) };
        for marker in &page.marker {
            let ([x, y, z], tip) = (marker.at, if marker.compared { moved } else { 0.0 });
            text += &format!("{time:.4},{},{x:.9},{:.9},{:.9}\n", marker.names[0], -z, y + tip);
        }
    }
    std::fs::write(folder.join("recordings").join(&page.recording[recording].files[0]), text).unwrap();
}

#[test]
fn a_known_modulus_comes_back_from_a_simulated_inflation() {
    let folder = folder("known");
    record(&folder, 0.8);
    let (report, out) = run(&folder, &folder.join("page.toml"), Some(&folder)).unwrap();
    let fitted = report.rows.iter().find(|row| row.name == "modulus fitted").unwrap();
    assert!((fitted.modulus_ratio / 0.8 - 1.0).abs() < 5e-3, "{}", fitted.modulus_ratio);
    let features = fitted.predictions[0].features.unwrap();
    let creep_error = features.creep() - report.recorded[0].features.creep();
    assert!(creep_error.abs() < 5e-3, "{creep_error}");
    // the unfitted material is stiffer, and moves less
    assert!(report.rows[0].predictions[0].features.unwrap().early.abs() < features.early.abs());
    let table = std::fs::read_to_string(out.join("real_box.csv")).unwrap();
    assert!(table.contains("modulus fitted") && report.to_string().contains("creep over the hold"));
    let metrics = std::fs::read_to_string(out.join("metrics.json")).unwrap();
    assert!(metrics.contains("real.box.step.creep_error_points"));
    std::fs::remove_dir_all(&folder).unwrap();
}

/// Relaxation as the isochronous modulus and no inertia, against the motion with both.
#[test]
fn a_held_step_moves_the_tip_as_the_motion_does() {
    let folder = folder("held");
    let page = Page::parse(PAGE, Path::new("page.toml")).unwrap();
    let case = simulate::case::read(&folder.join("case.toml")).unwrap();
    let body = Meshed::new(&page, &case, &folder.join("recordings"), (1.0, &folder)).unwrap();
    let materials: IdentifiedMaterials = toml::from_str(MATERIALS).unwrap();
    let material = IdentifiedMaterial { youngs_modulus: 1.2e5, stiffening: [0.5, 0.0], ..materials.law[0].clone() };
    let (recording, supply) = (&page.recording[0], page.supply(0.0));
    let moved = body.motion(&material, (recording, &supply), 0.6).unwrap();
    let held = body.inflate(&material, (recording, &supply), 0.6, &mut Vec::new()).unwrap();
    let [moved, held]: [Features; 2] = [moved, held].map(|course| Features::of(&page, 0.6, &course.tip));
    assert!((held.early / moved.early - 1.0).abs() < 0.01, "{held:?} {moved:?}");
    assert!((held.late / moved.late - 1.0).abs() < 2e-3 && moved.creep() > 0.01, "{held:?} {moved:?}");
    std::fs::remove_dir_all(&folder).unwrap();
}

/// A second recording, and a pressure that settles.
const SECOND: &str = r#"
[[recording]]
name = "higher"
files = ["higher.csv"]
pressure = 9e3
hold = [0.2, 0.8]
[[marker]]
names = ["tip"]"#;

#[test]
fn what_is_missing_of_the_pressure_comes_back_with_the_modulus() {
    let folder = folder("missing");
    let page = PAGE
        .replacen("[[marker]]\nnames = [\"tip\"]", SECOND.trim_start(), 1)
        .replace("rise =", "settling = 0.4\nrise =");
    std::fs::write(folder.join("page.toml"), page).unwrap();
    [0, 1].into_iter().for_each(|recording| record_with(&folder, (0.8, 1e3), recording));
    let (report, _) = run(&folder, &folder.join("page.toml"), Some(&folder)).unwrap();
    let joint: Vec<_> = report.rows.iter().filter(|row| row.used.len() == 2).collect();
    let [without, with] = [0, 1].map(|k| (joint[k].missing, joint[k].predictions[1].features.unwrap().creep()));
    let measured = report.recorded[1].features.creep();
    assert!(without.0 == 0.0 && (with.0 / 1e3 - 1.0).abs() < 0.1, "{without:?} {with:?}");
    assert!((with.1 - measured).abs() < 3e-3 && (without.1 - measured).abs() > 2e-2, "{without:?} {with:?} {measured}");
    assert!(report.to_string().contains("mbar missing at first"));
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn a_known_modulus_comes_back_from_a_history_that_begins_inflated() {
    let folder = folder("history");
    let page = PAGE.replace("pressure = 6e3", HISTORY).replace("early = [0.2, 0.3]", "early = [0.42, 0.5]");
    std::fs::write(folder.join("page.toml"), page).unwrap();
    record(&folder, 0.8);
    let (report, _) = run(&folder, &folder.join("page.toml"), Some(&folder)).unwrap();
    let fitted = report.rows.iter().find(|row| row.name == "modulus fitted").unwrap();
    assert!((fitted.modulus_ratio / 0.8 - 1.0).abs() < 5e-3, "{}", fitted.modulus_ratio);
    // the displacement is that since ambient pressure, and grows with the second ramp
    let course = &fitted.predictions[0].course.tip;
    let at = |time: f64| course.iter().find(|(t, _)| *t >= time).unwrap().1.abs();
    assert!(course[0].1.abs() > 0.0 && at(0.12) > 2.0 * course[0].1.abs() && at(0.55) > 1.5 * at(0.12), "{course:?}");
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn what_is_missing_or_does_not_fit_is_refused_with_what_to_do() {
    let folder = folder("refused");
    let said = |change: &dyn Fn(&str) -> String| {
        std::fs::write(folder.join("case.toml"), change(CASE)).unwrap();
        run(&folder, &folder.join("page.toml"), Some(&folder)).err().map(|e| e.to_string()).unwrap_or_default()
    };
    assert!(said(&str::to_owned).contains("a recording of `box` is not there"));
    record(&folder, 1.0);
    let missing = said(&|case| case.replace("box.stl", "gone.stl"));
    assert!(missing.contains("gone.stl") && missing.contains("recordings"), "{missing}");
    let two_chambers = said(&|case| format!("{case}[[chamber]]\nnumber = 1\npressure = 0.0\n"));
    assert!(two_chambers.contains("one inflated chamber") && two_chambers.contains("do:"), "{two_chambers}");
    let page = PAGE.replace("pressure = 6e3", HISTORY).replace("early = [0.2, 0.3]", "early = [0.42, 0.5]");
    std::fs::write(folder.join("page.toml"), page).unwrap();
    let fixed =
        said(&|case| case.replace("adaptive = { tolerance = 1e-4, shortest = 1e-3, longest = 0.1 }", "step = 0.1"));
    assert!(fixed.contains("adaptive steps") && fixed.contains("do:"), "{fixed}");
    std::fs::remove_file(folder.join("real_bar_materials.toml")).unwrap();
    let unidentified = said(&str::to_owned);
    assert!(unidentified.contains("study fit"), "{unidentified}");
    std::fs::remove_dir_all(&folder).unwrap();
}

/// What is printed of the page, changed, on recordings of the box as it is.
fn printed(name: &str, page: &str) -> (String, String, String) {
    let folder = folder(name);
    record(&folder, 1.0);
    std::fs::write(folder.join("page.toml"), page).unwrap();
    let (report, out) = run(&folder, &folder.join("page.toml"), Some(&folder)).unwrap();
    let read = |file: &str| std::fs::read_to_string(out.join(file)).unwrap();
    let printed = (report.to_string(), read("real_box.csv"), read("metrics.json"));
    std::fs::remove_dir_all(&folder).unwrap();
    printed
}

#[test]
fn a_fit_to_a_tip_that_moves_the_other_way_or_to_a_wall_that_balloons_is_not_printed_as_one() {
    for (name, pressure, why) in
        [("sign", "-6e3", "which no modulus turns round"), ("burst", "1e6", "balloons without bound")]
    {
        let page = PAGE.replace("pressure = 6e3", &format!("pressure = {pressure}"));
        let (text, table, metrics) = printed(name, &page);
        let line = text.lines().find(|line| line.starts_with("modulus fitted to step")).unwrap();
        assert_eq!(line.split(", walls").next(), Some("modulus fitted to step: no fit"), "{text}");
        let warning = "warning: `modulus fitted` is no fit: the ";
        assert!(text.contains(warning) && text.contains(why) && text.contains("step.csv"), "{text}");
        assert!(table.contains("\"modulus fitted\",step,,,") && table.contains(warning), "{table}");
        assert!(
            !text.contains("NaN") && !table.contains("NaN") && metrics.contains("not predicted"),
            "{text}{metrics}"
        );
    }
}

#[test]
fn a_recording_in_which_nothing_moves_is_refused_by_its_file() {
    let folder = folder("still");
    record(&folder, 1.0);
    let place = folder.join("recordings/step.csv");
    let text = std::fs::read_to_string(&place).unwrap();
    let rest: Vec<&str> = text.lines().filter(|line| line.starts_with("0.0000,tip")).collect();
    let [_, at] = rest[0].splitn(2, ',').collect::<Vec<_>>()[..] else { panic!("a line has a time") };
    let still = |line: &str| match line.split_once(',') {
        Some((time, tip)) if tip.starts_with("tip") => format!("{time},{at}\n"),
        _ => format!("{line}\n"),
    };
    std::fs::write(&place, text.lines().map(still).collect::<String>()).unwrap();
    let refused = run(&folder, &folder.join("page.toml"), Some(&folder)).err().unwrap().to_string();
    std::fs::remove_dir_all(&folder).unwrap();
    assert!(refused.contains("step.csv: the tip does not move in `step`"), "{refused}");
}

/// The end of a fit.
fn end(at: [f64; 3], next_step: f64) -> Option<End> {
    Some(End { at, free: 3, next_step })
}

#[test]
fn an_estimate_on_an_end_of_its_range_and_a_fit_that_did_not_converge_are_warned_of() {
    let with = |end: Option<End>| {
        let mut report = walls(&[(None, 10.0)]);
        (report.rows[0].end, report.rows[0].used) = (end, vec![0]);
        super::warnings::warnings(&report)
    };
    assert!(with(end([0.1, 0.5, 1.0], 1e-4)).is_empty());
    let on_bounds = with(end([0.1, -0.2, 8.0], 1e-4));
    assert!(on_bounds[0].contains("C20/C10 of `` lies on an end of its range, -0.2 to 4"), "{on_bounds:?}");
    assert!(on_bounds[1].contains("missing pressure") && on_bounds.len() == 2, "{on_bounds:?}");
    let unfinished = with(end([1.2, 0.5, 1.0], 0.3));
    assert!(unfinished.len() == 1 && unfinished[0].contains("did not converge"), "{unfinished:?}");
}

/// A report of one recording that moves by 10 mm, of bodies whose walls (mm) let it move by so many mm.
fn walls(moved: &[(Option<f64>, f64)]) -> Report {
    let materials: IdentifiedMaterials = toml::from_str(MATERIALS).unwrap();
    let material = materials.law(None).unwrap().clone();
    let features = |early: f64| Features { early: 1e-3 * early, late: 1e-3 * early };
    let row = |(wall, early): &(Option<f64>, f64)| Row {
        name: String::new(),
        modulus_ratio: 1.0,
        material: material.clone(),
        missing: 0.0,
        used: Vec::new(),
        end: None,
        wall: wall.map(|wall| 1e-3 * wall),
        predictions: vec![Prediction {
            course: Course { tip: Vec::new(), burst: None },
            features: Some(features(*early)),
        }],
    };
    Report {
        page: Page::parse(PAGE, Path::new("page.toml")).unwrap(),
        recorded: vec![Recorded { tip: si::Series::new(0.0, 1.0, vec![0.0; 2]).unwrap(), features: features(10.0) }],
        rows: moved.iter().map(row).collect(),
        left_out: vec![Vec::new()],
    }
}

#[test]
fn the_wall_that_explains_a_displacement_is_between_those_that_let_it_move_more_and_less() {
    // the logarithm is linear: 20 mm at 2 mm and 5 mm at 3 mm are 10 mm at 2.5 mm, and 40 mm are 10 mm at two thirds of the way
    let wall = |moved: &[(Option<f64>, f64)]| walls(moved).explaining_wall(0).map(|wall| (1e9 * wall).round() * 1e-6);
    assert_eq!(wall(&[(Some(3.0), 5.0), (Some(2.0), 20.0)]), Some(2.5));
    assert_eq!(wall(&[(Some(1.0), 80.0), (Some(2.0), 40.0), (Some(3.5), 5.0)]), Some(3.0));
    assert_eq!(wall(&[(Some(2.0), 20.0), (None, 5.0)]), None, "a wall that is not known");
    assert_eq!(wall(&[(Some(2.0), 20.0), (Some(3.0), 12.0)]), None, "no wall encloses it");
    assert_eq!(wall(&[(Some(2.0), 20.0), (Some(3.0), -5.0)]), None, "the other way");
}
