//! Regions of gmsh that are in no physical group, endings in upper case, and hexahedra with a named side.

use super::{example, folder, here, solve};
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

/// A bar of 100 × 10 × 6 mm in hexahedra of eight nodes, with a named side x = 0, as gmsh's file.
fn bar_of_hexahedra() -> String {
    let [nx, ny, nz] = [20, 2, 2];
    let number = |i: usize, j: usize, k: usize| 1 + i + (nx + 1) * (j + (ny + 1) * k);
    let (mut nodes, mut elements) = (Vec::new(), Vec::new());
    for (i, j, k) in (0..=nz).flat_map(|k| (0..=ny).flat_map(move |j| (0..=nx).map(move |i| (i, j, k)))) {
        nodes.push(format!("{} {} {} {}", number(i, j, k), 5 * i, 5 * j, 3 * k));
    }
    let side = |i: usize, j: usize, k: usize| {
        [number(i, j, k), number(i, j + 1, k), number(i, j + 1, k + 1), number(i, j, k + 1)]
            .map(|n| n.to_string())
            .join(" ")
    };
    for (i, j, k) in (0..nz).flat_map(|k| (0..ny).flat_map(move |j| (0..nx).map(move |i| (i, j, k)))) {
        elements.push(format!("5 2 7 1 {} {}", side(i, j, k), side(i + 1, j, k)));
        elements.extend((i == 0).then(|| format!("3 2 9 1 {}", side(i, j, k))));
    }
    let numbered: Vec<String> = elements.iter().enumerate().map(|(n, text)| format!("{} {text}", n + 1)).collect();
    format!(
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n2 9 \"root\"\n3 7 \"beam\"\n$EndPhysicalNames\n\
         $Nodes\n{}\n{}\n$EndNodes\n$Elements\n{}\n{}\n$EndElements\n",
        nodes.len(),
        nodes.join("\n"),
        numbered.len(),
        numbered.join("\n")
    )
}

#[test]
fn a_bar_of_hexahedra_is_held_by_its_named_side_and_bends_as_timoshenkos() {
    let file = folder("hexahedra_file").join("bar.msh");
    std::fs::write(&file, bar_of_hexahedra()).unwrap();
    let case =
        example("cantilever.toml").replace("file = \"cantilever.msh\"", &format!("file = \"{}\"", file.display()));
    let case = case.replace("plane = { x = 0.0 }", "surface = \"root\"").replace("order = \"quadratic\"", "");
    let (_, table) = solve("hexahedra_bar", &case).unwrap();
    assert!((table.column("tip_uz_m")[1] + 7.8e-3).abs() < 2e-4, "{:?}", table.column("tip_uz_m"));
    let linear = solve("hexahedra_linear", &case.replace("unit = \"mm\"", "unit = \"mm\"\norder = \"linear\""));
    assert!(linear.err().is_some_and(|error| error.contains("leave mesh.order away")));
}
