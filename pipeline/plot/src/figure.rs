//! Figures: rows of panels on a page of given width.

use crate::panels::Panel;

/// Width of one column of the paper, mm.
pub const SINGLE_COLUMN_MM: f64 = 88.0;
/// Width of both columns of the paper, mm.
pub const DOUBLE_COLUMN_MM: f64 = 181.0;
/// Largest size of a figure, bytes: figures are stored in the repository and loaded by the paper.
pub const SVG_BYTES_LIMIT: usize = 400 * 1024;

/// A panel in its row.
#[derive(Debug, Clone, PartialEq)]
pub struct Placed {
    /// The panel.
    pub panel: Panel,
    /// Its share of the row's width, relative to the shares of its neighbours.
    pub share: f64,
    /// Its title, beside its label.
    pub title: Option<String>,
    /// Whether it has a label, (a), (b), …; a figure of one panel has none.
    pub has_panel_label: bool,
}

impl From<Panel> for Placed {
    fn from(panel: Panel) -> Self {
        Self { panel, share: 1.0, title: None, has_panel_label: true }
    }
}

impl Placed {
    /// The same panel with a title.
    pub fn titled(self, title: &str) -> Self {
        Self { title: Some(title.to_owned()), ..self }
    }

    /// The same panel with another share of the row's width.
    pub fn share(self, share: f64) -> Self {
        Self { share, ..self }
    }

    /// The same panel without a label, because it continues the one before.
    pub fn without_panel_label(self) -> Self {
        Self { has_panel_label: false, ..self }
    }
}

impl Panel {
    /// The panel with a title.
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

/// Frames and when they are shown.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Animation {
    pub(crate) frames: Vec<Figure>,
    /// The frames in the order in which they are shown, each as long as the others; one may be shown more than once.
    pub(crate) order: Vec<usize>,
    /// How long the whole order takes, s.
    pub(crate) seconds: f64,
}

/// A figure.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// A title over all panels; papers have captions instead.
    pub title: Option<String>,
    /// A small line under all panels, such as the origin of the data.
    pub note: Option<String>,
    pub(crate) width_mm: f64,
    pub(crate) rows: Vec<Row>,
    /// Its frames, where it moves: then it has no rows of its own.
    pub(crate) animation: Option<Animation>,
}

impl Figure {
    /// An empty figure of a width, mm ([`SINGLE_COLUMN_MM`] or [`DOUBLE_COLUMN_MM`]).
    pub fn new(width_mm: f64) -> Self {
        Self { title: None, note: None, width_mm, rows: Vec::new(), animation: None }
    }

    /// A figure that shows `frames` of one size in an `order` of their indices, each as long as the others, over and over in `seconds`.
    pub fn animated(frames: Vec<Self>, order: Vec<usize>, seconds: f64) -> Self {
        let width_mm = frames.first().map_or(DOUBLE_COLUMN_MM, |frame| frame.width_mm);
        Self { animation: Some(Animation { frames, order, seconds }), ..Self::new(width_mm) }
    }

    /// The same figure with one more row of panels, `height_mm` high with all labels.
    pub fn row<P: Into<Placed>>(mut self, height_mm: f64, panels: impl IntoIterator<Item = P>) -> Self {
        self.rows.push(Row { height_mm, panels: panels.into_iter().map(Into::into).collect() });
        self
    }

    /// The same figure with a title over all panels.
    pub fn titled(self, title: &str) -> Self {
        Self { title: Some(title.to_owned()), ..self }
    }

    /// The same figure with a small line under all panels.
    pub fn noted(self, note: &str) -> Self {
        Self { note: Some(note.to_owned()), ..self }
    }
}
