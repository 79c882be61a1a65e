//! From the canvas to SVG text, through plotters.
//!
//! plotters writes integer coordinates, so the canvas is scaled by [`GRID`] and the viewBox with it: curves have a
//! resolution of a twentieth of a point (0.018 mm). The root element holds the attributes that plotters repeats or does
//! not support (font, size in millimetres, round joints); pictures and dash patterns are inserted between its elements.

use plotters::drawing::{DrawingArea, DrawingAreaErrorKind, IntoDrawingArea};
use plotters::element::{Circle, PathElement, Polygon, Text};
use plotters::prelude::{Color, RGBColor, SVGBackend, ShapeStyle};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{FontDesc, FontFamily, FontStyle, FontTransform, TextStyle};
use si::Point2;

use crate::canvas::{Canvas, Item, POINTS_PER_MM, TextItem};
use crate::raster::base64;
use crate::{Colour, Dash, PlotError, Side, thin};

/// Font families in order of preference; the fallback is any sans-serif.
pub(crate) const FONT_FAMILIES: &str = "Helvetica, Arial, 'Liberation Sans', Arimo, 'DejaVu Sans', sans-serif";

/// Units of the SVG in a point of print.
const GRID: f64 = 20.0;
/// Half of a grid step: points this close to a line are rounded onto it anyway.
const TOLERANCE: f64 = 0.5 / GRID;
/// plotters divides a font size by this before it writes it.
const PLOTTERS_FONT_SCALE: f64 = 1.24;
/// Middle height of digits above the base line, less the quarter em by which plotters lowers centred text.
const LIFT: f64 = 0.36 - 0.25;

type DrawingError = DrawingAreaErrorKind<std::io::Error>;
type Page<'a> = DrawingArea<SVGBackend<'a>, plotters::coord::Shift>;

/// The canvas, `size` points of print large, as SVG text.
///
/// # Errors
/// [`PlotError::Encoder`] when plotters refuses.
pub(crate) fn write_svg(canvas: &Canvas, size: Point2) -> Result<String, PlotError> {
    let grid = size.map(|v| (v * GRID).round() as u32);
    let mut body = String::new();
    for run in canvas.items.chunk_by(|a, b| !is_special(a) && !is_special(b)) {
        body += &match &run[0] {
            Item::Picture { area, png } => picture_element(area.from, [area.width(), area.height()], png),
            Item::Path { dash, width, .. } if *dash != Dash::Solid => {
                dashed_line(&plotters_shapes(run, grid)?, *dash, *width)
            }
            _ => plotters_shapes(run, grid)?,
        };
    }
    let mm = size.map(|v| v / POINTS_PER_MM);
    Ok(format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" xmlns:xlink=\"http://www.w3.org/1999/xlink\" width=\"{:.2}mm\" \
         height=\"{:.2}mm\" viewBox=\"0 0 {} {}\" font-family=\"{FONT_FAMILIES}\" stroke-linejoin=\"round\" \
         stroke-linecap=\"butt\">\n<rect width=\"100%\" height=\"100%\" fill=\"#FFFFFF\"/>\n{body}</svg>\n",
        mm[0], mm[1], grid[0], grid[1]
    ))
}

/// Whether an item has attributes that plotters does not support.
fn is_special(item: &Item) -> bool {
    match item {
        Item::Picture { .. } => true,
        Item::Path { dash, .. } => *dash != Dash::Solid,
        _ => false,
    }
}

/// A line of plotters with a dash pattern.
fn dashed_line(line: &str, dash: Dash, width: f64) -> String {
    let (on, off) = match dash {
        Dash::Dotted => (width.max(0.6), 1.5),
        _ => (3.2, 1.8),
    };
    let pattern = format!("<polyline stroke-dasharray=\"{} {}\" ", (on * GRID).round(), (off * GRID).round());
    line.replacen("<polyline ", &pattern, 1)
}

/// A run of shapes as plotters writes them, without its root element and without attributes that the root holds.
fn plotters_shapes(run: &[Item], grid: [u32; 2]) -> Result<String, PlotError> {
    let mut text = String::new();
    {
        let page = SVGBackend::with_string(&mut text, (grid[0], grid[1])).into_drawing_area();
        for item in run {
            draw_item(&page, item).map_err(|error| PlotError::Encoder { encoder: "svg", source: error.into() })?;
        }
        page.present().map_err(|error| PlotError::Encoder { encoder: "svg", source: error.into() })?;
    }
    let lines = text.lines().filter(|line| !line.starts_with("<svg") && *line != "</svg>");
    let mut elements: String = lines.flat_map(|line| [line, "\n"]).collect();
    for repeated in [" font-family=\"sans-serif\"", " opacity=\"1\"", " stroke=\"none\""] {
        elements = elements.replace(repeated, "");
    }
    Ok(elements.replace("\n</text>", "</text>"))
}

fn draw_item(page: &Page, item: &Item) -> Result<(), DrawingError> {
    match item {
        Item::Path { points, width, colour, opacity, .. } => page.draw(&PathElement::new(
            snapped_points(&thin::thin_line(points, TOLERANCE)),
            stroke_style(*colour, *opacity, *width),
        )),
        Item::Polygon { points, colour, opacity } => page.draw(&Polygon::new(
            snapped_points(&thin::thin_line(points, TOLERANCE)),
            stroke_style(*colour, *opacity, 0.0).filled(),
        )),
        Item::Disc { at, radius, line, colour, opacity } => {
            let style = stroke_style(*colour, *opacity, line.unwrap_or(0.0));
            let style = if line.is_none() { style.filled() } else { style };
            page.draw(&Circle::new(snap_to_grid(*at), (radius * GRID).round() as u32, style))
        }
        Item::Text(text) => page.draw(&Text::new(text.text.as_str(), text_place(text), text_style(text))),
        Item::Picture { .. } => Ok(()),
    }
}

fn snap_to_grid(p: Point2) -> (i32, i32) {
    ((p[0] * GRID).round() as i32, (p[1] * GRID).round() as i32)
}

/// Points on the grid, without repetitions.
fn snapped_points(points: &[Point2]) -> Vec<(i32, i32)> {
    let mut points: Vec<_> = points.iter().map(|p| snap_to_grid(*p)).collect();
    points.dedup();
    points
}

fn rgb(colour: Colour) -> RGBColor {
    RGBColor(colour.0, colour.1, colour.2)
}

fn stroke_style(colour: Colour, opacity: f64, width: f64) -> ShapeStyle {
    ShapeStyle { color: rgb(colour).mix(opacity), filled: false, stroke_width: (width * GRID).round() as u32 }
}

/// The anchor for plotters at which half of the text's height is at its point.
fn text_place(text: &TextItem) -> (i32, i32) {
    let lift = LIFT * text.size;
    snap_to_grid(match text.vertical {
        false => [text.at[0], text.at[1] + lift],
        true => [text.at[0] + lift, text.at[1]],
    })
}

fn text_style(text: &TextItem) -> TextStyle<'static> {
    let weight = if text.bold { FontStyle::Bold } else { FontStyle::Normal };
    let font = FontDesc::new(FontFamily::SansSerif, (text.size * GRID).round() * PLOTTERS_FONT_SCALE, weight);
    let turn = if text.vertical { FontTransform::Rotate270 } else { FontTransform::None };
    let side = match text.side {
        Side::Left => HPos::Right,
        Side::Right => HPos::Left,
        _ => HPos::Center,
    };
    TextStyle { pos: Pos::new(side, VPos::Center), ..font.transform(turn).color(&rgb(text.colour)) }
}

fn picture_element(at: Point2, size: Point2, png: &[u8]) -> String {
    let ((x, y), (width, height)) = (snap_to_grid(at), snap_to_grid(size));
    format!(
        "<image x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" preserveAspectRatio=\"none\" \
         xlink:href=\"data:image/png;base64,{}\"/>\n",
        base64(png)
    )
}
