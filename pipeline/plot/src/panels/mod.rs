//! The kinds of panels: one file each, and the enum of all.

pub mod axes;
pub mod camera;
pub mod colour_bar;
pub mod diagram;
pub mod landscape;
mod parts;
pub mod picture;
pub mod scene;
mod shading;
mod symbols;
mod z_buffer;

use crate::panel::Draw;

/// A panel of a figure.
#[derive(Debug, Clone, PartialEq)]
pub enum Panel {
    /// Curves and points on two axes.
    Axes(axes::Axes),
    /// A heat map with contours: a loss over two parameters.
    Landscape(landscape::Landscape),
    /// Triangles in space in orthographic projection.
    Scene(scene::Scene),
    /// Boxes, arrows, springs and text.
    Diagram(diagram::Diagram),
    /// A grey picture, such as a frame of a video.
    Picture(picture::Picture),
}

impl Panel {
    pub(crate) fn as_draw(&self) -> &dyn Draw {
        match self {
            Self::Axes(panel) => panel,
            Self::Landscape(panel) => panel,
            Self::Scene(panel) => panel,
            Self::Diagram(panel) => panel,
            Self::Picture(panel) => panel,
        }
    }
}
