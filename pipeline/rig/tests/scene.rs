//! The scene against its truth: a mark is drawn exactly where the truth says it is.
//!
//! Stands on: `rig`, `shape`. Never knows: finite elements, a film.
#![allow(clippy::unwrap_used)] // a test may fail where it stands

use lab::card::Medium;
use rig::camera::{Passing, View};
use rig::card;
use rig::scene::Canvas;
use rig::scene::paint::Mark;
use rig::scene::skin::Skin;
use rig::settings::Settings;
use rig::specimens::ALL;
use rig::studio::Studio;
use shape::tail::Resolution;
use si::{Point2, Point3};

/// Weighted middle of a canvas that was 255 before something dark was drawn.
fn middle_of_darkness(canvas: &Canvas) -> Point2 {
    let mut sums = [0.0; 3];
    for (i, level) in canvas.levels.iter().enumerate() {
        let dark = f64::from(255.0 - level);
        sums[0] += dark;
        sums[1] += dark * (i % canvas.width) as f64;
        sums[2] += dark * (i / canvas.width) as f64;
    }
    [sums[1] / sums[0], sums[2] / sums[0]]
}

/// The nodes on a circular arc of curvature `bend` (1/m) in the plane.
fn bent(nodes: &[Point3], bend: f64) -> Vec<Point3> {
    let turn = |[x, y, z]: Point3| {
        let angle = bend * x;
        let radius = 1.0 / bend - y;
        [radius * angle.sin(), 1.0 / bend - radius * angle.cos(), z]
    };
    nodes.iter().map(|x| turn(*x)).collect()
}

#[test]
fn a_drawn_mark_has_its_centroid_at_the_true_pixel_to_a_hundredth() {
    let (set, specimen) = (Settings::built_in(), &ALL[0]);
    let (own, tail) = (&set.specimen[specimen.name], (specimen.tail)());
    let resolution = Resolution { edge: 0.004, per_chamber: 1, per_rib: 1 };
    let mesh = shape::quadratic(&tail.mesh(&resolution).unwrap());
    let camera = Studio::new(&set, own.seed, own.clamp).camera;
    for (_, at) in card::marks(&tail, own) {
        let (mark, off) = Mark::paint(&mesh, at, own.marker_diameter);
        assert!(off < 5e-4, "{off} m off the skin"); // chords of a rib-long element under a round back
        for nodes in [mesh.nodes.clone(), bent(&mesh.nodes, 4.0), bent(&mesh.nodes, -9.0)] {
            let mut canvas = Canvas::filled(camera.width, camera.height, 255.0);
            let view = View { camera, water: None };
            let still = Passing::around(0.0, 1.0, &|_| nodes.clone());
            mark.draw(&mut canvas, &view, &still);
            let (drawn, truth) = (middle_of_darkness(&canvas), mark.pixel(&camera, &nodes).unwrap());
            let centre = camera.pixel(mark.at(&nodes)).unwrap();
            assert!((drawn[0] - truth[0]).hypot(drawn[1] - truth[1]) < 0.01, "{drawn:?} {truth:?}");
            assert!((centre[0] - truth[0]).hypot(centre[1] - truth[1]) < 0.2, "{centre:?} {truth:?}");
        }
    }
}

#[test]
fn the_skin_covers_the_tail_and_nothing_beside_it() {
    let (set, specimen) = (Settings::built_in(), &ALL[0]);
    let (own, tail) = (&set.specimen[specimen.name], (specimen.tail)());
    let resolution = Resolution { edge: 0.006, per_chamber: 1, per_rib: 1 };
    let mesh = shape::quadratic(&tail.mesh(&resolution).unwrap());
    let camera = Studio::new(&set, own.seed, own.clamp).camera;
    let mut canvas = Canvas::filled(camera.width, camera.height, 0.0);
    let view = View { camera, water: None };
    Skin::new(&mesh).draw(&mut canvas, &view, &Passing::around(0.0, 1.0, &|_| mesh.nodes.clone()));
    let level = |at: Point3| {
        let [u, v] = camera.pixel(at).unwrap().map(|p| p.round() as usize);
        canvas.levels[v * canvas.width + u]
    };
    let side = tail.half_width(0.03, 0.0);
    for (at, seen) in [(0.8 * side, true), (-0.8 * side, true), (1.2 * side, false), (-1.2 * side, false)] {
        assert_eq!(level([0.03, at, 0.0]) > 20.0, seen, "y = {at} m");
    }
    assert!(level([0.04, 0.0, tail.half_height(0.04)]) > level([0.04, 0.9 * side, 0.0]), "the back is the brightest");
}

#[test]
fn a_mark_that_swings_under_rippled_water_is_drawn_at_its_true_pixel_to_a_hundredth() {
    let (set, specimen) = (Settings::built_in(), &ALL[0]);
    let (own, tail) = (&set.specimen[specimen.name], (specimen.tail)());
    let mesh = shape::quadratic(&tail.mesh(&Resolution { edge: 0.006, per_chamber: 1, per_rib: 1 }).unwrap());
    let studio = Studio::new(&set, own.seed, own.clamp);
    let film = studio.set(Medium::Water, "test");
    let (_, at) = card::marks(&tail, own)[1];
    let (mark, _) = Mark::paint(&mesh, at, own.marker_diameter);
    let swing = |t: f64| bent(&mesh.nodes, 8.0 * (25.0 * t).sin() + 1e-6);
    for frame in 0..6 {
        let by = Passing::around(0.1 + f64::from(frame) / 60.0, 1.0 / 60.0, &swing);
        let mut canvas = Canvas::filled(studio.camera.width, studio.camera.height, 255.0);
        mark.draw(&mut canvas, &film.view, &by);
        let (drawn, truth) = (middle_of_darkness(&canvas), mark.seen(&film.view, &by).unwrap());
        assert!((drawn[0] - truth[0]).hypot(drawn[1] - truth[1]) < 0.01, "{drawn:?} {truth:?}");
        let dry = mark.pixel(&studio.camera, by.now()).unwrap();
        assert!((dry[0] - truth[0]).hypot(dry[1] - truth[1]) > 0.5, "water must matter: {dry:?} {truth:?}");
    }
}
