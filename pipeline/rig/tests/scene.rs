//! The rendered scene against its ground truth.
#![allow(clippy::unwrap_used)] // a panic fails the test

use lab::card::Medium;
use rig::camera::{FrameMotion, View};
use rig::card;
use rig::renderer::Renderer;
use rig::scene::Canvas;
use rig::scene::mark::Mark;
use rig::scene::skin::Skin;
use rig::settings::Settings;
use rig::specimens::ALL;
use si::{Point2, Point3};
use tail_cad::Resolution;

/// Centroid of what was drawn on a white canvas.
fn centroid_of_darkness(canvas: &Canvas) -> Point2 {
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
fn the_centroid_of_a_drawn_mark_is_the_true_pixel_to_a_hundredth() {
    let (set, specimen) = (Settings::built_in(), &ALL[0]);
    let (own, tail) = (&set.specimen[&*specimen.name], (specimen.tail)());
    let resolution = Resolution { edge: 0.004, per_chamber: 1, per_rib: 1 };
    let mesh = mesh::quadratic(&tail.mesh(&resolution).unwrap());
    let camera = Renderer::new(&set, own.seed, own.clamp).camera;
    for (_, at) in card::nominal_marks(&tail, own) {
        let (mark, off) = Mark::paint_on_skin(&mesh, at, own.marker_diameter);
        assert!(off < 5e-4, "{off} m off the skin"); // chords of a rib-long element under a round back
        for nodes in [mesh.nodes.clone(), bent(&mesh.nodes, 4.0), bent(&mesh.nodes, -9.0)] {
            let mut canvas = Canvas::filled(camera.width, camera.height, 255.0);
            let view = View { camera, water: None };
            let motion = FrameMotion::sample(0.0, 1.0, &|_| nodes.clone());
            mark.draw_in_frame(&mut canvas, &view, &motion);
            let (drawn, truth) = (centroid_of_darkness(&canvas), mark.pixel_at_rest(&camera, &nodes).unwrap());
            let centre = camera.pixel(mark.centre_position(&nodes)).unwrap();
            assert!((drawn[0] - truth[0]).hypot(drawn[1] - truth[1]) < 0.01, "{drawn:?} {truth:?}");
            assert!((centre[0] - truth[0]).hypot(centre[1] - truth[1]) < 0.2, "{centre:?} {truth:?}");
        }
    }
}

#[test]
fn the_skin_covers_the_tail_and_nothing_else() {
    let (set, specimen) = (Settings::built_in(), &ALL[0]);
    let (own, tail) = (&set.specimen[&*specimen.name], (specimen.tail)());
    let resolution = Resolution { edge: 0.006, per_chamber: 1, per_rib: 1 };
    let mesh = mesh::quadratic(&tail.mesh(&resolution).unwrap());
    let camera = Renderer::new(&set, own.seed, own.clamp).camera;
    let mut canvas = Canvas::filled(camera.width, camera.height, 0.0);
    let view = View { camera, water: None };
    Skin::new(&mesh).draw_in_frame(&mut canvas, &view, &FrameMotion::sample(0.0, 1.0, &|_| mesh.nodes.clone()));
    let level = |at: Point3| {
        let [u, v] = camera.pixel(at).unwrap().map(|p| p.round() as usize);
        canvas.levels[v * canvas.width + u]
    };
    let side = tail.half_width(0.03, 0.0);
    for (at, visible) in [(0.8 * side, true), (-0.8 * side, true), (1.2 * side, false), (-1.2 * side, false)] {
        assert_eq!(level([0.03, at, 0.0]) > 20.0, visible, "y = {at} m");
    }
    assert!(level([0.04, 0.0, tail.half_height(0.04)]) > level([0.04, 0.9 * side, 0.0]), "the back is the brightest");
}

#[test]
fn a_moving_mark_under_ripples_is_drawn_at_its_true_pixel_to_a_hundredth() {
    let (set, specimen) = (Settings::built_in(), &ALL[0]);
    let (own, tail) = (&set.specimen[&*specimen.name], (specimen.tail)());
    let mesh = mesh::quadratic(&tail.mesh(&Resolution { edge: 0.006, per_chamber: 1, per_rib: 1 }).unwrap());
    let renderer = Renderer::new(&set, own.seed, own.clamp);
    let recording = renderer.of_recording(Medium::Water, "test");
    let (_, at) = card::nominal_marks(&tail, own)[1];
    let (mark, _) = Mark::paint_on_skin(&mesh, at, own.marker_diameter);
    let oscillation = |t: f64| bent(&mesh.nodes, 8.0 * (25.0 * t).sin() + 1e-6);
    for frame in 0..6 {
        let motion = FrameMotion::sample(0.1 + f64::from(frame) / 60.0, 1.0 / 60.0, &oscillation);
        let mut canvas = Canvas::filled(renderer.camera.width, renderer.camera.height, 255.0);
        mark.draw_in_frame(&mut canvas, &recording.view, &motion);
        let (drawn, truth) = (centroid_of_darkness(&canvas), mark.pixel_in_frame(&recording.view, &motion).unwrap());
        assert!((drawn[0] - truth[0]).hypot(drawn[1] - truth[1]) < 0.01, "{drawn:?} {truth:?}");
        let dry = mark.pixel_at_rest(&renderer.camera, motion.current_nodes()).unwrap();
        assert!((dry[0] - truth[0]).hypot(dry[1] - truth[1]) > 0.5, "refraction is not negligible: {dry:?} {truth:?}");
    }
}
