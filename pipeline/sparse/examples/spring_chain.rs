//! A chain of springs that is pulled at its end: the matrix of its stiffness is assembled in 3 × 3 blocks, factorised and solved; each spring stretches by
//! the same length.

use nalgebra::Matrix3;
use sparse::{Factor, NodeGraph, Pattern, Symbolic};

const SPRINGS: u32 = 100;
/// N/m and N.
const STIFFNESS: f64 = 50.0;
const FORCE: f64 = 2.0;

/// # Errors
/// When the matrix cannot be factorised.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let elements: Vec<u32> = (0..SPRINGS).flat_map(|spring| [spring, spring + 1]).collect();
    let nodes = SPRINGS as usize + 1;
    let positions: Vec<[f64; 3]> = (0..nodes).map(|node| [node as f64, 0.0, 0.0]).collect();
    let graph = NodeGraph::new(nodes, &elements, 2);
    let fixed: Vec<[bool; 3]> = (0..nodes).map(|node| [node == 0; 3]).collect();
    let pattern = Pattern::new(&positions, &graph, &fixed);
    let mut values = vec![0.0; pattern.entries()];
    let block = Matrix3::identity() * STIFFNESS;
    for (a, b) in (0..SPRINGS).map(|spring| (spring, spring + 1)) {
        for ((row, column), block) in [((a, a), block), ((b, b), block), ((b, a), -block)] {
            if let Some(position) = pattern.block_position(row, column) {
                pattern.add(&mut values, position, (row, column), &block);
            }
        }
    }
    let symbolic = Symbolic::new(&pattern)?;
    let mut factor = Factor::new(&symbolic);
    factor.compute(&symbolic, &pattern, &values, &vec![STIFFNESS; pattern.dofs()])?;
    let mut load = vec![0.0; 3 * nodes];
    load[3 * (nodes - 1)] = FORCE;
    let mut solution = pattern.gather(&load);
    factor.solve(&symbolic, &mut solution);
    let moved = pattern.scattered(&solution, 1.0, 3 * nodes);
    println!("{} entries; the end moves by {:.6} m", pattern.entries(), moved[3 * (nodes - 1)]);
    let stretched = |node: usize| node as f64 * FORCE / STIFFNESS;
    assert!((0..nodes).all(|node| (moved[3 * node] - stretched(node)).abs() < 1e-9));
    Ok(())
}
