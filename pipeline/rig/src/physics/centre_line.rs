//! The centre line of a tail: stations along the sheet.
//!
//! A station's position in the plane of motion is a weighted mean of the sheet's nodes around it (hat functions along x), and so linear in the
//! displacements; a force on a station is distributed to the same nodes with the same weights, so that virtual work is preserved.

use nalgebra::{DMatrix, DVector};
use si::{Metre, Point2};
use tail_cad::Tail;

use super::Body;

/// The sheet's region.
const SHEET: u16 = 1;
/// Stations from the holder to the trailing edge.
const FORWARD: usize = 22;

/// A station.
#[derive(Debug, Clone, PartialEq)]
pub struct Station {
    /// Along the tail at rest, m.
    pub x: Metre,
    /// Of the section there, m.
    pub depth: Metre,
    /// Nodes and their weights, which sum to 1.
    pub nodes: Vec<(u32, f64)>,
}

/// Stations, evenly spaced.
#[derive(Debug, Clone, PartialEq)]
pub struct CentreLine {
    /// From the holder to the fin's tip.
    pub stations: Vec<Station>,
    /// The station of the trailing edge, where the fin is deepest.
    pub trailing: usize,
    /// Between two, m.
    pub spacing: Metre,
}

impl CentreLine {
    /// Of `tail`, meshed as `body`, from `clamp` (m) on.
    pub fn of_tail(tail: &Tail, body: &Body, clamp: Metre) -> Self {
        let trailing_edge = tail.fin.iter().fold((0.0, 0.0), |deepest, f| if f.1 > deepest.1 { *f } else { deepest }).0;
        let spacing = (trailing_edge - clamp) / FORWARD as f64;
        let count = ((tail.length() - clamp) / spacing) as usize + 1;
        let sheet = sheet_nodes(body);
        let station = |k: usize| {
            let x = clamp + k as f64 * spacing;
            Station { x, depth: section_depth(tail, x), nodes: nodes_around(body, &sheet, x, spacing) }
        };
        Self { stations: (0..count).map(station).collect(), trailing: FORWARD, spacing }
    }

    /// Positions at rest, m.
    pub fn rest_positions(&self, body: &Body) -> Vec<Point2> {
        let station_position = |station: &Station| {
            station.nodes.iter().fold([0.0; 2], |sum, (node, weight)| {
                let position = body.mesh.nodes[*node as usize];
                [sum[0] + weight * position[0], sum[1] + weight * position[1]]
            })
        };
        self.stations.iter().map(station_position).collect()
    }

    /// Displacement of each station along x and y by each coordinate, (stations × 2) × coordinates, m.
    pub fn station_rows(&self, reduced: &fem::ReducedModel) -> DMatrix<f64> {
        let mut rows = DMatrix::zeros(2 * self.stations.len(), reduced.coordinates());
        for (k, station) in self.stations.iter().enumerate() {
            for (node, weight) in &station.nodes {
                for axis in 0..2 {
                    for (entry, along) in
                        rows.row_mut(2 * k + axis).iter_mut().zip(reduced.row(3 * *node as usize + axis))
                    {
                        *entry += weight * along;
                    }
                }
            }
        }
        rows
    }

    /// Nodal forces (3 a node, N) of a lateral force at each station, given by `each`.
    pub(crate) fn lateral_forces(&self, nodes: usize, each: &dyn Fn(&Station) -> f64) -> Vec<f64> {
        let mut forces = vec![0.0; 3 * nodes];
        for station in &self.stations {
            let force = each(station);
            station.nodes.iter().for_each(|(node, weight)| forces[3 * *node as usize + 1] += weight * force);
        }
        forces
    }

    /// Nodal forces (3 a node, N) of forces at all stations (x, y; N).
    pub fn nodal_forces(&self, nodes: usize, forces: &DVector<f64>) -> Vec<f64> {
        let mut nodal = vec![0.0; 3 * nodes];
        for (k, station) in self.stations.iter().enumerate() {
            for (node, weight) in &station.nodes {
                (0..2).for_each(|axis| nodal[3 * *node as usize + axis] += weight * forces[2 * k + axis]);
            }
        }
        nodal
    }

    /// Displacements of the stations (x₀, y₀, x₁, …; m) for nodal displacements `u` (3 a node, m).
    pub fn displacements(&self, u: &[f64]) -> DVector<f64> {
        let part = |station: &Station, axis: usize| -> f64 {
            station.nodes.iter().map(|(node, weight)| weight * u[3 * *node as usize + axis]).sum()
        };
        let numbers = self.stations.iter().flat_map(|s| [part(s, 0), part(s, 1)]);
        DVector::from_iterator(2 * self.stations.len(), numbers)
    }
}

/// Depth of the section at `x`: the body's, or the fin's where it is deeper.
fn section_depth(tail: &Tail, x: Metre) -> Metre {
    let body = if x <= tail.body_end() { tail.half_height(x) } else { 0.0 };
    2.0 * body.max(tail.sheet_half_height(x))
}

fn sheet_nodes(body: &Body) -> Vec<u32> {
    let of_sheet = body.mesh.elements.iter().zip(&body.mesh.regions).filter(|(_, region)| **region == SHEET);
    let mut nodes: Vec<u32> = of_sheet.flat_map(|(tet, _)| tet.iter().copied()).collect();
    nodes.sort_unstable();
    nodes.dedup();
    nodes
}

/// The sheet's nodes within `reach` of `x`, with weights that decrease linearly with the distance.
fn nodes_around(body: &Body, sheet: &[u32], x: Metre, reach: Metre) -> Vec<(u32, f64)> {
    let weighted = |node: &u32| (*node, 1.0 - (body.mesh.nodes[*node as usize][0] - x).abs() / reach);
    let nodes: Vec<(u32, f64)> = sheet.iter().map(weighted).filter(|(_, weight)| *weight > 0.0).collect();
    let sum: f64 = nodes.iter().map(|(_, weight)| weight).sum();
    nodes.into_iter().map(|(node, weight)| (node, weight / sum)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two stations that share a node.
    fn two_stations() -> CentreLine {
        let station = |x, nodes: [(u32, f64); 2]| Station { x, depth: 0.05, nodes: nodes.into() };
        let stations = vec![station(0.0, [(0, 0.25), (2, 0.75)]), station(0.01, [(2, 0.5), (1, 0.5)])];
        CentreLine { stations, trailing: 1, spacing: 0.01 }
    }

    #[test]
    fn forces_on_stations_do_the_work_of_their_nodal_forces() {
        let line = two_stations();
        let u: Vec<f64> = (0..9).map(|i| 1e-3 * f64::from(i * i % 7)).collect();
        let forces = DVector::from_vec(vec![1.0, -2.0, 0.5, 3.0]);
        let nodal = line.nodal_forces(3, &forces);
        let work: f64 = nodal.iter().zip(&u).map(|(f, u)| f * u).sum();
        assert!((work - forces.dot(&line.displacements(&u))).abs() < 1e-15, "{work}");
        // by hand: node 2 carries three quarters of the first station's force and half of the second's
        assert_eq!(nodal[6..8], [0.75 + 0.25, -1.5 + 1.5]);
        assert_eq!(nodal[2], 0.0);
    }

    #[test]
    fn lateral_forces_are_those_along_y() {
        let line = two_stations();
        let lateral = line.lateral_forces(3, &|station| 2.0 + 100.0 * station.x);
        assert_eq!(lateral, line.nodal_forces(3, &DVector::from_vec(vec![0.0, 2.0, 0.0, 3.0])));
    }
}
