//! Boards on cards: dots, asymmetric dots and ChArUco.
#![allow(clippy::unwrap_used)] // a test may fail where it stands

use std::path::Path;

use lab::card::{self, BoardKind, Card};

const GOOD: &str = include_str!("../../study/tests/card.toml");

fn at() -> &'static Path {
    Path::new("data/raw/fish/specimen.toml")
}

fn good() -> Card {
    card::parse(GOOD, at()).unwrap()
}

#[test]
fn a_board_of_dots_is_read_back_the_same() {
    let text = GOOD.replacen("[camera.board]\n", "[camera.board]\nkind = \"dots\"\n", 1);
    let card = card::parse(&text, at()).unwrap();
    let kind = |card: &Card| card.camera.as_ref().map(|camera| camera.board.kind);
    assert_eq!((kind(&good()), kind(&card)), (Some(BoardKind::Checkerboard), Some(BoardKind::Dots)));
    assert_eq!(card::parse(&card::write(&card), at()).unwrap(), card);
}

#[test]
fn a_charuco_board_is_read_back_the_same_and_has_marker_and_dictionary() {
    let with = |keys: &str| GOOD.replacen("[camera.board]\n", &format!("[camera.board]\n{keys}"), 1);
    let marker = "marker = 0.008\n";
    let whole = format!("kind = \"charuco\"\n{marker}dictionary = \"DICT_5X5_250\"\n");
    let card = card::parse(&with(&whole), at()).unwrap();
    assert_eq!(card.camera.as_ref().map(|camera| camera.board.kind), Some(BoardKind::Charuco));
    assert_eq!(card::parse(&card::write(&card), at()).unwrap(), card);
    let refusals = [
        ("kind = \"charuco\"\n", "the ChArUco board has no marker"),
        (marker, "marker belongs to a ChArUco board"),
        (&whole.replace("5X5", "5X6"), "`DICT_5X6_250` is not a dictionary that is known here"),
        (&whole.replace("0.008", "0.2"), "do not fit into the squares"),
    ];
    for (keys, reason) in refusals {
        let refusal = card::parse(&with(keys), at()).unwrap_err().to_string();
        assert!(refusal.contains(reason) && refusal.contains("specimen.toml, line"), "{refusal}");
    }
    let shifted = card::parse(&with("kind = \"asymmetric_dots\"\n"), at()).unwrap();
    assert_eq!(card::parse(&card::write(&shifted), at()).unwrap(), shifted);
}
