//! Dead loads: pressure normal to walls at rest, and forces from a table.

use super::{assert_near, example, folder, solve};

#[test]
fn a_dead_pressure_on_a_plane_end_is_the_traction_against_its_normal() {
    let beam = example("cantilever.toml").replace("levels = [0.1, 1.0]", "levels = [1.0]");
    let pressed = |load: &str| {
        let case = beam.replace("traction = [0.0, 0.0, -70.0]", load);
        assert_ne!(case, beam);
        solve("dead", &case).unwrap().1.column("tip_ux_m")[0]
    };
    let (pressure, traction) = (pressed("pressure = 60.0"), pressed("traction = [-60.0, 0.0, 0.0]"));
    assert!(pressure < 0.0 && (pressure / traction - 1.0).abs() < 1e-9, "{pressure} and {traction}");
}

#[test]
fn a_dead_pressure_in_a_chamber_is_the_following_one_while_the_body_hardly_moves() {
    let finger = example("finger.toml");
    let (before, rest) = finger.split_once("[[chamber]]").unwrap();
    let (_, after) = rest.split_once("[static]").unwrap();
    let tip = |load: &str, levels: &str| {
        let solved = format!("{before}{load}\n\n[static]{after}");
        let line = solved.lines().find(|line| line.starts_with("levels")).unwrap().to_owned();
        solve("chamber", &solved.replace(&line, levels)).unwrap().1
    };
    let inside = rest.lines().find(|line| line.starts_with("inside")).unwrap();
    let [dead, following] = ["[[load]]", "[[chamber]]"].map(|table| format!("{table}\n{inside}\npressure = 8000.0"));
    let apart = |levels: &str| {
        let [a, b] = [&dead, &following].map(|load| tip(load, levels).column("tip_uy_m")[0]);
        (a / b - 1.0).abs()
    };
    let (small, large) = (apart("levels = [0.001]"), apart("levels = [1.0]"));
    // both are linear in the load to first order, and apart by the rotation and growth of the walls
    assert!(small < 5e-3 && large > 20.0 * small, "{small} and {large}");
}

#[test]
fn forces_of_a_table_are_those_at_the_nodes_that_it_names() {
    let beam = example("cantilever.toml").replace("levels = [0.1, 1.0]", "levels = [1.0]");
    let load = "plane = { x = 0.1 }\ntraction = [0.0, 0.0, -70.0]";
    let table = |text: &str| {
        let file = folder("table").join("forces.csv");
        std::fs::write(&file, text).unwrap();
        solve("of_table", &beam.replace(load, &format!("table = \"{}\"", file.display())))
    };
    let point = beam.replace(load, "near = [0.1, 0, 0]\nforce = [0, 0, -4e-3]");
    let tip = solve("of_point", &point).unwrap().1.column("tip_uz_m")[0];
    let halves = "x_m,y_m,z_m,fx_n,fy_n,fz_n\n0.1,0,0,0,0,-1e-3\n0.1,0,0,0,0,-3e-3\n";
    assert_near(table(halves).unwrap().1.column("tip_uz_m")[0], tip, 1e-9);
    let refused = |text: &str, said: &str| {
        let error = table(text).map(|_| ()).unwrap_err();
        assert!(error.contains(said), "{error}");
    };
    refused("node,fx_n,fy_n,fz_n\n99999999,0,0,1\n", "line 2 of its table, names node 99999999");
    refused("node,fx_n,fy_n,fz_n\n1,0,0,much\n", "forces.csv, line 2");
    refused("x_m,y_m,fx_n,fy_n,fz_n\n1,0,0,0,1\n", "has the columns node,fx_n,fy_n,fz_n or x_m");
}
