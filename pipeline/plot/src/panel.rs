//! The contract of a panel: it computes the margins for its labels and draws itself into a frame.

use crate::PlotError;
use crate::canvas::{Area, Canvas};

/// Margins of a frame for its labels, in points of print.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Margins {
    /// On the left.
    pub left: f64,
    /// On the right.
    pub right: f64,
    /// Above.
    pub top: f64,
    /// Below.
    pub bottom: f64,
    /// For a colour bar, beyond `right`; not shared with panels that have none.
    pub beyond: f64,
}

/// Where the legend stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LegendPlacement {
    /// In an empty corner of the frame.
    Inside,
    /// In lines over the frame.
    Over,
}

/// A panel that can be drawn.
pub trait Draw {
    /// Refuses content that cannot be drawn, before the layout.
    fn check_content(&self) -> Result<(), PlotError>;

    /// The margins that its frame needs inside of a cell of this size, or `None` when it has no frame and fills its
    /// cell.
    fn frame_margins(&self, cell: Area, legend: LegendPlacement) -> Result<Option<Margins>, PlotError>;

    /// Whether the legend fits into this frame without covering data.
    fn legend_fits(&self, _frame: Area) -> Result<bool, PlotError> {
        Ok(true)
    }

    /// Draws it; `frame` is the cell less the margins.
    fn draw_panel(&self, canvas: &mut Canvas, frame: Area, legend: LegendPlacement) -> Result<(), PlotError>;
}
