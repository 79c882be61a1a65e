//! The chambers of the tail: where they lie, and the parameters that leave no room for them.
#![allow(clippy::unwrap_used)] // a test may fail where it stands

use tail_cad::{Resolution, Tail, TailError};

fn near(found: f64, expected: f64) {
    assert!((found - expected).abs() < 1e-12, "{found} instead of {expected}");
}

#[test]
fn the_chambers_fill_their_part_of_the_tail_with_ribs_between_them() {
    for tail in [Tail::nine_chambers(), Tail { first_longer: 3e-3, ..Tail::nine_chambers() }] {
        let length = |i: usize| tail.chamber(i)[1] - tail.chamber(i)[0];
        near(tail.chamber(0)[0], tail.chambers_start);
        near(tail.chamber(8)[1], tail.chambers_end);
        near(length(0) - length(1), tail.first_longer);
        (0..8).for_each(|i| near(tail.chamber(i + 1)[0] - tail.chamber(i)[1], tail.rib));
    }
}

#[test]
fn twelve_chambers_lie_where_the_nine_do_between_thinner_ribs() {
    let (nine, twelve) = (Tail::nine_chambers(), Tail::twelve_chambers());
    near(twelve.chamber(0)[0], nine.chamber(0)[0]);
    near(twelve.chamber(11)[1], nine.chamber(8)[1]);
    assert!(twelve.rib < nine.rib && nine.rib > 1.2 * (twelve.chamber(1)[0] - twelve.chamber(0)[1]));
}

/// The part for which a tail has no room.
fn refused(tail: &Tail) -> &'static str {
    match tail.solids(2e-3) {
        Err(TailError::TooSmall { part, .. }) => part,
        other => panic!("{other:?}"),
    }
}

#[test]
fn parts_that_leave_no_room_for_others_are_refused_by_name() {
    let tail = Tail::nine_chambers;
    assert_eq!(refused(&Tail { rib: 8e-3, ..tail() }), "a chamber's length");
    assert_eq!(refused(&Tail { channel_half_height: 8e-3, ..tail() }), "the chamber above the channel");
    assert_eq!(refused(&Tail { wall: [2e-3, 9e-3], ..tail() }), "the chamber's depth beyond the channel");
    assert_eq!(refused(&Tail { slot_share: 0.0, ..tail() }), "the slot above the channel");
    assert_eq!(refused(&Tail { slot_share: 1.0, ..tail() }), "the sheet above the slot");
}

#[test]
fn the_last_chamber_needs_no_room_for_a_channel_behind_it() {
    // beyond its walls it is 2.9 mm deep at its end, the one before it 4.1 mm
    assert!(Tail { channel_depth: 3.3e-3, ..Tail::nine_chambers() }.solids(2e-3).is_ok());
}

#[test]
fn a_refusal_gives_both_sizes_in_millimetres() {
    // nine chambers and eight ribs of 8 mm in 63 mm
    let refused = Tail { rib: 8e-3, ..Tail::nine_chambers() }.solids(2e-3).unwrap_err().to_string();
    assert!(refused.starts_with("a chamber's length is -0.111 mm at x = 8.00 mm"), "{refused}");
    assert!(refused.contains("it must be more than 0.500 mm"), "{refused}");
}

#[test]
fn a_deeper_channel_adds_its_depth_in_every_rib() {
    let volume = |depth: f64| {
        let tail = Tail { channel_depth: depth, ..Tail::nine_chambers() };
        tail.mesh(&Resolution::even(&tail, 4e-3)).unwrap().chamber_volume(0)
    };
    // eight ribs of 2.5 mm, half a channel 2 mm high, deeper by 1 mm: 40 mm³
    near((volume(3e-3) - volume(2e-3)) / 40e-9, 1.0);
}

/// The lines across the tail, µm.
fn lines(tail: &Tail) -> Vec<i64> {
    let mesh = tail.mesh(&Resolution::even(tail, 4e-3)).unwrap();
    let mut lines: Vec<i64> = mesh.nodes.iter().map(|node| (node[0] * 1e6).round() as i64).collect();
    lines.sort_unstable();
    lines.dedup();
    lines
}

#[test]
fn the_lines_across_the_clamped_end_are_an_edge_apart() {
    assert_eq!(lines(&Tail::nine_chambers())[..3], [0, 4000, 8000]);
}

#[test]
fn a_first_chamber_of_twice_the_length_has_twice_the_lines() {
    // the others are (63 − 5 − 8 × 2.5) / 9 = 4.222 mm long, the first by 5 mm longer
    let tail = Tail { first_longer: 5e-3, ..Tail::nine_chambers() };
    assert_eq!(lines(&tail)[2..5], [8000, 12_611, 17_222]);
}
