//! Stations: lines across the plan between which no outline begins, ends or turns back, and the outlines between them as curves.

use crate::columns::arrange::Graph;
use crate::columns::resample::{find_chains, path_corners, simplify_path};
use si::{Metre, Point2};

/// The plan between two stations: outlines as curves p(q) that do not cross, in rising p.
#[derive(Debug, Clone, PartialEq)]
pub struct Slab {
    /// Where it begins, m.
    pub from: Metre,
    /// Where it ends, m.
    pub to: Metre,
    /// (q, p) along each outline, m.
    curves: Vec<Vec<Point2>>,
}

impl Slab {
    /// The slab between two stations (m) with `outlines`: p of each at q, in rising order, sampled at so many places, two at least. They lie beside the
    /// stations, where outlines that meet on them are apart.
    pub fn sampled([from, to]: [Metre; 2], samples: usize, outlines: &dyn Fn(Metre) -> Vec<Metre>) -> Self {
        let inset = BESIDE * (to - from);
        let station = |n: usize| from + inset + (to - from - 2.0 * inset) * n as f64 / (samples - 1) as f64;
        let mut curves = vec![Vec::with_capacity(samples); outlines(0.5 * (from + to)).len()];
        for q in (0..samples).map(station) {
            // length: outlines neither begin nor end between two stations
            curves.iter_mut().zip(outlines(q)).for_each(|(curve, p): (&mut Vec<Point2>, _)| curve.push([q, p]));
        }
        Self { from, to, curves }
    }

    /// m.
    pub(crate) fn length(&self) -> Metre {
        self.to - self.from
    }

    /// The strips between neighbouring outlines, by the number of the lower one.
    pub(crate) fn strips(&self) -> impl Iterator<Item = (&Self, usize)> {
        (0..self.curves.len().saturating_sub(1)).map(move |lower| (self, lower))
    }

    /// The middle of each strip.
    pub(crate) fn strip_centres(&self) -> impl Iterator<Item = Point2> {
        let q = 0.5 * (self.from + self.to);
        self.strips()
            .map(move |(slab, lower)| [0.5 * (slab.curve_position(lower, q) + slab.curve_position(lower + 1, q)), q])
    }

    /// Number of outlines.
    pub(crate) fn curves(&self) -> usize {
        self.curves.len()
    }

    /// p of an outline at q, m.
    pub(crate) fn curve_position(&self, curve: usize, q: Metre) -> Metre {
        let points = &self.curves[curve];
        let next = points.partition_point(|point| point[0] < q).clamp(1, points.len() - 1);
        let (a, b) = (points[next - 1], points[next]);
        let part = ((q - a[0]) / (b[0] - a[0]).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        a[1] + part * (b[1] - a[1])
    }
}

/// Distance from a station at which outlines are sampled, over the length of a slab.
const BESIDE: f64 = 1e-6;

/// The slabs of a plan, along q; points nearer than `tolerance` (m) to a station lie on it.
///
/// # Errors
/// A place where the number of outlines changes between two stations.
pub(crate) fn find_slabs(outlines: &Graph, tolerance: Metre) -> Result<Vec<Slab>, Point2> {
    let stations = find_stations(outlines, tolerance);
    let on_station = |q: Metre| {
        let nearest = stations.iter().min_by(|a, b| (*a - q).abs().total_cmp(&(*b - q).abs()));
        nearest.copied().filter(|station| (station - q).abs() <= tolerance).unwrap_or(q)
    };
    let points: Vec<Point2> = outlines.points.iter().map(|&[p, q]| [on_station(q), p]).collect();
    let edges = outlines.edges.iter().map(|edge| edge.map(|v| points[v as usize]));
    let rising = edges.map(|[a, b]| if a[0] <= b[0] { [a, b] } else { [b, a] });
    // an edge along a station bounds no strip
    let edges: Vec<[Point2; 2]> = rising.filter(|[a, b]| b[0] > a[0]).collect();
    stations.windows(2).map(|pair| sampled_slab(&edges, pair[0], pair[1])).collect()
}

fn sampled_slab(edges: &[[Point2; 2]], from: Metre, to: Metre) -> Result<Slab, Point2> {
    let inside: Vec<&[Point2; 2]> = edges.iter().filter(|[a, b]| a[0] < to && b[0] > from).collect();
    let mut samples: Vec<Metre> = inside.iter().flat_map(|edge| edge.map(|point| point[0])).collect();
    samples.retain(|q| *q > from && *q < to);
    // beside the stations, where curves that meet on them are apart
    let inset = BESIDE * (to - from);
    samples.extend([from + inset, 0.5 * (from + to), to - inset]);
    samples.sort_by(f64::total_cmp);
    samples.dedup();
    let crossings = |q: Metre| {
        let crossing = |[a, b]: &[Point2; 2]| a[1] + (b[1] - a[1]) * (q - a[0]) / (b[0] - a[0]);
        let mut crossings: Vec<Metre> =
            inside.iter().filter(|[a, b]| a[0] <= q && q < b[0]).map(|edge| crossing(edge)).collect();
        crossings.sort_by(f64::total_cmp);
        crossings
    };
    let count = crossings(0.5 * (from + to)).len();
    let mut curves = vec![Vec::with_capacity(samples.len()); count];
    for q in samples {
        let crossings = crossings(q);
        if crossings.len() != count {
            return Err([crossings.first().copied().unwrap_or(0.0), q]);
        }
        curves.iter_mut().zip(crossings).for_each(|(curve, p)| curve.push([q, p]));
    }
    Ok(Slab { from, to, curves })
}

/// q of junctions, corners and points where an outline turns back, m; those within the tolerance of each other are one.
fn find_stations(outlines: &Graph, tolerance: Metre) -> Vec<Metre> {
    let mut places = Vec::new();
    for chain in find_chains(outlines) {
        let points: Vec<Point2> = chain.iter().map(|&v| outlines.points[v as usize]).collect();
        places.extend(path_corners(&points, &simplify_path(&points, tolerance)).into_iter().map(|n| points[n][1]));
        places.extend(turning_stations(&points, tolerance));
    }
    places.sort_by(f64::total_cmp);
    let mut stations: Vec<Vec<Metre>> = Vec::new();
    for q in places {
        match stations.last_mut() {
            // Against the first of a group and not the last: a chain of places, each near the one before, would become
            // one station.
            Some(station) if q - station[0] <= tolerance => station.push(q),
            _ => stations.push(vec![q]),
        }
    }
    stations.iter().map(|station| station.iter().sum::<f64>() / station.len() as f64).collect()
}

/// q of the points where a path turns back along q by more than the tolerance.
fn turning_stations(path: &[Point2], tolerance: Metre) -> Vec<Metre> {
    let (mut turns, mut farthest, mut forward) = (Vec::new(), path[0][1], None);
    for &[_, q] in path {
        let ahead = q - farthest;
        match forward {
            None if ahead.abs() > tolerance => (forward, farthest) = (Some(ahead > 0.0), q),
            Some(way) if (ahead > 0.0) == way => farthest = q,
            Some(way) if ahead.abs() > tolerance => {
                turns.push(farthest);
                (forward, farthest) = (Some(!way), q);
            }
            _ => {}
        }
    }
    turns
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::columns::arrange::arrange_segments;

    #[test]
    fn a_rectangle_with_a_notch_has_stations_at_its_corners_and_a_circle_at_its_ends() {
        let ring = |points: &[Point2]| -> Vec<[Point2; 2]> {
            (0..points.len()).map(|n| [points[n], points[(n + 1) % points.len()]]).collect()
        };
        let outline = [[0.0, 0.0], [0.0, 3.0], [1.0, 3.0], [1.0, 2.0], [2.0, 2.0], [2.0, 0.0]];
        let slabs = find_slabs(&arrange_segments(&ring(&outline), 1e-6), 1e-3).unwrap();
        let ends: Vec<_> = slabs.iter().map(|slab| (slab.from, slab.to, slab.curves())).collect();
        assert_eq!(ends, [(0.0, 2.0, 2), (2.0, 3.0, 2)]);
        assert!((slabs[1].curve_position(1, 2.5) - 1.0).abs() < 1e-12);
        let angle = |n: u32| f64::from(n) * std::f64::consts::TAU / 200.0;
        let circle: Vec<Point2> = (0..200).map(|n| [angle(n).cos(), angle(n).sin()]).collect();
        let slabs = super::find_slabs(&arrange_segments(&ring(&circle), 1e-6), 1e-3).unwrap();
        // the arbitrary start of a closed path is a station as well
        assert!(slabs.len() <= 3 && (slabs[0].from + 1.0).abs() < 1e-12, "{}", slabs.len());
        let at = slabs.iter().find(|slab| slab.from < 0.3 && slab.to > 0.3).unwrap();
        assert!((at.curve_position(1, 0.3) - (1.0f64 - 0.09).sqrt()).abs() < 1e-3);
    }
}
