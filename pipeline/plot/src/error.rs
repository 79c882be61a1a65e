//! Errors of figures and tables: what is wrong, why, and what to do.

/// Why a figure or table cannot be drawn.
#[derive(Debug, thiserror::Error)]
pub enum PlotError {
    /// A coordinate that is NaN or infinite.
    #[error(
        "{what} has {value} as value {index}\n  why: an axis shows finite numbers only\n  do:  leave the point out, or split the line there"
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
        "the axis `{axis}` is logarithmic and has the value {value}\n  why: a logarithm needs a number above 0\n  do:  use a linear axis, or leave the point out"
    )]
    NotPositive {
        /// The axis' label.
        axis: String,
        /// The number.
        value: f64,
    },
    /// An axis with an empty or infinite range.
    #[error(
        "the axis `{axis}` runs from {low} to {high}\n  why: its range must be finite, with the upper end above the lower one\n  do:  set its range, or add a mark with data"
    )]
    Range {
        /// The axis' label.
        axis: String,
        /// Its lower end.
        low: f64,
        /// Its upper end.
        high: f64,
    },
    /// Lists of different lengths.
    #[error(
        "{what} has {found} entries where {expected} are needed\n  why: the lists have one entry for each point\n  do:  build them from the same data"
    )]
    Length {
        /// Which list.
        what: String,
        /// Its length.
        found: usize,
        /// The length that fits.
        expected: usize,
    },
    /// A panel whose frame is too small beside its labels.
    #[error(
        "panel {panel} has {width:.1} × {height:.1} mm left for its content\n  why: at least {least:.1} mm are needed in each direction beside the labels\n  do:  give the row more height, the figure more width, or the panel a larger share"
    )]
    TooSmall {
        /// Which panel, counted from 1.
        panel: usize,
        /// The frame's width, mm.
        width: f64,
        /// The frame's height, mm.
        height: f64,
        /// The limit, mm.
        least: f64,
    },
    /// A figure, row, scene, picture or table without content.
    #[error("{what} is empty\n  why: there is nothing to draw\n  do:  add content, or leave it out of the figure")]
    Empty {
        /// What has no content.
        what: &'static str,
    },
    /// A figure above the limit of size.
    #[error("the figure takes {bytes} bytes\n  why: the limit is {limit}\n  do:  draw fewer curves, or fewer pictures")]
    TooLarge {
        /// Its size.
        bytes: usize,
        /// The limit.
        limit: usize,
    },
    /// The PNG or SVG encoder failed.
    #[error(
        "the {encoder} encoder refused a drawing: {source}\n  why: its size is not supported\n  do:  check the panel's size and content"
    )]
    Encoder {
        /// Which encoder.
        encoder: &'static str,
        /// The encoder's error.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
}
