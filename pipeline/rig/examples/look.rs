//! A look at the bench: a picture of each specimen at rest and filled, and of the checkerboard, as PNG.
//!
//! `cargo run --release -p rig --example look -- FOLDER [PROFILE] [PRESSURE in mbar]`
//!
//! Stands on: the bench's rooms. Never knows: a recording.

use std::error::Error;
use std::path::Path;
use std::time::Instant;

use lab::card::Side;
use rig::calibration::Calibration;
use rig::physics::{Body, ladder, rungs};
use rig::scene::paint::Mark;
use rig::scene::skin::Skin;
use rig::scene::{Canvas, board};
use rig::settings::Settings;
use rig::specimen::{Hidden, Specimen};
use rig::specimens::ALL;
use rig::studio::{Studio, Subject};
use rig::{card, draw::Draw};
use si::{MILLIBAR, Point3, vec3};

fn main() -> Result<(), Box<dyn Error>> {
    let mut given = std::env::args().skip(1);
    let folder = given.next().unwrap_or_else(|| "target/look".to_owned());
    let profile = given.next().unwrap_or_else(|| "quick".to_owned());
    let pressure = given.next().map_or(Ok(0.0), |p| p.parse::<f64>())? * MILLIBAR;
    std::fs::create_dir_all(&folder)?;
    ALL.iter().try_for_each(|specimen| look(specimen, &profile, pressure, Path::new(&folder)))
}

fn look(specimen: &Specimen, profile: &str, pressure: f64, folder: &Path) -> Result<(), Box<dyn Error>> {
    let set = Settings::built_in();
    let (own, profile, tail) = (&set.specimen[specimen.name], &set.profile[profile], (specimen.tail)());
    let studio = Studio::new(&set, own.seed, own.clamp);
    let save = |canvas: &Canvas, name: &str| -> Result<(), Box<dyn Error>> {
        Ok(std::fs::write(folder.join(format!("{name}.png")), studio.expose(canvas, name, 0).to_png()?)?)
    };
    let layout = board::layout(&set.plane);
    let film = Calibration::new(&set, &studio, profile.poses, own.seed);
    let poses = board::poses(&studio.camera, &layout, profile.poses, &mut Draw::new(own.seed, "board"));
    for (i, place) in poses.iter().take(3).chain([&board::flat(&set.plane)]).enumerate() {
        save(&studio.board(&layout, place), &format!("board_{i}"))?;
    }
    println!("calibration: {} frames, flat {:?} s", film.frames(), film.flat);

    let body = Body::new(&tail, &profile.resolution, own, &Hidden::drawn(own))?;
    println!("{}: {} nodes, {} tetrahedra", specimen.name, body.mesh.nodes.len(), body.mesh.tets.len());
    let marks = card::marks(&tail, own).into_iter().map(|(name, at)| {
        let (mark, off) = Mark::paint(&body.mesh, at, own.marker_diameter);
        println!("mark {name}: {:.4} mm off the skin", off * 1e3);
        mark
    });
    let subject = Subject { marks: marks.collect(), skin: Skin::new(&body.mesh) };
    let begun = Instant::now();
    save(&studio.tail(&subject, &body.mesh.nodes, 0.0), &format!("{}_rest", specimen.name))?;
    println!("a frame takes {:.1} ms with its PNG", begun.elapsed().as_secs_f64() * 1e3);
    if pressure > 0.0 {
        let begun = Instant::now();
        let levels = rungs(&[pressure], 3);
        let shapes = ladder(&body, Side::Left, &levels, &|| ())?;
        println!("{} equilibria in {:.1} s", levels.len() - 1, begun.elapsed().as_secs_f64());
        levels.iter().zip(&shapes).for_each(|(p, u)| report(&body, &subject, u, p / MILLIBAR));
        save(
            &studio.tail(&subject, &moved(&body, &shapes[shapes.len() - 1]), 1.0),
            &format!("{}_filled", specimen.name),
        )?;
    }
    Ok(())
}

fn moved(body: &Body, u: &[f64]) -> Vec<Point3> {
    let node = |(i, x): (usize, &Point3)| vec3::add(*x, [u[3 * i], u[3 * i + 1], u[3 * i + 2]]);
    body.mesh.nodes.iter().enumerate().map(node).collect()
}

fn report(body: &Body, subject: &Subject, u: &[f64], pressure: f64) {
    let nodes = moved(body, u);
    let tip = (0..nodes.len()).max_by(|a, b| body.mesh.nodes[*a][0].total_cmp(&body.mesh.nodes[*b][0])).unwrap_or(0);
    let millimetres = |from: Point3, to: Point3| vec3::norm(vec3::sub(to, from)) * 1e3;
    let marks: Vec<String> =
        subject.marks.iter().map(|m| format!("{:.2}", millimetres(m.at(&body.mesh.nodes), m.at(&nodes)))).collect();
    println!(
        "{pressure:6.1} mbar: tip {:.2} mm, marks {} mm",
        millimetres(body.mesh.nodes[tip], nodes[tip]),
        marks.join(" ")
    );
}
