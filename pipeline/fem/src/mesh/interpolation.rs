//! A field on the nodes of a mesh, at any points: what was solved for on one mesh is a guess on another.

use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;
use si::{Metre, Point3};

use super::Mesh;
use crate::assembly::shape_functions::{element, is_wedge, wedge};

/// Iterations for the reference coordinates of a point: elements are nearly straight, and two or three suffice.
const ITERATIONS: usize = 8;
/// Part of an element's size by which a point may miss it and still lie in it.
const INSIDE: f64 = 1e-6;
/// Part of an element's size by which its box is widened: a curved side lies beyond its nodes.
const MARGIN: f64 = 0.1;

/// One element with the box around it.
struct BoxedElement {
    nodes: Vec<u32>,
    low: Vector3<f64>,
    high: Vector3<f64>,
}

impl Mesh {
    /// The values of a nodal `field` (3 entries a node) at `points` (m), 3 entries each; where the mesh does not hold a point, at the place of an
    /// element near to it that is nearest.
    pub fn field_at(&self, field: &[f64], points: &[Point3]) -> Vec<f64> {
        let elements: Vec<BoxedElement> = self.boxed_elements();
        let value_at = |point: &Point3| {
            let place = Vector3::from(*point);
            let (nodes, shapes) = self.nearest_place(&elements, &place);
            [0, 1, 2].map(|axis| nodes.iter().zip(&shapes).map(|(&n, w)| w * field[3 * n as usize + axis]).sum::<f64>())
        };
        let values: Vec<[f64; 3]> = points.par_iter().map(value_at).collect();
        values.into_flattened()
    }

    fn boxed_elements(&self) -> Vec<BoxedElement> {
        let boxed = |number: usize| {
            let nodes = self.elements.nodes(number).to_vec();
            let corners = || nodes.iter().map(|&node| Vector3::from(self.nodes[node as usize]));
            let low = corners().reduce(|a, b| a.inf(&b)).unwrap_or_default();
            let high = corners().reduce(|a, b| a.sup(&b)).unwrap_or_default();
            let margin = Vector3::repeat(MARGIN * (high - low).amax());
            BoxedElement { nodes, low: low - margin, high: high + margin }
        };
        (0..self.elements.len()).map(boxed).collect()
    }

    /// The nodes of the element that misses a point least, and their shape functions there.
    fn nearest_place<'a>(&self, elements: &'a [BoxedElement], point: &Vector3<f64>) -> (&'a [u32], Vec<f64>) {
        let mut nearest = (f64::INFINITY, [].as_slice(), Vec::new());
        let holds_point = |boxed: &&BoxedElement| boxed.distance(point) == 0.0;
        for boxed in elements.iter().filter(holds_point) {
            let (distance, shapes) = self.place_in(&boxed.nodes, point);
            if distance < nearest.0 {
                nearest = (distance, &boxed.nodes, shapes);
            }
            if distance < INSIDE * (boxed.high - boxed.low).amax() {
                break;
            }
        }
        if nearest.1.is_empty() {
            let closest = elements.iter().min_by(|a, b| a.distance(point).total_cmp(&b.distance(point)));
            nearest = closest.map_or(nearest, |boxed| (0.0, &boxed.nodes, self.place_in(&boxed.nodes, point).1));
        }
        (nearest.1, nearest.2)
    }

    /// By how much an element misses a point (m), and its shape functions at the place that does.
    fn place_in(&self, nodes: &[u32], point: &Vector3<f64>) -> (Metre, Vec<f64>) {
        let is_prism = nodes.len() == 20 && is_wedge(nodes);
        let shapes_at = |at: Point3| if is_prism { wedge(at) } else { element(nodes.len(), at) };
        let is_simplex = [4, 10].contains(&nodes.len());
        let mut place = Vector3::repeat(if is_simplex { 0.25 } else { 1.0 / 3.0 });
        for _ in 0..ITERATIONS {
            let shapes = shapes_at(place.into());
            let (mut miss, mut jacobian) = (-*point, Matrix3::zeros());
            for (&node, (value, by_place)) in nodes.iter().zip(&shapes) {
                let position = Vector3::from(self.nodes[node as usize]);
                miss += position * *value;
                jacobian += position * Vector3::from(*by_place).transpose();
            }
            let Some(step) = jacobian.lu().solve(&miss) else { break };
            place = inside_reference(place - step, (is_simplex, is_prism));
        }
        let shapes: Vec<f64> = shapes_at(place.into()).into_iter().map(|(value, _)| value).collect();
        let position: Vector3<f64> =
            nodes.iter().zip(&shapes).map(|(&node, value)| Vector3::from(self.nodes[node as usize]) * *value).sum();
        ((position - point).norm(), shapes)
    }
}

impl BoxedElement {
    /// Of a point from the box, m; 0 inside.
    fn distance(&self, point: &Vector3<f64>) -> Metre {
        (self.low - point).sup(&(point - self.high)).map(|beyond| beyond.max(0.0)).norm()
    }
}

/// Reference coordinates moved into the reference tetrahedron, wedge or cube.
fn inside_reference(place: Vector3<f64>, (is_simplex, is_prism): (bool, bool)) -> Vector3<f64> {
    let mut inside = place.map(|coordinate| coordinate.clamp(0.0, 1.0));
    let shared = if is_simplex { 3 } else { 2 * usize::from(is_prism) };
    let sum = inside.iter().take(shared).sum::<f64>();
    if sum > 1.0 {
        inside.iter_mut().take(shared).for_each(|coordinate| *coordinate /= sum);
    }
    inside
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{box_mesh, wedges};

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
            let nodal: Vec<f64> = mesh.nodes.iter().flat_map(|node| field(*node)).collect();
            let kind = mesh.elements.nodes_each();
            for (found, point) in mesh.field_at(&nodal, &points).as_chunks::<3>().0.iter().zip(&points) {
                let exact = field(*point);
                assert!((0..3).all(|k| (found[k] - exact[k]).abs() < 1e-9), "{kind}: {found:?} {exact:?}");
            }
            // beyond the mesh, the value at its surface
            let beyond = mesh.field_at(&nodal, &[[0.1, 0.101, 0.05]]);
            let surface = field([0.1, 0.1, 0.05]);
            assert!((0..3).all(|k| (beyond[k] - surface[k]).abs() < 1e-3), "{kind}: {beyond:?} {surface:?}");
        }
    }
}
