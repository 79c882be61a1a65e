//! The card of a body as its model reads it: materials, clamp, length, markers.

use lab::card::{Card, Clamp, Part};
use serde::Serialize;
use si::{KilogramPerCubicMetre, Metre, Pascal, Point2, Point3};

/// One solid's material.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Material {
    /// The solid's name.
    pub name: String,
    /// The law's name in `fem`.
    pub law: String,
    /// Nominal E, Pa.
    pub youngs_modulus: Pascal,
    /// ν, no unit.
    pub poissons_ratio: f64,
    /// kg/m³.
    pub density: KilogramPerCubicMetre,
    /// Nominal C₂₀/C₁₀ and C₃₀/C₁₀, no unit.
    pub stiffening: [f64; 2],
    /// Standard deviations of `stiffening`, where the card has them.
    pub stiffening_sigma: Option<[f64; 2]>,
    /// Lowest and highest plausible E, Pa.
    pub plausible: [Pascal; 2],
}

/// What a model reads of a specimen's card.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Body {
    /// Of the solids, the softest first: one a region of the mesh.
    pub materials: Vec<Material>,
    /// The clamped part.
    pub clamp: Clamp,
    /// The specimen's length, m.
    pub length: Metre,
    /// Where the markers are on the undeformed body, m.
    pub markers: Vec<Point3>,
    /// Their diameters, m; none of a marker that is a point.
    pub marker_diameters: Vec<Option<Metre>>,
}

impl Body {
    /// The body on a card.
    pub fn of(card: &Card) -> Self {
        Self {
            materials: card.solid.parts.iter().map(Material::of).collect(),
            clamp: card.clamp.clone(),
            length: card.length,
            markers: card.marker.iter().map(|m| m.at).collect(),
            marker_diameters: card.marker.iter().map(|m| m.diameter).collect(),
        }
    }

    /// Places (m) and diameters (m) of the markers at their measured positions at rest (m, in the plane): the camera sees no height, and that of
    /// the card stays.
    pub fn marks_at<'a>(&'a self, rest: &'a [Point2]) -> impl Iterator<Item = (Point3, Option<Metre>)> + 'a {
        // length: a diameter for each marker, and a measured place for each of the card
        let marks = self.markers.iter().zip(&self.marker_diameters).zip(rest);
        marks.map(|((at, diameter), [x, y])| ([*x, *y, at[2]], *diameter))
    }

    /// The markers from the clamp to the tip.
    pub fn markers_by_x(&self) -> Vec<usize> {
        let mut order: Vec<usize> = (0..self.markers.len()).collect();
        order.sort_by(|&a, &b| self.markers[a][0].total_cmp(&self.markers[b][0]));
        order
    }

    /// The marker farthest from the clamp.
    pub fn tip_marker(&self) -> usize {
        let order = |a: &usize, b: &usize| self.markers[*a][0].total_cmp(&self.markers[*b][0]);
        (0..self.markers.len()).max_by(order).unwrap_or(0)
    }
}

impl Material {
    fn of(Part { name, solid }: &Part) -> Self {
        Self {
            name: name.clone(),
            law: solid.material.clone(),
            youngs_modulus: solid.youngs_modulus,
            poissons_ratio: solid.poissons_ratio,
            density: solid.density,
            stiffening: solid.stiffening,
            stiffening_sigma: solid.stiffening_sigma,
            plausible: solid.plausible,
        }
    }
}
