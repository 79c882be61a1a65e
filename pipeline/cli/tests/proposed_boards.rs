//! Boards other than checkerboards: `study doctor FOLDER` tells them with their size, and stage camera reads what it proposes.
#![allow(clippy::unwrap_used)]

mod specimen;

use std::fs;
use std::path::PathBuf;
use std::process::Command;

use cli::proposal::{Confidence, Guess, Proposal, propose};
use specimen::print::{POSES, Posed, checkerboard, posed, rendered};
use specimen::{Project, card, changed};

use track::Gray;
use track::video::{Quality, Writer};

/// Flat before the camera.
const FLAT: Posed = ([0.0; 2], 0.0, [0.0; 3]);

/// The level of a print at a place, px from its middle.
type Print = Box<dyn Fn([f64; 2]) -> f64>;

/// A print of OpenCV at 32 px a square, shown at `side` px a square.
fn charuco(file: &str, side: f64) -> Print {
    let path = format!("{}/../track/tests/data/charuco/{file}.png", env!("CARGO_MANIFEST_DIR"));
    let print = Gray::from_png(&fs::read(path).unwrap()).unwrap();
    Box::new(move |[x, y]| {
        let [u, v] = [0.5 * print.width as f64 + x * 32.0 / side, 0.5 * print.height as f64 + y * 32.0 / side];
        let is_inside = (0.0..print.width as f64).contains(&u) && (0.0..print.height as f64).contains(&v);
        if is_inside { 40.0 + 0.65 * print.pixel_level(u as usize, v as usize) } else { 206.0 }
    })
}

/// The level at a place that is so far from the middle of the nearest dot.
fn dot([x, y]: [f64; 2], radius: f64) -> f64 {
    if x.hypot(y) < radius { 40.0 } else { 205.0 }
}

fn square_dots(size: [usize; 2], pitch: f64) -> Print {
    Box::new(move |place| {
        let offset = [0, 1].map(|k| {
            let middle = 0.5 * (size[k] as f64 - 1.0);
            let nearest = (place[k] / pitch + middle).round().clamp(0.0, 2.0 * middle) - middle;
            place[k] - pitch * nearest
        });
        dot(offset, 0.3 * pitch)
    })
}

/// Rows along y, shifted in turn.
fn shifted_dots([columns, rows]: [usize; 2], step: f64) -> Print {
    Box::new(move |[x, y]| {
        let middle = 0.5 * (rows as f64 - 1.0);
        let row = (x / step + middle).round().clamp(0.0, 2.0 * middle);
        let begin = row % 2.0 - columns as f64;
        let i = (0.5 * (y / step - begin)).round().clamp(0.0, columns as f64 - 1.0);
        dot([x - step * (row - middle), y - step * (begin + 2.0 * i)], 0.4 * step)
    })
}

/// A folder with a film of a board in its poses and at rest, removed at the end.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str, print: &Print) -> Self {
        let folder = std::env::temp_dir().join(format!("board-{name}-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let film = Writer::create(&folder.join("board.mp4"), (320, 240), 10.0, Quality::Quantiser(20));
        let mut film = film.unwrap();
        (0..POSES).for_each(|pose| film.push(&posed(print, pose)).unwrap());
        (0..6).for_each(|_| film.push(&rendered(print, FLAT)).unwrap());
        film.finish().unwrap();
        Self(folder)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn guess<'a>(proposal: &'a Proposal, about: &str) -> &'a Guess {
    let guess = proposal.guesses.iter().find(|guess| guess.about == about);
    guess.unwrap_or_else(|| panic!("no guess on {about}: {proposal}"))
}

/// The proposal for a film of a print; its card can be parsed.
fn proposed(name: &str, print: &Print) -> (Proposal, toml::Table) {
    let folder = Folder::new(name, print);
    let proposal = propose(&folder.0, "specimen").unwrap();
    let card: toml::Table = toml::from_str(&proposal.card).unwrap_or_else(|e| panic!("{e}\n{}", proposal.card));
    (proposal, card)
}

fn board(card: &toml::Table, key: &str) -> String {
    card["camera"]["board"].get(key).map_or_else(|| "none".to_owned(), ToString::to_string).replace('"', "")
}

#[test]
fn each_kind_of_board_is_told_with_its_size() {
    let boards: [(&str, Print, [&str; 4]); 6] = [
        ("checkerboard", Box::new(|at| checkerboard([9, 6], 22.0, at)), ["checkerboard", "9", "6", "none"]),
        ("dots", square_dots([9, 6], 24.0), ["dots", "9", "6", "none"]),
        ("shifted", shifted_dots([4, 11], 20.0), ["asymmetric_dots", "4", "11", "none"]),
        ("four", charuco("dict_4x4_50_7x5", 28.0), ["charuco", "7", "5", "DICT_4X4_50"]),
        ("legacy", charuco("dict_5x5_100_8x6_legacy", 28.0), ["charuco", "8", "6", "DICT_5X5_50"]),
        ("six", charuco("dict_6x6_250_6x4", 34.0), ["charuco", "6", "4", "DICT_6X6_50"]),
    ];
    for (name, print, truth) in boards {
        let (proposal, card) = proposed(name, &print);
        assert_eq!(["kind", "columns", "rows", "dictionary"].map(|key| board(&card, key)), truth, "{name}: {proposal}");
        let sure = ["kind", "columns", "rows"].map(|key| guess(&proposal, &format!("camera.board.{key}")).confidence);
        assert_eq!(sure, [Confidence::Certain; 3], "{name}: {proposal}");
        assert_eq!(guess(&proposal, "camera.board.square").value, None);
        let [from, until] = [0, 1].map(|k| card["camera"]["plane"]["seconds"][k].as_float().unwrap());
        assert!((1.1..1.4).contains(&from) && (1.65..1.75).contains(&until), "{name}: {from} to {until}");
    }
}

#[test]
fn the_print_of_a_charuco_board_and_the_share_of_its_markers_are_told() {
    for (name, file, white) in [("new", "dict_4x4_50_7x5", "black"), ("old", "dict_5x5_100_8x6_legacy", "white")] {
        let (proposal, card) = proposed(&format!("print-{name}"), &charuco(file, 28.0));
        let print = guess(&proposal, "camera.board.print").value.clone().unwrap();
        assert_eq!(print, format!("upper left square {white}"));
        let marker = &guess(&proposal, "camera.board.marker").evidence;
        let share: f64 = marker.split(": ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
        assert!((share - 0.75).abs() < 0.04, "{marker}");
        assert!(
            board(&card, "marker") == "nan"
                && guess(&proposal, "camera.board.dictionary").confidence == Confidence::Likely
        );
    }
}

#[test]
fn what_a_film_does_not_show_is_a_question_or_less_than_certain() {
    // the last rows are behind a dark holder
    let prints: [(&str, Print); 3] = [
        ("covered", charuco("dict_4x4_50_7x5", 28.0)),
        ("held", square_dots([9, 6], 24.0)),
        ("clamped", Box::new(|at| checkerboard([9, 7], 22.0, at))),
    ];
    for (name, print) in prints {
        let covered: Print = Box::new(move |[x, y]| if y > 11.0 { 80.0 } else { print([x, y]) });
        let (proposal, _) = proposed(name, &covered);
        let sizes = proposal.guesses.iter().filter(|guess| guess.about.starts_with("camera.board."));
        assert!(
            sizes.into_iter().all(|guess| guess.about.ends_with("kind") || guess.confidence > Confidence::Certain),
            "{proposal}"
        );
    }
    let (proposal, _) = proposed("even", &shifted_dots([4, 10], 20.0));
    assert_eq!(guess(&proposal, "camera.board.rows").confidence, Confidence::Likely, "{proposal}");
    assert!(guess(&proposal, "camera.board").evidence.contains("look the same from two sides"));
    let (proposal, _) = proposed("square", &square_dots([6, 6], 26.0));
    assert_eq!(guess(&proposal, "camera.board.columns").confidence, Confidence::Likely, "{proposal}");
    // a checkerboard's black squares alone
    let (proposal, _) = proposed("few", &square_dots([3, 3], 26.0));
    assert_eq!(guess(&proposal, "camera.calibration").value, None, "{proposal}");
}

/// A ChArUco film on the card as it is proposed, with what was measured on the print.
#[test]
fn a_charuco_film_goes_through_the_doctor_and_the_stage_that_calibrates() {
    let print = charuco("dict_4x4_50_7x5", 28.0);
    let project = Project::new("charuco");
    let (frames, views) = (30, POSES * 6);
    project.film("camera/calibration.mp4", frames + views, |k| {
        if k < frames { rendered(&print, FLAT) } else { posed(&print, (k - frames) / 6) }
    });
    // 28 px a square at 20 px for 12 mm; the plane's scale and place are those of the card
    let board =
        "kind = \"charuco\"\ncolumns = 7\nrows = 5\nsquare = 0.0168\nmarker = 0.0126\ndictionary = \"DICT_4X4_50\"\n";
    let card = changed(&card(), "columns = 9\nrows = 6\nsquare = 0.012  # m\n", board);
    // inner corner (0, 0) is the lower left one: 2.5 squares left and 1.5 below the picture's middle
    let origin = "origin = [0.0263, -0.0242]";
    project.write("specimen.toml", &changed(&card, origin, "origin = [-0.0157, -0.0254]"));
    let run = |words: &[&str]| {
        let output =
            Command::new(env!("CARGO_BIN_EXE_study")).args(words).arg("--root").arg(&project.0).output().unwrap();
        let text = format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
        (output.status.code(), text)
    };
    let (code, said) = run(&["doctor", "fish"]);
    assert!(code == Some(0) && said.contains(" 0 to fix"), "{said}");
    let (code, said) = run(&["run", "camera", "--specimen", "fish"]);
    assert_eq!(code, Some(0), "{said}");
    // a wrong dictionary is refused by both, with the right one
    project.write(
        "specimen.toml",
        &changed(&fs::read_to_string(project.path("specimen.toml")).unwrap(), "DICT_4X4_50", "DICT_6X6_250"),
    );
    for words in [&["doctor", "fish"][..], &["run", "camera", "--specimen", "fish"]] {
        let (code, said) = run(words);
        assert!(code != Some(0) && said.contains("DICT_4X4"), "{said}");
    }
}
