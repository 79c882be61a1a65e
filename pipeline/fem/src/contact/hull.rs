//! Whether two faces stay apart in a step, by planes between their convex hulls.
//!
//! The points of a face stay inside the hull of its control points. As those move along straight lines, so do their projections on a fixed
//! axis: hulls that an axis separates before and after a step are separated by it all the way.

use super::APPROACH;
use super::boxes::ClosePair;
use nalgebra::Vector3;
use si::Metre;

/// Control points of a face.
pub(crate) type Hull = Vec<Vector3<f64>>;

/// The hulls of all faces, and those of their mirror images or none. Each belongs to many pairs, and is made once.
pub(crate) type Hulls = [Vec<Hull>; 2];

/// Those of a pair.
pub(crate) fn of_pair<'a>(hulls: &'a Hulls, pair: &ClosePair) -> [&'a Hull; 2] {
    pair.faces().map(|(face, mirrored)| &hulls[usize::from(mirrored)][face as usize])
}

/// Whether one of the axes separates two hulls before a step, and keeps enough of their gap after it. `hulls`: both before and both after.
pub(crate) fn stay_apart([before, after]: [[&Hull; 2]; 2]) -> bool {
    let keeps = |axis: Vector3<f64>| {
        let now = gap_along(before, &axis);
        now > 0.0 && gap_along(after, &axis) >= (1.0 - APPROACH) * now
    };
    separating_axes(before).into_iter().any(keeps)
}

/// A lower bound of the distance of two hulls, m: their largest gap along one of the axes; negative where none separates them.
pub(crate) fn hull_gap(hulls: [&Hull; 2]) -> Metre {
    let gap_on_axis = |axis: Vector3<f64>| gap_along(hulls, &axis) / axis.norm();
    separating_axes(hulls).into_iter().map(gap_on_axis).fold(f64::NEG_INFINITY, f64::max)
}

/// An upper bound of the motion of a point of one face relative to one of the other, m.
pub(crate) fn relative_motion([before, after]: [[&Hull; 2]; 2]) -> Metre {
    let steps = [0, 1].map(|face| before[face].iter().zip(after[face]).map(|(from, to)| to - from).collect::<Hull>());
    let each = steps[0].iter().flat_map(|a| steps[1].iter().map(move |b| (a - b).norm()));
    each.fold(0.0, f64::max)
}

/// The direction from one middle to the other, and the normals of both faces either way.
fn separating_axes([a, b]: [&Hull; 2]) -> [Vector3<f64>; 5] {
    let normal = |hull: &Hull| (hull[1] - hull[0]).cross(&(hull[2] - hull[0]));
    let middle = |hull: &Hull| hull.iter().sum::<Vector3<f64>>() / hull.len() as f64;
    // Five axes and not those of all pairs of edges: an axis that is missed costs a look at the samples, and no
    // contact.
    [middle(b) - middle(a), normal(a), normal(b), -normal(a), -normal(b)]
}

/// By how much the second hull lies beyond the first along an `axis`, in units of its length; negative where it does not.
fn gap_along([a, b]: [&Hull; 2], axis: &Vector3<f64>) -> f64 {
    let high = a.iter().map(|point| point.dot(axis)).fold(f64::NEG_INFINITY, f64::max);
    let low = b.iter().map(|point| point.dot(axis)).fold(f64::INFINITY, f64::min);
    low - high
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle(z: f64, tilt: f64) -> Hull {
        [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].map(|[x, y]| Vector3::new(x, y, z + tilt * x)).to_vec()
    }

    #[test]
    fn faces_stay_apart_while_an_axis_keeps_a_fifth_of_their_gap() {
        let from = [&triangle(0.0, 0.0), &triangle(1.0, 0.0)];
        let apart = |z, tilt| stay_apart([from, [&triangle(0.0, 0.0), &triangle(z, tilt)]]);
        assert!(apart(0.9, 0.0) && apart(0.21, 0.0) && !apart(0.19, 0.0) && !apart(-1.0, 0.0));
        // sideways and turned, yet on its side
        assert!(apart(0.7, 0.5));
        let gaps = [hull_gap(from), hull_gap([&triangle(0.0, 0.0), &triangle(0.5, 1.0)])];
        assert!((gaps[0] - 1.0).abs() < 1e-12 && (gaps[1] - 0.5).abs() < 1e-12, "{gaps:?}");
        assert!((relative_motion([from, [&triangle(0.3, 0.0), &triangle(0.8, 0.0)]]) - 0.5).abs() < 1e-12);
        // no plane lies between two that cross
        let crossing = [&triangle(-0.5, 1.0), &triangle(0.0, 0.0)];
        assert!(!stay_apart([crossing, crossing]));
    }
}
