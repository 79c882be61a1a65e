//! `study doctor` on a small valid specimen, and with one error introduced at a time: no finding on the former, one line with the
//! next action for each of the latter.
#![allow(clippy::unwrap_used)]

mod specimen;

use std::fs;
use std::process::{Command, Output};

use specimen::print::{checkerboard, rendered};
use specimen::{FILM, LOG, Project, RATE, card, changed, log, picture, shown, solids, with_lamp};
use track::Gray;
use track::video::{Quality, Writer};

impl Project {
    /// The same of 66 pictures of another size.
    fn film_of(&self, place: &str, size: (usize, usize), picture: impl Fn(usize) -> Gray) {
        let mut film = Writer::create(&self.path(place), size, RATE, Quality::Quantiser(20)).unwrap();
        (0..66).for_each(|k| film.push(&picture(k)).unwrap());
        film.finish().unwrap();
    }

    /// DeepLabCut's tracks of the film, with each place changed.
    fn tracks(&self, change: impl Fn(usize, [f64; 2]) -> [f64; 2]) {
        let titles = "scorer,net,net,net\nbodyparts,m1,m1,m1\ncoords,x,y,likelihood\n".to_owned();
        let line = |k: usize| {
            let [u, v] = change(k, [200.0 + 0.25 * k as f64, 120.0]);
            format!("{k},{u:.2},{v:.2},0.99\n")
        };
        self.write("trials/static_left/deeplabcut.csv", &(titles + &(0..66).map(line).collect::<String>()));
        let entry =
            "\n[[tracks]]\ntrial = \"static_left\"\nfile = \"trials/static_left/deeplabcut.csv\"\nsigma = 0.5\n";
        self.write("specimen.toml", &(card() + entry));
    }

    fn doctor(&self) -> Output {
        Command::new(env!("CARGO_BIN_EXE_study")).args(["doctor", "fish", "--root"]).arg(&self.0).output().unwrap()
    }

    /// One line begins with this word and contains these pieces and an action; the exit code is that of its severity.
    fn finds(&self, word: &str, pieces: &[&str]) {
        let output = self.doctor();
        let said = String::from_utf8_lossy(&output.stdout);
        let holds = |line: &&str| {
            line.starts_with(word) && line.contains("; do: ") && pieces.iter().all(|piece| line.contains(piece))
        };
        let evaluated = format!("{said}{}", String::from_utf8_lossy(&output.stderr));
        assert_eq!(said.lines().filter(holds).count(), 1, "{pieces:?} is not in one line of:\n{evaluated}");
        assert_eq!(output.status.code(), Some(i32::from(word == "fix")), "{evaluated}");
    }
}

/// The log with every row changed.
fn rows(change: impl Fn(usize, &mut [f64])) -> String {
    let log = log();
    let (head, rest) = log.split_once('\n').unwrap();
    let row = |(i, line): (usize, &str)| {
        let mut values: Vec<f64> = line.split(',').map(|word| word.parse().unwrap()).collect();
        change(i, &mut values);
        values.iter().map(|v| format!("{v:.4}")).collect::<Vec<_>>().join(",") + "\n"
    };
    format!("{head}\n{}", rest.lines().enumerate().map(row).collect::<String>())
}

#[test]
fn nothing_is_found_on_a_sound_specimen() {
    let output = Project::new("sound").doctor();
    let said = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{said}");
    let (read, rest) = said.split_once('\n').unwrap();
    assert!(read.starts_with("log  data/raw/fish/trials/static_left/pressure.csv: 260 samples at 200.00 Hz"), "{said}");
    assert!(
        read.contains("jitter 0.00 ms rms")
            && read.ends_with("longest step 5.00 ms of 15.00 ms allowed; it is read as stamped")
    );
    assert_eq!(rest, "fish: 1 trials checked, 0 to fix, 0 notes\n");
}

#[test]
fn a_specimen_that_is_not_there_is_refused_with_those_that_are() {
    let project = Project::new("other");
    let output = Command::new(env!("CARGO_BIN_EXE_study")).args(["doctor", "whale", "--root"]).arg(&project.0).output();
    let output = output.unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.code() == Some(1) && said.contains("there are: fish"), "{said}");
}

macro_rules! planted { ($($name:ident: $plant:expr => $word:literal, $pieces:expr;)*) => {$( #[test] fn $name() { let project = Project::new(stringify!($name)); let plant: fn(&Project) = $plant; plant(&project); project.finds($word, &$pieces); } )*}; }

planted! { an_unknown_key_is_found: |p| p.write("specimen.toml", &changed(&card(), "[led]", "[led]\ncenter = [1.0, 1.0]")) => "fix", ["specimen.toml, line", "unknown field `center`", "`centre`"]; a_length_in_millimetres_is_found: |p| p.write("specimen.toml", &changed(&card(), "length = 0.1", "length = 100.0")) => "fix", ["specimen.toml, line 3", "length = 100 m is out of range"]; a_surface_in_metres_is_found: |p| p.solid("body", &solids().0, 1.0) => "fix", ["body.stl", "an STL in metres or inches read as millimetres?"]; a_surface_in_centimetres_is_found: |p| p.solid("body", &solids().0, 1e-2) => "fix", ["body.stl", "the card's length is 0.1 m", "read in mm"]; an_open_surface_is_found: |p| { let (mut body, _) = solids(); body.faces.pop(); p.solid("body", &body, 1e-3); } => "fix", ["body.stl", "open edge"]; normals_that_point_inwards_are_found: |p| { let (_, mut spine) = solids(); spine.faces.iter_mut().for_each(|face| face.swap(1, 2)); p.solid("spine", &spine, 1e-3); } => "fix", ["spine.stl", "inside out"]; a_spine_that_is_not_in_its_place_is_found: |p| { let (_, mut spine) = solids(); spine.points.iter_mut().for_each(|point| point[1] += 2e-3); p.solid("spine", &spine, 1e-3); } => "fix", ["fish: ", "body and spine"]; a_chamber_outside_of_its_cavity_is_found: |p| p.write("specimen.toml", &changed(&card(), "at = [0.02, 0.006, 0.0]", "at = [0.02, 0.06, 0.0]")) => "fix", ["chamber `left` is not where the card says"]; a_clamp_that_holds_nothing_is_found: |p| p.write("specimen.toml", &changed(&card(), "below_x = 0.004", "below_x = -0.4")) => "fix", ["clamp.below_x = -0.4 m constrains nothing"]; a_missing_film_is_found: |p| fs::remove_file(p.path(FILM)).unwrap() => "fix", ["video.mp4", "missing"]; a_film_cut_short_is_found: |p| { let whole = fs::read(p.path(FILM)).unwrap(); fs::write(p.path(FILM), &whole[..whole.len() * 2 / 3]).unwrap(); } => "fix", ["video.mp4", "cut short"]; a_film_shorter_than_what_was_done_is_found: |p| p.film(FILM, 20, picture) => "fix", ["video.mp4 lasts 0.33 s (20 frames)", "0.50 s"]; a_dark_film_is_found: |p| p.film(FILM, 66, |k| { let light = picture(k); Gray::from_fn(320, 240, |u, v| 0.1 * light.pixel_level(u, v)) }) => "fix", ["video.mp4 is dark", "of 255"]; a_lamp_that_never_lights_is_found: |p| p.film(FILM, 66, |k| with_lamp(k, 110.0)) => "fix", ["video.mp4: the lamp does not light", "of 255"]; a_lamp_out_of_the_picture_is_found: |p| p.write("specimen.toml", &changed(&card(), "centre = [40.0, 40.0]", "centre = [600.0, 40.0]")) => "fix", ["the lamp at (600, 40) px is out of the picture"]; a_marker_out_of_view_is_found: |p| p.write("specimen.toml", &changed(&card(), "clicked = [200.0, 120.0]", "clicked = [500.0, 120.0]")) => "fix", ["video.mp4", "marker `m1` at (500, 120) px is out of the picture"]; a_marker_that_is_elsewhere_is_found: |p| p.write("specimen.toml", &changed(&card(), "clicked = [200.0, 120.0]", "clicked = [100.0, 190.0]")) => "fix", ["video.mp4", "marker `m1`", "frame 0"]; a_marker_close_to_an_edge_is_noted: |p| p.film(FILM, 66, |k| { let light = picture(k); Gray::from_fn(320, 240, |u, v| if v > 138 { 40.0 } else { light.pixel_level(u, v) }) }) => "note", ["video.mp4", "marker `m1` are dark and not its own", "farther from the body's edge"]; a_calibration_without_a_board_is_found: |p| p.film("camera/calibration.mp4", 30, |_| Gray::filled(320, 240, 128)) => "fix", ["calibration.mp4 shows no board between 0 and 0.4 s"]; a_wide_range_of_moduli_is_noted: |p| p.write("specimen.toml", &changed(&card(), "plausible = [5.0e4, 1.0e6]", "plausible = [1e4, 1e7]")) => "note", ["plausible of solid.body spans a factor of 1000"]; a_film_of_another_size_is_found: |p| p.film_of(FILM, (240, 180), |k| { let whole = picture(k); Gray::from_fn(240, 180, |u, v| whole.interpolated_level([u as f64 / 0.75, v as f64 / 0.75])) }) => "fix", ["video.mp4", "the film has pictures of 240 × 180 px, the calibration of 320 × 240 px", "scaled by 0.750"]; a_film_in_which_the_markers_are_not_where_the_card_says_is_found: |p| p.write("specimen.toml", &changed(&card(), "at = [0.05, 0.0, 0.0174]", "at = [0.07, 0.0, 0.0174]")) => "fix", ["video.mp4 has marker `m1` at", "it is painted at (0.0700, 0.0000) m", "neither cut, scaled, mirrored nor turned"]; a_point_of_imported_tracks_that_is_far_away_is_found: |p| p.tracks(|k, [u, v]| if k == 20 { [u + 100.0, v] } else { [u, v] }) => "fix", ["deeplabcut.csv", "marker `m1` moves by 100.2500 px before frame 20"]; imported_tracks_that_are_too_few_are_found: |p| { p.tracks(|_, at| at); let text = fs::read_to_string(p.path("trials/static_left/deeplabcut.csv")).unwrap(); p.write("trials/static_left/deeplabcut.csv", &text[..text.len() - "64,216.00,120.00,0.99\n65,216.25,120.00,0.99\n".len()]); } => "fix", ["deeplabcut.csv", "the film 66 frames"]; a_log_that_is_not_in_utf_8_is_noted: |p| { let text = log().replacen("time_s", "time_s,T_\u{b0}C", 1); let rows = text.split_once('\n').unwrap(); let wide = rows.1.lines().map(|line| line.replacen(',', ",21,", 1) + "\n").collect::<String>(); let bytes: Vec<u8> = format!("{}\n{wide}", rows.0).chars().map(|c| c as u8).collect(); fs::write(p.path(LOG), bytes).unwrap(); } => "note", ["pressure.csv is not in UTF-8", "Windows-1252"]; a_board_that_is_carried_is_found: |p| p.film("camera/calibration.mp4", 30, |k| shown(k as f64, 1.0)) => "fix", ["calibration.mp4: the board moves by", "lies still"]; a_board_that_is_tilted_is_noted: |p| p.calibration(|_| rendered(&|at| checkerboard([9, 6], 20.0, at), ([0.0, 0.645], 0.0, [0.0; 3]))) => "note", ["calibration.mp4", "the board is tilted by about 37°"]; a_lamp_that_is_not_in_the_log_is_found: |p| p.write(LOG, &rows(|_, row| row[5] = 0.0)) => "fix", ["the lamp in the log", "does not have two levels"]; a_log_that_missed_an_edge_is_found: |p| p.write(LOG, &rows(|i, row| if i > 100 { row[5] = 1.0 })) => "fix", ["two clocks recorded different edges"]; a_command_before_the_film_shows_rest_is_found: |p| p.write(LOG, &rows(|i, row| if (30..60).contains(&i) { row[1] = 50.0 })) => "fix", ["commands pressure after", "rest"]; a_missing_column_is_found: |p| p.write(LOG, &changed(&log(), "left_mbar", "links_mbar")) => "fix", ["pressure.csv, line 1", "`left_mbar` is missing"]; measured_columns_that_are_swapped_are_found: |p| p.write(LOG, &rows(|_, row| row.swap(3, 4))) => "fix", ["pressure.csv", "left is filled, and right_mbar rises", "swapped"]; a_log_of_the_other_side_is_found: |p| p.write(LOG, &rows(|_, row| { row.swap(1, 2); row.swap(3, 4); })) => "fix", ["the first command is right_command_mbar's"]; a_log_in_kilopascals_is_found: |p| p.write(LOG, &rows(|_, row| (1..5).for_each(|k| row[k] *= 0.1))) => "fix", ["commands up to 10.0 mbar, the card 100.0 mbar"]; a_sensor_in_pounds_is_found: |p| p.write(LOG, &rows(|_, row| (3..5).for_each(|k| row[k] *= 0.0145))) => "fix", ["at a command of 100.0 mbar left_mbar reaches 1."]; a_decimal_comma_in_a_field_is_found: |p| p.write(LOG, &changed(&log(), ",50.00,", ",\"50,00\",")) => "fix", ["pressure.csv, line 82", "left_command_mbar is `50,00`", "a comma separates the columns"]; a_byte_order_mark_is_noted_and_skipped: |p| p.write(LOG, &format!("\u{feff}{}", log())) => "note", ["pressure.csv begins with a byte-order mark"]; line_ends_of_another_system_are_noted_and_skipped: |p| p.write(LOG, &log().replace('\n', "\r\n")) => "note", ["pressure.csv has lines that end in CRLF"]; a_hole_in_the_numbers_is_found: |p| p.write(LOG, &rows(|i, row| if i == 7 { row[3] = f64::NAN })) => "fix", ["pressure.csv, line 9", "left_mbar is `NaN`"]; a_pressure_below_ambient_is_found: |p| p.write(LOG, &rows(|_, row| row[4] = -80.0)) => "fix", ["right_mbar is -80.0 mbar at time_s = 0.000"]; time_that_runs_backwards_is_found: |p| p.write(LOG, &rows(|i, row| if i == 20 { row[0] = 0.01 })) => "fix", ["pressure.csv, line 22", "time_s goes from"]; time_in_milliseconds_is_found: |p| p.write(LOG, &rows(|_, row| row[0] *= 1e3)) => "fix", ["the edges of two clocks do not belong together"]; a_log_that_is_too_short_is_found: |p| p.write(LOG, &log().lines().take(60).map(|line| format!("{line}\n")).collect::<String>()) => "fix", ["pressure.csv lasts 0.2900 s", "0.50 s"]; a_force_log_without_the_lamp_is_found: |p| { p.write("specimen.toml", &changed(&card(), "levels =", "force = \"trials/static_left/force.csv\"\nlevels =")); p.write("trials/static_left/force.csv", &(0..120).fold("time_s,force_n\n".to_owned(), |text, i| text + &format!("{:.4},0.01\n", 0.01 * f64::from(i)))); } => "fix", ["force.csv has no column led"]; }

const FORCE: &str = "trials/static_left/force.csv";

/// The card with a force log, and `fixture` behind it.
fn with_force(fixture: &str) -> String {
    let named = changed(&card(), "levels =", &format!("force = \"{FORCE}\"\nlevels ="));
    format!("{named}\n{fixture}")
}

/// A force log of `samples` at 80 Hz with the lamp.
fn forces(samples: usize) -> String {
    let lamp = |i: usize| u8::from((24..80).contains(&i));
    let line = |i: usize| format!("{:.4},0.010,{}.000\n", i as f64 / 80.0, lamp(i));
    "time_s,force_n,led\n".to_owned() + &(0..samples).map(line).collect::<String>()
}

#[test]
fn a_force_log_that_ends_before_its_trial_is_found() {
    let project = Project::new("early");
    project.write("specimen.toml", &with_force(""));
    project.write(FORCE, &forces(100));
    assert_eq!(project.doctor().status.code(), Some(0));
    project.write(FORCE, &forces(50));
    project.finds("fix", &["force.csv ends 0.3", "after the lamp has lit", "0.50 s"]);
}

#[test]
fn a_log_that_was_cut_within_a_number_is_found() {
    let project = Project::new("cut");
    let whole = log();
    project.write(LOG, &whole[..whole.len() - 3]);
    project.finds("fix", &["pressure.csv, line 261", "the last line is", "no line end"]);
}

/// A fixture that was tapped `taps` times at 2 s and every two seconds then, its log ending at `end` (s).
fn tapped(project: &Project, taps: usize, end: f64) {
    let fixture = "[[fixture]]\nid = \"taps\"\nkind = \"taps\"\nmedium = \"air\"\nforce = \"trials/taps/force.csv\"\nhammer = \"trials/taps/hammer.csv\"\ncount = 3\n";
    project.write("specimen.toml", &with_force(fixture));
    project.write(FORCE, &forces(100));
    fs::create_dir_all(project.path("trials/taps")).unwrap();
    let since = |t: f64| (1..=taps).map(move |k| t - 2.0 * k as f64);
    let hammer = |t: f64| since(t).filter(|s| (0.0..6e-3).contains(s)).map(|s| 4.0 * (523.6 * s).sin()).sum::<f64>();
    // An impulse of 15 mN s on a fixture of 14 Hz that is damped by 3 %.
    let ring = |t: f64| since(t).filter(|s| *s > 0.0).map(|s| 1.3 * (-2.6 * s).exp() * (88.0 * s).sin()).sum::<f64>();
    let log = |rate: f64, force: &dyn Fn(f64) -> f64| {
        let line = |i: usize| format!("{:.6},{:.5}\n", i as f64 / rate, force(i as f64 / rate));
        "time_s,force_n\n".to_owned() + &(0..(end * rate) as usize).map(line).collect::<String>()
    };
    project.write("trials/taps/hammer.csv", &log(1000.0, &hammer));
    project.write("trials/taps/force.csv", &log(80.0, &ring));
}

#[test]
fn taps_that_are_missing_or_cut_off_are_found() {
    let project = Project::new("taps");
    tapped(&project, 3, 8.0);
    assert_eq!(project.doctor().status.code(), Some(0));
    tapped(&project, 2, 8.0);
    project.finds("fix", &["taps/force.csv", "2 taps are found", "count = 3"]);
    tapped(&project, 3, 6.1);
    project.finds("fix", &["taps/force.csv", "tap 3 begins at 6.0", "a tap needs 0.2 s"]);
}

/// The chamber that is filled lies at positive y, which points downwards in this picture.
#[test]
fn a_body_that_bends_towards_its_filled_chamber_is_noted() {
    let moving = |speed: f64| {
        move |frame: usize| {
            let still = picture(0);
            let lamp = picture(frame).pixel_level(40, 40);
            Gray::from_fn(320, 240, |u, v| {
                let from = |centre: [f64; 2]| (u as f64 - centre[0]).hypot(v as f64 - centre[1]);
                match () {
                    () if from([40.0, 40.0]) < 16.0 => lamp,
                    () if from([200.0, 120.0 + speed * frame as f64]) < 9.0 => 40.0,
                    () if from([200.0, 120.0]) < 10.0 => 200.0,
                    () => still.pixel_level(u, v),
                }
            })
        }
    };
    let project = Project::new("side");
    project.film(FILM, 66, moving(-0.25));
    assert_eq!(project.doctor().status.code(), Some(0));
    assert!(!String::from_utf8_lossy(&project.doctor().stdout).contains("towards the side"));
    project.film(FILM, 66, moving(0.25));
    project.finds(
        "note",
        &["video.mp4: marker `m1` moves by", "mm towards the side of left", "not mirrored against the calibration"],
    );
}

#[test]
fn a_film_and_a_log_that_both_end_before_the_lamp_goes_out_are_found() {
    let project = Project::new("both");
    project.film(FILM, 40, picture);
    project.write(LOG, &log().lines().take(160).map(|line| format!("{line}\n")).collect::<String>());
    project.finds("fix", &["ends at 0.6", "by the card, the trial lasts until 0.7"]);
}

/// A log with each row's time changed.
fn timed(change: impl Fn(usize) -> f64) -> String {
    rows(|i, row| row[0] += change(i))
}

#[test]
fn a_log_with_semicolons_and_decimal_commas_is_sound() {
    let project = Project::new("commas");
    project.write(LOG, &log().replace(',', ";").replace('.', ","));
    assert_eq!(project.doctor().status.code(), Some(0));
}

#[test]
fn what_is_made_of_a_jittered_log_is_printed() {
    let project = Project::new("jitter");
    project.write(LOG, &timed(|i| 2e-3 * (1.0 + (i as f64 * 2.4).sin())));
    let output = project.doctor();
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert_eq!(output.status.code(), Some(0), "{said}");
    let line = said.lines().find(|line| line.starts_with("log  ")).unwrap();
    // its values stay where an even clock has them
    assert!(line.contains("260 samples") && line.contains("were taken evenly and stamped late"), "{line}");
}

#[test]
fn every_gap_is_found_with_its_line_and_a_clock_that_slows_down_is_noted() {
    let project = Project::new("gaps");
    let gaps = |i: usize| f64::from(u8::from(i >= 20) + u8::from(i >= 200)) * 0.02;
    project.write(LOG, &timed(gaps));
    project.finds("fix", &["pressure.csv, line 22", "comes 0.0250 s later"]);
    project.finds("fix", &["pressure.csv, line 202", "comes 0.0250 s later"]);
    project.write(LOG, &timed(|i| 1e-4 * i.saturating_sub(190) as f64));
    project.finds("note", &["pressure.csv, line 19", "the rate goes from 200.0", "to 196.1"]);
}
