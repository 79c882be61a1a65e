//! `[camera]`, its board and plane, and `[led]`.

use track::board::any::GridKind;
use track::board::charuco::any::AnyCharuco;

use crate::proposal::film::{BoardSeen, Footage, Print};
use crate::proposal::guess::{Confidence, Guess};
use crate::proposal::lamp::Lamp;

use super::Writer;

impl Writer {
    pub(super) fn camera(&mut self, calibration: Option<&Footage>, films: &[Footage]) {
        let Some((film, board)) = calibration.and_then(|film| Some((film, film.board.as_ref()?))) else {
            if !films.is_empty() {
                self.guesses.push(Guess::question(
                    "camera.calibration",
                    "no film shows a whole board that is carried: name the recording of the board",
                ));
            }
            return;
        };
        let other_boards =
            films.iter().filter(|other| other.board.as_ref().is_some_and(|board| board.pictures.0 >= 3)).count();
        let (count, searched) = board.pictures;
        let boards_seen = format!("{} in {count} of {searched} pictures", print_word(&board.print));
        let confidence = if other_boards == 1 { Confidence::Certain } else { Confidence::Likely };
        let evidence = if other_boards == 1 {
            format!("{boards_seen}, and in no other film")
        } else {
            format!("{boards_seen}; other films show one too")
        };
        self.text.push_str("\n[camera]\n");
        self.file("calibration", &film.name, Guess::new(confidence, "camera.calibration", &film.name, evidence));
        let every = (film.info.frames / 40).clamp(1, 1000);
        self.line("frame_every", Guess::new(Confidence::Likely, "camera.frame_every", every, "some forty views"));
        self.text.push_str("readout = 0.0  # s, from the first row to the last: 0 for a global shutter, some 0.01 to 0.03 for a phone\n");
        self.guesses.push(Guess::question("camera.readout", "0 is written: right for a global shutter alone"));
        self.text.push_str("\n[camera.board]\n");
        match board.print {
            Print::Grid(kind, size) => self.grid(kind, size, board),
            Print::Markers(_, Some(charuco)) => self.charuco(&charuco, board),
            Print::Markers(dictionary, None) => self.markers_alone(&dictionary.to_string()),
        }
        self.plane(board.still);
    }

    fn grid(&mut self, kind: GridKind, [columns, rows]: [usize; 2], board: &BoardSeen) {
        let (count, searched) = board.pictures;
        let (word, cells, has_one_order) = match kind {
            GridKind::Checkerboard => ("checkerboard", "squares", (columns + rows) % 2 == 1),
            GridKind::Dots => ("dots", "dots", columns != rows),
            GridKind::AsymmetricDots => ("asymmetric_dots", "rows of dots, shifted in turn,", rows % 2 == 1),
        };
        let confidence = sureness(board.whole >= 5 && has_one_order && count * 2 > searched);
        let size = match kind {
            GridKind::Checkerboard => format!("{} × {} inner corners", columns - 1, rows - 1),
            _ => format!("{columns} × {rows} {cells}"),
        };
        let evidence =
            format!("{size} in {count} of {searched} pictures, {} of them with light ground all around", board.whole);
        self.line("kind", Guess::new(confidence, "camera.board.kind", format!("{word:?}"), &evidence));
        self.line("columns", Guess::new(confidence, "camera.board.columns", columns, &evidence));
        self.line("rows", Guess::new(confidence, "camera.board.rows", rows, &evidence));
        if !has_one_order {
            let symmetry = format!(
                "{columns} × {rows} {cells} look the same from two sides, and are not read: film another board"
            );
            self.guesses.push(Guess::question("camera.board", symmetry));
        }
        self.square(match kind {
            GridKind::Checkerboard => "the side of a square, measured on the print",
            GridKind::Dots => "the distance of the middles of two dots, measured on the print",
            GridKind::AsymmetricDots => {
                "the distance of two rows, half that of two dots of a row, measured on the print"
            }
        });
    }

    fn charuco(&mut self, charuco: &AnyCharuco, board: &BoardSeen) {
        let (count, searched) = board.pictures;
        let AnyCharuco { columns, rows, .. } = *charuco;
        let is_plausible = charuco.first == 0 && (rows % 2 == 0 || !charuco.is_legacy);
        let confidence = sureness(board.whole >= 5 && is_plausible && count * 2 > searched);
        let evidence = format!(
            "the numbers of the markers in {count} of {searched} pictures, {} of them with light ground all around",
            charuco.whole
        );
        self.line(
            "kind",
            Guess::new(sureness(count >= 5 && is_plausible), "camera.board.kind", "\"charuco\"", &evidence),
        );
        self.line("columns", Guess::new(confidence, "camera.board.columns", columns, &evidence));
        self.line("rows", Guess::new(confidence, "camera.board.rows", rows, &evidence));
        let print = if charuco.is_legacy { "white" } else { "black" };
        let print =
            Guess::new(confidence, "camera.board.print", format!("upper left square {print}"), "both prints are read");
        self.put(format_args!("# {}  # {}\n", print.value.as_deref().unwrap_or_default(), print.remark()));
        self.guesses.push(print);
        self.dictionary(charuco);
        self.square("the side of a square, measured on the print");
        let marker = format!(
            "m, 0.0005 to 0.2; the side of a marker: {:.2} of that of a square, by the pictures",
            charuco.marker_share
        );
        self.question("camera.board.", "marker", "nan", &marker);
        if !is_plausible {
            let evidence =
                format!("its first marker has number {}: boards count from 0 in their upper left", charuco.first);
            self.guesses.push(Guess::question("camera.board", evidence));
        }
    }

    fn dictionary(&mut self, charuco: &AnyCharuco) {
        let dictionary = charuco.dictionary;
        let (confidence, evidence) = match dictionary.has_siblings() {
            true => {
                (Confidence::Likely, "the smallest with its markers; larger ones of as many bits begin with the same")
            }
            false => (sureness(charuco.whole >= 5), "the only one with its markers"),
        };
        let name = format!("{:?}", dictionary.to_string());
        self.line("dictionary", Guess::new(confidence, "camera.board.dictionary", name, evidence));
    }

    /// Markers that stand on no ChArUco board.
    fn markers_alone(&mut self, dictionary: &str) {
        let table = "camera.board.";
        let action =
            format!("squares, 3 to 100; markers of {dictionary} are seen, but not where a ChArUco board has them");
        self.question(table, "columns", "nan", &action);
        self.question(table, "rows", "nan", &action);
        self.square("the side of a square, measured on the print");
    }

    fn square(&mut self, action: &str) {
        self.question("camera.board.", "square", "nan", &format!("m, 0.001 to 0.2; {action}"));
    }

    fn plane(&mut self, still: Option<[f64; 2]>) {
        self.text.push_str("\n[camera.plane]\n");
        match still {
            Some([from, to]) => {
                let evidence = "the board lies still then, at the end of its film";
                let value = format!("[{from:?}, {to:?}]");
                self.line("seconds", Guess::new(Confidence::Likely, "camera.plane.seconds", value, evidence));
            }
            None => self.question(
                "camera.plane.",
                "seconds",
                "[nan, nan]",
                "s, 0 to 3600; when the board lies on the plane",
            ),
        }
        self.question(
            "camera.plane.",
            "origin",
            "[nan, nan]",
            "m, -1 to 1; x and y of its inner corner (0, 0), of dots the first",
        );
        self.text.push_str("along = [1.0, 0.0]  # x and y of the direction along which columns count up\n");
        self.guesses.push(Guess::question("camera.plane.along", "[1.0, 0.0] is written: along x of the CAD frame"));
        self.question("camera.plane.", "height", "nan", "m, -1 to 1; z of the board's upper side");
    }

    /// The lamp; `is_logged` is whether a log has one that is on as long.
    pub(super) fn lamp(&mut self, lamp: Option<&Lamp>, films: &[&Footage], is_logged: bool) {
        if films.is_empty() {
            return;
        }
        self.text.push_str("\n[led]\n");
        let Some(lamp) = lamp else {
            self.question(
                "led.",
                "centre",
                "[nan, nan]",
                "px, 0 to 20000; no place is dark, light and dark again in the films",
            );
            self.question("led.", "radius", "nan", "px, 1 to 500; of its bright disc");
            return;
        };
        let (confidence, logged) = match is_logged {
            true => (Confidence::Likely, "as long as in the logs"),
            false => (Confidence::Unsure, "but as long in no log: it may be a mark that moves"),
        };
        let evidence = format!("dark, light, then dark again in the {} films, {logged}", films.len());
        let centre = format!("[{:.1}, {:.1}]", lamp.centre[0], lamp.centre[1]);
        self.line("centre", Guess::new(confidence, "led.centre", centre, &evidence));
        self.line("radius", Guess::new(confidence, "led.radius", format!("{:.1}", lamp.radius), &evidence));
    }
}

fn sureness(is_sure: bool) -> Confidence {
    if is_sure { Confidence::Certain } else { Confidence::Likely }
}

fn print_word(print: &Print) -> &'static str {
    match print {
        Print::Grid(GridKind::Checkerboard, _) => "a whole checkerboard",
        Print::Grid(GridKind::Dots, _) => "a whole grid of dots",
        Print::Grid(GridKind::AsymmetricDots, _) => "a whole grid of shifted rows of dots",
        Print::Markers(_, Some(_)) => "a ChArUco board",
        Print::Markers(_, None) => "markers",
    }
}
