//! Generalised winding numbers of a surface, for those who compare a mesh with what it was made from.

use si::Point3;

use crate::tree::Tree;

/// The winding numbers of a surface \[jacobson2013\].
#[derive(Debug, Clone)]
pub struct Winding(Tree);

impl Winding {
    /// Of triangles (m) whose normals point outwards.
    pub fn new(triangles: &[[Point3; 3]]) -> Self {
        Self(Tree::new(triangles))
    }

    /// The number at a point (m), without unit: 1 within one closed surface, 2 within two that overlap, 0 outside; between them where there are holes.
    pub fn number_at(&self, point: Point3) -> f64 {
        self.0.winding_number(point)
    }
}
