//! Points of one mesh as material points of another: what was solved for on one is a guess on the other.

use fem::{Elements, Mesh};
use mesh::Spot;
use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;
use si::{Metre, Point3};

/// Iterations for the reference coordinates of a point: elements are nearly straight, and two or three suffice.
const ITERATIONS: usize = 8;
/// Part of an element's size by which a point may miss it and still lie in it.
const INSIDE: f64 = 1e-6;
/// Part of an element's size by which its box is widened: a curved side lies beyond its nodes.
const MARGIN: f64 = 0.1;

/// The box around an element.
struct BoxedElement {
    number: usize,
    low: Vector3<f64>,
    high: Vector3<f64>,
}

/// The material points of a `mesh` at `points` (m); where it does not hold one, the nearest place of an element near to it.
pub(crate) fn spots_inside(mesh: &Mesh, points: &[Point3]) -> Vec<Spot> {
    let elements: Vec<BoxedElement> = (0..mesh.elements.len()).map(|number| boxed_element(mesh, number)).collect();
    points.par_iter().map(|point| nearest_spot(mesh, &elements, &Vector3::from(*point))).collect()
}

fn boxed_element(mesh: &Mesh, number: usize) -> BoxedElement {
    let corners = || mesh.elements.nodes(number).iter().map(|&node| Vector3::from(mesh.nodes[node as usize]));
    let low = corners().reduce(|a, b| a.inf(&b)).unwrap_or_default();
    let high = corners().reduce(|a, b| a.sup(&b)).unwrap_or_default();
    let margin = Vector3::repeat(MARGIN * (high - low).amax());
    BoxedElement { number, low: low - margin, high: high + margin }
}

/// The material point of the element that misses a point least.
fn nearest_spot(mesh: &Mesh, elements: &[BoxedElement], point: &Vector3<f64>) -> Spot {
    let mut nearest: Option<(Metre, Spot)> = None;
    for boxed in elements.iter().filter(|boxed| boxed.distance(point) == 0.0) {
        let (distance, spot) = spot_in_element(mesh, boxed.number, point);
        if nearest.as_ref().is_none_or(|(least, _)| distance < *least) {
            nearest = Some((distance, spot));
        }
        if distance < INSIDE * (boxed.high - boxed.low).amax() {
            break;
        }
    }
    let closest = || elements.iter().min_by(|a, b| a.distance(point).total_cmp(&b.distance(point)));
    let nearest = nearest.or_else(|| closest().map(|boxed| spot_in_element(mesh, boxed.number, point)));
    nearest.map_or(Spot { weights: Vec::new() }, |(_, spot)| spot)
}

/// By how much an element misses a point (m), and the material point that does.
fn spot_in_element(mesh: &Mesh, number: usize, point: &Vector3<f64>) -> (Metre, Spot) {
    let (elements, nodes) = (&mesh.elements, mesh.elements.nodes(number));
    let position = |node: u32| Vector3::from(mesh.nodes[node as usize]);
    let barycentric = barycentric_coordinates(elements, number);
    let mut place = Vector3::repeat(0.25);
    for _ in 0..ITERATIONS {
        let (mut miss, mut jacobian) = (-*point, Matrix3::zeros());
        for (&node, (value, by_place)) in nodes.iter().zip(elements.shape_functions(number, place.into())) {
            miss += position(node) * value;
            jacobian += position(node) * Vector3::from(by_place).transpose();
        }
        let Some(step) = jacobian.lu().solve(&miss) else { break };
        place = inside_reference(place - step, barycentric);
    }
    let values = elements.shape_functions(number, place.into()).into_iter().map(|(value, _)| value);
    let weights: Vec<(u32, f64)> = nodes.iter().copied().zip(values).collect();
    let place: Vector3<f64> = weights.iter().map(|&(node, weight)| position(node) * weight).sum();
    ((place - point).norm(), Spot { weights })
}

impl BoxedElement {
    /// Of a point from the box, m; 0 inside.
    fn distance(&self, point: &Vector3<f64>) -> Metre {
        (self.low - point).sup(&(point - self.high)).map(|beyond| beyond.max(0.0)).norm()
    }
}

/// How many of the reference coordinates add up to at most one: all of a tetrahedron, those in the triangle of a wedge, none of a cube.
fn barycentric_coordinates(elements: &Elements, number: usize) -> usize {
    match elements {
        Elements::Linear(_) | Elements::Quadratic(_) => 3,
        _ => 2 * usize::from(elements.is_wedge(number)),
    }
}

/// Reference coordinates moved into their element.
fn inside_reference(place: Vector3<f64>, barycentric: usize) -> Vector3<f64> {
    let mut inside = place.map(|coordinate| coordinate.clamp(0.0, 1.0));
    let sum = inside.iter().take(barycentric).sum::<f64>();
    if sum > 1.0 {
        inside.iter_mut().take(barycentric).for_each(|coordinate| *coordinate /= sum);
    }
    inside
}

#[cfg(test)]
mod tests {
    use super::*;
    use fem::{box_mesh, wedges};

    const SIZE: Point3 = [0.3, 0.1, 0.2];

    fn linear([x, y, z]: Point3) -> [f64; 3] {
        [1.0 + x, z - 0.5 * x, y - 2.0 * z]
    }

    fn quadratic([x, y, z]: Point3) -> [f64; 3] {
        [1.0 + x * y, z * z - 0.5 * x, y - 2.0 * x * z]
    }

    #[test]
    fn a_field_that_a_mesh_can_have_is_found_everywhere_on_it() {
        let cubes =
            box_mesh::quadratic_hexahedra([3, 2, 2], false, |at| std::array::from_fn(|k| SIZE[k] * at[k]), |_| Some(0));
        let meshes = [
            (box_mesh::linear(SIZE, [3, 2, 2]), linear as fn(Point3) -> [f64; 3]),
            (box_mesh::hexahedra(SIZE, [3, 2, 2]), linear),
            (box_mesh::quadratic(SIZE, [3, 2, 2]), quadratic),
            (wedges::split(&cubes), quadratic),
            (cubes, quadratic),
        ];
        let points: Vec<Point3> = (0..40_u32)
            .map(|i| std::array::from_fn(|k| SIZE[k] * (0.5 + 0.5 * (f64::from(i) * (1.3 + k as f64)).sin())))
            .collect();
        for (mesh, field) in meshes {
            let nodal: Vec<[f64; 3]> = mesh.nodes.iter().map(|node| field(*node)).collect();
            let kind = mesh.elements.nodes_each();
            for (spot, point) in spots_inside(&mesh, &points).iter().zip(&points) {
                let (found, exact) = (spot.at(&nodal), field(*point));
                assert!((0..3).all(|k| (found[k] - exact[k]).abs() < 1e-9), "{kind}: {found:?} {exact:?}");
            }
            // a millimetre beyond the mesh, a place within a millimetre of the point below; fields change by twice as much at most
            let value_beyond = spots_inside(&mesh, &[[0.1, 0.101, 0.05]])[0].at(&nodal);
            let surface = field([0.1, 0.1, 0.05]);
            assert!(
                (0..3).all(|k| (value_beyond[k] - surface[k]).abs() < 2.5e-3),
                "{kind}: {value_beyond:?} {surface:?}"
            );
        }
    }
}
