//! Pictures of a mesh, cut open across its thinnest side with its worst elements in red, and of surfaces that are refused, with the place.

use std::fmt::Write;

use mesh::quality::worst_elements;
use mesh::{Surface, TetMesh};
use si::{Point2, Point3};

/// Width of the picture and the margin around the body, px.
const WIDTH: f64 = 1000.0;
const MARGIN: f64 = 20.0;
/// Number of worst elements that are drawn.
const WORST: usize = 20;
/// Fill of the regions, from the first; later ones begin anew.
const FILLS: [&str; 4] = ["#d7e3ee", "#f0d9a8", "#cfe6c8", "#e6cfe0"];
/// Faces of refused surfaces that are drawn, evenly spaced in their list where there are more: a picture of all would be larger than the file.
const OUTLINES: usize = 20_000;
/// Radius of the circle around a place, px.
const CIRCLE: f64 = 12.0;
/// The six edges of a tetrahedron.
const EDGES: [[usize; 2]; 6] = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];

/// Where the body is cut, and how the plane is seen.
struct View {
    /// The axis across the plane, and those along it.
    across: usize,
    axes: [usize; 2],
    /// The plane's place along the first axis, m.
    height: f64,
    low: Point2,
    high: Point2,
    /// px/m
    scale: f64,
}

impl View {
    fn new(points: &[Point3]) -> Self {
        let bound = |k: usize, pick: fn(f64, f64) -> f64, start: f64| points.iter().map(|p| p[k]).fold(start, pick);
        let low = [0, 1, 2].map(|k| bound(k, f64::min, f64::INFINITY));
        let high = [0, 1, 2].map(|k| bound(k, f64::max, f64::NEG_INFINITY));
        let mut order = [0, 1, 2];
        order.sort_by(|i, j| (high[*j] - low[*j]).total_cmp(&(high[*i] - low[*i])));
        let [first, second, across] = order;
        let scale = (WIDTH - 2.0 * MARGIN) / (high[first] - low[first]).max(f64::MIN_POSITIVE);
        // off the middle by an irrational share: planes of symmetry are full of nodes
        let height = low[across] + 0.487_31 * (high[across] - low[across]);
        let axes = [first, second];
        Self { across, axes, height, low: axes.map(|k| low[k]), high: axes.map(|k| high[k]), scale }
    }

    fn to_pixel(&self, point: Point3) -> Point2 {
        let [x, y] = self.axes.map(|k| point[k]);
        [MARGIN + self.scale * (x - self.low[0]), MARGIN + self.scale * (self.high[1] - y)]
    }

    fn picture_size(&self) -> Point2 {
        [WIDTH, 2.0 * MARGIN + self.scale * (self.high[1] - self.low[1])]
    }

    /// The beginning of an SVG file, and of its first group.
    fn empty_picture(&self) -> String {
        let [width, height] = self.picture_size();
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.0} {height:.0}\" stroke-linejoin=\"round\">\n\
             <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n<g stroke=\"#445\" stroke-width=\"0.6\">\n"
        )
    }

    /// The section of a tetrahedron, as a polygon; empty where the plane does not cross it.
    fn tet_section(&self, corners: [Point3; 4]) -> Vec<Point2> {
        let heights = corners.map(|p| p[self.across] - self.height);
        let crossed = EDGES.into_iter().filter(|[i, j]| (heights[*i] < 0.0) != (heights[*j] < 0.0));
        let meeting = |[i, j]: [usize; 2]| {
            let share = heights[i] / (heights[i] - heights[j]);
            self.to_pixel([0, 1, 2].map(|k| corners[i][k] + share * (corners[j][k] - corners[i][k])))
        };
        in_angular_order(crossed.map(meeting).collect())
    }
}

/// Points of a convex polygon in their order around it.
fn in_angular_order(mut points: Vec<Point2>) -> Vec<Point2> {
    let count = points.len().max(1) as f64;
    let middle = [0, 1].map(|k| points.iter().map(|p| p[k]).sum::<f64>() / count);
    let angle = |p: &Point2| (p[1] - middle[1]).atan2(p[0] - middle[0]);
    points.sort_by(|p, q| angle(p).total_cmp(&angle(q)));
    points
}

/// The mesh cut open, as SVG.
pub(super) fn section_picture(mesh: &TetMesh) -> String {
    let view = View::new(&mesh.nodes);
    let mut svg = view.empty_picture();
    for (tet, region) in mesh.regions.iter().enumerate() {
        let section = view.tet_section(mesh.corners(tet));
        if section.len() > 2 {
            write_polygon(&mut svg, &section, &format!("fill=\"{}\"", FILLS[usize::from(*region) % FILLS.len()]));
        }
    }
    svg += "</g>\n<g fill=\"none\" stroke=\"#c00000\" stroke-width=\"1.5\">\n";
    for (tet, angle) in worst_elements(mesh, WORST) {
        let corners = mesh.corners(tet).map(|p| view.to_pixel(p));
        let sides: String = EDGES.iter().map(|[i, j]| line_path(corners[*i], corners[*j])).collect();
        let _ = writeln!(svg, "<path d=\"{sides}\"><title>element {tet}: {angle:.2}°</title></path>");
    }
    svg + "</g>\n</svg>\n"
}

/// Surfaces as outlines of their faces, with a circle around the place (m) where they were refused, as SVG.
pub(super) fn refusal_picture(surfaces: &[&Surface], place: Point3) -> String {
    let points: Vec<Point3> = surfaces.iter().flat_map(|surface| surface.points.iter().copied()).collect();
    let view = View::new(&points);
    let mut svg = view.empty_picture();
    for surface in surfaces {
        for face in (0..surface.faces.len()).step_by(surface.faces.len().div_ceil(OUTLINES).max(1)) {
            write_polygon(&mut svg, &surface.corners(face).map(|p| view.to_pixel(p)), "fill=\"none\"");
        }
    }
    let ([x, y], [a, b, c]) = (view.to_pixel(place), place.map(|p| 1e3 * p));
    let _ = writeln!(
        svg,
        "</g>\n<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{CIRCLE}\" fill=\"none\" stroke=\"#c00000\" stroke-width=\"3\">\
         <title>({a:.2}, {b:.2}, {c:.2}) mm</title></circle>"
    );
    svg + "</svg>\n"
}

fn write_polygon(svg: &mut String, points: &[Point2], style: &str) {
    let places: Vec<String> = points.iter().map(|[x, y]| format!("{x:.1},{y:.1}")).collect();
    let _ = writeln!(svg, "<polygon points=\"{}\" {style}/>", places.join(" "));
}

fn line_path([x, y]: Point2, [u, v]: Point2) -> String {
    format!("M{x:.1} {y:.1}L{u:.1} {v:.1}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tetrahedron_that_the_plane_crosses_is_a_polygon_and_its_six_edges_are_drawn() {
        let nodes = vec![[0.0; 3], [0.02, 0.0, 0.0], [0.0, 0.015, 0.0], [0.0, 0.0, 0.01]];
        let mesh = TetMesh { nodes, tets: vec![[0, 1, 2, 3]], regions: vec![0], skin: Vec::new(), half: false };
        let svg = section_picture(&mesh);
        assert_eq!((svg.matches("<polygon").count(), svg.matches("<path").count()), (1, 1));
        assert_eq!(svg.matches('L').count(), 6);
    }
}
