//! Check of `[camera.board]`: sizes in their ranges, and the keys of a ChArUco board where it is one.

use crate::range::{Checked, violation, within};

use super::camera::{Board, BoardKind};

/// Bits along a side of a marker, and markers of a dictionary, in the names of OpenCV's predefined dictionaries.
const SIDES: [usize; 4] = [4, 5, 6, 7];
const COUNTS: [usize; 4] = [50, 100, 250, 1000];
/// Those of a name of their own.
const OTHERS: [&str; 6] = [
    "DICT_ARUCO_ORIGINAL",
    "DICT_APRILTAG_16h5",
    "DICT_APRILTAG_25h9",
    "DICT_APRILTAG_36h10",
    "DICT_APRILTAG_36h11",
    "DICT_ARUCO_MIP_36h12",
];

/// Checks the numbers of a board, and that `marker` and `dictionary` stand on a ChArUco board alone.
pub(super) fn check_board(board: &Board) -> Checked {
    within("camera.board.columns", board.columns as f64, 3.0..=100.0, "squares")?;
    within("camera.board.rows", board.rows as f64, 3.0..=100.0, "squares")?;
    within("camera.board.square", board.square, 1e-3..=0.2, "m")?;
    match (board.kind, board.marker, &board.dictionary) {
        (BoardKind::Charuco, Some(marker), Some(dictionary)) => {
            within("camera.board.marker", marker, 5e-4..=0.2, "m")?;
            check_smaller(marker, board.square)?;
            check_dictionary(dictionary)
        }
        (BoardKind::Charuco, marker, _) => {
            let key = if marker.is_none() { "marker" } else { "dictionary" };
            let defect = format!("the ChArUco board has no {key}");
            let reason = "its corners are told apart by the numbers of its markers";
            violation(
                &format!("camera.board.{key}"),
                defect,
                reason,
                "add marker (m) and dictionary, such as \"DICT_4X4_50\"",
            )
        }
        (_, None, None) => Ok(()),
        (_, marker, _) => {
            let key = if marker.is_some() { "marker" } else { "dictionary" };
            let defect = format!("{key} belongs to a ChArUco board");
            let action = "set kind = \"charuco\", or take marker and dictionary out";
            violation(&format!("camera.board.{key}"), defect, "the board is of another kind", action)
        }
    }
}

fn check_smaller(marker: f64, square: f64) -> Checked {
    if marker < 0.95 * square {
        return Ok(());
    }
    let defect = format!("the markers of {marker} m do not fit into the squares of {square} m");
    let reason = "white ground around a marker sets it off; it takes a share of 5 % at least";
    violation("camera.board.marker", defect, reason, "measure marker and square on the print")
}

fn check_dictionary(name: &str) -> Checked {
    let mut names = SIDES.iter().flat_map(|side| COUNTS.map(|count| format!("DICT_{side}X{side}_{count}")));
    if names.any(|known| known == name) || OTHERS.contains(&name) {
        return Ok(());
    }
    let defect = format!("`{name}` is not a dictionary that is known here");
    let reason = format!("the predefined ones of 4×4 to 7×7 bits are, as OpenCV names them, and {}", OTHERS.join(", "));
    let action = "give DICT_4X4_50, DICT_5X5_100, DICT_6X6_250 or the like; 50, 100, 250 or 1000 markers";
    violation("camera.board.dictionary", defect, &reason, action)
}
