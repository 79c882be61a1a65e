//! The parametric tail through its surfaces: the mesher must find the tail's own volumes, chambers and marker points.

use mesh::{BODY, SPINE, Settings, Skin, Surface, embed, mesh, quadratic, stl};
use tail_cad::{Resolution, Tail};

const EDGE: f64 = 4e-3;

/// Both solids of the nine-chamber tail, through single precision as a file would bring them.
fn tail() -> (Surface, Surface) {
    let (body, spine) = Tail::nine_chambers().solids(2e-3).expect("the tail is drawn");
    let file = |s: &Surface| stl::read(&stl::write(s, 1e-3, "a tail"), 1e-3).expect("what was written is read");
    (file(&body), file(&spine))
}

#[test]
fn the_tail_from_its_surfaces_has_its_chambers_and_volumes() {
    let (body, spine) = tail();
    for edge in [EDGE, 2.5e-3] {
        let (made, report) = mesh(&body, &spine, &Settings::new(edge)).unwrap();
        assert_eq!(made.nonconformity(), None);
        assert_eq!(report.chambers.len(), 2);
        assert!((report.volume_body / report.volume_body_stl - 1.0).abs() < 0.01);
        assert!((report.volume_spine / report.volume_spine_stl - 1.0).abs() < 0.01);
        assert!(report.min_dihedral_deg > 1.5, "{}", report.min_dihedral_deg);
        assert!(report.hausdorff_m < 0.4e-3, "{}", report.hausdorff_m);
        assert!(made.nodes.iter().all(|n| n[2] >= 0.0));
    }
}

#[test]
fn the_tail_from_its_surfaces_agrees_with_its_own_mesh() {
    let (body, spine) = tail();
    let nine = Tail::nine_chambers();
    let own = nine.mesh(&Resolution::even(&nine, 2.5e-3)).unwrap();
    let (made, _) = mesh(&body, &spine, &Settings::new(2.5e-3)).unwrap();
    let same = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 0.01, "{a} against {b}");
    same(own.region_volume(BODY), made.region_volume(BODY));
    same(own.region_volume(SPINE), made.region_volume(SPINE));
    (0..2).for_each(|k| same(own.chamber_volume(k), made.chamber_volume(k)));
    assert_ne!(own.nodes.len(), made.nodes.len());
}

#[test]
fn the_same_surfaces_give_the_same_mesh() {
    let (body, spine) = tail();
    let set = Settings::new(EDGE);
    assert_eq!(mesh(&body, &spine, &set).unwrap(), mesh(&body, &spine, &set).unwrap());
}

#[test]
fn a_half_model_has_half_the_volume_and_is_closed_by_the_cut() {
    let (body, spine) = tail();
    let (half, _) = mesh(&body, &spine, &Settings::new(EDGE)).unwrap();
    let (whole, report) = mesh(&body, &spine, &Settings { use_symmetry: false, ..Settings::new(EDGE) }).unwrap();
    assert!(half.half && !whole.half && !report.half);
    assert_eq!(whole.nonconformity(), None);
    for region in [BODY, SPINE] {
        let ratio = 2.0 * half.region_volume(region) / whole.region_volume(region);
        assert!((ratio - 1.0).abs() < 0.005, "{ratio}");
    }
    assert!(half.skin.iter().any(|f| f.on == Skin::Symmetry));
    assert!(whole.skin.iter().all(|f| f.on != Skin::Symmetry));
}

#[test]
fn a_marker_on_the_back_is_embedded_within_a_tenth_of_a_millimetre() {
    let (body, spine) = tail();
    let (made, _) = mesh(&body, &spine, &Settings::new(EDGE)).unwrap();
    let fine = quadratic(&made);
    for x in [40e-3, 52e-3, 64e-3] {
        let at = Tail::nine_chambers().back_point(x);
        let (spot, distance) = embed(&fine, at);
        assert!(distance < 1e-4, "{distance}");
        assert!(si::vec3::norm(si::vec3::sub(spot.at(&fine.nodes), at)) <= distance + 1e-12);
    }
}

#[test]
fn a_tail_with_one_thicker_wall_is_meshed_as_it_is() {
    let uneven = Tail { wall: [2e-3, 2.4e-3], ..Tail::nine_chambers() };
    let (body, spine) = uneven.solids(2e-3).unwrap();
    let (_, report) = mesh(&body, &spine, &Settings::new(EDGE)).unwrap();
    assert!(report.chambers[0].volume > 1.03 * report.chambers[1].volume);
}
