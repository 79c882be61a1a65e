//! What a mesh would take, estimated from its surfaces before memory is taken for it.

use super::{MeshError, Settings};
use crate::{Detail, Surface};

/// Elements at most: a hundred times the finest tail of the study; ten times more than can be solved in 24 GiB.
const MAX_ELEMENTS: f64 = 5e6;
/// Volume of a regular tetrahedron, and area of an equilateral triangle, over powers of their edge.
const TETRAHEDRON: f64 = 0.117_85;
const TRIANGLE: f64 = 0.433;
/// Elements between the two sides of a column that is thinner than an edge.
const THIN: f64 = 3.0;

/// Whether surfaces can be meshed by these settings: points and faces exist, numbers are finite, and the estimated elements are not too many.
///
/// # Errors
/// [`MeshError::Surface`], [`MeshError::Settings`] or [`MeshError::TooLarge`].
pub(crate) fn check_size(parts: &[(&'static str, &Surface)], set: &Settings) -> Result<(), MeshError> {
    for &(role, surface) in parts {
        surface.check().map_err(|source| MeshError::Surface { role, source })?;
    }
    let Settings { edge, tolerance, volume_limit, distance_limit, .. } = *set;
    let numbers = [("edge", edge), ("tolerance", tolerance), ("volume_limit", volume_limit)];
    let Detail { envelope, smallest, layers } = set.detail;
    let asked = [("envelope", envelope), ("smallest", smallest), ("layers", layers.map(f64::from))];
    let asked = asked.into_iter().filter_map(|(name, value)| Some((name, value?)));
    for (name, value) in numbers.into_iter().chain([("distance_limit", distance_limit)]).chain(asked) {
        if !(value > 0.0 && value.is_finite()) {
            return Err(MeshError::Settings { name, value });
        }
    }
    let length = parts.iter().map(|(_, surface)| surface.length()).fold(0.0, f64::max);
    let elements = parts.iter().map(|(_, surface)| estimated_elements(surface, edge)).sum::<f64>();
    // an overflow is none of a number below the limit
    if elements <= MAX_ELEMENTS {
        Ok(())
    } else {
        Err(MeshError::TooLarge { length, edge, elements, limit: MAX_ELEMENTS })
    }
}

/// Estimated elements of a solid: those of its volume, and those under its faces, of which each column has two.
fn estimated_elements(surface: &Surface, edge: f64) -> f64 {
    // Within a factor of three of what was meshed on three bodies. Without it, a sphere of 60 m with edges of 5 mm took
    // 24 GB.
    surface.volume().abs() / (TETRAHEDRON * edge.powi(3)) + THIN * surface.area() / (2.0 * TRIANGLE * edge.powi(2))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh_without_sheet;
    use crate::surface::tests::block;

    #[test]
    fn the_estimate_is_within_three_times_what_is_meshed() {
        for (size, edge) in [([0.06, 0.03, 0.02], 4e-3), ([0.1, 0.1, 0.001], 5e-3), ([0.03; 3], 2e-3)] {
            let body = block([0.0; 3], size);
            let set = Settings { use_symmetry: false, ..Settings::new(edge) };
            let (made, _) = mesh_without_sheet(&body, &set).unwrap();
            let ratio = estimated_elements(&body, edge) / made.tets.len() as f64;
            assert!((1.0 / 3.0..3.0).contains(&ratio), "{ratio} of {}", made.tets.len());
        }
    }
}
