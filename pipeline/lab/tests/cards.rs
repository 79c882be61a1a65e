//! Cards: round trip, and each error with its line and action.
#![allow(clippy::unwrap_used)] // a test may fail where it stands

use std::path::Path;

use lab::card::{self, Card, Experiment, FixtureOf};

/// A card that is right in every line.
const GOOD: &str = r#"name = "pike"
origin = "laboratory"
length = 0.1

[solid]
unit = "mm"

[solid.body]
file = "cad/body.stl"
material = "neo_hookean"
youngs_modulus = 200000
poissons_ratio = 0.49
density = 1070.0
plausible = [0.05e6, 1e6]

[solid.spine]
file = "cad/spine.stl"
material = "neo_hookean"
youngs_modulus = 3.0e9
poissons_ratio = 0.37
density = 1410.0
plausible = [1e9, 6e9]

[clamp]
below_x = 0.004

[[chamber]]
name = "left"
at = [0.012, 0.006, 0.0]
channel = "left"

[[chamber]]
name = "right"
at = [0.012, -0.006, 0.0]
channel = "right"

[[marker]]
name = "m1"
at = [0.055, 0.0, 0.0155]
clicked = [512.0, 360.0]
diameter = 0.004

[camera]
calibration = "camera/calibration.mp4"
frame_every = 10
readout = 0.006

[camera.board]
columns = 9
rows = 6
square = 0.012

[camera.plane]
seconds = [8.0, 9.0]
origin = [0.0, 0.05]
along = [1.0, 0.0]
height = -0.045

[water]
surface = 0.05
index = 1.333

[led]
centre = [1200.0, 60.0]
radius = 14.0

[[trial]]
id = "static_left"
kind = "staircase"
role = "identify"
medium = "air"
channels = ["left"]
video = "trials/static_left/video.mp4"
pressure = "trials/static_left/pressure.csv"
levels = [5000.0, 10000.0]
hold = 1.0
pause = 0.5

[[trial]]
id = "flap"
kind = "flapping"
role = "validate"
medium = "air"
channels = ["left", "right"]
video = "trials/flap/video.mp4"
pressure = "trials/flap/pressure.csv"
amplitude = 20000.0
frequency = 2.0
cycles = 15
last_frame = 900
force = "trials/flap/force.csv"

[[tracks]]
trial = "flap"
file = "trials/flap/dlc.csv"
sigma = 0.5

[[fixture]]
id = "taps"
kind = "taps"
medium = "air"
force = "trials/taps/force.csv"
hammer = "trials/taps/hammer.csv"

[tank]
length = 0.45
depth = 0.15

[[fixture]]
id = "still_water"
kind = "still_water"
medium = "water"
force = "trials/still_water/force.csv"
"#;

fn at() -> &'static Path {
    Path::new("data/raw/pike/specimen.toml")
}

fn good() -> Card {
    card::parse(GOOD, at()).unwrap()
}

/// The refusal of the good card with `from` changed to `to`.
fn refusal(from: &str, to: &str) -> String {
    assert!(GOOD.contains(from), "`{from}` is on the good card");
    card::parse(&GOOD.replacen(from, to, 1), at()).unwrap_err().to_string()
}

/// Line of the good card on which `text` stands.
fn line(text: &str) -> String {
    let line = GOOD.lines().position(|l| l.contains(text)).unwrap() + 1;
    format!("specimen.toml, line {line}:")
}

#[test]
fn a_card_that_is_written_is_read_back_the_same() {
    let card = good();
    let text = card::write(&card);
    assert_eq!(card::parse(&text, at()).unwrap(), card);
    assert_eq!(card::write(&card::parse(&text, at()).unwrap()), text);
}

#[test]
fn a_trial_in_water_without_the_water_s_surface_is_refused() {
    let dry = GOOD.replacen("[water]\nsurface = 0.05\nindex = 1.333\n", "", 1);
    assert_eq!(card::parse(&dry, at()).unwrap().water, None);
    let error = card::parse(&dry.replacen("medium = \"air\"", "medium = \"water\"", 1), at()).unwrap_err().to_string();
    assert!(error.contains("`static_left` is in water") && error.contains("surface"), "{error}");
}

#[test]
fn the_default_shutter_is_global() {
    let card = card::parse(&GOOD.replacen("readout = 0.006\n", "", 1), at()).unwrap();
    assert_eq!(card.camera.as_ref().unwrap().readout, 0.0);
    assert!(!card::write(&card).contains("readout"));
}

#[test]
fn a_trial_is_read_by_its_kind() {
    let card = good();
    assert!(matches!(&card.trial[0].experiment, Experiment::Staircase { levels, .. } if levels.len() == 2));
    assert!(matches!(card.trial[1].experiment, Experiment::Flapping { cycles: 15, .. }));
    assert_eq!((card.trial[0].first_frame, card.trial[1].last_frame), (0, Some(900)));
}

#[test]
fn a_byte_order_mark_and_crlf_are_tolerated() {
    let text = format!("\u{feff}{}", GOOD.replace('\n', "\r\n"));
    assert_eq!(card::parse(&text, at()).unwrap(), good());
}

#[test]
fn an_unknown_key_is_refused_with_its_line_and_the_nearest_key() {
    let error = refusal("density = 1410.0", "densty = 1410.0");
    assert!(error.contains(&line("density = 1410.0")) && error.contains("unknown field `densty`"), "{error}");
    assert!(error.contains("write `density` instead of `densty`"), "{error}");
}

#[test]
fn an_unknown_key_of_a_trial_is_refused_with_the_nearest_key() {
    let error = refusal("cycles = 15", "cycle = 15");
    assert!(error.contains("write `cycles` instead of `cycle`") && error.contains(&line("cycles = 15")), "{error}");
}

#[test]
fn a_missing_key_is_refused_with_its_name() {
    let error = refusal("below_x = 0.004", "");
    assert!(
        error.contains("[clamp] does not have exactly one of below_x") && error.contains("do:  give one"),
        "{error}"
    );
}

#[test]
fn a_missing_key_of_a_kind_of_trial_is_refused_with_the_trial() {
    let error = refusal("hold = 1.0", "");
    assert!(error.contains("kind `staircase` needs the key `hold`") && error.contains("`static_left`"), "{error}");
}

#[test]
fn a_key_of_another_kind_of_trial_is_refused() {
    let error = refusal("hold = 1.0", "hold = 1.0\ncycles = 3");
    assert!(error.contains("kind `staircase` has no key `cycles`"), "{error}");
}

#[test]
fn a_strange_word_is_refused_with_the_words_that_are_known() {
    let error = refusal("role = \"identify\"", "role = \"training\"");
    assert!(error.contains("`identify`") && error.contains("`validate`"), "{error}");
}

#[test]
fn text_that_is_no_toml_is_refused_with_its_line() {
    let error = refusal("length = 0.1", "length = ");
    assert!(error.contains(&line("length = 0.1")), "{error}");
}

/// Each slip of unit or sign, the line it must be blamed on, and a word of the reason.
const SLIPS: &[(&str, &str, &str)] = &[
    ("length = 0.1", "length = 100.0", "0.01 to 1 m"),
    ("youngs_modulus = 200000", "youngs_modulus = 0.2", "1000 to 1000000000000 Pa"),
    ("youngs_modulus = 3.0e9", "youngs_modulus = nan", "is not a finite number"),
    ("poissons_ratio = 0.49", "poissons_ratio = 0.5", "-1 to 0.499"),
    ("density = 1070.0", "density = 1.07", "100 to 20000 kg/m³"),
    ("below_x = 0.004", "below_x = 4.0", "-1 to 1 m"),
    ("diameter = 0.004", "diameter = 4.0", "0.0002 to 0.05 m"),
    ("square = 0.012", "square = 12.0", "0.001 to 0.2 m"),
    ("height = -0.045", "height = -45.0", "-1 to 1 m"),
    ("readout = 0.006", "readout = 6.0", "0 to 0.1 s"),
    ("surface = 0.05", "surface = 50.0", "-1 to 1 m"),
    ("index = 1.333", "index = 1.0", "1.3 to 1.4"),
    ("sigma = 0.5", "sigma = 500.0", "0.001 to 100 px"),
    ("trial = \"flap\"", "trial = \"flop\"", "belong to a trial"),
    ("frequency = 2.0", "frequency = 2000.0", "0.05 to 50 Hz"),
    ("amplitude = 20000.0", "amplitude = 2e7", "0 to 500000 Pa"),
    ("cycles = 15", "cycles = 0", "1 to 100000"),
    ("name = \"m1\"", "name = \"m/1\"", "letters, digits"),
];

#[test]
fn a_slip_of_unit_is_refused_with_its_line_and_its_range() {
    for (from, to, why) in SLIPS {
        let error = refusal(from, to);
        assert!(error.contains(&line(from)), "{to}: {error}");
        assert!(error.contains(why), "{to}: {error}");
    }
}

#[test]
fn a_file_outside_the_folder_is_refused() {
    for bad in ["../other/body.stl", "/tmp/body.stl", "C:/body.stl", "cad\\\\body.stl"] {
        let error = refusal("cad/body.stl", bad);
        assert!(error.contains("leaves the folder") && error.contains(&line("cad/body.stl")), "{error}");
    }
}

#[test]
fn a_card_in_a_folder_of_another_name_is_refused() {
    let error = card::parse(GOOD, Path::new("data/raw/perch/specimen.toml")).unwrap_err().to_string();
    assert!(error.contains("`pike`") && error.contains("`perch`"), "{error}");
}

#[test]
fn a_first_guess_outside_the_plausible_box_is_refused() {
    // on the bound there is no way to one side
    for bad in ["[4e9, 6e9]", "[3e9, 6e9]", "[1e9, 3e9]"] {
        let error = refusal("plausible = [1e9, 6e9]", &format!("plausible = {bad}"));
        assert!(error.contains("widen plausible"), "{error}");
    }
}

#[test]
fn two_trials_of_one_name_are_refused() {
    let error = refusal("id = \"flap\"", "id = \"static_left\"");
    assert!(error.contains("stands twice"), "{error}");
}

#[test]
fn a_force_log_is_optional_and_a_fixture_is_read_by_its_kind() {
    let card = good();
    assert_eq!((&card.trial[0].force, card.trial[1].force.as_deref()), (&None, Some("trials/flap/force.csv")));
    assert!(matches!(&card.fixture[0].of, FixtureOf::Taps { hammer, .. } if hammer == "trials/taps/hammer.csv"));
    assert_eq!(card.fixture[1].of, FixtureOf::StillWater);
}

#[test]
fn a_card_without_any_force_log_is_valid() {
    let (before, _) = GOOD.split_once("force = ").unwrap();
    let card = card::parse(before, at()).unwrap();
    assert!(card.fixture.is_empty() && card.trial.iter().all(|t| t.force.is_none()));
    assert_eq!(card::parse(&card::write(&card), at()).unwrap(), card);
}

#[test]
fn taps_without_a_hammer_and_a_fixture_named_like_a_trial_are_refused() {
    let error = refusal("hammer = \"trials/taps/hammer.csv\"", "");
    assert!(error.contains("needs the key `hammer`") && error.contains("`taps`"), "{error}");
    let error = refusal("kind = \"still_water\"", "kind = \"still_water\"\nhammer = \"a.csv\"");
    assert!(error.contains("has no key `hammer`"), "{error}");
    let error = refusal("id = \"still_water\"", "id = \"flap\"");
    assert!(error.contains(&line("id = \"still_water\"")) && error.contains("is a trial's as well"), "{error}");
}

#[test]
fn a_force_log_outside_the_folder_is_refused() {
    for file in ["trials/flap/force.csv", "trials/taps/force.csv", "trials/taps/hammer.csv"] {
        let error = refusal(file, "../force.csv");
        assert!(error.contains("leaves the folder") && error.contains(&line(file)), "{error}");
    }
}

/// The good card with markers that are looked for.
fn searching(search: &str) -> String {
    let card = GOOD.replacen("clicked = [512.0, 360.0]\n", "", 1);
    card.replacen("[camera]\n", &format!("{search}\n[camera]\n"), 1)
}

#[test]
fn markers_that_are_looked_for_need_no_click_and_are_read_back_the_same() {
    let text = searching("[search]\nregion = [300.0, 200.0, 900.0, 500.0]\norder = \"leftwards\"\nby = \"corners\"\n");
    let card = card::parse(&text, at()).unwrap();
    let search = card.search.clone().unwrap();
    assert_eq!((card.marker[0].clicked, search.order.word(), search.by.word()), (None, "leftwards", "corners"));
    assert_eq!(card::parse(&card::write(&card), at()).unwrap(), card);
}

#[test]
fn markers_both_clicked_and_looked_for_or_neither_are_refused() {
    let error = card::parse(&searching(""), at()).unwrap_err().to_string();
    assert!(error.contains("marker `m1`") && error.contains("[search]"), "{error}");
    let error = refusal("[camera]\n", "[search]\nregion = [300.0, 200.0, 900.0, 500.0]\n\n[camera]\n");
    assert!(error.contains("`m1` is clicked"), "{error}");
    let error = card::parse(&searching("[search]\nregion = [900.0, 200.0, 300.0, 500.0]\n"), at()).unwrap_err();
    assert!(error.to_string().contains("-600 × 300 px"), "{error}");
}

/// The good card with tracks in space.
fn in_space(rest: &str) -> String {
    GOOD.replacen("dlc.csv\"\nsigma = 0.5", &format!("mocap.c3d\"\n{rest}"), 1)
}

#[test]
fn tracks_in_space_are_read_with_their_axes() {
    let text = in_space("sigma = 2e-4\n[tracks.space]\nstart = 0.25\nx = [0.0, 1.0, 0.0]\n");
    let card = card::parse(&text, at()).unwrap();
    let axes = card.tracks[0].space.clone().unwrap();
    assert_eq!((axes.start, axes.origin, axes.x, axes.z), (0.25, [0.0; 3], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]));
    assert_eq!(card::parse(&card::write(&card), at()).unwrap(), card);
}

#[test]
fn tracks_in_space_without_axes_or_with_pixels_for_metres_are_refused() {
    let error = card::parse(&in_space("sigma = 0.5"), at()).unwrap_err().to_string();
    assert!(error.contains("mocap.c3d holds places in space") && error.contains("[tracks.space]"), "{error}");
    let error = card::parse(&in_space("sigma = 0.5\n[tracks.space]\n"), at()).unwrap_err().to_string();
    assert!(error.contains("tracks.0.sigma = 0.5 m is out of range"), "{error}");
    let error = card::parse(&in_space("sigma = 2e-4\n[tracks.space]\nx = [0.0, 0.0, 1.0]\n"), at()).unwrap_err();
    assert!(error.to_string().contains("tracks.0.space.z"), "{error}");
}

#[test]
fn a_region_too_flat_or_too_narrow_for_a_marker_is_refused() {
    for (region, size) in
        [("[100.0, 200.0, 900.0, 204.0]", "800 × 4 px"), ("[100.0, 200.0, 104.0, 900.0]", "4 × 700 px")]
    {
        let card = searching(&format!("[search]\nregion = {region}"));
        let error = card::parse(&card, at()).unwrap_err().to_string();
        assert!(error.contains(size) && error.contains("every marker"), "{error}");
    }
    let smallest = searching("[search]\nregion = [100.0, 200.0, 108.0, 208.0]");
    assert!(card::parse(&smallest, at()).is_ok(), "8 × 8 px are enough");
}

#[test]
fn a_trial_of_one_frame_is_refused() {
    let error = refusal("last_frame = 900", "last_frame = 0");
    assert!(error.contains("last_frame = 0 is out of range") && error.contains("the range is 1 to"), "{error}");
}

#[test]
fn a_staircase_lasts_from_its_first_hold_to_its_last() {
    let stairs = |count| Experiment::Staircase {
        channels: vec!["left".into()],
        levels: vec![1e4; count],
        hold: 1.5,
        pause: 0.5,
    };
    assert_eq!([1, 3].map(|count| stairs(count).duration()), [1.5, 5.5]);
    let flaps = Experiment::Flapping { channels: vec!["left".into()], amplitude: 1e4, frequency: 2.0, cycles: 15 };
    assert_eq!(flaps.duration(), 7.5);
}

/// The good card in a folder of its own, and its specimen.
fn folder(test: &str) -> (std::path::PathBuf, lab::Specimen) {
    let top = std::env::temp_dir().join(format!("lab_{test}_{}", std::process::id()));
    let folder = top.join("pike");
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("specimen.toml"), GOOD).unwrap();
    let specimen = lab::Specimen::open(&folder).unwrap();
    (top, specimen)
}

#[test]
fn files_that_a_card_names_and_that_are_not_there_are_named_with_their_key() {
    let (top, specimen) = folder("missing");
    let errors: Vec<String> = specimen.missing().iter().map(ToString::to_string).collect();
    assert_eq!(errors.len(), 12, "{errors:?}");
    for key in ["solid.spine.file", "pressure of trial `flap`", "tracks of trial `flap`", "hammer of fixture `taps`"] {
        let named = |s: &String| s.contains("the file is missing") && s.contains(&format!("names it as {key}\n"));
        assert_eq!(errors.iter().filter(|s| named(s)).count(), 1, "{key}: {errors:?}");
    }
    std::fs::remove_dir_all(top).unwrap();
}

#[test]
fn a_film_may_be_a_folder_of_pictures_and_a_log_may_not() {
    let (top, specimen) = folder("pictures");
    for (key, file) in specimen.files() {
        let path = specimen.file(file);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        match key.starts_with("video") {
            true => std::fs::create_dir_all(path).unwrap(),
            false => std::fs::write(path, "1").unwrap(),
        }
    }
    assert_eq!(specimen.missing(), []);
    let log = specimen.file("trials/flap/force.csv");
    std::fs::remove_file(&log).unwrap();
    std::fs::create_dir(&log).unwrap();
    let error = specimen.missing().iter().map(ToString::to_string).collect::<String>();
    assert!(error.contains("force.csv: the file cannot be used: it is a folder"), "{error}");
    std::fs::remove_dir_all(top).unwrap();
}
