//! Contact of walls on the bench: the first rib of a slack side that folds meets the head, and stays out of it.
#![allow(clippy::unwrap_used)] // a panic fails the test

use mesh::Skin;
use rig::Side;
use rig::physics::{Body, BodySettings, PressureSweep, even_pressures};
use rig::settings::{Resolution, Settings};
use rig::specimen::{HiddenProperties, SHEET};
use tail_cad::Tail;

#[test]
fn the_first_rib_of_a_folded_side_stays_out_of_the_head() {
    let set = Settings::built_in();
    let own = &set.specimen["nemo"];
    let mut hidden = HiddenProperties::drawn(&set, own);
    hidden.body.stiffening = [0.1, 0.3];
    let walls = Tail { wall: [1.5e-3; 2], rib: 1.5e-3, inner_wall: 0.4e-3, top_wall: 1.5e-3, ..Tail::nine_chambers() };
    let tail = Tail { sheet: 0.6e-3, slot_share: 0.5, first_longer: 0.0, ..walls };
    let resolution = Resolution { edge: 0.006, per_chamber: 1, per_rib: 1, hexahedra: None };
    let laws = [&*set.material[&own.body].law, &*set.material[SHEET].law];
    let body = Body::new(&tail, &BodySettings { resolution: &resolution, clamp: own.clamp, laws }, &hidden).unwrap();
    let sweep = PressureSweep::solve_sweep(&body, Side::Left, &even_pressures(2.4e4, 8), &|| ()).unwrap();
    let ([head, rib], rest) = (tail.chamber(0), &body.mesh.nodes);
    // the slack side is that of negative y
    let faces = body.mesh.skin.iter().filter(|face| matches!(face.on, Skin::Chamber(_)));
    let far = |node: &usize| rest[*node][0] > 0.5 * (head + rib) && rest[*node][1] < 0.0;
    let nodes: Vec<usize> = faces.flat_map(|face| face.nodes()).map(|&node| node as usize).filter(far).collect();
    let distance = |shape: &Vec<f64>| nodes.iter().map(|n| rest[*n][0] + shape[3 * n] - head).fold(1.0, f64::min);
    let distances: Vec<f64> = sweep.shapes.iter().map(distance).collect();
    let nearest = distances.iter().copied().fold(1.0, f64::min);
    assert!(distances[0] > 3e-3 && nearest > 0.0 && nearest < 5e-4, "{distances:?}");
}

#[test]
fn every_tail_of_the_paper_profile_as_it_was_cast_has_hexahedra_with_a_film_where_silicone_and_sheet_do_not_adhere() {
    let set = Settings::built_in();
    let profile = &set.profile["paper"];
    let resolution = Resolution { hexahedra: Some(1.25), ..profile.resolution };
    for specimen in rig::specimens::ALL.iter().filter(|specimen| profile.specimens.contains(&specimen.name.to_string()))
    {
        let own = &set.specimen[&*specimen.name];
        let laws = [&*set.material[&own.body].law, &*set.material[SHEET].law];
        let settings = BodySettings { resolution: &resolution, clamp: own.clamp, laws };
        let body = Body::new(&(specimen.tail)(), &settings, &HiddenProperties::drawn(&set, own)).unwrap();
        assert_eq!((body.mesh.elements.name(), body.mesh.half), ("hexahedra", true), "{}", specimen.name);
        assert_eq!(body.mesh.regions.contains(&tail_cad::FILM), set.casting.unbonded > 0, "{}", specimen.name);
    }
}
