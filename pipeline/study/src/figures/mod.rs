//! The figures of the paper, in its order.

mod calibration;
mod designs;
mod dynamics;
mod four_parameters;
mod load_cell;
pub mod order;
mod overview;
mod relaxation;
mod setup;
mod sysid;
mod tail;
mod thrust;
mod waveforms;

use crate::subject::Study;
use workflow::entry::{Entry, figure};

/// Every figure.
pub const ALL: &[Entry<Study>] = &[
    figure::<tail::Tail>(),
    figure::<overview::Overview>(),
    figure::<designs::Designs>(),
    figure::<setup::Setup>(),
    figure::<sysid::Sysid>(),
    figure::<four_parameters::FourParameters>(),
    figure::<relaxation::Relaxation>(),
    figure::<dynamics::Dynamics>(),
    figure::<dynamics::DynamicsWater>(),
    figure::<thrust::Thrust>(),
    figure::<waveforms::Waveforms>(),
    figure::<load_cell::LoadCell>(),
    figure::<calibration::Calibration>(),
];

/// From where a body cut open at mid height shows its inside: from above, before and beside.
const CUT_VIEW: plot::View = plot::View { direction: [-0.25, 0.62, -0.75], up: [0.0, 0.0, 1.0] };

/// The origin of the data, as a note for the reader.
fn origin_note<'a>(mut cards: impl Iterator<Item = &'a lab::Card>) -> String {
    match cards.all(|card| card.origin == lab::card::Origin::Laboratory) {
        true => String::new(),
        false => "All data are from the virtual bench; nothing was measured.".into(),
    }
}
