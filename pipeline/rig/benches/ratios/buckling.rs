//! Cost of the pressures at which a wall buckles, over that of those at which it does not: the tail with thin walls, filled on one side.

use std::time::Instant;

use mesh::wall::{Section, buckling_pressure};
use rig::Side;
use rig::physics::{Body, BodySettings, PressureSweep, even_pressures};
use rig::settings::{Resolution, Settings};
use rig::specimen::{HiddenProperties, SHEET};
use si::{MILLIBAR, Point3, Second};

const RESOLUTION: Resolution = Resolution { edge: 0.005, per_chamber: 1, per_rib: 1, hexahedra: None };
/// Highest pressure, mbar, and its levels.
const HIGHEST: f64 = 240.0;
const LEVELS: usize = 24;
/// A level this close to the critical pressure counts as one with a buckle, mbar.
const NEAR: f64 = 25.0;

/// Prints the mean time of a level with a buckle over that of one without.
pub fn print() {
    let set = Settings::built_in();
    let specimen =
        rig::specimens::ALL.iter().find(|s| s.name == "nemo").expect("the bench has the tail of the photograph");
    let specimen_settings = &set.specimen[&*specimen.name];
    let hidden = HiddenProperties::drawn(&set, specimen_settings);
    let laws = [&*set.material[&specimen_settings.body].law, &*set.material[SHEET].law];
    let settings = BodySettings { resolution: &RESOLUTION, clamp: specimen_settings.clamp, laws };
    let body = Body::new(&(specimen.tail)(), &settings, &hidden).expect("the specimen's own shape");
    let pressures = even_pressures(HIGHEST * MILLIBAR, LEVELS);
    let ticks = std::sync::Mutex::new(vec![Instant::now()]);
    let tick = || ticks.lock().expect("one thread").push(Instant::now());
    let sweep = PressureSweep::solve_sweep(&body, Side::Left, &pressures, &tick).expect("equilibria");
    let section = Section::of(&body.mesh).expect("nodes at mid height");
    let dent = |shape: &Vec<f64>| {
        let displaced = |(x, u): (&Point3, &[f64; 3])| si::vec3::add(*x, *u);
        let nodes: Vec<Point3> = body.mesh.nodes.iter().zip(shape.as_chunks::<3>().0).map(displaced).collect();
        section.walls(&nodes, true).dent_m
    };
    let dents: Vec<f64> = sweep.shapes.iter().map(dent).collect();
    let critical = buckling_pressure(&pressures, &dents).expect("the wall buckles") / MILLIBAR;
    let ticks = ticks.into_inner().expect("one thread");
    let times = ticks.windows(2).map(|pair| (pair[1] - pair[0]).as_secs_f64());
    let (with, without): (Vec<(f64, Second)>, Vec<_>) = pressures[1..]
        .iter()
        .map(|pressure| pressure / MILLIBAR)
        .zip(times)
        .partition(|(pressure, _)| (pressure - critical).abs() < NEAR);
    let mean = |levels: &[(f64, Second)]| levels.iter().map(|(_, time)| time).sum::<f64>() / levels.len() as f64;
    println!(
        "buckle at {critical:.0} mbar: {:.2} s a level within {NEAR} mbar, {:.2} s elsewhere, ratio {:.2}; {:.1} s in all",
        mean(&with),
        mean(&without),
        mean(&with) / mean(&without),
        mean(&with) * with.len() as f64 + mean(&without) * without.len() as f64,
    );
}
