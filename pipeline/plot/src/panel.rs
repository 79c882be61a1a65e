//! What a panel is: something that says how much room its labels need, and draws itself into a frame.
//!
//! Stands on: `canvas`. Never knows: its members (`panels/`), its neighbours on the page, or its letter.

use crate::PlotError;
use crate::canvas::{Area, Canvas};

/// Room for labels beside a frame, in points of print.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Margins {
    /// Before it.
    pub left: f64,
    /// After it.
    pub right: f64,
    /// Over it.
    pub top: f64,
    /// Under it.
    pub bottom: f64,
    /// For a colour bar, beyond `right`; not shared with panels that have none.
    pub beyond: f64,
}

/// Where the legend stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Where {
    /// In an empty corner of the frame.
    Inside,
    /// In lines over the frame.
    Over,
}

/// A panel that can be drawn.
pub trait Draw {
    /// Refuses what has no place on paper, before anything is laid out.
    fn check(&self) -> Result<(), PlotError>;

    /// The room for labels that its frame needs inside of a cell of this size, or `None` when it has no frame
    /// and fills its cell.
    fn margins(&self, cell: Area, legend: Where) -> Result<Option<Margins>, PlotError>;

    /// Whether the legend stands in this frame without covering data.
    fn legend_fits(&self, _frame: Area) -> Result<bool, PlotError> {
        Ok(true)
    }

    /// Draws it; `frame` is the cell less the margins.
    fn draw(&self, canvas: &mut Canvas, frame: Area, legend: Where) -> Result<(), PlotError>;
}
