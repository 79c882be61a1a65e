//! Regions of gmsh that are in no physical group, and endings in upper case.

use super::{folder, here};
use simulate::run;

/// Two bars of 40 mm end to end, the first clamped, under a shear of 10 Pa at the far end.
fn case(regions: [(&str, &str); 2]) -> String {
    let region = |(name, modulus): (&str, &str)| {
        format!(
            "[[region]]\n{name}\nmaterial = \"neo_hookean\"\nyoungs_modulus = {modulus}\npoissons_ratio = 0.45\ndensity = 1070.0\n"
        )
    };
    let regions: String = regions.into_iter().filter(|(name, _)| !name.is_empty()).map(region).collect();
    format!(
        "[mesh]\nfile = \"BARS.MSH\"\nunit = \"mm\"\n{regions}[[clamp]]\nplane = {{ x = 0.0 }}\n[[load]]\nplane = {{ x = 0.08 }}\n\
         traction = [0.0, -10.0, 0.0]\n[static]\nlevels = [1.0]\n[output]\nnode = [{{ name = \"tip\", near = [0.08, 0.0, 0.0] }}]\n"
    )
}

fn tip(test: &str, mesh: &str, case: &str) -> Result<f64, String> {
    let folder = folder(test);
    std::fs::copy(here("../mesh/tests/data").join(mesh), folder.join("BARS.MSH")).unwrap();
    std::fs::write(folder.join("case.toml"), case).unwrap();
    run(&folder.join("case.toml"), None, true, None).map_err(|diagnostic| diagnostic.to_string())?;
    Ok(super::Table::read(&folder.join("case.out/case.csv")).column("tip_uy_m")[0])
}

#[test]
fn a_volume_in_no_group_needs_a_material_of_its_own() {
    let mesh = "bars_ungrouped.msh";
    let said = tip("ungrouped", mesh, &case([("name = \"soft\"", "1.6e5"), ("", "")])).unwrap_err();
    assert!(said.contains("region `volume 2`, tag -2 has 0 materials") && said.contains("`soft`, tag 2"), "{said}");
    let soft_root =
        tip("soft_root", mesh, &case([("name = \"soft\"", "1.6e5"), ("name = \"volume 2\"", "2.0e7")])).unwrap();
    let soft_end = tip("soft_end", mesh, &case([("name = \"soft\"", "2.0e7"), ("tag = -2", "1.6e5")])).unwrap();
    // Bernoulli's beam of a soft half at the clamp bends by 7 P a³/3EI, at the end by P a³/3EI
    assert!((soft_root / soft_end - 7.0).abs() < 1.0 && soft_root < 0.0, "{soft_root} {soft_end}");
}

#[test]
fn a_group_of_which_no_element_is_left_is_not_in_the_mesh() {
    let regions = [("name = \"soft\"", "1.6e5"), ("tag = 1", "2.0e7")];
    let said = tip("lost_group", "bars_ungrouped_legacy.msh", &case(regions)).unwrap_err();
    assert!(said.contains("region 0 of the case (`soft`) is not in the mesh"), "{said}");
    assert!(said.contains("`volume 1`, tag 1; `volume 2`, tag 2"), "{said}");
}
