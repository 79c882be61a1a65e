//! The pictures of a board: frames of a film, or the files of a folder.

use std::path::Path;

use diagnostics::{Diagnostic, Result};
use si::Point2;
use track::Gray;
use track::board::Target;
use track::video::{Film, pictures};

use crate::Interrupt;

/// The pictures in which the board was found.
#[derive(Default)]
pub(super) struct Views {
    /// Name of each picture, or time of each frame.
    pub names: Vec<String>,
    /// Points of the board in each, px.
    pub corners: Vec<Vec<Point2>>,
    /// The first of the pictures, for the figure.
    pub first: Option<Gray>,
    /// Size of all, px.
    pub size: (usize, usize),
    /// Pictures without the whole board.
    pub without: usize,
    /// Why the last of those has none.
    refusal: Option<Diagnostic>,
}

impl Views {
    /// The views in a film, one frame in `every`, or in a folder of pictures.
    ///
    /// # Errors
    /// A [`Diagnostic`] when the source cannot be read, its pictures differ in size, none shows the board, or it was interrupted.
    pub(super) fn seen((source, every): (&Path, usize), target: &Target, interrupt: Interrupt<'_>) -> Result<Self> {
        let mut views = Self::default();
        if source.is_dir() {
            for picture in pictures(source)? {
                crate::interrupted(interrupt)?;
                let (path, gray) = picture?;
                let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
                views.look(name, gray, target)?;
            }
        } else {
            for frame in Film::open(source)? {
                crate::interrupted(interrupt)?;
                let frame = frame?;
                if frame.index.is_multiple_of(every) {
                    views.look(format!("{:.3} s", frame.time), frame.gray, target)?;
                }
            }
        }
        match views.corners.is_empty() {
            true => Err(views.none(source)),
            false => Ok(views),
        }
    }

    fn look(&mut self, name: String, gray: Gray, target: &Target) -> Result<()> {
        let size = (gray.width, gray.height);
        if self.size != (0, 0) && self.size != size {
            let what = format!("picture {name} has {} × {} px", size.0, size.1);
            let why = format!(
                "those before it have {} × {} px, and a camera file holds for one size",
                self.size.0, self.size.1
            );
            return Err(Diagnostic::new(what, why, "take out the pictures of another camera, size or orientation"));
        }
        self.size = size;
        match target.find(&gray) {
            Ok(corners) => {
                self.names.push(name);
                self.corners.push(corners);
                self.first.get_or_insert(gray);
            }
            Err(refusal) => {
                self.without += 1;
                self.refusal = Some(Diagnostic::from(refusal).while_doing(name));
            }
        }
        Ok(())
    }

    fn none(self, source: &Path) -> Diagnostic {
        let no_picture =
            || Diagnostic::new("there is no picture", "PNG and JPEG are read", "put pictures of the board there");
        self.refusal.unwrap_or_else(no_picture).in_file_unless_named(source)
    }
}
