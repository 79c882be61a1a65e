//! Budgets: a search for an equilibrium that there is none of ends at its limits, with the last state on the disk.

use simulate::{Budget, RunOptions, run_with};

use super::{example, folder, here, solve};

/// A finger at a hundred times its pressure.
fn burst(keys: &str) -> String {
    example("finger.toml").replace("8.0e3", "8.0e5").replace("[static]", &format!("[static]\n{keys}"))
}

#[test]
fn keys_of_a_case_end_its_search() {
    let far = burst("levels = [0.01, 1.0]\nmax_iterations = 20").replace("\nlevels = [0.25, 0.5, 0.75, 1.0]", "");
    let said = solve("budget_keys", &far).map(|_| ()).unwrap_err();
    assert!(said.contains("level 1: no equilibrium is found beyond level 0.010000"), "{said}");
    assert!(said.contains("it took 20 Newton iterations, the limit max_iterations"), "{said}");
    assert!(said.contains("last converged state: "), "{said}");
    let said = solve("budget_seconds", &burst("timeout = 0.001")).map(|_| ()).unwrap_err();
    assert!(said.contains("the limit timeout"), "{said}");
    let said = solve("budget_cutbacks", &burst("max_cutbacks = 0\nload_steps = 1")).map(|_| ()).unwrap_err();
    assert!(said.contains("in load steps of 100.00 %"), "{said}");
}

#[test]
fn options_take_the_place_of_the_keys() {
    let folder = folder("budget_options");
    let mesh = format!("file = \"{}\"", here("examples/finger.msh").display());
    let page = folder.join("case.toml");
    std::fs::write(&page, burst("max_iterations = 20").replace("file = \"finger.msh\"", &mesh)).unwrap();
    let budget = Budget { max_iterations: Some(7), ..Budget::default() };
    let options = RunOptions { quiet: true, budget, ..RunOptions::default() };
    let said = run_with(&page, options).unwrap_err().to_string();
    assert!(said.contains("it took 7 Newton iterations"), "{said}");
}

#[test]
fn iterations_are_those_of_each_level_so_that_many_easy_ones_pass() {
    let easy = example("finger.toml").replace("[static]", "[static]\nmax_iterations = 20");
    let (summary, _) = solve("budget_levels", &easy).unwrap();
    assert!(summary.iterations.unwrap() > 20, "{summary:?}");
}
