//! Cost of a film: frames a second on one core for drawing in air and water, exposure and encoding.

use std::time::Instant;

use lab::card::Medium;
use rig::camera::FrameMotion;
use rig::renderer::{Renderer, Subject};
use rig::scene::mark::Mark;
use rig::scene::skin::Skin;
use rig::settings::Settings;
use tail_cad::Resolution;
use track::video::{Quality, Writer};

const FRAMES: usize = 120;

/// Prints the frames a second by profile and medium.
pub fn print() {
    let set = Settings::built_in();
    let specimen = &rig::specimens::ALL[0];
    let (own, tail) = (&set.specimen[&*specimen.name], (specimen.tail)());
    for (name, profile) in &set.profile {
        let r = profile.resolution;
        let resolution = Resolution { edge: r.edge, per_chamber: r.per_chamber, per_rib: r.per_rib };
        let mesh = mesh::quadratic(&tail.mesh(&resolution).expect("the specimen's own shape"));
        let renderer = Renderer::new(&set, own.seed, own.clamp);
        let paint = |x: &f64| Mark::paint_on_skin(&mesh, tail.back_point(*x), own.marker_diameter).0;
        let subject = Subject { skin: Skin::new(&mesh), marks: own.markers.iter().map(paint).collect() };
        let oscillation = |t: f64| {
            let bend = 4.0 * (25.0 * t).sin();
            mesh.nodes.iter().map(|[x, y, z]| [*x, y + bend * x * x, *z]).collect()
        };
        for medium in [Medium::Air, Medium::Water] {
            let recording = renderer.of_recording(medium, "bench");
            let file = std::env::temp_dir().join("rig-bench.mp4");
            let quality = Quality::Quantiser(set.camera.quantiser);
            let mut writer = Writer::create(&file, (set.camera.width, set.camera.height), set.camera.rate, quality)
                .expect("a writable folder");
            let (mut drawn, mut exposed, mut encoded) = (0.0, 0.0, 0.0);
            for frame in 0..FRAMES {
                let start = Instant::now();
                let motion = FrameMotion::sample(frame as f64 / set.camera.rate, 1.0 / set.camera.rate, &oscillation);
                let canvas = recording.tail_frame(&subject, &motion, 0.5);
                drawn += start.elapsed().as_secs_f64();
                let start = Instant::now();
                let picture = renderer.expose_canvas(&canvas, "bench", frame);
                exposed += start.elapsed().as_secs_f64();
                let start = Instant::now();
                writer.push(&picture).expect("an encoder");
                encoded += start.elapsed().as_secs_f64();
            }
            writer.finish().expect("an encoder");
            let each = 1e3 / FRAMES as f64;
            println!(
                "{name:6} {:5}  {:5.1} frames/s  draw {:.2}  expose {:.2}  encode {:.2} ms",
                medium.word(),
                FRAMES as f64 / (drawn + exposed + encoded),
                drawn * each,
                exposed * each,
                encoded * each
            );
        }
    }
}
