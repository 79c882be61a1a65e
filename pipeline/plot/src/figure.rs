//! Figures: rows of panels on a page of given width, lettered and aligned.
//!
//! Stands on: `panels`, `layout`, `svg`. Never knows: where the figure is stored.

use crate::canvas::Canvas;
use crate::panels::Panel;
use crate::{PlotError, layout, svg};

/// Width of one column of the paper, mm.
pub const SINGLE_COLUMN_MM: f64 = 88.0;
/// Width of both columns of the paper, mm.
pub const DOUBLE_COLUMN_MM: f64 = 181.0;
/// No figure may be larger: the repository keeps them and the paper loads them.
pub const SVG_BYTES_LIMIT: usize = 400 * 1024;

/// A panel in its row.
#[derive(Debug, Clone, PartialEq)]
pub struct Placed {
    /// The panel.
    pub panel: Panel,
    /// Its part of the row's width, against the shares of its neighbours.
    pub share: f64,
    /// Words beside its letter.
    pub title: Option<String>,
    /// Whether it has a letter, when the figure has more than one panel.
    pub lettered: bool,
}

impl From<Panel> for Placed {
    fn from(panel: Panel) -> Self {
        Self { panel, share: 1.0, title: None, lettered: true }
    }
}

impl Placed {
    /// The same panel with words beside its letter.
    pub fn titled(self, title: &str) -> Self {
        Self { title: Some(title.to_owned()), ..self }
    }

    /// The same panel with another part of the row's width.
    pub fn share(self, share: f64) -> Self {
        Self { share, ..self }
    }

    /// The same panel without a letter, because it continues the one before.
    pub fn unlettered(self) -> Self {
        Self { lettered: false, ..self }
    }
}

impl Panel {
    /// The panel with words beside its letter.
    pub fn titled(self, title: &str) -> Placed {
        Placed::from(self).titled(title)
    }
}

/// Panels side by side.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Row {
    /// Height with all labels, mm.
    pub height_mm: f64,
    /// From the left.
    pub panels: Vec<Placed>,
}

/// A figure.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// Words over everything; papers have captions instead.
    pub title: Option<String>,
    /// A small line under everything, such as where the data come from.
    pub note: Option<String>,
    pub(crate) width_mm: f64,
    pub(crate) rows: Vec<Row>,
}

impl Figure {
    /// An empty figure of a width, mm ([`SINGLE_COLUMN_MM`] or [`DOUBLE_COLUMN_MM`]).
    pub fn new(width_mm: f64) -> Self {
        Self { title: None, note: None, width_mm, rows: Vec::new() }
    }

    /// The same figure with one more row of panels, `height_mm` high with all labels.
    pub fn row<P: Into<Placed>>(mut self, height_mm: f64, panels: impl IntoIterator<Item = P>) -> Self {
        self.rows.push(Row { height_mm, panels: panels.into_iter().map(Into::into).collect() });
        self
    }

    /// The same figure with words over everything.
    pub fn titled(self, title: &str) -> Self {
        Self { title: Some(title.to_owned()), ..self }
    }

    /// The same figure with a small line under everything.
    pub fn noted(self, note: &str) -> Self {
        Self { note: Some(note.to_owned()), ..self }
    }

    /// The figure as SVG text. The same figure gives the same bytes.
    ///
    /// # Errors
    /// [`PlotError`] when a number has no place, a frame no room, or the text is above [`SVG_BYTES_LIMIT`].
    pub fn svg(&self) -> Result<String, PlotError> {
        let mut canvas = Canvas::default();
        let page = layout::draw(self, &mut canvas)?;
        let text = svg::write(&canvas, page)?;
        match text.len() {
            bytes if bytes > SVG_BYTES_LIMIT => Err(PlotError::TooLarge { bytes, limit: SVG_BYTES_LIMIT }),
            _ => Ok(text),
        }
    }
}
