//! The figures of the paper, in its order, and that of the front page.

mod calibration;
mod designs;
mod dynamics;
mod four_parameters;
mod inflation;
mod load_cell;
pub mod order;
mod overview;
mod relaxation;
mod setup;
mod static_overlay;
mod sysid;
mod tail;
mod thrust;
mod waveforms;

use plot::{Mark, palette};
use records::subject::Study;
use si::Point2;
use workflow::entry::{Entry, figure};

/// Every figure.
pub const ALL: &[Entry<Study>] = &[
    figure::<tail::Tail>(),
    figure::<overview::Overview>(),
    figure::<designs::Designs>(),
    figure::<setup::Setup>(),
    figure::<sysid::Sysid>(),
    figure::<static_overlay::StaticOverlay>(),
    figure::<four_parameters::FourParameters>(),
    figure::<relaxation::Relaxation>(),
    figure::<dynamics::Dynamics>(),
    figure::<dynamics::DynamicsWater>(),
    figure::<thrust::Thrust>(),
    figure::<waveforms::Waveforms>(),
    figure::<load_cell::LoadCell>(),
    figure::<calibration::Calibration>(),
    figure::<inflation::Inflation>(),
];

/// From where a body cut open at mid height shows its inside: from above, before and beside.
const CUT_VIEW: plot::View = plot::View { direction: [-0.25, 0.62, -0.75], up: [0.0, 0.0, 1.0] };

/// Radius of a circle around a marker of a film, px.
const CIRCLE: f64 = 14.0;

/// A circle around each place in a picture (px), which leaves what is there to be seen.
fn marker_circles(centres: &[Point2]) -> impl Iterator<Item = Mark> {
    centres.iter().map(|[x, y]| {
        let turn = |k: u32| (std::f64::consts::TAU * f64::from(k) / 24.0).sin_cos();
        let rim = (0..=24).map(|k| [x + CIRCLE * turn(k).1, y + CIRCLE * turn(k).0]).collect();
        Mark::line(rim, palette::PRESSURE).sized(1.2)
    })
}

/// The origin of the data, as a note for the reader.
fn origin_note<'a>(mut cards: impl Iterator<Item = &'a lab::Card>) -> String {
    match cards.all(|card| card.origin == lab::card::Origin::Laboratory) {
        true => String::new(),
        false => "All data are from the virtual bench; nothing was measured.".into(),
    }
}
