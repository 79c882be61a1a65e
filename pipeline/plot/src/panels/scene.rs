//! Scenes: triangles in space, seen from far away in one direction, with a scale bar and words over them.
//!
//! The triangles become one picture through a depth buffer, so a mesh of any size gives a small figure; what is laid
//! over it stays lines and text.
//!
//! Stands on: `camera`, `z_buffer`, `shading`, `colour_bar`, `canvas`. Never knows: what the triangles belong to.

use si::vec3::{add, dot, norm, scale};
use si::{MILLIMETRE, Metre, Point2, Point3};

use crate::canvas::{Area, Canvas, Item};
use crate::frame::SMALL;
use crate::mark::{Mark, Marker, Side};
use crate::mark_ink::draw_marker;
use crate::panel::{Draw, Margins, Where};
use crate::panels::camera::{Camera, View};
use crate::panels::colour_bar::{Bar, ColourBar};
use crate::panels::shading::{lit, normals};
use crate::panels::z_buffer::{Facet, render};
use crate::{Colour, Dash, PlotError, palette, text};

/// What colour a triangle has.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Paint {
    /// One colour.
    Solid(Colour),
    /// One colour that lets through what is behind; 1 covers.
    Clear(Colour, f64),
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

/// What is laid over a scene.
#[derive(Debug, Clone, PartialEq)]
pub enum OverlayKind {
    /// A line through the points.
    Line(Dash),
    /// A marker at each point.
    Markers(Marker),
    /// Words at the first point.
    Text(String, Side),
}

/// Lines, markers and words at points in space, never hidden.
#[derive(Debug, Clone, PartialEq)]
pub struct Overlay {
    /// Where, m.
    pub points: Vec<Point3>,
    /// What.
    pub kind: OverlayKind,
    /// Its colour.
    pub colour: Colour,
    /// Line width, marker diameter or text size, in points of print.
    pub size: f64,
}

/// Triangles seen from one side.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// The triangles.
    pub triangles: Vec<Triangle>,
    /// Where the eye looks.
    pub view: View,
    /// What [`Paint::Values`] mean.
    pub bar: Option<ColourBar>,
    /// Length of a scale bar, m.
    pub scale_bar: Option<Metre>,
    /// What is laid over.
    pub overlays: Vec<Overlay>,
    /// Two corners in space that are shown whatever the triangles are, so that several scenes have one scale, m.
    pub window: Option<[Point3; 2]>,
}

/// Dots in a point of print at first (288 an inch); fewer when the picture gets too heavy.
const DOTS_PER_POINT: f64 = 4.0;
/// A picture may weigh so many bytes for each square point of its cell: at most 200 kB on a whole column of 60 mm.
const BYTES_PER_SQUARE_POINT: f64 = 4.5;
/// An outline is drawn where depth jumps by this part of the scene's size.
const JUMP: f64 = 0.02;
/// Room under the triangles for the scale bar.
const BAR_ROOM: f64 = 12.0;

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

    /// The same scene with something laid over.
    pub fn with_overlay(mut self, points: Vec<Point3>, kind: OverlayKind, colour: Colour, size: f64) -> Self {
        self.overlays.push(Overlay { points, kind, colour, size });
        self
    }

    /// The same scene with a scale bar of this length, m.
    pub fn with_scale_bar(self, length: Metre) -> Self {
        Self { scale_bar: Some(length), ..self }
    }

    /// The same scene with two corners in space that are shown in any case, m.
    pub fn with_window(self, low: Point3, high: Point3) -> Self {
        Self { window: Some([low, high]), ..self }
    }

    fn all_points(&self) -> impl Iterator<Item = Point3> + '_ {
        let overlaid = self.overlays.iter().flat_map(|o| o.points.iter().copied());
        self.triangles.iter().flat_map(|t| t.corners).chain(overlaid)
    }

    /// The rectangle that is shown, in metres on the plane of view.
    fn shown(&self) -> [Point2; 2] {
        let [right, up, _] = self.view.basis();
        let seen = |p: Point3| [dot(p, right), dot(p, up)];
        let grow = |[low, high]: [Point2; 2], p: Point2| {
            [[low[0].min(p[0]), low[1].min(p[1])], [high[0].max(p[0]), high[1].max(p[1])]]
        };
        let start = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
        match self.window {
            Some(corners) => corners.into_iter().map(seen).fold(start, grow),
            None => self.all_points().map(seen).fold(start, grow),
        }
    }

    fn bar(&self) -> Result<Option<Bar<'_>>, PlotError> {
        let values = self.triangles.iter().flat_map(|t| match t.paint {
            Paint::Values(values) => values.to_vec(),
            _ => vec![],
        });
        self.bar.as_ref().map(|axis| Bar::new(axis, values)).transpose()
    }

    /// The projection onto a cell, less the room for the scale bar.
    fn camera(&self, cell: Area) -> Camera {
        let area = Area { from: cell.from, to: [cell.to[0], cell.to[1] - self.bar_room()] };
        Camera::new(&self.view, self.shown(), area)
    }

    fn bar_room(&self) -> f64 {
        if self.scale_bar.is_some() { BAR_ROOM } else { 0.0 }
    }

    /// Places and colours of all triangles, with light from above and left of the eye.
    fn facets(&self, camera: &Camera, bar: Option<&Bar>) -> Vec<Facet> {
        let [right, up, away] = camera.basis;
        let lamp = add(add(scale(away, -0.75), scale(up, 0.5)), scale(right, -0.35));
        let (lamp, eye) = (scale(lamp, 1.0 / norm(lamp)), scale(away, -1.0));
        let corners: Vec<[Point3; 3]> = self.triangles.iter().map(|t| t.corners).collect();
        let facet = |(triangle, normals): (&Triangle, [Point3; 3])| {
            let (plain, opacity) = match triangle.paint {
                Paint::Solid(colour) => ([colour; 3], 1.0),
                Paint::Clear(colour, opacity) => ([colour; 3], opacity),
                Paint::Values(values) => (values.map(|v| bar.map_or(palette::MISSING, |b| b.colour(v))), 1.0),
            };
            let colours = std::array::from_fn(|k| lit(plain[k], normals[k], lamp, eye));
            Facet { corners: triangle.corners.map(|p| camera.dot_place(p)), colours, opacity }
        };
        self.triangles.iter().zip(normals(&corners)).map(facet).collect()
    }

    /// The picture, with as many dots as its weight allows.
    fn picture(&self, camera: &Camera, bar: Option<&Bar>) -> Result<Vec<u8>, PlotError> {
        let facets = self.facets(camera, bar);
        let size = [camera.area.width(), camera.area.height()];
        let jump = JUMP * size[0].max(size[1]);
        let limit = (BYTES_PER_SQUARE_POINT * size[0] * size[1]) as usize;
        let mut dots = DOTS_PER_POINT;
        loop {
            let scaled: Vec<Facet> = facets.iter().map(|f| f.scaled(dots)).collect();
            let [w, h] = size.map(|v| (v * dots).round().max(1.0) as usize);
            let png = render(&scaled, w, h, jump).png()?;
            if png.len() <= limit || dots <= 1.5 {
                return Ok(png);
            }
            dots *= 0.8;
        }
    }

    fn draw_scale_bar(&self, canvas: &mut Canvas, camera: &Camera) {
        let Some(length) = self.scale_bar else { return };
        let (from, y) = ([camera.area.from[0] + 2.0, camera.area.to[1] + 4.0], camera.area.to[1] + 4.0);
        let to = [from[0] + length * camera.zoom, y];
        canvas.segment(from, to, 1.2, palette::INK);
        for end in [from, to] {
            canvas.segment([end[0], y - 1.8], [end[0], y + 1.8], 0.8, palette::INK);
        }
        let words = format!("{} mm", text::number(length / MILLIMETRE, 0));
        canvas.words([to[0] + 3.5, y], &words, SMALL, Side::Right, palette::INK);
    }
}

impl Facet {
    fn scaled(&self, dots: f64) -> Self {
        Self { corners: self.corners.map(|[x, y, depth]| [x * dots, y * dots, depth]), ..*self }
    }
}

impl Draw for Scene {
    fn check(&self) -> Result<(), PlotError> {
        if self.triangles.is_empty() {
            return Err(PlotError::Empty { what: "a scene" });
        }
        if let Some((index, p)) = self.all_points().enumerate().find(|(_, p)| p.iter().any(|v| !v.is_finite())) {
            let value = p.into_iter().find(|v| !v.is_finite()).unwrap_or(f64::NAN);
            return Err(PlotError::NotFinite { what: "a scene".to_owned(), index, value });
        }
        let [low, high] = self.shown();
        if high[0] <= low[0] || high[1] <= low[1] {
            return Err(PlotError::Empty { what: "the view of a scene" });
        }
        self.bar().map(drop)
    }

    fn margins(&self, _cell: Area, _legend: Where) -> Result<Option<Margins>, PlotError> {
        Ok(None)
    }

    fn draw(&self, canvas: &mut Canvas, cell: Area, _legend: Where) -> Result<(), PlotError> {
        let bar = self.bar()?;
        let height = 0.8 * cell.height();
        let wide = bar.as_ref().map_or(0.0, |b| b.width(height));
        let room = Area { from: cell.from, to: [cell.to[0] - wide, cell.to[1]] };
        let camera = self.camera(room);
        canvas.items.push(Item::Picture { area: camera.area, png: self.picture(&camera, bar.as_ref())? });
        for overlay in &self.overlays {
            overlay.draw(canvas, &camera);
        }
        self.draw_scale_bar(canvas, &camera);
        let beside = Area {
            from: [room.from[0], cell.centre()[1] - 0.5 * height],
            to: [room.to[0], cell.centre()[1] + 0.5 * height],
        };
        bar.map_or(Ok(()), |b| b.draw(canvas, beside))
    }
}

impl Overlay {
    fn draw(&self, canvas: &mut Canvas, camera: &Camera) {
        let places: Vec<Point2> = self.points.iter().map(|p| camera.place(*p)).collect();
        match &self.kind {
            OverlayKind::Line(dash) => canvas.path(places, self.size, *dash, self.colour),
            OverlayKind::Markers(marker) => {
                let mark = Mark::points(vec![], *marker, self.colour).sized(self.size);
                places.iter().for_each(|p| draw_marker(canvas, &mark, *p, *marker));
            }
            OverlayKind::Text(text, side) => {
                if let Some(place) = places.first() {
                    canvas.words(*place, text, self.size, *side, self.colour);
                }
            }
        }
    }
}
