//! Films: size, rate and length, the board that they show, and the blocks in which a lamp is looked for.

use diagnostics::{Diagnostic, Result};
use track::Gray;
use track::board::{AnyCheckerboard, any_checkerboard};
use track::video::{Film, Info};

use super::files::Recording;
use super::lamp::Blocks;

/// A film that was looked at.
#[derive(Debug)]
pub(super) struct Footage {
    pub(super) name: String,
    pub(super) info: Info,
    pub(super) blocks: Blocks,
    pub(super) board: Option<BoardSeen>,
}

/// The checkerboard of a film.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct BoardSeen {
    /// Squares along the longer and the shorter side.
    pub(super) size: (usize, usize),
    /// Pictures with a board of that size, and pictures that were searched.
    pub(super) pictures: (usize, usize),
    /// The last interval in which it lies still, s.
    pub(super) still: Option<[f64; 2]>,
}

/// Pictures of a film that are searched for a board.
const SEARCHED: usize = 40;
/// Pictures that are searched before a film is given up: a film of a board shows it in a quarter of the first ones.
const ENOUGH: usize = 8;
/// A board moved by less, px, lies still; one moved by more was carried.
const MOVED: f64 = 2.0;
const CARRIED: f64 = 20.0;

/// Looks through a film.
///
/// # Errors
/// A [`Diagnostic`] when it cannot be read.
pub(super) fn read_footage(recording: &Recording) -> Result<Footage> {
    let (film, _) = Film::open_board(&recording.path, 1).map_err(Diagnostic::from)?;
    let info = film.info();
    let every = (info.frames / SEARCHED).max(1);
    let mut blocks = Blocks::new(info.width, info.height, info.frames);
    let mut search = Search::default();
    for frame in film {
        let frame = frame.map_err(Diagnostic::from)?;
        blocks.push(&frame.gray);
        if frame.index.is_multiple_of(every) {
            search.take_picture(frame.time, &frame.gray);
        }
    }
    Ok(Footage { name: recording.name.clone(), info, blocks, board: search.carried_board() })
}

/// A board in one picture.
struct Seen {
    time: f64,
    board: AnyCheckerboard,
}

/// The search for a board in the pictures of a film.
#[derive(Default)]
struct Search {
    offered: usize,
    pictures: usize,
    seen: Vec<Seen>,
}

impl Search {
    /// Searches a picture: no further one of a film whose first show none, and few of one in which it does not move.
    fn take_picture(&mut self, time: f64, gray: &Gray) {
        self.offered += 1;
        let is_late = self.pictures >= ENOUGH;
        let is_hopeless = is_late && self.seen.len() * 4 < ENOUGH;
        let is_dull = is_late && !self.is_carried() && !self.offered.is_multiple_of(4);
        if is_hopeless || is_dull {
            return;
        }
        self.pictures += 1;
        self.seen.extend(any_checkerboard(gray).map(|board| Seen { time, board }));
    }

    /// Whether two boards of one size stand apart; those in a row do, or it stands as part of the background.
    fn is_carried(&self) -> bool {
        self.seen.windows(2).any(|pair| distance(&pair[0], &pair[1]).is_some_and(|distance| distance > CARRIED))
    }

    /// The board that most pictures show, where it is carried: what lies still throughout is part of the background.
    fn carried_board(&self) -> Option<BoardSeen> {
        let count = |size: (usize, usize)| self.seen.iter().filter(|seen| seen.size() == size).count();
        let size = self.seen.iter().map(Seen::size).max_by_key(|size| (count(*size), size.0 * size.1))?;
        let views: Vec<&Seen> = self.seen.iter().filter(|seen| seen.size() == size).collect();
        let last = views.last()?;
        let is_near = |seen: &&&Seen| distance(seen, last).is_some_and(|distance| distance < MOVED);
        let still_since = views.iter().rev().take_while(is_near).last()?.time;
        let still = (last.time > still_since).then_some([still_since, last.time]);
        self.is_carried().then_some(BoardSeen { size, pictures: (views.len(), self.pictures), still })
    }
}

impl Seen {
    fn size(&self) -> (usize, usize) {
        (self.board.columns, self.board.rows)
    }
}

/// The largest distance of the same corners, px; none of boards of two sizes.
fn distance(a: &Seen, b: &Seen) -> Option<f64> {
    // length: boards of one size have as many corners
    let pairs = a.board.corners.iter().zip(&b.board.corners);
    let largest = pairs.map(|(p, q)| (p[0] - q[0]).hypot(p[1] - q[1])).fold(0.0, f64::max);
    (a.size() == b.size()).then_some(largest)
}
