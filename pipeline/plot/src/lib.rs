//! Figures and tables: panels with axes, heat maps, meshes and diagrams become one SVG text each.
//!
//! One visual language for the whole paper: [`palette`] gives each role its colour, and fonts, line widths, ticks,
//! letters and legends are decided here once, so that a figure says only what it shows. The same figure gives the same
//! bytes. Coordinates are written on a grid of a twentieth of a point, and text stays text.
//!
//! ```
//! use plot::{Axes, Axis, Figure, Mark, Panel, palette};
//!
//! let wave: Vec<[f64; 2]> = (0..200).map(|i| f64::from(i) * 0.01).map(|t| [t, (6.28 * t).sin()]).collect();
//! let axes = Axes::new(Axis::linear("time", "s"), Axis::linear("tip", "mm"))
//!     .with(Mark::line(wave, palette::SIMULATED).labelled("simulated"));
//! let svg = Figure::new(plot::SINGLE_COLUMN_MM).row(45.0, [Panel::Axes(axes)]).svg()?;
//! assert!(svg.starts_with("<svg"));
//! # Ok::<(), plot::PlotError>(())
//! ```
//!
//! Stands on: `si`, plotters for the drawing, image for PNG. Never knows: a specimen, a stage, a file.

mod axis;
mod canvas;
mod clip;
mod contour;
mod error;
mod figure;
mod frame;
mod ink;
mod layout;
mod legend;
mod mark;
mod mark_ink;
pub mod palette;
mod panel;
pub mod panels;
mod raster;
mod ruler;
mod svg;
mod table;
mod table_text;
mod text;
mod thin;

pub use axis::{Axis, Scale};
pub use error::PlotError;
pub use figure::{DOUBLE_COLUMN_MM, Figure, Placed, SINGLE_COLUMN_MM, SVG_BYTES_LIMIT};
pub use mark::{Dash, Mark, Marker, Shape, Side};
pub use palette::Colour;
pub use panels::Panel;
pub use panels::axes::{Axes, Legend};
pub use panels::camera::View;
pub use panels::colour_bar::ColourBar;
pub use panels::diagram::{Diagram, Part};
pub use panels::landscape::{Landscape, Shading};
pub use panels::picture::Picture;
pub use panels::scene::{Overlay, OverlayKind, Paint, Scene, Triangle};
pub use svg::FONT_FAMILIES;
pub use table::{Alignment, Column, Table};
