//! What can be wrong with a figure, said so that the next move is clear.
//!
//! Stands on: nothing. Never knows: which figure is drawn.

/// Why a figure or table cannot be drawn.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PlotError {
    /// A coordinate that is NaN or infinite.
    #[error(
        "{what} has {value} as value {index}\n  why: only finite numbers have a place on an axis\n  do:  leave the point out, or split the line there"
    )]
    NotFinite {
        /// What was drawn.
        what: String,
        /// Which of its numbers.
        index: usize,
        /// The number.
        value: f64,
    },
    /// Zero or less on a logarithmic axis.
    #[error(
        "the axis `{axis}` is logarithmic and meets {value}\n  why: a logarithm needs a number above 0\n  do:  use a linear axis, or leave the point out"
    )]
    NotPositive {
        /// The axis' label.
        axis: String,
        /// The number.
        value: f64,
    },
    /// An axis that ends where it begins, or has nothing to show.
    #[error(
        "the axis `{axis}` runs from {low} to {high}\n  why: it must run upwards over a finite range\n  do:  set its range, or draw something on it"
    )]
    Range {
        /// The axis' label.
        axis: String,
        /// Its lower end.
        low: f64,
        /// Its upper end.
        high: f64,
    },
    /// Lists that belong together and differ in length.
    #[error(
        "{what} has {found} entries where {expected} are needed\n  why: the lists belong together, entry by entry\n  do:  build them from the same source"
    )]
    Length {
        /// Which list.
        what: String,
        /// Its length.
        found: usize,
        /// The length that fits.
        expected: usize,
    },
    /// A panel whose frame has no room left beside its labels.
    #[error(
        "panel {panel} has {width:.1} × {height:.1} mm left for its content\n  why: at least {least:.1} mm are needed each way beside the labels\n  do:  give the row more height, the figure more width, or the panel a larger share"
    )]
    TooSmall {
        /// Which panel, counted from 1.
        panel: usize,
        /// What is left across, mm.
        width: f64,
        /// What is left upwards, mm.
        height: f64,
        /// The limit, mm.
        least: f64,
    },
    /// A figure, row, scene, picture or table without content.
    #[error(
        "{what} is empty\n  why: there is nothing to draw\n  do:  hand it something, or leave it out of the figure"
    )]
    Empty {
        /// What has no content.
        what: &'static str,
    },
    /// A figure that is too heavy for the repository and the paper.
    #[error("the figure takes {bytes} bytes\n  why: the limit is {limit}\n  do:  draw fewer curves, or fewer pictures")]
    TooLarge {
        /// Its size.
        bytes: usize,
        /// The limit.
        limit: usize,
    },
    /// The PNG or SVG encoder refused.
    #[error(
        "the {encoder} encoder refused a drawing: {reason}\n  why: its size or shape is not possible\n  do:  look at the panel's size and content"
    )]
    Encoder {
        /// Which encoder.
        encoder: &'static str,
        /// What it said.
        reason: String,
    },
}
