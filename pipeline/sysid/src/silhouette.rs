//! Silhouettes of a tail at rest and under pressure, of its film and of its model alike: half widths across the clamped spline through the markers.

use hydro::line::CentreLine;
use mesh::silhouette::{Normal, Projected, Silhouette};
use mesh::wall::Walls;
use mesh::{QuadraticMesh, Spot};
use si::{MILLIMETRE, Metre, Point2, Point3};

use crate::surfaces::{Bounds, Surfaces};

/// Largest distance of two stations: a sixteenth of a chamber.
const APART: Metre = 0.5 * MILLIMETRE;
/// The outline is searched this far from the centre line, as a share of the distance from the clamp to the last marker.
const REACH: f64 = 0.6;

/// Where along a tail half widths are measured.
pub struct Stations {
    line: CentreLine,
    /// The card's markers from the clamp on.
    order: Vec<usize>,
    at: Vec<Metre>,
    reach: Metre,
}

impl Stations {
    /// Between the clamp's end and the last of the card's markers (m); none where no line can be laid through them.
    pub fn new(clamp: Metre, markers: &[Point3]) -> Option<Self> {
        let mut order: Vec<usize> = (0..markers.len()).collect();
        order.sort_by(|&a, &b| markers[a][0].total_cmp(&markers[b][0]));
        let marks: Vec<Metre> = order.iter().map(|&i| markers[i][0]).collect();
        let line = CentreLine::new(clamp, &marks).filter(|_| clamp.is_finite())?;
        let stations = line.stations(APART);
        Some(Self { line, order, at: stations, reach: REACH * (marks.last()? - clamp) })
    }

    /// With the card's markers displaced by `displacements` (m), and the outline at `edge` along a normal, searched so far.
    pub fn silhouette(&self, displacements: &[Point2], edge: impl Fn(Normal, Metre) -> Option<Metre>) -> Silhouette {
        let sorted: Vec<Point2> = self.order.iter().map(|&i| displacements[i]).collect();
        let normals: Vec<Normal> = self.at.iter().map(|a| self.line.normal(*a, &sorted)).collect();
        Silhouette::across(&normals, |normal| edge(normal, self.reach))
    }

    /// Of a solid with moved nodes (m), as `eye` (m) sees it, and the displacements of its markers, m.
    pub fn of_solid(
        &self,
        body: (&QuadraticMesh, &[Spot]),
        nodes: &[Point3],
        eye: Point3,
    ) -> (Silhouette, Vec<Point2>) {
        let (projected, displacements) = (project_skin(body.0, nodes, eye), marker_displacements(body, nodes));
        (self.silhouette(&displacements, |normal, reach| projected.edge(normal, reach)), displacements)
    }

    /// Both sides of the outline of a solid with moved nodes (m), as `eye` (m) sees it on the plane at mid height: left and right, m.
    pub fn outline(&self, body: (&QuadraticMesh, &[Spot]), nodes: &[Point3], eye: Point3) -> [Vec<Point2>; 2] {
        self.outline_of(&project_skin(body.0, nodes, eye), &marker_displacements(body, nodes))
    }

    fn outline_of(&self, projected: &Projected, displacements: &[Point2]) -> [Vec<Point2>; 2] {
        let sorted: Vec<Point2> = self.order.iter().map(|&marker| displacements[marker]).collect();
        [1.0, -1.0].map(|turn| {
            let point = |station: &Metre| {
                let [base, [x, y]] = self.line.normal(*station, &sorted);
                let outwards = [turn * x, turn * y];
                let width = projected.edge([base, outwards], self.reach)?;
                Some([base[0] + width * outwards[0], base[1] + width * outwards[1]])
            };
            self.at.iter().filter_map(point).collect()
        })
    }

    /// Dent and bulge against the silhouette at rest; the tail bends away from its filled side.
    pub fn walls(
        &self,
        (deformed, displacements): &(Silhouette, Vec<Point2>),
        undeformed: &Silhouette,
    ) -> Option<Walls> {
        deformed.walls(undeformed, &self.at, displacements[*self.order.last()?][1] < 0.0)
    }
}

/// The outer skin of a solid with moved nodes (m) as `eye` (m) sees it.
fn project_skin(solid: &QuadraticMesh, nodes: &[Point3], eye: Point3) -> Projected {
    let surfaces = Surfaces::whole(solid, nodes);
    let outer = [Bounds::Body, Bounds::Sheet].iter().filter_map(|b| surfaces.faces.get(b)).flatten().copied();
    Projected::new(&surfaces.points, outer, eye)
}

/// Displacements of the markers in the plane when the nodes have moved to `nodes` (m), m.
fn marker_displacements((solid, markers): (&QuadraticMesh, &[Spot]), nodes: &[Point3]) -> Vec<Point2> {
    let displacement = |moved: Point3, initial: Point3| [moved[0] - initial[0], moved[1] - initial[1]];
    markers.iter().map(|marker| displacement(marker.at(nodes), marker.at(&solid.nodes))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const MARKERS: [Point3; 4] = [[0.037, 0.0, 0.0], [0.022, 0.0, 0.0], [0.052, 0.0, 0.0], [0.067, 0.0, 0.0]];
    const CLAMP: Metre = 0.004;
    /// Radius of the bent tail's sheet, m: its centre lies to the right of the clamp.
    const RADIUS: Metre = 0.08;

    /// The half width on the right is notched at the station 18 mm.
    fn half(station: Metre, left: bool) -> Metre {
        0.018 - if left { 0.0 } else { 3e-3 * (-((station - 0.018) / 0.004).powi(2)).exp() }
    }

    /// A tail bent to an arc: its markers' displacements, and its outline as a polygon's corners by station.
    fn bent() -> (Vec<Point2>, Projected) {
        let at = |a: Metre, out: Metre| {
            let (s, c) = ((a - CLAMP) / RADIUS).sin_cos();
            [CLAMP + (RADIUS + out) * s, (RADIUS + out) * c - RADIUS, 0.0]
        };
        let moved = MARKERS.map(|m| [at(m[0], 0.0)[0] - m[0], at(m[0], 0.0)[1]]).to_vec();
        let stations = || (0..800).map(|i| 1e-4 * f64::from(i));
        let corners: Vec<Point3> = stations().flat_map(|a| [at(a, half(a, true)), at(a, -half(a, false))]).collect();
        let faces = (0..2 * 799).map(|i| [i, i + 1, i + 2]);
        (moved, Projected::new(&corners, faces, [0.06, 0.0, 0.2]))
    }

    #[test]
    fn bending_alone_dents_nothing_and_a_notch_is_found_with_its_depth_at_its_station() {
        let stations = Stations::new(CLAMP, &MARKERS).unwrap();
        let rest = stations.silhouette(&[[0.0; 2]; 4], |_, _| Some(0.018));
        let (moved, body) = bent();
        let now = stations.silhouette(&moved, |normal, reach| body.edge(normal, reach));
        let walls = stations.walls(&(now, moved), &rest).unwrap();
        // the spline through four markers leaves the arc by 0.1 mm
        assert!((walls.dent_m - 3e-3).abs() < 1.5e-4 && walls.bulge_m < 1.5e-4, "{walls:?}");
        assert!((walls.dent_at[0] - 0.018).abs() < 1.1e-3 && walls.dent_at[1] < 0.0, "{walls:?}");
    }

    #[test]
    fn the_outline_of_a_bent_body_lies_half_its_width_beside_the_arc() {
        let stations = Stations::new(CLAMP, &MARKERS).unwrap();
        let (moved, body) = bent();
        let [left, right] = stations.outline_of(&body, &moved);
        let radius = |[x, y]: &Point2| (x - CLAMP).hypot(y + RADIUS);
        // far from the notch, and within the polygon's sagitta and the spline's deviation from the arc
        let is_plain = |[x, y]: &&Point2| (x - CLAMP).atan2(y + RADIUS) * RADIUS > 0.035;
        assert!(left.len() > 100 && right.len() > 100);
        assert!(left.iter().all(|p| (radius(p) - RADIUS - 0.018).abs() < 2e-5));
        assert!(right.iter().filter(is_plain).all(|p| (radius(p) - RADIUS + 0.018).abs() < 2e-5));
    }

    #[test]
    fn without_a_clamp_or_with_markers_at_one_place_there_are_no_stations() {
        assert!(Stations::new(f64::NEG_INFINITY, &MARKERS).is_none());
        assert!(Stations::new(CLAMP, &[MARKERS[0], MARKERS[0]]).is_none());
    }
}
