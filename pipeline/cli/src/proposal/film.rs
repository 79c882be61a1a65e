//! Films: size, rate and length, the board that they show, and the blocks in which a lamp is looked for.

use diagnostics::{Diagnostic, Result};
use si::Point2;
use track::Gray;
use track::board::any::{AnyBoard, GridKind, any_board};
use track::board::charuco::Dictionary;
use track::board::charuco::any::{AnyCharuco, MarkerSet, any_charuco};
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

/// What is printed on a board, and its size.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Print {
    /// Squares or dots along the longer and the shorter side; of asymmetric dots, dots of a row and rows.
    Grid(GridKind, [usize; 2]),
    /// Markers of a dictionary; none where they stand on no ChArUco board.
    Markers(Dictionary, Option<AnyCharuco>),
}

/// The board of a film.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct BoardSeen {
    pub(super) print: Print,
    /// Pictures with such a board, and pictures that were searched.
    pub(super) pictures: (usize, usize),
    /// Of the former, those that show light ground all around it.
    pub(super) whole: usize,
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
        blocks.push(frame.time, &frame.gray);
        if frame.index.is_multiple_of(every) {
            search.take_picture(frame.time, &frame.gray);
        }
    }
    Ok(Footage { name: recording.name.clone(), info, blocks, board: search.carried_board() })
}

/// A board in one picture.
struct Seen {
    time: f64,
    board: AnyBoard,
}

/// What boards of several pictures have in common.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Class {
    Grid(GridKind, [usize; 2]),
    Markers(Dictionary),
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
        self.seen.extend(any_board(gray).map(|board| Seen { time, board }));
    }

    /// Whether two boards of one class stand apart; those in a row do, or it stands as part of the background.
    fn is_carried(&self) -> bool {
        self.seen.windows(2).any(|pair| distance(&pair[0], &pair[1]).is_some_and(|distance| distance > CARRIED))
    }

    /// The board that most pictures show, where it is carried: what lies still throughout is part of the background.
    fn carried_board(&self) -> Option<BoardSeen> {
        let count = |class: Class| self.seen.iter().filter(|seen| seen.class() == class).count();
        let class = self.seen.iter().map(Seen::class).max_by_key(|class| (count(*class), class.points()))?;
        let views: Vec<&Seen> = self.seen.iter().filter(|seen| seen.class() == class).collect();
        let last = views.last()?;
        let is_near = |seen: &&&Seen| distance(seen, last).is_some_and(|distance| distance < MOVED);
        let still_since = views.iter().rev().take_while(is_near).last()?.time;
        let still = (last.time > still_since).then_some([still_since, last.time]);
        let has_margin = |seen: &&&Seen| matches!(&seen.board, AnyBoard::Grid(grid) if grid.has_margin);
        let mut whole = views.iter().filter(has_margin).count();
        let print = match class {
            Class::Grid(kind, size) => Print::Grid(kind, size),
            Class::Markers(dictionary) => {
                let sets: Vec<&MarkerSet> = views.iter().filter_map(|seen| seen.markers()).collect();
                let charuco = any_charuco(&sets);
                whole = charuco.map_or(0, |charuco| charuco.whole);
                Print::Markers(dictionary, charuco)
            }
        };
        self.is_carried().then_some(BoardSeen { print, pictures: (views.len(), self.pictures), whole, still })
    }
}

impl Class {
    fn points(self) -> usize {
        match self {
            Self::Grid(_, [columns, rows]) => columns * rows,
            Self::Markers(_) => 0,
        }
    }
}

impl Seen {
    fn class(&self) -> Class {
        match &self.board {
            AnyBoard::Grid(grid) => Class::Grid(grid.kind, [grid.columns, grid.rows]),
            AnyBoard::Markers(set) => Class::Markers(set.dictionary),
        }
    }

    fn markers(&self) -> Option<&MarkerSet> {
        match &self.board {
            AnyBoard::Markers(set) => Some(set),
            AnyBoard::Grid(_) => None,
        }
    }
}

/// The largest distance of the same points, px; none of boards of two classes, or without a common marker.
fn distance(a: &Seen, b: &Seen) -> Option<f64> {
    let apart = |p: &Point2, q: &Point2| (p[0] - q[0]).hypot(p[1] - q[1]);
    let distances: Vec<f64> = match (&a.board, &b.board) {
        // length: boards of one class have as many points
        (AnyBoard::Grid(p), AnyBoard::Grid(q)) => p.points.iter().zip(&q.points).map(|(p, q)| apart(p, q)).collect(),
        (AnyBoard::Markers(p), AnyBoard::Markers(q)) => {
            p.markers.iter().filter_map(|(number, quad)| Some(apart(&quad[0], &q.markers.get(number)?[0]))).collect()
        }
        _ => return None,
    };
    (a.class() == b.class()).then(|| distances.into_iter().reduce(f64::max)).flatten()
}
