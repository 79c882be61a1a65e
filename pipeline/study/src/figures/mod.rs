//! The figures of the paper, in its order.
//!
//! Stands on: the contract in `figure.rs` and its members. Never knows: a file name, a stage's code.
//! A new figure: its file and its line in [`ALL`].

mod designs;
mod dynamics;
mod four_parameters;
mod load_cell;
pub mod order;
pub mod overview;
mod setup;
pub mod solid;
mod sysid;
mod tail;
mod thrust;

use crate::entry::{Entry, figure};

/// Every figure.
pub const ALL: &[Entry] = &[
    figure::<tail::Tail>(),
    figure::<overview::Overview>(),
    figure::<designs::Designs>(),
    figure::<setup::Setup>(),
    figure::<sysid::Sysid>(),
    figure::<four_parameters::FourParameters>(),
    figure::<dynamics::Dynamics>(),
    figure::<dynamics::DynamicsWater>(),
    figure::<thrust::Thrust>(),
    figure::<load_cell::LoadCell>(),
];

/// From where a body cut open at mid height shows its inside: from above, before and beside.
const CUT_VIEW: plot::View = plot::View { towards: [-0.25, 0.62, -0.75], up: [0.0, 0.0, 1.0] };

/// What a reader must know of where the data come from.
fn origin_note<'a>(mut cards: impl Iterator<Item = &'a lab::Card>) -> String {
    match cards.all(|card| card.origin == lab::card::Origin::Laboratory) {
        true => String::new(),
        false => "All data from the virtual bench: nothing here was measured.".into(),
    }
}
