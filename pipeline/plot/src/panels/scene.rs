//! Scenes: triangles in space in orthographic projection, with a scale bar and overlays.
//!
//! The triangles are rendered into one picture with a depth buffer, so that the size of the figure does not depend on the
//! size of the mesh; overlays stay vector graphics.

use si::vec3::{add, dot, norm, scale};
use si::{MILLIMETRE, Metre, Point2, Point3};

use crate::canvas::{Area, Canvas, Item, TextItem};
use crate::frame::SMALL;
use crate::mark::{Mark, Marker, Side};
use crate::mark_painter::draw_marker;
use crate::panel::{Draw, LegendPlacement, Margins};
use crate::panels::camera::{Camera, View};
use crate::panels::colour_bar::{Bar, ColourBar};
use crate::panels::shading::{corner_normals, lit_colour};
use crate::panels::z_buffer::{Facet, render_facets};
use crate::{Colour, Dash, PlotError, palette, text};

/// The colour of a triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Paint {
    /// One colour.
    Solid(Colour),
    /// One colour with an opacity, 0 to 1.
    Transparent(Colour, f64),
    /// A value at each corner, shown by the scene's colour bar.
    Values([f64; 3]),
}

/// A triangle in space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Triangle {
    /// Its corners, m.
    pub corners: [Point3; 3],
    /// Its colour.
    pub paint: Paint,
}

/// The kind of an overlay.
#[derive(Debug, Clone, PartialEq)]
pub enum OverlayKind {
    /// A line through the points.
    Line(Dash),
    /// A marker at each point.
    Markers(Marker),
    /// Text at the first point.
    Text(String, Side),
}

/// Lines, markers and text at points in space; the triangles do not hide them.
#[derive(Debug, Clone, PartialEq)]
pub struct Overlay {
    /// The points, m.
    pub points: Vec<Point3>,
    /// Its kind.
    pub kind: OverlayKind,
    /// Its colour.
    pub colour: Colour,
    /// Line width, marker diameter or text size, in points of print.
    pub size: f64,
}

/// Triangles in orthographic projection.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// The triangles.
    pub triangles: Vec<Triangle>,
    /// The direction of view.
    pub view: View,
    /// The scale of [`Paint::Values`].
    pub bar: Option<ColourBar>,
    /// Length of a scale bar, m.
    pub scale_bar: Option<Metre>,
    /// Lines, markers and text over the triangles.
    pub overlays: Vec<Overlay>,
    /// Two corners of the volume that is shown, so that several scenes have one scale, m; without it, all triangles are.
    pub window: Option<[Point3; 2]>,
}

/// Pixels in a point of print at first (288 an inch); fewer when the picture takes too many bytes.
const PIXELS_PER_POINT: f64 = 4.0;
/// Limit of the PNG's size for each square point of its cell: 200 kB for a column of 60 mm.
const BYTES_PER_SQUARE_POINT: f64 = 4.5;
/// An outline is drawn where the depth jumps by this fraction of the scene's size.
const JUMP: f64 = 0.02;
/// Height of the scale bar under the triangles.
const SCALE_BAR_HEIGHT: f64 = 12.0;

impl Scene {
    /// An empty scene.
    pub fn new(view: View) -> Self {
        Self { triangles: vec![], view, bar: None, scale_bar: None, overlays: vec![], window: None }
    }

    /// The same scene with a surface in one paint: points (m) and faces by index of their corners.
    pub fn with_surface(mut self, points: &[Point3], faces: &[[u32; 3]], paint: Paint) -> Self {
        let corner = |i: u32| points[i as usize];
        self.triangles.extend(faces.iter().map(|f| Triangle { corners: f.map(corner), paint }));
        self
    }

    /// The same scene with a surface painted by a value a point.
    pub fn with_values(mut self, points: &[Point3], faces: &[[u32; 3]], values: &[f64], bar: ColourBar) -> Self {
        let triangle = |f: &[u32; 3]| Triangle {
            corners: f.map(|i| points[i as usize]),
            paint: Paint::Values(f.map(|i| values[i as usize])),
        };
        self.triangles.extend(faces.iter().map(triangle));
        Self { bar: Some(bar), ..self }
    }

    /// The same scene with an overlay.
    pub fn with_overlay(mut self, points: Vec<Point3>, kind: OverlayKind, colour: Colour, size: f64) -> Self {
        self.overlays.push(Overlay { points, kind, colour, size });
        self
    }

    /// The same scene with a scale bar of this length, m.
    pub fn with_scale_bar(self, length: Metre) -> Self {
        Self { scale_bar: Some(length), ..self }
    }

    /// The same scene with the volume that is shown, given by two corners, m.
    pub fn with_window(self, low: Point3, high: Point3) -> Self {
        Self { window: Some([low, high]), ..self }
    }

    fn all_points(&self) -> impl Iterator<Item = Point3> + '_ {
        let overlaid = self.overlays.iter().flat_map(|o| o.points.iter().copied());
        self.triangles.iter().flat_map(|t| t.corners).chain(overlaid)
    }

    /// The rectangle that is shown, in metres on the plane of view.
    fn shown_rectangle(&self) -> [Point2; 2] {
        let [right, up, _] = self.view.basis();
        let projected = |p: Point3| [dot(p, right), dot(p, up)];
        let grow = |[low, high]: [Point2; 2], p: Point2| {
            [[low[0].min(p[0]), low[1].min(p[1])], [high[0].max(p[0]), high[1].max(p[1])]]
        };
        let start = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
        match self.window {
            Some(corners) => corners.into_iter().map(projected).fold(start, grow),
            None => self.all_points().map(projected).fold(start, grow),
        }
    }

    fn colour_bar(&self) -> Result<Option<Bar<'_>>, PlotError> {
        let values = self.triangles.iter().flat_map(|t| match t.paint {
            Paint::Values(values) => values.to_vec(),
            _ => vec![],
        });
        self.bar.as_ref().map(|axis| Bar::new(axis, values)).transpose()
    }

    /// The projection onto a cell without the height of the scale bar.
    fn scene_camera(&self, cell: Area) -> Camera {
        let area = Area { from: cell.from, to: [cell.to[0], cell.to[1] - self.scale_bar_height()] };
        Camera::new(&self.view, self.shown_rectangle(), area)
    }

    fn scale_bar_height(&self) -> f64 {
        if self.scale_bar.is_some() { SCALE_BAR_HEIGHT } else { 0.0 }
    }

    /// Places and colours of all triangles, with light from above and left of the eye.
    fn shaded_facets(&self, camera: &Camera, bar: Option<&Bar>) -> Vec<Facet> {
        let [right, up, away] = camera.basis;
        let lamp = add(add(scale(away, -0.75), scale(up, 0.5)), scale(right, -0.35));
        let (lamp, eye) = (scale(lamp, 1.0 / norm(lamp)), scale(away, -1.0));
        let corners: Vec<[Point3; 3]> = self.triangles.iter().map(|t| t.corners).collect();
        let facet = |(triangle, normals): (&Triangle, [Point3; 3])| {
            let (plain, opacity) = match triangle.paint {
                Paint::Solid(colour) => ([colour; 3], 1.0),
                Paint::Transparent(colour, opacity) => ([colour; 3], opacity),
                Paint::Values(values) => (values.map(|v| bar.map_or(palette::MISSING, |b| b.colour_of(v))), 1.0),
            };
            let colours = std::array::from_fn(|k| lit_colour(plain[k], normals[k], lamp, eye));
            Facet { corners: triangle.corners.map(|p| camera.pixel_place(p)), colours, opacity }
        };
        self.triangles.iter().zip(corner_normals(&corners)).map(facet).collect()
    }

    /// The picture, with as many pixels as the limit of its size allows.
    fn render_picture(&self, camera: &Camera, bar: Option<&Bar>) -> Result<Vec<u8>, PlotError> {
        let facets = self.shaded_facets(camera, bar);
        let size = [camera.area.width(), camera.area.height()];
        let jump = JUMP * size[0].max(size[1]);
        let limit = (BYTES_PER_SQUARE_POINT * size[0] * size[1]) as usize;
        // the size of a PNG is not predictable from the mesh: render, measure, reduce the resolution
        let mut resolution = PIXELS_PER_POINT;
        loop {
            let scaled: Vec<Facet> = facets.iter().map(|f| f.scaled_facet(resolution)).collect();
            let [w, h] = size.map(|v| (v * resolution).round().max(1.0) as usize);
            let png = render_facets(&scaled, w, h, jump).to_png()?;
            if png.len() <= limit || resolution <= 1.5 {
                return Ok(png);
            }
            resolution *= 0.8;
        }
    }

    fn draw_scale_bar(&self, canvas: &mut Canvas, camera: &Camera) {
        let Some(length) = self.scale_bar else { return };
        let (from, y) = ([camera.area.from[0] + 2.0, camera.area.to[1] + 4.0], camera.area.to[1] + 4.0);
        let to = [from[0] + length * camera.zoom, y];
        canvas.draw_segment(from, to, 1.2, palette::BLACK);
        for end in [from, to] {
            canvas.draw_segment([end[0], y - 1.8], [end[0], y + 1.8], 0.8, palette::BLACK);
        }
        let text = format!("{} mm", text::number(length / MILLIMETRE, 0));
        canvas.draw_text(TextItem::new([to[0] + 3.5, y], &text, SMALL).side(Side::Right));
    }
}

impl Facet {
    fn scaled_facet(&self, resolution: f64) -> Self {
        Self { corners: self.corners.map(|[x, y, depth]| [x * resolution, y * resolution, depth]), ..*self }
    }
}

impl Draw for Scene {
    fn check_content(&self) -> Result<(), PlotError> {
        if self.triangles.is_empty() {
            return Err(PlotError::Empty { what: "a scene" });
        }
        if let Some((index, p)) = self.all_points().enumerate().find(|(_, p)| p.iter().any(|v| !v.is_finite())) {
            let value = p.into_iter().find(|v| !v.is_finite()).unwrap_or(f64::NAN);
            return Err(PlotError::NotFinite { what: "a scene".to_owned(), index, value });
        }
        let [low, high] = self.shown_rectangle();
        if high[0] <= low[0] || high[1] <= low[1] {
            return Err(PlotError::Empty { what: "the view of a scene" });
        }
        self.colour_bar().map(drop)
    }

    fn frame_margins(&self, _cell: Area, _legend: LegendPlacement) -> Result<Option<Margins>, PlotError> {
        Ok(None)
    }

    fn draw_panel(&self, canvas: &mut Canvas, cell: Area, _legend: LegendPlacement) -> Result<(), PlotError> {
        let bar = self.colour_bar()?;
        let height = 0.8 * cell.height();
        let wide = bar.as_ref().map_or(0.0, |b| b.total_width(height));
        let remaining = Area { from: cell.from, to: [cell.to[0] - wide, cell.to[1]] };
        let camera = self.scene_camera(remaining);
        canvas.items.push(Item::Picture { area: camera.area, png: self.render_picture(&camera, bar.as_ref())? });
        for overlay in &self.overlays {
            overlay.draw_overlay(canvas, &camera);
        }
        self.draw_scale_bar(canvas, &camera);
        let bar_area = Area {
            from: [remaining.from[0], cell.centre()[1] - 0.5 * height],
            to: [remaining.to[0], cell.centre()[1] + 0.5 * height],
        };
        bar.map_or(Ok(()), |b| b.draw_bar(canvas, bar_area))
    }
}

impl Overlay {
    fn draw_overlay(&self, canvas: &mut Canvas, camera: &Camera) {
        let places: Vec<Point2> = self.points.iter().map(|p| camera.page_place(*p)).collect();
        match &self.kind {
            OverlayKind::Line(dash) => canvas.draw_path(places, self.size, *dash, self.colour),
            OverlayKind::Markers(marker) => {
                let mark = Mark::points(vec![], *marker, self.colour).sized(self.size);
                places.iter().for_each(|p| draw_marker(canvas, &mark, *p, *marker));
            }
            OverlayKind::Text(text, side) => {
                if let Some(place) = places.first() {
                    canvas.draw_text(TextItem::new(*place, text, self.size).side(*side).colour(self.colour));
                }
            }
        }
    }
}
