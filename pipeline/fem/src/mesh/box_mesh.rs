//! Box meshes: boxes and hollow boxes cut into tetrahedra on a grid, bodies with closed-form solutions for tests and
//! timings.
//!
//! Every cell is cut into six tetrahedra around its long diagonal (Kuhn), so that neighbours match. Cells before the
//! middle are mirror images of those behind it: where the numbers of cells are even, the mesh has the symmetry of the
//! body.

use crate::assembly::shape_functions::{CUBE_EDGES, EDGES, QUADRILATERAL_SIDES, SIDES};
use crate::mesh::{Chamber, Elements, Faces, Mesh};
use crate::setup_error::SetupError;
use si::Point3;
use std::collections::{BTreeMap, BTreeSet};

/// The six paths from corner (0,0,0) to (1,1,1) along cell edges, as permutations of the axes; even ones first.
const PATHS: [([usize; 3], bool); 6] = [
    ([0, 1, 2], true),
    ([1, 2, 0], true),
    ([2, 0, 1], true),
    ([0, 2, 1], false),
    ([2, 1, 0], false),
    ([1, 0, 2], false),
];

/// Cells at most: six tetrahedra of ten nodes in each take 1 GB, and their factors more than any of these programs can use.
const MAX_CELLS: usize = 1_000_000;

/// Whether a box of this `size` (m) can be cut into so many `cells`; asked before memory is taken.
///
/// # Errors
/// [`SetupError::Box`] when a side or a number of cells is not positive, or there are more than a million cells.
pub fn check(size: Point3, cells: [usize; 3]) -> Result<(), SetupError> {
    let count = cells.iter().try_fold(1_usize, |product, count| product.checked_mul(*count)).unwrap_or(usize::MAX);
    let sound = size.iter().all(|side| *side > 0.0 && side.is_finite()) && (1..=MAX_CELLS).contains(&count);
    if sound { Ok(()) } else { Err(SetupError::Box { size, cells, largest: MAX_CELLS }) }
}

/// A box [0, size] (m) of `cells` grid cells along x, y, z, as 4-node tetrahedra. [`check`] finds sizes that would take
/// too much memory; so for the others.
pub fn linear(size: Point3, cells: [usize; 3]) -> Mesh {
    grid(cells, false, |at| std::array::from_fn(|axis| size[axis] * at[axis]), |_| Some(0))
}

/// The same box as 10-node tetrahedra.
pub fn quadratic(size: Point3, cells: [usize; 3]) -> Mesh {
    to_quadratic(&linear(size, cells))
}

/// A grid of `cells` over [0, 1]³ mapped by `place` (to m); `region` gives the region of each cell, counted along x, y,
/// z. Cells without a region are air; each connected part of the air that solid encloses is one chamber. With `half`,
/// the mesh is the half z ≥ 0 of a symmetric body: its lowest layer must be placed at z = 0.
pub fn grid(
    cells: [usize; 3],
    half: bool,
    place: impl Fn(Point3) -> Point3,
    region: impl Fn([usize; 3]) -> Option<u16>,
) -> Mesh {
    let mut numbers = BTreeMap::new();
    let mut mesh = Mesh {
        nodes: Vec::new(),
        elements: Elements::Linear(Vec::new()),
        regions: Vec::new(),
        chambers: Vec::new(),
        symmetry_plane_z: half,
    };
    let mut tets = Vec::new();
    for cell in all_cells(cells) {
        let Some(material) = region(cell) else { continue };
        let mirror = mirrored_axes(cells, half, cell);
        for path in PATHS {
            let mut number = |corner: [usize; 3]| {
                *numbers.entry(corner).or_insert_with(|| {
                    mesh.nodes.push(place(std::array::from_fn(|axis| corner[axis] as f64 / cells[axis] as f64)));
                    mesh.nodes.len() as u32 - 1
                })
            };
            tets.push(path_corners(cell, path, mirror).map(&mut number));
            mesh.regions.push(material);
        }
    }
    let triangles = |side: Side| side_triangles(side, mirrored_axes(cells, half, side.cell), &numbers);
    let chamber = |walls: Vec<Side>| Chamber { faces: Faces::Linear(walls.into_iter().flat_map(triangles).collect()) };
    mesh.chambers = chamber_walls(cells, half, &region).into_iter().map(chamber).collect();
    mesh.elements = Elements::Linear(tets);
    mesh
}

/// The same mesh with a node in the middle of each edge (10-node tetrahedra).
///
/// # Panics
/// When `mesh` is quadratic already.
pub fn to_quadratic(mesh: &Mesh) -> Mesh {
    let Elements::Linear(tets) = &mesh.elements else { panic!("the mesh is quadratic already") };
    let mut nodes = mesh.nodes.clone();
    let mut numbers = BTreeMap::new();
    let mut middle = |a: u32, b: u32| {
        *numbers.entry((a.min(b), a.max(b))).or_insert_with(|| {
            let (from, to) = (mesh.nodes[a as usize], mesh.nodes[b as usize]);
            nodes.push(std::array::from_fn(|axis| 0.5 * (from[axis] + to[axis])));
            nodes.len() as u32 - 1
        })
    };
    let elements = tets
        .iter()
        .map(|tet| {
            std::array::from_fn(|n| if n < 4 { tet[n] } else { middle(tet[EDGES[n - 4].0], tet[EDGES[n - 4].1]) })
        })
        .collect();
    let mut walls = Vec::new();
    for chamber in &mesh.chambers {
        let Faces::Linear(faces) = &chamber.faces else { panic!("the mesh is quadratic already") };
        let faces = faces.iter().map(|face| {
            std::array::from_fn(|n| if n < 3 { face[n] } else { middle(face[SIDES[n - 3].0], face[SIDES[n - 3].1]) })
        });
        walls.push(Chamber { faces: Faces::Quadratic(faces.collect()) });
    }
    Mesh {
        nodes,
        elements: Elements::Quadratic(elements),
        regions: mesh.regions.clone(),
        chambers: walls,
        symmetry_plane_z: mesh.symmetry_plane_z,
    }
}

/// The same box as 8-node hexahedra; nodes and elements are counted along x, then y, then z.
pub fn hexahedra(size: Point3, cells: [usize; 3]) -> Mesh {
    let [nx, ny, nz] = cells.map(|count| count + 1);
    let node_position = |n: usize| {
        let index = [n % nx, n / nx % ny, n / (nx * ny)];
        std::array::from_fn(|axis| size[axis] * index[axis] as f64 / cells[axis] as f64)
    };
    let corner = |[i, j, k]: [usize; 3], [x, y, z]: [usize; 3]| (i + x + nx * (j + y + ny * (k + z))) as u32;
    let element = |cell| std::array::from_fn(|n| corner(cell, [SQUARE[n % 4][0], SQUARE[n % 4][1], n / 4]));
    let elements: Vec<[u32; 8]> = all_cells(cells).map(element).collect();
    Mesh {
        nodes: (0..nx * ny * nz).map(node_position).collect(),
        regions: vec![0; elements.len()],
        elements: Elements::Hexahedra(elements),
        chambers: Vec::new(),
        symmetry_plane_z: false,
    }
}

/// A grid of `cells` as 20-node hexahedra, and its chambers; the arguments are those of [`grid`]. Mid-edge nodes are placed on the grid of
/// half the cells, so that curved bodies have curved elements.
pub fn quadratic_hexahedra(
    cells: [usize; 3],
    half: bool,
    place: impl Fn(Point3) -> Point3,
    region: impl Fn([usize; 3]) -> Option<u16>,
) -> Mesh {
    let (mut numbers, mut nodes) = (BTreeMap::new(), Vec::new());
    let mut number = |at: [usize; 3]| {
        *numbers.entry(at).or_insert_with(|| {
            nodes.push(place(std::array::from_fn(|axis| at[axis] as f64 / (2 * cells[axis]) as f64)));
            nodes.len() as u32 - 1
        })
    };
    let (mut elements, mut regions) = (Vec::new(), Vec::new());
    for cell in all_cells(cells) {
        let Some(material) = region(cell) else { continue };
        let corners: [[usize; 3]; 8] = std::array::from_fn(|n| {
            let [x, y] = SQUARE[n % 4];
            [2 * (cell[0] + x), 2 * (cell[1] + y), 2 * (cell[2] + n / 4)]
        });
        elements.push(with_middles(&corners, &CUBE_EDGES).map(&mut number));
        regions.push(material);
    }
    let mut chambers = Vec::new();
    for walls in chamber_walls(cells, half, &region) {
        let faces = walls.into_iter().map(|side| side.side_nodes().map(&mut number)).collect();
        chambers.push(Chamber { faces: Faces::QuadraticQuadrilaterals(faces) });
    }
    Mesh { nodes, elements: Elements::QuadraticHexahedra(elements), regions, chambers, symmetry_plane_z: half }
}

/// Corners of a square, counterclockwise.
const SQUARE: [[usize; 2]; 4] = [[0, 0], [1, 0], [1, 1], [0, 1]];

/// Corners on a grid of twice the cells, then the middles of their edges.
fn with_middles<const N: usize>(corners: &[[usize; 3]], edges: &[(usize, usize)]) -> [[usize; 3]; N] {
    let middle = |&(a, b): &(usize, usize)| std::array::from_fn(|axis| (corners[a][axis] + corners[b][axis]) / 2);
    let each: Vec<[usize; 3]> = corners.iter().copied().chain(edges.iter().map(middle)).collect();
    std::array::from_fn(|n| each[n])
}

fn all_cells(cells: [usize; 3]) -> impl Iterator<Item = [usize; 3]> {
    (0..cells[2]).flat_map(move |k| (0..cells[1]).flat_map(move |j| (0..cells[0]).map(move |i| [i, j, k])))
}

/// The axes along which a cell is cut as a mirror image: those along which it lies before the middle of the body.
fn mirrored_axes(cells: [usize; 3], half: bool, cell: [usize; 3]) -> [bool; 3] {
    std::array::from_fn(|axis| 2 * cell[axis] + 1 < cells[axis] && !(half && axis == 2))
}

/// The four corners on one path through a cell, ordered so that their volume is positive.
fn path_corners(cell: [usize; 3], (order, even): ([usize; 3], bool), mirror: [bool; 3]) -> [[usize; 3]; 4] {
    let mut corner: [usize; 3] = std::array::from_fn(|axis| cell[axis] + usize::from(mirror[axis]));
    let path: [[usize; 3]; 4] = std::array::from_fn(|step| {
        if let Some(&axis) = step.checked_sub(1).map(|last| &order[last]) {
            corner[axis] = if mirror[axis] { corner[axis] - 1 } else { corner[axis] + 1 };
        }
        corner
    });
    let even = mirror.iter().fold(even, |even, &mirrored| even != mirrored);
    if even { path } else { [path[0], path[2], path[1], path[3]] }
}

/// Sides between solid cells and enclosed air, one list per connected air space that does not reach the outside.
fn chamber_walls(cells: [usize; 3], half: bool, region: &impl Fn([usize; 3]) -> Option<u16>) -> Vec<Vec<Side>> {
    let mut visited = BTreeSet::new();
    let mut chambers = Vec::new();
    for start in all_cells(cells) {
        if region(start).is_some() || visited.contains(&start) {
            continue;
        }
        let (mut queue, mut sides, mut closed) = (vec![start], Vec::new(), true);
        visited.insert(start);
        while let Some(cell) = queue.pop() {
            for (axis, ahead) in (0..3).flat_map(|axis| [(axis, true), (axis, false)]) {
                match neighbour_cell(cells, cell, axis, ahead) {
                    None => closed &= half && axis == 2 && !ahead,
                    Some(next) if region(next).is_some() => sides.push(Side { cell, axis, ahead }),
                    Some(next) => {
                        if visited.insert(next) {
                            queue.push(next);
                        }
                    }
                }
            }
        }
        if closed {
            chambers.push(sides);
        }
    }
    chambers
}

fn neighbour_cell(cells: [usize; 3], cell: [usize; 3], axis: usize, ahead: bool) -> Option<[usize; 3]> {
    let mut next = cell;
    next[axis] = if ahead { cell[axis] + 1 } else { cell[axis].checked_sub(1)? };
    (next[axis] < cells[axis]).then_some(next)
}

/// A side of a cell: its axis, and whether it is the far one.
#[derive(Clone, Copy)]
struct Side {
    cell: [usize; 3],
    axis: usize,
    ahead: bool,
}

impl Side {
    /// The eight nodes of an air cell's side on the grid of twice the cells, normal into the air.
    fn side_nodes(self) -> [[usize; 3]; 8] {
        let (p, q) = ((self.axis + 1) % 3, (self.axis + 2) % 3);
        let corner = |[along_p, along_q]: [usize; 2]| {
            let mut node = self.cell.map(|index| 2 * index);
            node[self.axis] += if self.ahead { 2 } else { 0 };
            node[p] += 2 * along_p;
            node[q] += 2 * along_q;
            node
        };
        // counterclockwise about +axis, which points into the air from the near side
        let mut corners = SQUARE.map(corner);
        if self.ahead {
            corners.reverse();
        }
        with_middles(&corners, &QUADRILATERAL_SIDES)
    }
}

/// The two triangles of an air cell's side, split as its solid neighbour is, normals into the air.
fn side_triangles(
    Side { cell, axis, ahead }: Side,
    mirror: [bool; 3],
    numbers: &BTreeMap<[usize; 3], u32>,
) -> [[u32; 3]; 2] {
    let mut low = cell;
    low[axis] += usize::from(ahead);
    let (p, q) = ((axis + 1) % 3, (axis + 2) % 3);
    let corner = |along_p: bool, along_q: bool| {
        let mut node = low;
        node[p] += usize::from(along_p != mirror[p]);
        node[q] += usize::from(along_q != mirror[q]);
        numbers[&node]
    };
    let (o, a, b, c) = (corner(false, false), corner(true, false), corner(false, true), corner(true, true));
    // The normal of (o, a, c) points along +axis, or −axis when mirrored once; a far side needs −axis to point into the
    // air.
    if ahead != (mirror[p] != mirror[q]) { [[o, c, a], [o, b, c]] } else { [[o, a, c], [o, c, b]] }
}
