//! The pictures of a board: frames of a film, or the files of a folder.

use std::path::Path;

use diagnostics::{Diagnostic, Result};
use rayon::prelude::*;
use si::Point2;
use track::Gray;
use track::board::{BoardError, Target};
use track::calibrate::View;
use track::video::{Film, picture, picture_files};

use crate::Interrupt;

/// A picture that was left out.
pub(super) struct LeftOut {
    pub name: String,
    /// The view that it repeats.
    pub repeats: Option<String>,
    /// What is wrong, and why.
    pub reason: String,
}

/// The pictures in which the board was found.
#[derive(Default)]
pub(super) struct Views {
    /// Name of each picture, or time of each frame.
    pub names: Vec<String>,
    /// The board in each.
    pub views: Vec<View>,
    /// The first of the pictures, for the figure.
    pub first: Option<Gray>,
    /// Size of all, px.
    pub size: (usize, usize),
    /// Pictures in which it was not found, or another part of it than is needed, and pictures of a view that another one shows.
    pub left_out: Vec<LeftOut>,
    /// Name and size of every picture, px.
    sizes: Vec<(String, (usize, usize))>,
    /// Why the last of those has none.
    refusal: Option<Diagnostic>,
}

impl Views {
    /// Pictures that repeat a view.
    pub(super) fn repeated(&self) -> usize {
        self.left_out.iter().filter(|picture| picture.repeats.is_some()).count()
    }

    /// Pictures in which the board, or enough of it, was not found.
    pub(super) fn without_board(&self) -> usize {
        self.left_out.len() - self.repeated()
    }

    /// The views in a film, one frame in `every`, or in a folder of pictures.
    ///
    /// # Errors
    /// A [`Diagnostic`] when the source cannot be read, its pictures differ in size, none shows the board, or it was interrupted.
    pub(super) fn from_source(
        (source, every): (&Path, usize),
        target: &Target,
        interrupt: Interrupt<'_>,
    ) -> Result<Self> {
        let mut views = Self::default();
        if source.is_dir() {
            // As many at a time as there are cores: a picture of 24 Mpx takes 100 MB while it is decoded.
            for files in picture_files(source)?.chunks(rayon::current_num_threads()) {
                crate::check_interrupt(interrupt)?;
                let looked: Vec<_> = files.par_iter().map(|file| Looked::find_board(picture(file)?, target)).collect();
                for (file, looked) in files.iter().zip(looked) {
                    views.take_view(file.file_name().unwrap_or_default().to_string_lossy().into_owned(), looked?);
                }
            }
            views.check_sizes(source)?;
        } else {
            for frame in Film::open(source)? {
                crate::check_interrupt(interrupt)?;
                let frame = frame?;
                if frame.index.is_multiple_of(every) {
                    views.take_view(format!("{:.3} s", frame.time), Looked::find_board(frame.gray, target)?);
                }
            }
        }
        match views.views.is_empty() {
            true => Err(views.no_view_diagnostic(source)),
            false => Ok(views),
        }
    }

    fn take_view(&mut self, name: String, Looked { gray, found }: Looked) {
        let size = (gray.width, gray.height);
        self.sizes.push((name.clone(), size));
        self.size = self.sizes[0].1;
        if size != self.size {
            return;
        }
        match found {
            Ok(view) => match self.views.iter().position(|previous| is_same(previous, &view)) {
                Some(previous) => {
                    let repeats = Some(self.names[previous].clone());
                    let reason = format!("it shows the view of {}", self.names[previous]);
                    self.left_out.push(LeftOut { name, repeats, reason });
                }
                None => {
                    self.names.push(name);
                    self.views.push(view);
                    self.first.get_or_insert(gray);
                }
            },
            Err(refusal) => {
                let refusal = Diagnostic::from(refusal);
                let reason = format!("{}; {}", refusal.what, refusal.why);
                self.left_out.push(LeftOut { name: name.clone(), repeats: None, reason });
                self.refusal = Some(refusal.while_doing(name));
            }
        }
    }

    /// Refuses pictures of several sizes by the names of those that the fewest have: they are the odd ones, whichever comes first.
    fn check_sizes(&self, source: &Path) -> Result<()> {
        let mut counts: Vec<((usize, usize), usize)> = Vec::new();
        for (_, size) in &self.sizes {
            match counts.iter_mut().find(|(counted, _)| counted == size) {
                Some((_, count)) => *count += 1,
                None => counts.push((*size, 1)),
            }
        }
        let Some(&(common, count)) = counts.iter().rev().max_by_key(|(_, count)| *count) else { return Ok(()) };
        let mut odd = self.sizes.iter().filter(|(_, size)| *size != common);
        let Some((name, (width, height))) = odd.next() else { return Ok(()) };
        let other_pictures = match odd.count() {
            0 => String::new(),
            more => format!("; {more} more pictures differ"),
        };
        let defect = format!("picture {name} has {width} × {height} px");
        let reason = format!(
            "{count} of {} pictures have {} × {} px, and a camera file holds for one size{other_pictures}",
            self.sizes.len(),
            common.0,
            common.1
        );
        let action = "take out the pictures of another camera, size or orientation";
        Err(Diagnostic::file(&source.join(name), defect, reason, action))
    }

    fn no_view_diagnostic(self, source: &Path) -> Diagnostic {
        let no_picture =
            || Diagnostic::new("there is no picture", "PNG and JPEG are read", "put pictures of the board there");
        self.refusal.unwrap_or_else(no_picture).in_file_unless_named(source)
    }
}

/// A picture and the board in it.
struct Looked {
    gray: Gray,
    found: std::result::Result<View, BoardError>,
}

impl Looked {
    fn find_board(gray: Gray, target: &Target) -> Result<Self> {
        Ok(Self { found: target.find(&gray), gray })
    }
}

/// Root mean square distance of the points of two pictures below which both show one view, px: a tenth of the noise of a corner in a good
/// picture. Two pictures of a camera at rest differ by more, and copies, also as another format, by less.
const SAME: f64 = 5e-3;

/// Whether the points are those of one picture: a copy adds no evidence, and would narrow every interval.
fn is_same(a: &View, b: &View) -> bool {
    let squared_distance = |(p, q): (&Point2, &Point2)| (p[0] - q[0]).powi(2) + (p[1] - q[1]).powi(2);
    let (is_of_same_points, a, b) = (a.numbers == b.numbers, &a.corners, &b.corners);
    is_of_same_points
        && a.len() == b.len()
        && a.iter().zip(b).map(squared_distance).sum::<f64>() < SAME * SAME * a.len() as f64
}
