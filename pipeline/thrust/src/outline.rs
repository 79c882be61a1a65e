//! Outline: the depth of a tail along its length, and its trailing edge.

use hydro::{Stations, Tail, TailError};
use mesh::{QuadraticMesh, Spot};
use si::{KilogramPerCubicMetre, Metre, Point3};
use sysid::Body;

/// Number of stations of the model.
const STATIONS: usize = 14;
/// Number of points among which the deepest is searched.
const PLACES: usize = 200;

/// A tail's outline seen from the side.
pub struct Outline<'a> {
    body: &'a Body,
    solid: &'a QuadraticMesh,
    /// Of the skin's triangles, the lower end first along x.
    edges: Vec<[Point3; 2]>,
    /// The trailing edge: the deepest section of the fin, behind which it narrows, m.
    trailing: Metre,
    /// The end of the fin, m.
    end: Metre,
}

impl<'a> Outline<'a> {
    /// Of the tail on `card`, meshed as `solid`.
    pub fn new(body: &'a Body, solid: &'a QuadraticMesh) -> Self {
        let corner =
            |face: &mesh::QuadraticFace, i: usize| solid.nodes[face.corners()[i % face.corners().len()] as usize];
        let along_x = |[a, b]: [Point3; 2]| if a[0] <= b[0] { [a, b] } else { [b, a] };
        let rising_edges = |face: &'a mesh::QuadraticFace| {
            (0..face.corners().len()).map(move |i| along_x([corner(face, i), corner(face, i + 1)]))
        };
        let edges = solid.skin.iter().flat_map(rising_edges).collect();
        let end = solid.nodes.iter().map(|n| n[0]).fold(f64::NEG_INFINITY, f64::max);
        let mut outline = Self { body, solid, edges, trailing: end, end };
        outline.trailing = outline.deepest_section();
        outline
    }

    /// The tail by the card's markers, from the head to the fin, up to its trailing edge.
    ///
    /// # Errors
    /// [`TailError`] when the markers do not rise from the clamp to the edge.
    pub fn marker_tail(&self, density: KilogramPerCubicMetre, sections: usize) -> Result<Tail, TailError> {
        let marks: Vec<Metre> = self.body.markers_by_x().iter().map(|&i| self.body.markers[i][0]).collect();
        let (clamp, edge) = (self.body.clamp.end(), self.trailing);
        Tail::new(density, &Stations { clamp, marks: &marks, edge, end: edge }, sections, &|a| self.section_depth(a))
    }

    /// The tail by stations of the model, including the fin behind the trailing edge, and those stations: a line through the markers,
    /// which end before the fin, would treat it as straight.
    ///
    /// # Errors
    /// [`TailError`] when there is no tail behind the clamp.
    pub fn whole(&self, density: KilogramPerCubicMetre, sections: usize) -> Result<(Tail, Vec<Spot>), TailError> {
        let clamp = self.body.clamp.end();
        let station_position = |i: usize| clamp + (self.end - clamp) * i as f64 / STATIONS as f64;
        let stations: Vec<Metre> = (1..=STATIONS).map(station_position).collect();
        // halfway up the half, where the mean over the value is
        let spot = |a: &Metre| mesh::embed(self.solid, [*a, 0.0, 0.25 * self.section_depth(*a)]).0;
        let spots = stations.iter().map(spot).collect();
        let tail = Tail::new(
            density,
            &Stations { clamp, marks: &stations, edge: self.trailing, end: self.end },
            sections,
            &|a| self.section_depth(a),
        )?;
        Ok((tail, spots))
    }

    /// Of the section at `a` (m), m.
    fn section_depth(&self, a: Metre) -> Metre {
        let crossing_edges = self.edges.iter().filter(|[lower, upper]| lower[0] <= a && a <= upper[0]);
        let crossing_height = |[lower, upper]: &[Point3; 2]| {
            let fraction = if upper[0] > lower[0] { (a - lower[0]) / (upper[0] - lower[0]) } else { 0.0 };
            lower[2] + fraction * (upper[2] - lower[2])
        };
        let (low, high) = crossing_edges
            .map(crossing_height)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), z| (l.min(z), h.max(z)));
        match (high > low, self.solid.half) {
            (true, true) => 2.0 * high,
            (true, false) => high - low,
            (false, _) => 0.0,
        }
    }

    /// Behind the last marker, m.
    fn deepest_section(&self) -> Metre {
        let clamp = self.body.clamp.end();
        let last_marker = self.body.markers_by_x().last().map_or(clamp, |&i| self.body.markers[i][0]);
        let position = |i: usize| clamp + (self.end - clamp) * i as f64 / PLACES as f64;
        let candidates = (0..=PLACES).map(position).filter(|a| *a >= last_marker);
        candidates.max_by(|a, b| self.section_depth(*a).total_cmp(&self.section_depth(*b))).unwrap_or(self.end)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mesh::{Settings, Surface};
    use sysid::Material;

    /// A bar of 100 × 4 × 40 mm, clamped over its first 10 mm; so thin that its sides are nearer to a station than its end.
    fn bar(use_symmetry: bool) -> (Body, QuadraticMesh) {
        let (low, high) = ([0.0, -0.002, -0.02], [0.1, 0.002, 0.02]);
        let corner = |i: usize| [0, 1, 2].map(|k| if i >> k & 1 == 1 { high[k] } else { low[k] });
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let faces = quads.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        let surface = Surface { points: (0..8).map(corner).collect(), faces };
        let settings = Settings { use_symmetry, ..Settings::new(0.01) };
        let (mesh, _) = mesh::mesh_without_sheet(&surface, &settings).unwrap();
        let soft = Material {
            name: "body".into(),
            law: "neo_hookean".into(),
            youngs_modulus: 2e5,
            poissons_ratio: 0.45,
            density: 1e3,
            stiffening: [0.0; 2],
            stiffening_sigma: None,
            plausible: [1e5, 1e6],
        };
        let markers = vec![[0.05, 0.0, 0.02], [0.08, 0.0, 0.02]];
        let marker_diameters = vec![None; markers.len()];
        let body = Body {
            materials: vec![soft.clone(), soft],
            clamp: lab::card::Clamp::below(0.01),
            length: 0.1,
            markers,
            marker_diameters,
        };
        (body, mesh::quadratic(&mesh))
    }

    #[test]
    fn a_whole_bar_and_its_half_have_one_depth() {
        for use_symmetry in [false, true] {
            let (body, solid) = bar(use_symmetry);
            let outline = Outline::new(&body, &solid);
            assert!((outline.section_depth(0.053) - 0.04).abs() < 1e-12, "{}", outline.section_depth(0.053));
        }
    }

    #[test]
    fn the_stations_of_the_model_divide_the_tail_behind_the_clamp_evenly() {
        let (body, solid) = bar(true);
        let (_, spots) = Outline::new(&body, &solid).whole(1e3, 10).unwrap();
        for (i, spot) in spots.iter().enumerate() {
            let x = 0.01 + 0.09 * (i + 1) as f64 / STATIONS as f64;
            let found = spot.at(&solid.nodes)[0];
            assert!((found - x).abs() < 1e-9, "station {i} at {found} instead of {x} m");
        }
        assert_eq!(spots.len(), STATIONS);
    }
}
