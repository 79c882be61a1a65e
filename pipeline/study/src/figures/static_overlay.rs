//! Figure `static_overlay`: frames of a film at rising pressures on one side, with the outline of the identified model and its marks over them.
//!
//! The outline lies where normals of the centre line leave the projected skin, from the clamp to the last mark; marks of the film are circles, those of
//! the model crosses.

use lab::card::Card;
use plot::{DOUBLE_COLUMN_MM, Figure, Mark, Marker, Panel, Picture, Placed, palette};
use si::{MILLIBAR, MILLIMETRE, Metre, Pascal, Point2, Point3};
use track::Gray;
use track::pose::Pose;

use super::order::{in_order, record_of};
use super::origin_note;
use diagnostics::{Diagnostic, Result};
use records::subject::{Specimen, Study, Trial};
use records::{Camera, ExampleFrames, HeldLevel, Inflation, Mesh, Shape};
use sysid::silhouette::Stations;
use workflow::figure;
use workflow::needs::Every;

/// The figure.
pub struct StaticOverlay;

/// Pictures in a row, rows, and the height of a row, mm.
const COLUMNS: usize = 4;
const ROWS: usize = 2;
const ROW_MM: f64 = 34.0;
/// A shape is that of a level when their pressures differ by less than this part.
const SAME_LEVEL: f64 = 0.01;

impl figure::Figure for StaticOverlay {
    type Of = Study;
    type Needs =
        (Every<Mesh, Specimen>, Every<Camera, Specimen>, Every<Inflation, Specimen>, Every<ExampleFrames, Trial>);
    const NAME: &'static str = "static_overlay";
    const CAPTION: &'static str = "the identified model over frames of the film at rising pressures";
    const VERSION: u32 = 3;

    fn draw((Every(meshes), Every(cameras), Every(inflations), Every(examples)): Self::Needs) -> Result<Figure> {
        let (inflations, meshes) = (in_order(inflations), in_order(meshes));
        let (cameras, examples) = (in_order(cameras), in_order(examples));
        let overlay = inflations.iter().find_map(|(specimen, inflation)| {
            let name = &specimen.card.name;
            let (mesh, camera, example) =
                (record_of(&meshes, name)?, record_of(&cameras, name)?, record_of(&examples, name)?);
            Some((specimen, FilmView { card: &specimen.card, mesh, camera, inflation, example }))
        });
        let (specimen, film) = overlay.ok_or_else(no_film)?;
        let panels: Vec<Placed> = film.overlaid_levels();
        if panels.is_empty() {
            return Err(no_film());
        }
        let rows = panels.chunks(COLUMNS).map(<[Placed]>::to_vec);
        let figure = rows.fold(Figure::new(DOUBLE_COLUMN_MM), |figure, row| figure.row(ROW_MM, row));
        Ok(figure.noted(&origin_note([specimen.card.as_ref()].into_iter())))
    }
}

fn no_film() -> Diagnostic {
    Diagnostic::new("there is no film to draw over", "no staircase in air was filmed and inflated", "study run inflate")
}

/// A specimen's film with the model of it.
struct FilmView<'a> {
    card: &'a Card,
    mesh: &'a Mesh,
    camera: &'a Camera,
    inflation: &'a Inflation,
    example: &'a ExampleFrames,
}

impl FilmView<'_> {
    /// As many levels as there are panels, evenly among those of which the model has a shape, the highest among them.
    fn overlaid_levels(&self) -> Vec<Placed> {
        let levels = self.example.seen.levels.iter().zip(&self.example.levels);
        let mut simulated: Vec<(&HeldLevel, &Gray, &Shape)> =
            levels.filter_map(|(level, picture)| Some((level, picture, self.shape_of(level)?))).collect();
        simulated.sort_by(|a, b| a.2.pressure().total_cmp(&b.2.pressure()));
        let panels = simulated.len().min(COLUMNS * ROWS);
        let chosen = (1..=panels).map(|panel| panel * simulated.len() / panels - 1);
        chosen.map(|index| self.overlaid_picture(simulated[index])).collect()
    }

    /// The shape under the pressure of a level.
    fn shape_of(&self, level: &HeldLevel) -> Option<&Shape> {
        let level_pressure = level.pressures_pa.iter().copied().fold(0.0, f64::max);
        let difference = |shape: &Shape| (shape.pressure() - level_pressure).abs();
        let nearest = self.inflation.shapes.iter().min_by(|a, b| difference(a).total_cmp(&difference(b)))?;
        (difference(nearest) < SAME_LEVEL * level_pressure).then_some(nearest)
    }

    /// The picture of a level with the shape's outline and marks.
    fn overlaid_picture(&self, (level, picture, shape): (&HeldLevel, &Gray, &Shape)) -> Placed {
        let nodes = self.inflation.moved(self.mesh, shape);
        let model: Vec<Point3> = self.mesh.markers.iter().map(|spot| spot.at(&nodes)).collect();
        let crosses: Vec<Point2> = model.iter().filter_map(|&mark| self.pixel_of_point(mark)).collect();
        let filmed: Vec<Point2> = level.markers_px.iter().map(|&mark| self.in_window(mark)).collect();
        let overlaid = Picture::new(picture.width, picture.height, picture.pixels.clone());
        let overlaid = super::marker_circles(&filmed).fold(overlaid, Picture::with);
        let overlaid = self
            .model_outline(&nodes)
            .into_iter()
            .fold(overlaid, |drawn, side| drawn.with(Mark::line(side, palette::SIMULATED).sized(1.4)));
        let overlaid = overlaid
            .with(Mark::points(crosses, Marker::Cross, palette::SIMULATED).sized(3.0))
            .with_scale_bar(0.02 * self.example.seen.px_per_m, "20 mm");
        Panel::Picture(overlaid).titled(&self.level_title(shape.pressure(), &filmed, &model))
    }

    /// Both sides of the model's outline, px of the window.
    fn model_outline(&self, nodes: &[Point3]) -> Vec<Vec<Point2>> {
        let markers: Vec<Point3> = self.card.marker.iter().map(|marker| marker.at).collect();
        let Some(stations) = Stations::new(self.card.clamp.end(), &markers) else { return Vec::new() };
        let sides = stations.outline((&self.mesh.solid, &self.mesh.markers), nodes, self.example.seen.eye_m);
        let on_plane = |[x, y]: &Point2| self.pixel_of_point([*x, *y, 0.0]);
        sides.iter().map(|side| side.iter().filter_map(on_plane).collect()).collect()
    }

    fn level_title(&self, pressure: Pascal, filmed: &[Point2], model: &[Point3]) -> String {
        let distance_in_film = |(seen, mark): (&Point2, &Point3)| -> Option<Metre> {
            let drawn = self.pixel_of_point(*mark)?;
            Some((drawn[0] - seen[0]).hypot(drawn[1] - seen[1]) / self.example.seen.px_per_m)
        };
        // length: the card's markers, in the film and in the mesh
        let farthest = filmed.iter().zip(model).filter_map(distance_in_film).fold(0.0, f64::max);
        format!("{:.0} mbar: {:.1} mm apart", pressure / MILLIBAR, farthest / MILLIMETRE)
    }

    /// Where the film's camera sees a point (m), px of the window; refraction is neglected, as the film is of a tail in air.
    fn pixel_of_point(&self, point: Point3) -> Option<Point2> {
        let (rotation, translation) = self.example.seen.camera_pose;
        let pose = Pose { rotation, translation };
        Some(self.in_window(self.camera.lens.project(pose.apply(point))?))
    }

    /// A pixel of the whole frame in the window, whose pixels are squares: the centre of the first is at a half.
    fn in_window(&self, [x, y]: Point2) -> Point2 {
        let [left, top, ..] = self.example.seen.window_px;
        [x - left as f64 + 0.5, y - top as f64 + 0.5]
    }
}
