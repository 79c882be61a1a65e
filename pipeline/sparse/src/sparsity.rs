//! Sparsity pattern of the stiffness matrix: lower triangle by columns, rows and columns in elimination order.
//!
//! Each node contributes up to three consecutive dofs; constrained ones are left out. The position of a 3 × 3 block is
//! one number, the offset of its row node within the column of its column node, so that assembly needs no search.

use crate::nested_dissection;
use crate::node_graph::NodeGraph;
use nalgebra::Matrix3;
use si::Point3;

/// Marks a constrained axis, or a block of a node without dofs.
pub const CONSTRAINED: u32 = u32::MAX;

/// A symmetric matrix by columns, its lower triangle alone: rows and columns in elimination order.
#[derive(Debug, Clone, Copy)]
pub struct LowerTriangle<'a> {
    /// dofs + 1: where each column begins in `rows` and `values`.
    pub columns: &'a [u32],
    /// Row of each entry, rising within a column, the diagonal first.
    pub rows: &'a [u32],
    /// N/m.
    pub values: &'a [f64],
    /// Dof → 3 node + axis.
    pub full_index: &'a [u32],
}

impl LowerTriangle<'_> {
    /// K x, in elimination order.
    pub(crate) fn multiply_vector(&self, x: &[f64]) -> Vec<f64> {
        let mut y = vec![0.0; x.len()];
        multiply_symmetric(self, x, &mut y);
        y
    }
}

/// y = K x, both in elimination order.
fn multiply_symmetric(matrix: &LowerTriangle, x: &[f64], y: &mut [f64]) {
    y.fill(0.0);
    for column in 0..x.len() {
        let (start, end) = (matrix.columns[column] as usize, matrix.columns[column + 1] as usize);
        let x_column = x[column];
        let mut sum = matrix.values[start] * x_column;
        for (&row, &value) in matrix.rows[start + 1..end].iter().zip(&matrix.values[start + 1..end]) {
            y[row as usize] += value * x_column;
            sum += value * x[row as usize];
        }
        y[column] += sum;
    }
}

/// Position of every dof and every entry.
#[derive(Debug, Clone)]
pub struct Pattern {
    /// nodes × axes: the row of the matrix, or [`CONSTRAINED`].
    pub dof: Vec<[u32; 3]>,
    /// dofs + 1: where each column begins.
    pub columns: Vec<u32>,
    /// Row of each entry, rising within a column, diagonal first.
    pub rows: Vec<u32>,
    /// Dof → 3 node + axis.
    pub full_index: Vec<u32>,
    rank: Vec<u32>,
    node_columns: Vec<u32>,
    node_rows: Vec<u32>,
    node_offsets: Vec<u32>,
}

impl Pattern {
    /// From the positions of the nodes (m), their graph, and the axes along which each is `constrained`.
    pub fn new(positions: &[Point3], graph: &NodeGraph, constrained: &[[bool; 3]]) -> Self {
        let active = (0..graph.len() as u32).filter(|&node| constrained[node as usize] != [true; 3]).collect();
        let order = nested_dissection::elimination_order(positions, graph, active);
        let mut pattern = Self {
            dof: vec![[CONSTRAINED; 3]; graph.len()],
            columns: vec![0],
            rows: Vec::new(),
            full_index: Vec::new(),
            rank: vec![CONSTRAINED; graph.len()],
            node_columns: vec![0],
            node_rows: Vec::new(),
            node_offsets: Vec::new(),
        };
        for (rank, &node) in order.iter().enumerate() {
            pattern.rank[node as usize] = rank as u32;
            for axis in (0..3).filter(|&axis| !constrained[node as usize][axis]) {
                pattern.dof[node as usize][axis] = pattern.full_index.len() as u32;
                pattern.full_index.push(3 * node + axis as u32);
            }
        }
        for &node in &order {
            pattern.add_columns(node, graph, &order);
        }
        pattern
    }

    /// Appends the columns of one node: the node itself first, then its neighbours that are eliminated later.
    fn add_columns(&mut self, node: u32, graph: &NodeGraph, order: &[u32]) {
        let node_rank = self.rank[node as usize];
        let mut later: Vec<u32> = graph.neighbours_of(node).iter().map(|&next| self.rank[next as usize]).collect();
        later.retain(|&rank| rank != CONSTRAINED && rank > node_rank);
        later.push(node_rank);
        later.sort_unstable();
        let mut block_rows = Vec::new();
        for rank in later {
            self.node_rows.push(rank);
            self.node_offsets.push(block_rows.len() as u32);
            block_rows.extend(self.dof[order[rank as usize] as usize].iter().filter(|&&row| row != CONSTRAINED));
        }
        self.node_columns.push(self.node_rows.len() as u32);
        let dofs = self.dof[node as usize].iter().filter(|&&row| row != CONSTRAINED).count();
        for column in 0..dofs {
            self.rows.extend(&block_rows[column..]);
            self.columns.push(self.rows.len() as u32);
        }
    }

    /// Number of dofs.
    pub fn dofs(&self) -> usize {
        self.full_index.len()
    }

    /// Number of entries of the lower triangle.
    pub fn entries(&self) -> usize {
        self.rows.len()
    }

    /// Position of the block of nodes `a` and `b`: [`CONSTRAINED`] when one has no dof, `None` when they share no
    /// element.
    pub fn block_position(&self, a: u32, b: u32) -> Option<u32> {
        let (low, high) = self.sorted_ranks(a, b);
        if high == CONSTRAINED {
            return Some(CONSTRAINED);
        }
        let (start, end) = (self.node_columns[low as usize] as usize, self.node_columns[low as usize + 1] as usize);
        let offset = self.node_rows[start..end].binary_search(&high).ok()?;
        Some(self.node_offsets[start + offset])
    }

    fn sorted_ranks(&self, a: u32, b: u32) -> (u32, u32) {
        let (a, b) = (self.rank[a as usize], self.rank[b as usize]);
        (a.min(b), a.max(b))
    }

    /// Adds the block ∂²/∂x_a∂x_b (rows: axes of `a`) at its `position`; blocks of a ≠ b are given once, not twice.
    #[inline]
    pub fn add(&self, values: &mut [f64], position: u32, (a, b): (u32, u32), block: &Matrix3<f64>) {
        if position == CONSTRAINED {
            return;
        }
        let transposed = self.rank[a as usize] < self.rank[b as usize];
        let (row_node, column_node) = if transposed { (b, a) } else { (a, b) };
        let rows = &self.dof[row_node as usize];
        let columns = &self.dof[column_node as usize];
        let (first_row, first_column) = (first_dof(rows), first_dof(columns));
        for k in 0..3 {
            if columns[k] == CONSTRAINED {
                continue;
            }
            let start = self.columns[columns[k] as usize] + position - (columns[k] - first_column);
            for i in 0..3 {
                if rows[i] == CONSTRAINED || rows[i] < columns[k] {
                    continue;
                }
                let entry = if transposed { block[(k, i)] } else { block[(i, k)] };
                values[(start + rows[i] - first_row) as usize] += entry;
            }
        }
    }

    /// y = K x for the symmetric matrix whose lower triangle is `values`; both in elimination order.
    pub fn multiply(&self, values: &[f64], x: &[f64], y: &mut [f64]) {
        multiply_symmetric(&self.lower_triangle(values), x, y);
    }

    /// The entries `values` with their pattern.
    pub fn lower_triangle<'a>(&'a self, values: &'a [f64]) -> LowerTriangle<'a> {
        LowerTriangle { columns: &self.columns, rows: &self.rows, values, full_index: &self.full_index }
    }

    /// A vector with 3 entries per node from its free entries; zero at constrained dofs.
    pub fn scattered(&self, free: &[f64], scale: f64, length: usize) -> Vec<f64> {
        let mut full = vec![0.0; length];
        self.scatter(free, scale, &mut full);
        full
    }

    /// The free entries of a vector with 3 entries per node, in elimination order.
    pub fn gather(&self, full: &[f64]) -> Vec<f64> {
        self.full_index.iter().map(|&index| full[index as usize]).collect()
    }

    /// Adds `scale` times the free entries to a vector with 3 entries per node; the counterpart of [`Pattern::gather`].
    pub fn scatter(&self, free: &[f64], scale: f64, full: &mut [f64]) {
        for (&index, value) in self.full_index.iter().zip(free) {
            full[index as usize] += scale * value;
        }
    }
}

fn first_dof(dof: &[u32; 3]) -> u32 {
    dof[0].min(dof[1]).min(dof[2])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Grid;

    fn clamped_bar() -> (Grid, Pattern) {
        let grid = Grid::new([6, 2, 2]);
        let mut constrained = grid.first_layer_constrained();
        constrained[grid.nodes.len() - 1] = [false, true, false];
        let pattern = Pattern::new(&grid.nodes, &grid.graph(), &constrained);
        (grid, pattern)
    }

    #[test]
    fn columns_begin_on_the_diagonal_and_rise() {
        let (_, pattern) = clamped_bar();
        for column in 0..pattern.dofs() {
            let rows = &pattern.rows[pattern.columns[column] as usize..pattern.columns[column + 1] as usize];
            assert_eq!(rows[0] as usize, column);
            assert!(rows.windows(2).all(|pair| pair[0] < pair[1]));
        }
    }

    #[test]
    fn a_block_lands_on_the_rows_and_columns_of_its_nodes() {
        let (grid, pattern) = clamped_bar();
        let nodes = grid.elements.last().unwrap();
        let block = Matrix3::new(1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0);
        for (&a, &b) in nodes.iter().flat_map(|a| nodes.iter().map(move |b| (a, b))).filter(|(a, b)| a != b) {
            let mut values = vec![0.0; pattern.entries()];
            pattern.add(&mut values, pattern.block_position(a, b).unwrap(), (a, b), &block);
            for (i, k) in (0..3).flat_map(|i| (0..3).map(move |k| (i, k))) {
                let (row, column) = (pattern.dof[a as usize][i], pattern.dof[b as usize][k]);
                if row != CONSTRAINED && column != CONSTRAINED {
                    let (row, column) = (row.max(column), row.min(column) as usize);
                    let (start, end) = (pattern.columns[column] as usize, pattern.columns[column + 1] as usize);
                    let offset = pattern.rows[start..end].binary_search(&row).unwrap();
                    assert_eq!(values[start + offset], block[(i, k)]);
                }
            }
        }
    }
}
