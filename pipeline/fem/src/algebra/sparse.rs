//! The stiffness matrix as the factor wants it: lower triangle by columns, rows and columns in elimination order.
//!
//! Nodes become runs of up to three freedoms; held ones are left out. The place of a 3 × 3 block is one number, the
//! position of its row node within the column of its column node, so that scattering needs no search.
//!
//! Stands on: `graph`, `order`, `clamps`. Never knows: an element's shape, a material, how to factorise.

use crate::algebra::graph::Graph;
use crate::algebra::order;
use crate::clamps::Clamps;
use nalgebra::Matrix3;
use si::Point3;

/// Marks an axis that is held, or a block that touches a node without freedoms.
pub(crate) const HELD: u32 = u32::MAX;

/// Where every freedom and every entry lives.
#[derive(Debug)]
pub(crate) struct Pattern {
    /// nodes × axes: the row of the matrix, or [`HELD`].
    pub freedom: Vec<[u32; 3]>,
    /// freedoms + 1: where each column begins.
    pub columns: Vec<u32>,
    /// Row of each entry, rising within a column, diagonal first.
    pub rows: Vec<u32>,
    /// Freedom → 3 node + axis.
    pub origin: Vec<u32>,
    rank: Vec<u32>,
    node_columns: Vec<u32>,
    node_rows: Vec<u32>,
    node_offsets: Vec<u32>,
}

impl Pattern {
    /// From the nodes' places (m), their graph and what holds them.
    pub fn new(places: &[Point3], graph: &Graph, clamps: &Clamps) -> Self {
        let mut held = vec![[false; 3]; graph.len()];
        clamps.iter().for_each(|(node, axes)| held[node as usize] = axes);
        let active = (0..graph.len() as u32).filter(|&node| held[node as usize] != [true; 3]).collect();
        let order = order::eliminate(places, graph, active);
        let mut pattern = Self {
            freedom: vec![[HELD; 3]; graph.len()],
            columns: vec![0],
            rows: Vec::new(),
            origin: Vec::new(),
            rank: vec![HELD; graph.len()],
            node_columns: vec![0],
            node_rows: Vec::new(),
            node_offsets: Vec::new(),
        };
        for (rank, &node) in order.iter().enumerate() {
            pattern.rank[node as usize] = rank as u32;
            for axis in (0..3).filter(|&axis| !held[node as usize][axis]) {
                pattern.freedom[node as usize][axis] = pattern.origin.len() as u32;
                pattern.origin.push(3 * node + axis as u32);
            }
        }
        for &node in &order {
            pattern.add_columns(node, graph, &order);
        }
        pattern
    }

    /// Appends the columns of one node: itself first, then the neighbours that are eliminated later.
    fn add_columns(&mut self, node: u32, graph: &Graph, order: &[u32]) {
        let own = self.rank[node as usize];
        let mut later: Vec<u32> = graph.of(node).iter().map(|&next| self.rank[next as usize]).collect();
        later.retain(|&rank| rank != HELD && rank > own);
        later.push(own);
        later.sort_unstable();
        let mut block_rows = Vec::new();
        for rank in later {
            self.node_rows.push(rank);
            self.node_offsets.push(block_rows.len() as u32);
            block_rows.extend(self.freedom[order[rank as usize] as usize].iter().filter(|&&row| row != HELD));
        }
        self.node_columns.push(self.node_rows.len() as u32);
        let freedoms = self.freedom[node as usize].iter().filter(|&&row| row != HELD).count();
        for column in 0..freedoms {
            self.rows.extend(&block_rows[column..]);
            self.columns.push(self.rows.len() as u32);
        }
    }

    /// How many freedoms there are.
    pub fn freedoms(&self) -> usize {
        self.origin.len()
    }

    /// How many entries the lower triangle has.
    pub fn entries(&self) -> usize {
        self.rows.len()
    }

    /// The place of the block between nodes `a` and `b`: [`HELD`] when one has no freedom, `None` when they share no
    /// element.
    pub fn place(&self, a: u32, b: u32) -> Option<u32> {
        let (low, high) = self.ranks(a, b);
        if high == HELD {
            return Some(HELD);
        }
        let (from, to) = (self.node_columns[low as usize] as usize, self.node_columns[low as usize + 1] as usize);
        let found = self.node_rows[from..to].binary_search(&high).ok()?;
        Some(self.node_offsets[from + found])
    }

    fn ranks(&self, a: u32, b: u32) -> (u32, u32) {
        let (a, b) = (self.rank[a as usize], self.rank[b as usize]);
        (a.min(b), a.max(b))
    }

    /// Adds the block ∂²/∂x_a∂x_b (rows: axes of `a`) at its `place`; blocks of a ≠ b are given once, not twice.
    #[inline]
    pub fn add(&self, values: &mut [f64], place: u32, (a, b): (u32, u32), block: &Matrix3<f64>) {
        if place == HELD {
            return;
        }
        let turned = self.rank[a as usize] < self.rank[b as usize];
        let (row_node, column_node) = if turned { (b, a) } else { (a, b) };
        let rows = &self.freedom[row_node as usize];
        let columns = &self.freedom[column_node as usize];
        let (first_row, first_column) = (first(rows), first(columns));
        for k in 0..3 {
            if columns[k] == HELD {
                continue;
            }
            let start = self.columns[columns[k] as usize] + place - (columns[k] - first_column);
            for i in 0..3 {
                if rows[i] == HELD || rows[i] < columns[k] {
                    continue;
                }
                let entry = if turned { block[(k, i)] } else { block[(i, k)] };
                values[(start + rows[i] - first_row) as usize] += entry;
            }
        }
    }

    /// y = K x for the symmetric matrix whose lower triangle is `values`; both in elimination order.
    pub fn multiply(&self, values: &[f64], x: &[f64], y: &mut [f64]) {
        y.fill(0.0);
        for column in 0..self.freedoms() {
            let (from, to) = (self.columns[column] as usize, self.columns[column + 1] as usize);
            let own = x[column];
            let mut sum = values[from] * own;
            for (&row, &value) in self.rows[from + 1..to].iter().zip(&values[from + 1..to]) {
                y[row as usize] += value * own;
                sum += value * x[row as usize];
            }
            y[column] += sum;
        }
    }

    /// The free entries of a vector with 3 a node, in elimination order.
    pub fn gather(&self, full: &[f64], free: &mut Vec<f64>) {
        free.clear();
        free.extend(self.origin.iter().map(|&at| full[at as usize]));
    }

    /// Adds `scale` times the free entries to a vector with 3 a node.
    pub fn spread(&self, free: &[f64], scale: f64, full: &mut [f64]) {
        for (&at, value) in self.origin.iter().zip(free) {
            full[at as usize] += scale * value;
        }
    }
}

fn first(freedom: &[u32; 3]) -> u32 {
    freedom[0].min(freedom[1]).min(freedom[2])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::boxes;

    fn clamped_bar() -> (crate::Mesh, Pattern) {
        let mesh = boxes::quadratic([0.1, 0.02, 0.02], [3, 1, 1]);
        let graph = Graph::new(mesh.nodes.len(), &mesh.elements);
        let mut clamps = Clamps::below_x(&mesh, 1e-9);
        clamps.hold(mesh.nodes.len() as u32 - 1, [false, true, false]);
        let pattern = Pattern::new(&mesh.nodes, &graph, &clamps);
        (mesh, pattern)
    }

    #[test]
    fn columns_begin_on_the_diagonal_and_rise() {
        let (_, pattern) = clamped_bar();
        for column in 0..pattern.freedoms() {
            let rows = &pattern.rows[pattern.columns[column] as usize..pattern.columns[column + 1] as usize];
            assert_eq!(rows[0] as usize, column);
            assert!(rows.windows(2).all(|pair| pair[0] < pair[1]));
        }
    }

    #[test]
    fn a_block_lands_on_the_rows_and_columns_of_its_nodes() {
        let (mesh, pattern) = clamped_bar();
        let nodes = mesh.elements.nodes(10);
        let block = Matrix3::new(1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0);
        for (&a, &b) in nodes.iter().flat_map(|a| nodes.iter().map(move |b| (a, b))).filter(|(a, b)| a != b) {
            let mut values = vec![0.0; pattern.entries()];
            pattern.add(&mut values, pattern.place(a, b).unwrap(), (a, b), &block);
            for (i, k) in (0..3).flat_map(|i| (0..3).map(move |k| (i, k))) {
                let (row, column) = (pattern.freedom[a as usize][i], pattern.freedom[b as usize][k]);
                if row != HELD && column != HELD {
                    let (row, column) = (row.max(column), row.min(column) as usize);
                    let (from, to) = (pattern.columns[column] as usize, pattern.columns[column + 1] as usize);
                    let found = pattern.rows[from..to].binary_search(&row).unwrap();
                    assert_eq!(values[from + found], block[(i, k)]);
                }
            }
        }
    }
}
