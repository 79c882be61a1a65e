//! Clamps by a surface that the mesh file names.

use super::solve;

/// The bar of the mesh's tests, 40 × 10 × 10 mm, held at one end and bent by its weight.
const BAR: &str = r#"
gravity = [0.0, 0.0, -9.81]
[mesh]
file = "bar_legacy.msh"
unit = "mm"
[[region]]
name = "silicone"
material = "neo_hookean"
youngs_modulus = 1e5
poissons_ratio = 0.45
density = 1070.0
[[clamp]]
plane = { x = 0.0 }
[static]
[output]
node = [{ name = "tip", near = [0.04, 0.0, 0.0] }]
"#;

fn tip(clamp: &str) -> Result<f64, String> {
    let case = BAR.replace("plane = { x = 0.0 }", clamp);
    solve("surface", &case).map(|(_, table)| table.column("tip_uz_m")[0])
}

#[test]
fn a_clamp_by_a_named_surface_is_the_clamp_by_its_plane() {
    let plane = tip("plane = { x = 0.0 }").unwrap();
    for clamp in ["surface = \"holder\"", "surface = \"11\""] {
        assert_eq!(tip(clamp).unwrap(), plane);
    }
    // held at both ends it sags far less
    assert!(plane < -1e-4 && tip("surface = \"both ends\"").unwrap().abs() < 0.05 * plane.abs(), "{plane}");
}

#[test]
fn a_surface_that_the_mesh_does_not_name_is_refused_with_those_that_it_does() {
    let refused = tip("surface = \"clamp\"").unwrap_err();
    assert!(refused.contains("no surface `clamp`") && refused.contains("`holder` (11), `both ends` (12)"), "{refused}");
    let two = tip("surface = \"holder\"\nplane = { x = 0.0 }").unwrap_err();
    assert!(two.contains("one of plane, box and surface"), "{two}");
}

/// The bar pulled by a grip on its other end by a quarter of its length.
fn pulled(grip: &str) -> Result<super::Table, String> {
    let head = BAR.split("[static]").next().unwrap().replace("gravity = [0.0, 0.0, -9.81]", "");
    let end = format!("{head}[[clamp]]\nplane = {{ x = 0.04 }}\n{grip}\n[static]\nlevels = [0.5, 1.0]\n");
    let held = end.replace("plane = { x = 0.0 }", "plane = { x = 0.0 }\nname = \"holder\"");
    solve("pulled", &held).map(|(_, table)| table)
}

#[test]
fn a_displaced_clamp_pulls_and_both_grips_write_opposite_forces() {
    let table = pulled("displacement = [0.01, 0.0, 0.0]\nname = \"grip\"").unwrap();
    let [grip, holder] = ["grip_fx_n", "holder_fx_n"].map(|name| table.column(name));
    // E A ε between grips that hold a third of the length: above that of a bar that thins everywhere, by less than a quarter
    let thin = 1e5 / 3.0 * (1.25 - 1.25_f64.powi(-2)) * 1e-4;
    assert!(grip[1] > thin && grip[1] < 1.25 * thin && grip[0] > 0.5 * grip[1], "{grip:?} {thin}");
    for (a, b) in grip.iter().zip(&holder) {
        assert!((a + b).abs() < 1e-6 * a, "{a} {b}");
    }
    let across = table.column("grip_fy_n");
    assert!(across.iter().all(|force| force.abs() < 1e-3 * grip[0]), "{across:?}");
}

#[test]
fn a_clamp_that_moves_where_it_cannot_is_refused() {
    let refused = |grip: &str| pulled(grip).map(|_| ()).unwrap_err();
    let along = refused("displacement = [0.0, 0.01, 0.0]\nhold = [\"x\"]");
    assert!(along.contains("clamp.1.displacement") && along.contains("along axes that it holds"), "{along}");
    let named = refused("displacement = [0.01, 0.0, 0.0]\nname = \"holder\"");
    assert!(named.contains("names must be unique"), "{named}");
    let twice = refused(
        "displacement = [0.01, 0.0, 0.0]\n[[clamp]]\nbox = { low = [0.03, 0.0, 0.0], high = [0.05, 1.0, 1.0] }",
    );
    assert!(twice.contains("clamp 2 moves node") && twice.contains("one displacement along each axis"), "{twice}");
}
