//! Cards of trials without a film, and of clamps by a named surface.

#![allow(clippy::unwrap_used)]

use std::path::Path;

use lab::card::{self, Card};

const CARD: &str = r#"name = "arm"
origin = "laboratory"
length = 0.1
[solid]
unit = "mm"
mesh = "cad/arm.msh"
[solid.silicone]
material = "neo_hookean"
youngs_modulus = 2.6e5
poissons_ratio = 0.49
density = 1070.0
plausible = [1e5, 6e5]
[clamp]
surface = "holder"
[[chamber]]
name = "front"
at = [0.05, 0.014, 0.0]
channel = "front"
[[marker]]
name = "tip"
at = [0.1, 0.0, 0.0]
[[trial]]
id = "step"
kind = "staircase"
role = "identify"
medium = "water"
channels = ["front"]
pressure = "trials/step/pressure.csv"
levels = [1e4]
hold = 3.0
pause = 0.0
[[tracks]]
trial = "step"
file = "trials/step/places.c3d"
sigma = 5e-5
[tracks.space]
start = 1.5
"#;

fn parsed(text: &str) -> Result<Card, String> {
    card::parse(text, Path::new("arm/specimen.toml")).map_err(|e| e.to_string())
}

/// The refusal of the card with `from` changed to `to`.
fn refusal(from: &str, to: &str) -> String {
    assert!(CARD.contains(from), "`{from}` is on the card");
    parsed(&CARD.replacen(from, to, 1)).unwrap_err()
}

#[test]
fn markers_in_space_need_neither_film_nor_camera_nor_lamp_nor_water_surface() {
    let card = parsed(CARD).unwrap();
    assert!(card.camera.is_none() && card.led.is_none() && card.trial[0].video.is_none());
    let (tracks, axes) = card.in_space(&card.trial[0]).unwrap();
    assert_eq!((tracks.file.as_str(), axes.start), ("trials/step/places.c3d", 1.5));
    assert_eq!(parsed(&card::write(&card)).unwrap(), card);
    let specimen = lab::Specimen { folder: "arm".into(), card };
    let files: Vec<&str> = specimen.files().into_iter().map(|(_, file)| file).collect();
    assert_eq!(files, ["cad/arm.msh", "trials/step/pressure.csv", "trials/step/places.c3d"]);
}

#[test]
fn a_trial_has_a_film_or_markers_in_space() {
    let dry = CARD.replacen("medium = \"water\"", "medium = \"air\"", 1);
    let message_of = |text: String| parsed(&text).unwrap_err();
    let without_axes = message_of(dry.replacen("[tracks.space]\nstart = 1.5\n", "", 1));
    assert!(without_axes.contains("the card has no axes"), "{without_axes}");
    let elsewhere = message_of(dry.replacen("trial = \"step\"", "trial = \"other\"", 1));
    assert!(elsewhere.contains("tracks of `other`, which is no trial"), "{elsewhere}");
    let alone = message_of(dry.split("[[tracks]]").next().unwrap().to_owned());
    assert!(alone.contains("trial `step` has neither a film nor markers in space") && alone.contains("do:"), "{alone}");
}

#[test]
fn a_film_needs_its_lamp_and_frames_need_a_film() {
    let message = refusal("pressure =", "video = \"film.mp4\"\npressure =");
    assert!(message.contains("trial `step` is filmed, but the card has no [led]"), "{message}");
    let message = refusal("hold = 3.0", "hold = 3.0\nlast_frame = 9");
    assert!(message.contains("trial `step` has no film, but trial.0.last_frame is given"), "{message}");
    assert!(message.contains("specimen.toml, line 31"), "{message}");
}

#[test]
fn pixels_need_a_camera_and_marks_a_diameter() {
    let filmed = CARD.replacen("pressure =", "video = \"film.mp4\"\npressure =", 1);
    let filmed = filmed.replacen("medium = \"water\"", "medium = \"air\"", 1);
    let pixels = filmed.replacen("places.c3d", "places.csv", 1).replacen(
        "sigma = 5e-5\n[tracks.space]\nstart = 1.5",
        "sigma = 0.1",
        1,
    );
    let lit = format!("{pixels}[led]\ncentre = [40.0, 40.0]\nradius = 9.0\n");
    let message = parsed(&lit).unwrap_err();
    assert!(message.contains("trial `step` is tracked in its film, but the card has no [camera]"), "{message}");
    let camera = "[camera]\ncalibration = \"c.mp4\"\nframe_every = 1\n[camera.board]\ncolumns = 9\nrows = 6\nsquare = 0.012\n\
                  [camera.plane]\nseconds = [0.0, 1.0]\norigin = [0.0, 0.0]\nalong = [1.0, 0.0]\nheight = 0.0\n";
    let message = parsed(&format!("{lit}{camera}")).unwrap_err();
    assert!(message.contains("marker `tip` has no diameter, and trial `step` is filmed"), "{message}");
    let complete_card =
        format!("{lit}{camera}").replacen("at = [0.1, 0.0, 0.0]", "at = [0.1, 0.0, 0.0]\ndiameter = 0.004", 1);
    assert!(parsed(&complete_card).is_ok(), "{:?}", parsed(&complete_card));
}

#[test]
fn a_named_surface_is_one_of_a_mesh_and_the_only_place_of_the_clamp() {
    let stl = CARD.replacen("mesh = \"cad/arm.msh\"\n", "", 1).replacen(
        "[solid.silicone]",
        "[solid.body]\nfile = \"a.stl\"",
        1,
    );
    let message = parsed(&stl).unwrap_err();
    assert!(message.contains("clamp.surface is given, but there is no solid.mesh"), "{message}");
    let message = refusal("surface = \"holder\"", "surface = \"holder\"\nbelow_x = 0.0");
    assert!(message.contains("exactly one of below_x, plane (across one axis), box and surface"), "{message}");
}
