//! Actuators of other kinds, from card to moduli: a finger with three channels and a strip bonded to it, from a mesh file, and a bellows
//! with one channel and no sheet, from its surface.
#![allow(clippy::unwrap_used)]

mod recordings;
mod voxels;

use std::path::Path;

use mesh::{Surface, stl};
use recordings::{Project, regions};
use sysid::Meshed;
use voxels::Voxels;

/// A finger of 14 × 5 × 5 cubes with a chamber along each of three edges, and a strip (2) of another material below.
const FINGER: Voxels = Voxels {
    side: 3.0,
    count: [14, 5, 5],
    tag: |[i, j, k]| {
        let within = (1..13).contains(&i);
        let chamber = within && [(1, 1), (3, 1), (2, 3)].contains(&(j, k));
        (!chamber).then_some(if k == 0 { 2 } else { 1 })
    },
};

/// A bellows of one chamber with two folds.
const BELLOWS: Voxels = Voxels {
    side: 3.0,
    count: [11, 8, 4],
    tag: |[i, j, k]| {
        let fold = (2..5).contains(&i) || (6..9).contains(&i);
        let outer = if fold { 0..8 } else { 1..7 };
        let inner = if i == 3 || i == 7 { 1..7 } else { 2..6 };
        let chamber = (1..10).contains(&i) && inner.contains(&j) && (1..3).contains(&k);
        (outer.contains(&j) && !chamber).then_some(1)
    },
};

/// The lamp of films.
const LAMP: &str = r#"
[led]
centre = [40.0, 40.0]
radius = 12.0
"#;

/// The time of the first place on the log's clock, s, of a trial without a film.
const START: f64 = 3.2;

/// A filmed trial that holds `levels` (Pa) in `channels`, with tracks in space.
fn filmed(id: &str, channels: &str, levels: &str) -> String {
    let video = format!("video = \"trials/{id}/video.mp4\"\npressure =");
    trial(id, channels, levels).replace("pressure =", &video).replace(&format!("start = {START:?}"), "start = 0.0")
}

/// A trial that holds `levels` (Pa) in `channels`, with tracks in space and without a film.
fn trial(id: &str, channels: &str, levels: &str) -> String {
    format!(
        r#"
[[trial]]
id = "{id}"
kind = "staircase"
role = "identify"
medium = "air"
channels = {channels}
pressure = "trials/{id}/pressure.csv"
levels = {levels}
hold = 1.5
pause = 1.0

[[tracks]]
trial = "{id}"
file = "trials/{id}/places.csv"
sigma = 2e-5

[tracks.space]
start = {START:?}
origin = [0.0, 0.0, 0.0]
x = [1.0, 0.0, 0.0]
z = [0.0, 0.0, 1.0]
"#
    )
}

/// A solid whose modulus is searched from a third to three times the nominal one, Pa.
fn solid(name: &str, source: &str, modulus: f64) -> String {
    let plausible = [modulus / 3.0, 3.0 * modulus];
    format!(
        "\n[solid.{name}]\n{source}\nmaterial = \"neo_hookean\"\nyoungs_modulus = {modulus:?}\npoissons_ratio = 0.48\n\
         density = 1070.0\nplausible = {plausible:?}\n"
    )
}

fn chamber(name: &str, at: [f64; 3]) -> String {
    let [x, y, z] = at.map(|x| 1e-3 * x);
    format!("\n[[chamber]]\nname = \"{name}\"\nat = [{x:.5}, {y:.5}, {z:.5}]\nchannel = \"{name}\"\n")
}

fn marker(name: &str, at: [f64; 3]) -> String {
    let [x, y, z] = at.map(|x| 1e-3 * x);
    format!("\n[[marker]]\nname = \"{name}\"\nat = [{x:.5}, {y:.5}, {z:.5}]\n")
}

/// The length of an edge in study.toml, m.
fn edge() -> f64 {
    let settings: toml::Table = toml::from_str(include_str!("../../../../study.toml")).unwrap();
    settings["mesh"]["edge"].as_float().unwrap()
}

/// Off by so much of a modulus at most: the recordings are those of the model, rounded to 10 nm, with the log's pressures to 1 Pa.
const OFF: f64 = 0.02;

fn assert_near(found: f64, hidden: f64) {
    assert!((found / hidden - 1.0).abs() < OFF, "{found} instead of {hidden}");
}

#[test]
fn a_finger_with_three_channels_and_two_solids_goes_from_card_to_moduli() {
    let mut card = r#"name = "finger"
origin = "laboratory"
length = 0.042

[solid]
unit = "mm"
mesh = "cad/finger.mesh"

[clamp]
surface = "5"
"#
    .to_owned();
    card += &solid("silicone", "region = \"1\"", 3e5);
    card += &solid("strip", "region = \"2\"", 3e6);
    for (name, j, k) in [("port", 1.5, 1.5), ("starboard", 3.5, 1.5), ("dorsal", 2.5, 3.5)] {
        card += &chamber(name, FINGER.place([7.0, j, k]));
    }
    for (i, x) in [5.0, 9.0, 12.0, 14.0].into_iter().enumerate() {
        card += &marker(&format!("m{}", i + 1), FINGER.place([x, 2.5, 5.0]));
    }
    card += LAMP;
    card += &filmed("port", r#"["port"]"#, "[10000.0, 20000.0]");
    card += &filmed("both", r#"["starboard", "dorsal"]"#, "[15000.0]");
    let bytes = FINGER.medit().into_bytes();
    let meshed = Meshed::of_file(Path::new("finger.mesh"), (&bytes, None), 1e-3, &regions(&card)).unwrap();
    let project = Project::new(&card, &[("cad/finger.mesh", bytes)]);
    project.record(&meshed, &[2.6e5, 2.2e6]);
    let output = project.study(&["run", "--specimen", "finger", "identify"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert_near(project.metric("identify.finger.silicone_e_mpa"), 0.26);
    assert_near(project.metric("identify.finger.strip_e_mpa"), 2.2);
}

#[test]
fn a_bellows_with_one_channel_no_sheet_and_no_film_goes_from_card_to_its_modulus() {
    let mut card = r#"name = "bellows"
origin = "laboratory"
length = 0.033

[solid]
unit = "mm"

[clamp]
plane = { x = 0.0 }
"#
    .to_owned();
    card += &solid("body", "file = \"cad/body.stl\"", 3e5);
    card += &chamber("air", BELLOWS.place([3.5, 4.0, 2.0]));
    for (i, at) in [[3.5, 8.0, 2.0], [7.5, 8.0, 2.0], [11.0, 5.0, 2.0], [11.0, 3.0, 2.0]].into_iter().enumerate() {
        card += &marker(&format!("m{}", i + 1), BELLOWS.place(at));
    }
    card += &trial("stairs", r#"["air"]"#, "[4000.0, 8000.0, 12000.0]");
    let surface = BELLOWS.surface();
    let metres = Surface { points: surface.points.iter().map(|p| p.map(|x| 1e-3 * x)).collect(), faces: surface.faces };
    // the mesh of study.toml: on another one its modulus differs by some percent, as the table mesh_sensitivity shows
    let by = mesh::Settings { use_symmetry: true, ..mesh::Settings::new(edge()) };
    let meshed = Meshed::of_surfaces((&metres, None), &by, mesh::ElementChoice::Tetrahedra, &regions(&card)).unwrap();
    let project = Project::new(&card, &[("cad/body.stl", stl::write(&metres, 1e-3, "body"))]);
    project.record(&meshed, &[2.6e5]);
    let doctor = project.study(&["doctor", "bellows"]);
    let said = String::from_utf8_lossy(&doctor.stdout);
    assert!(doctor.status.success() && said.contains("0 to fix, 0 notes"), "{said}");
    for line in ["there is no film of stairs; camera, track", "they are on the log's clock from 3.200 to"] {
        assert!(said.contains(line), "{said}");
    }
    let output = project.study(&["run", "--specimen", "bellows", "identify", "track", "setup"]);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(said.contains("bellows: there is no film of stairs; camera, track, example_frames and"), "{said}");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    // the recordings are those of this very mesh, whose error is none of the material
    let mesh_shift = project.metric("identify.bellows.body_e.discretisation_percent");
    assert_near(project.metric("identify.bellows.body_e_mpa") * (1.0 + 0.01 * mesh_shift), 0.26);
}
