//! Figures and tables: panels with axes, heat maps, meshes and diagrams become one SVG text each.
//!
//! All figures of the paper have one style: [`palette`] assigns colours to roles; fonts, line widths, ticks, panel labels
//! and legends are defined here once. A figure is a pure function of its data: the same figure gives the same bytes.
//! Coordinates have a resolution of a twentieth of a point, and text is stored as text.
//!
//! | item | content |
//! |------|---------|
//! | [`Figure`] | rows of panels, aligned and labelled |
//! | [`Panel`] | [`Axes`], [`Landscape`] (heat map), [`Scene`] (triangles in space), [`Diagram`], [`Picture`] |
//! | [`Mark`] | a line, points, a band or text on axes |
//! | [`Table`] | CSV, LaTeX and SVG |
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
//! Depends on `si`, plotters (SVG) and image (PNG); on no specimen, stage or file.

mod animation;
mod axis;
mod canvas;
mod clip;
mod contour;
mod coverage;
mod error;
mod figure;
mod frame;
mod layout;
mod legend;
mod mark;
mod mark_painter;
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
pub use table::{Alignment, Column, Table};
