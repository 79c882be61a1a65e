//! The half of a tail as a structured grid, whose planes lie at the features of the tail: ribs and chambers along x, layers of wall, chamber
//! and sheet along y, slot, chamber and back along z. Without channel and fin.

use fem::{Mesh, box_mesh};
use si::{Metre, Point3};
use tail_cad::Tail;

/// Where the grid has planes between the features.
#[derive(Debug, Clone, Copy)]
pub struct Cuts {
    /// Inside of each chamber, as fractions of its length.
    pub chamber: &'static [f64],
    /// Inside of each chamber's depth, as fractions from the sheet outwards.
    pub depth: &'static [f64],
    /// Cells from mid height to the slots' end, to the chambers' end, to the back.
    pub heights: [usize; 3],
    /// Cells through the outer wall.
    pub wall: usize,
}

/// Elements on the grid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Family {
    /// Six 10-node tetrahedra a cell.
    Tetrahedra,
    /// One 20-node hexahedron a cell.
    Hexahedra,
}

/// What lies between two planes of constant y.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Layer {
    Silicone,
    Chamber,
    Sheet,
}

/// What lies between two planes of constant x.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Slab {
    Solid,
    Chamber,
    Rib,
}

/// The planes of a grid.
struct Planes<'a> {
    tail: &'a Tail,
    cuts: Cuts,
    /// m.
    x: Vec<Metre>,
    slabs: Vec<Slab>,
    layers: Vec<Layer>,
}

/// The mesh of a tail's half z ≥ 0; chambers lie at y < 0 and y > 0, each by itself.
pub fn mesh(tail: &Tail, cuts: Cuts, family: Family) -> Mesh {
    let planes = Planes::of(tail, cuts);
    let cells = [planes.slabs.len(), planes.layers.len(), cuts.heights.iter().sum()];
    let position = |at: Point3| planes.place(std::array::from_fn(|axis| at[axis] * cells[axis] as f64));
    let region = |cell: [usize; 3]| planes.region(cell);
    match family {
        Family::Tetrahedra => box_mesh::to_quadratic(&box_mesh::grid(cells, true, position, region)),
        Family::Hexahedra => box_mesh::quadratic_hexahedra(cells, true, position, region),
    }
}

impl<'a> Planes<'a> {
    fn of(tail: &'a Tail, cuts: Cuts) -> Self {
        let (mut x, mut slabs) = (vec![0.0, 0.5 * tail.chambers_start, tail.chambers_start], vec![Slab::Solid; 2]);
        for chamber in 0..tail.chambers {
            let [from, to] = tail.chamber(chamber);
            x.extend(cuts.chamber.iter().map(|part| from + part * (to - from)).chain([to]));
            slabs.extend(vec![Slab::Chamber; cuts.chamber.len() + 1]);
            if chamber + 1 < tail.chambers {
                x.push(tail.chamber(chamber + 1)[0]);
                slabs.push(Slab::Rib);
            }
        }
        let end = tail.body_end();
        x.extend([0.5 * (tail.chambers_end + end), end]);
        slabs.extend([Slab::Solid; 2]);
        let (wall, depth) = (vec![Layer::Silicone; cuts.wall], vec![Layer::Chamber; cuts.depth.len() + 1]);
        let side: Vec<Layer> = [Layer::Silicone].into_iter().chain(depth).chain(wall).collect();
        let layers = side.iter().rev().chain(&[Layer::Sheet]).chain(&side).copied().collect();
        Self { tail, cuts, x, slabs, layers }
    }

    /// A place in the body, m, from one counted in cells; a half is the middle of a cell.
    fn place(&self, at: Point3) -> Point3 {
        let x = between(&self.x, at[0]);
        let z = between(&self.heights(x), at[2]);
        let half = self.distances(x, z);
        let middle = 0.5 * self.layers.len() as f64;
        let away = (at[1] - middle).abs();
        // the sheet is one cell about the middle
        let y = if away < 0.5 { away * self.tail.sheet } else { between(&half, away - 0.5) };
        [x, y.copysign(at[1] - middle), z]
    }

    /// Heights of the planes at x, m.
    fn heights(&self, x: Metre) -> Vec<Metre> {
        let back = self.tail.half_height(x);
        let ends = [0.0, self.tail.slot_share * back, back - self.tail.top_wall, back];
        let parts = ends.windows(2).zip(self.cuts.heights);
        let inside = parts.flat_map(|(pair, cells)| {
            (1..=cells).map(move |k| pair[0] + (pair[1] - pair[0]) * k as f64 / cells as f64).collect::<Vec<_>>()
        });
        std::iter::once(0.0).chain(inside).collect()
    }

    /// Distances of the planes of one side from the middle, m, from the face of the sheet outwards.
    fn distances(&self, x: Metre, z: Metre) -> Vec<Metre> {
        let (skin, inner) = (self.tail.half_width(x, z), self.tail.inner_face());
        // behind the chambers the body is thinner than two walls
        let wall = (skin - self.tail.wall[0]).max(inner + 0.5 * (skin - inner));
        let depth = self.cuts.depth.iter().map(|part| inner + part * (wall - inner));
        let through = (1..=self.cuts.wall).map(|k| wall + (skin - wall) * k as f64 / self.cuts.wall as f64);
        [0.5 * self.tail.sheet, inner].into_iter().chain(depth).chain([wall]).chain(through).collect()
    }

    fn region(&self, [i, j, k]: [usize; 3]) -> Option<u16> {
        let [slot, chamber, _] = self.cuts.heights;
        match (self.layers[j], self.slabs[i]) {
            (Layer::Chamber, Slab::Chamber) if k < slot + chamber => None,
            (Layer::Sheet, Slab::Rib) if k < slot => Some(mesh::BODY),
            (Layer::Sheet, _) if k < slot + chamber => Some(mesh::SPINE),
            _ => Some(mesh::BODY),
        }
    }
}

/// The value at a place counted in intervals, linear between two.
fn between(values: &[Metre], at: f64) -> Metre {
    let first = (at.floor() as usize).min(values.len() - 2);
    let part = at - first as f64;
    values[first] * (1.0 - part) + values[first + 1] * part
}
