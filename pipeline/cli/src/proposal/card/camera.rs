//! `[camera]`, its board and plane, and `[led]`.

use crate::proposal::film::Footage;
use crate::proposal::guess::{Confidence, Guess};
use crate::proposal::lamp::Lamp;

use super::Writer;

impl Writer {
    pub(super) fn camera(&mut self, calibration: Option<&Footage>, films: &[Footage]) {
        let Some((film, board)) = calibration.and_then(|film| Some((film, film.board.as_ref()?))) else {
            if !films.is_empty() {
                self.guesses.push(Guess::question(
                    "camera.calibration",
                    "no film shows a whole checkerboard: name the recording of the board",
                ));
            }
            return;
        };
        let other_boards =
            films.iter().filter(|other| other.board.as_ref().is_some_and(|board| board.pictures.0 >= 3)).count();
        let (count, searched) = board.pictures;
        let boards_seen = format!("a whole checkerboard in {count} of {searched} pictures");
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
        self.board(board.size, (count, searched));
        self.plane(board.still);
    }

    fn board(&mut self, (columns, rows): (usize, usize), (count, searched): (usize, usize)) {
        self.text.push_str("\n[camera.board]\n");
        let is_sure = count >= 5 && (columns + rows) % 2 == 1 && count * 2 > searched;
        let confidence = if is_sure { Confidence::Certain } else { Confidence::Likely };
        let corners_seen = format!("{} × {} inner corners in {count} of {searched} pictures", columns - 1, rows - 1);
        self.line("columns", Guess::new(confidence, "camera.board.columns", columns, &corners_seen));
        self.line("rows", Guess::new(confidence, "camera.board.rows", rows, &corners_seen));
        self.question("camera.board.", "square", "nan", "m, 0.001 to 0.2; the side of a square, measured on the print");
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
        self.question("camera.plane.", "origin", "[nan, nan]", "m, -1 to 1; x and y of its inner corner (0, 0)");
        self.text.push_str("along = [1.0, 0.0]  # x and y of the direction along which columns count up\n");
        self.guesses.push(Guess::question("camera.plane.along", "[1.0, 0.0] is written: along x of the CAD frame"));
        self.question("camera.plane.", "height", "nan", "m, -1 to 1; z of the board's upper side");
    }

    pub(super) fn lamp(&mut self, lamp: Option<&Lamp>, films: &[&Footage]) {
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
        let evidence = format!("dark, light, then dark again in the {} films", films.len());
        let centre = format!("[{:.1}, {:.1}]", lamp.centre[0], lamp.centre[1]);
        self.line("centre", Guess::new(Confidence::Likely, "led.centre", centre, &evidence));
        self.line("radius", Guess::new(Confidence::Likely, "led.radius", format!("{:.1}", lamp.radius), &evidence));
    }
}
