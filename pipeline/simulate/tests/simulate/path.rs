//! Paths by the arc-length method, end to end: a column that buckles, a finger that does not, and refused input.

use std::path::Path;

use super::{Table, assert_near, example, solve};

#[test]
fn a_column_is_followed_through_its_bifurcation() {
    let (summary, table) = solve("column", &example("column.toml")).unwrap();
    let out = Path::new(env!("CARGO_TARGET_TMPDIR")).join("column/case.out");
    let text = std::fs::read_to_string(out.join("case_critical.json")).unwrap();
    let critical: serde_json::Value = serde_json::from_str(&text).unwrap();
    let [found] = &critical.as_array().unwrap()[..] else { panic!("one critical point: {text}") };
    assert_eq!(found["kind"], "bifurcation");
    assert_eq!(found["negative_eigenvalues"], serde_json::json!([0, 1]));
    // the clamp holds the section's width too
    assert_near(found["level"].as_f64().unwrap(), 1.0, 0.01);
    assert_eq!((found["place_m"][0].as_f64(), found["frame"].as_str()), (Some(0.1), Some("critical_0000.vtu")));
    assert!(std::fs::read_to_string(out.join("critical_0000.vtu")).unwrap().contains("Name=\"mode\""));
    assert!(std::fs::read_to_string(out.join("case.pvd")).unwrap().contains("critical_0000.vtu"));
    // The elastica under 1.1 times Euler's load moves its end by 0.485 of the length.
    let (level, tip) = (table.column("level"), table.column("tip_uz_m"));
    assert_eq!((level.len(), level[level.len() - 1]), (summary.solved, 1.1));
    assert_near(tip[tip.len() - 1], -0.0485, 0.02);
    assert!(table.column("negative_eigenvalues").iter().all(|count| *count == 0.0));
    let nearest = table.column("eigenvalue_n_per_m");
    assert!(nearest.iter().all(|value| *value > 0.0) && nearest[1] < nearest[0], "{nearest:?}");
}

#[test]
fn a_path_without_critical_points_passes_the_equilibria_of_its_levels_under_gravity() {
    let case =
        example("finger.toml").replace("\"quadratic\"", "\"linear\"").replace("0.25, 0.5, 0.75, 1.0", "0.5, 1.0");
    let case = format!("gravity = [0.0, -9.81, 0.0]\n{case}");
    let (_, stepped) = solve("levels", &case).unwrap();
    let (_, path) = solve("path", &case.replace("[output]", "arc_length = {}\n[output]")).unwrap();
    let (level, tip) = (path.column("level"), path.column("tip_uy_m"));
    for (wanted, exact) in [0.5, 1.0].into_iter().zip(stepped.column("tip_uy_m")) {
        let row = level.iter().position(|at| *at == wanted).unwrap();
        assert_near(tip[row], exact, 1e-7);
    }
    assert!(level[0] == 0.0 && tip[0] < -1e-4, "it begins bent by its weight: {}", tip[0]);
    let out = Path::new(env!("CARGO_TARGET_TMPDIR")).join("path/case.out");
    assert_eq!(std::fs::read_to_string(out.join("case_critical.json")).unwrap(), "[]\n");
}

#[test]
fn a_path_that_needs_more_steps_keeps_its_points_and_says_so() {
    let short = example("column.toml").replace("\"against_mode\"", "\"against_mode\", max_steps = 2");
    let said = solve("path_steps", &short).map(|_| ()).unwrap_err();
    assert!(said.contains("the path does not reach level 1.1") && said.contains("it took 2 steps"), "{said}");
    let out = Path::new(env!("CARGO_TARGET_TMPDIR")).join("path_steps/case.out");
    assert_eq!(Table::read(&out.join("case.csv")).rows.len(), 3);
}

#[test]
fn a_path_is_refused_where_its_load_does_not_grow_in_proportion() {
    let path = "arc_length = {}\n[output]";
    let finger = example("finger.toml").replace("[output]", path);
    let tries = [
        (finger.replace("0.25, 0.5", "0.5, 0.25"), "with arc_length the levels rise from above 0"),
        (finger.replace("pressure = 8.0e3", "pressure = { ramp = { to = 8e3, seconds = 1 } }"), "is a plain number"),
        (finger.replace("pressure = 8.0e3", "pressure = 8e3\nsealed_in = 101325.0"), "chambers are fed"),
        (finger.replace("pressure = 8.0e3", "pressure = 0.0"), "the load moves nothing"),
        (finger.replace("arc_length = {}", "arc_length = { max_step = 2.0 }"), "static.arc_length.max_step = 2"),
        (finger.replace("arc_length = {}", "arc_length = { branch = \"left\" }"), "unknown variant `left`"),
    ];
    for (case, expected) in tries {
        let said = solve("path_refused", &case).map(|_| ()).unwrap_err();
        assert!(said.contains(expected) && said.contains("do:"), "{expected}: {said}");
    }
}
