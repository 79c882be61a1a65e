//! Cases whose mesh is made of STL files.

use super::{folder, solve};

#[test]
fn two_surfaces_are_meshed_and_simulated() {
    let tests = folder("surfaces_cad");
    let (body, spine) = tail_cad::Tail::nine_chambers().solids(3e-3).unwrap();
    std::fs::write(tests.join("body.stl"), mesh::stl::write(&body, 1e-3, "body")).unwrap();
    std::fs::write(tests.join("spine.stl"), mesh::stl::write(&spine, 1e-3, "spine")).unwrap();
    let region = |name: &str, modulus: f64| {
        format!(
            "[[region]]\nname = \"{name}\"\nmaterial = \"corotated\"\nyoungs_modulus = {modulus:e}\npoissons_ratio = 0.3\n\
             density = 1070.0\n"
        )
    };
    let quoted_path = |name: &str| format!("\"{}\"", tests.join(name).display());
    let case = format!(
        "[mesh]\nbody = {}\nspine = {}\nedge = 0.008\nunit = \"mm\"\nhalf = true\norder = \"linear\"\n{}{}\
         [[clamp]]\nplane = {{ x = 0.0 }}\n[[chamber]]\nnumber = 0\npressure = 1e3\n[static]\n",
        quoted_path("body.stl"),
        quoted_path("spine.stl"),
        region("body", 2e5),
        region("spine", 1e9),
    );
    let (summary, table) = solve("surfaces", &case).unwrap();
    assert!(summary.dofs > 1000);
    assert!(table.column("chamber_0_volume_m3")[0] > 1e-6);
    // tetrahedra lock in the walls: they swell less, the more so the coarser they are
    let swelling = |name: &str, elements: &str, edge: &str| {
        let case = case.replace("edge = 0.008", edge).replace("order = \"linear\"", elements);
        let (_, table) = solve(name, &case.replace("[static]", "[static]\nlevels = [1e-9, 1.0]")).unwrap();
        let volume = table.column("chamber_0_volume_m3");
        (volume[0], volume[1] / volume[0] - 1.0)
    };
    let hexahedra = swelling("surfaces_hexahedra", "elements = \"hexahedra\"", "edge = 0.008");
    let [coarse, fine] =
        ["edge = 0.008", "edge = 0.004"].map(|edge| swelling("surfaces_tetrahedra", "elements = \"tetrahedra\"", edge));
    // who says nothing gets the hexahedra
    assert_eq!(swelling("surfaces_free", "order = \"quadratic\"", "edge = 0.008"), hexahedra);
    assert!((hexahedra.0 / fine.0 - 1.0).abs() < 0.01, "{hexahedra:?} {fine:?}");
    assert!(coarse.1 < fine.1 && fine.1 < hexahedra.1 && hexahedra.1 < 1.1 * fine.1, "{hexahedra:?} {fine:?}");
}

#[test]
fn elements_through_a_wall_are_asked_of_the_general_method_alone() {
    let tests = folder("detail");
    let plate = mesh::Surface {
        points: (0..8).map(|n| [0, 1, 2].map(|k| if n >> k & 1 == 0 { 0.0 } else { [0.02, 0.01, 0.002][k] })).collect(),
        faces: [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
            .iter()
            .flat_map(|&[a, b, c, d]: &[u32; 4]| [[a, b, c], [a, c, d]])
            .collect(),
    };
    std::fs::write(tests.join("plate.stl"), mesh::stl::write(&plate, 1e-3, "plate")).unwrap();
    let solved = |name: &str, keys: &str| {
        let case = format!(
            "gravity = [0.0, 0.0, -9.81]\n[mesh]\nbody = \"{}\"\nedge = 0.005\nunit = \"mm\"\n{keys}\n[[region]]\n\
             material = \"linear\"\nyoungs_modulus = 1e6\npoissons_ratio = 0.3\ndensity = 1070.0\n\
             [[clamp]]\nplane = {{ x = 0.0 }}\n[static]\n",
            tests.join("plate.stl").display()
        );
        solve(name, &case).map(|(summary, _)| summary.dofs)
    };
    let hexahedra = solved("no_chamber", "elements = \"hexahedra\"").unwrap();
    assert!(solved("no_chamber", "").unwrap() > hexahedra, "a plate has no chamber that would size hexahedra");
    let [one, two] = [1, 2].map(|layers| solved("detail_case", &format!("detail.layers = {layers}")).unwrap());
    assert!(two > 4 * one, "{one} {two}");
    for keys in
        ["method = \"columns\"\ndetail.layers = 2", "elements = \"auto\"\ndetail.layers = 2", "detail.layers = 0"]
    {
        assert!(solved("detail_refused", keys).unwrap_err().to_string().contains("mesh.detail"), "{keys}");
    }
}
