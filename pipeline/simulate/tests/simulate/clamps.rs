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
