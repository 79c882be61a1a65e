//! The thin wall of a closed bellows under pressure: the gain of its volume converges at the order of its elements.
//!
//! The wall lies between two smooth surfaces r(θ) = R (1 + a cos 4θ) about the z axis, one convolution from pole to pole, a tenth as thick as it is
//! wide. No edge and no clamp disturbs the solution: the energy that pressure stores, p ΔV / 2, then has the order 2k of elements of order k.

#![allow(clippy::unwrap_used)] // a test may fail where it stands

use fem::{Chamber, Clamps, Elements, Faces, Mesh, RegionProperties, StaticSettings, System, materials};
use std::collections::HashMap;
use std::f64::consts::FRAC_PI_4;

/// Mean radius of the inner surface, and thickness of the wall, m.
const RADIUS: f64 = 0.01;
const WALL: f64 = 0.001;
/// Depth of the convolution over the radius.
const DEPTH: f64 = 0.15;
const E: f64 = 2e5;
/// Swells it by a twentieth, Pa.
const PRESSURE: f64 = 400.0;

/// A place on the lattice: on the surface of a cube, and through the wall. Corners of cells have even numbers, middles of edges may have odd ones.
type Key = [usize; 4];

/// The shell of a cube of so many cells along an edge, and through the wall.
#[derive(Debug, Clone, Copy)]
struct Shell {
    along: usize,
    through: usize,
}

impl Shell {
    /// From the lattice to the bellows, m; equal angles along each edge of the cube.
    fn place(self, [i, j, k, layer]: Key) -> [f64; 3] {
        let tangent = |n: usize| (FRAC_PI_4 * (n as f64 / self.along as f64 - 1.0)).tan();
        let direction = [i, j, k].map(tangent);
        let length = direction.iter().map(|x| x * x).sum::<f64>().sqrt();
        let polar = (direction[2] / length).acos();
        let wall = WALL * layer as f64 / (2 * self.through) as f64;
        let radius = RADIUS * (1.0 + DEPTH * (4.0 * polar).cos()) + wall;
        direction.map(|x| radius * x / length)
    }

    /// Corners of all cells with z ≥ 0 in the order of VTK, the inner side first.
    fn cells(self) -> Vec<[Key; 8]> {
        let mut cells = Vec::new();
        for (axis, is_far) in (0..3).flat_map(|axis| [(axis, false), (axis, true)]) {
            let (first, second) =
                if is_far { ((axis + 1) % 3, (axis + 2) % 3) } else { ((axis + 2) % 3, (axis + 1) % 3) };
            for (p, q) in (0..self.along).flat_map(|p| (0..self.along).map(move |q| (p, q))) {
                let corner = |along: usize, across: usize, layer: usize| {
                    let mut key = [0, 0, 0, 2 * layer];
                    (key[axis], key[first], key[second]) =
                        (if is_far { 2 * self.along } else { 0 }, 2 * (p + along), 2 * (q + across));
                    key
                };
                let side = |layer: usize| [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(a, b)| corner(a, b, layer));
                let layers = (0..self.through).map(|layer| [side(layer), side(layer + 1)].concat());
                cells.extend(layers.map(|keys| <[Key; 8]>::try_from(keys).unwrap()));
            }
        }
        cells.retain(|cell| cell.iter().all(|key| key[2] >= self.along));
        cells
    }
}

/// Nodes of a mesh, numbered as they are named.
struct Numbering {
    shell: Shell,
    numbers: HashMap<Key, u32>,
    nodes: Vec<[f64; 3]>,
}

impl Numbering {
    fn node(&mut self, key: Key) -> u32 {
        *self.numbers.entry(key).or_insert_with(|| {
            self.nodes.push(self.shell.place(key));
            self.nodes.len() as u32 - 1
        })
    }

    /// The corners, then the middles of `edges` between them, which lie on the curved surfaces.
    fn element<const N: usize>(&mut self, corners: &[Key], edges: &[[usize; 2]]) -> [u32; N] {
        let middles = edges.iter().map(|&[a, b]| std::array::from_fn(|axis| (corners[a][axis] + corners[b][axis]) / 2));
        let keys: Vec<Key> = corners.iter().copied().chain(middles).collect();
        std::array::from_fn(|n| self.node(keys[n]))
    }
}

const CUBE_EDGES: [[usize; 2]; 12] =
    [[0, 1], [1, 2], [2, 3], [3, 0], [4, 5], [5, 6], [6, 7], [7, 4], [0, 4], [1, 5], [2, 6], [3, 7]];
const TETRAHEDRON_EDGES: [[usize; 2]; 6] = [[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]];
const CUBE_SIDES: [[usize; 4]; 6] =
    [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]];
const TETRAHEDRON_SIDES: [[usize; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];

/// Six tetrahedra of a cell: from its least corner to halves of the sides that do not hold it, each cut from its own least corner.
fn tetrahedra(cell: &[Key; 8]) -> Vec<[Key; 4]> {
    let apex = *cell.iter().min().unwrap();
    let sides = CUBE_SIDES.map(|side| side.map(|corner| cell[corner]));
    let opposite = sides.iter().filter(|side| !side.contains(&apex));
    opposite
        .flat_map(|side| {
            let least = (0..4).min_by_key(|corner| side[*corner]).unwrap();
            let turned = |n: usize| side[(least + n) % 4];
            // seen from the apex, an outward side is clockwise
            [[apex, turned(0), turned(1), turned(2)], [apex, turned(0), turned(2), turned(3)]]
        })
        .collect()
}

fn is_inner(side: &[Key]) -> bool {
    side.iter().all(|key| key[3] == 0)
}

/// Elements and the wall of the chamber.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Family {
    Linear,
    Quadratic,
    Hexahedra,
}

impl Family {
    fn mesh(self, shell: Shell) -> Mesh {
        let mut numbering = Numbering { shell, numbers: HashMap::new(), nodes: Vec::new() };
        let cells = shell.cells();
        let (elements, faces) = match self {
            Self::Hexahedra => {
                let elements = cells.iter().map(|cell| numbering.element(cell, &CUBE_EDGES)).collect();
                let sides = cells.iter().flat_map(|cell| CUBE_SIDES.map(|side| side.map(|corner| cell[corner])));
                let inner = sides.filter(|side| is_inner(side));
                let faces = inner.map(|side| numbering.element(&side, &CUBE_EDGES[..4])).collect();
                (Elements::QuadraticHexahedra(elements), Faces::QuadraticQuadrilaterals(faces))
            }
            Self::Linear | Self::Quadratic => {
                let tets: Vec<[Key; 4]> = cells.iter().flat_map(tetrahedra).collect();
                let sides = tets.iter().flat_map(|tet| TETRAHEDRON_SIDES.map(|side| side.map(|corner| tet[corner])));
                let inner: Vec<[Key; 3]> = sides.filter(|side| is_inner(side)).collect();
                if self == Self::Linear {
                    let elements = tets.iter().map(|tet| numbering.element(tet, &[])).collect();
                    let faces = inner.iter().map(|side| numbering.element(side, &[])).collect();
                    (Elements::Linear(elements), Faces::Linear(faces))
                } else {
                    let elements = tets.iter().map(|tet| numbering.element(tet, &TETRAHEDRON_EDGES)).collect();
                    let edges = [[0, 1], [1, 2], [2, 0]];
                    let faces = inner.iter().map(|side| numbering.element(side, &edges)).collect();
                    (Elements::Quadratic(elements), Faces::Quadratic(faces))
                }
            }
        };
        let regions = vec![0; elements.len()];
        Mesh { nodes: numbering.nodes, elements, regions, chambers: vec![Chamber { faces }], symmetry_plane_z: true }
    }

    /// The relative gain of the chamber's volume under [`PRESSURE`].
    fn gain(self, shell: Shell, nu: f64) -> f64 {
        let mesh = self.mesh(shell);
        let wall = RegionProperties::elastic(materials::by_name("neo_hookean").unwrap(), E, nu, 1070.0);
        let clamps = Clamps::where_nodes(&mesh, [true, false, false], |at| at[0].abs() < 1e-9)
            .and(&Clamps::where_nodes(&mesh, [false, true, false], |at| at[1].abs() < 1e-9));
        let system = System::new(mesh, vec![wall], clamps).unwrap();
        let found = system.solver().equilibrium(&[PRESSURE], None, &StaticSettings::default()).unwrap();
        let [rest, now] = [vec![0.0; found.displacement.len()], found.displacement]
            .map(|displacement| system.chamber_volume(0, &displacement));
        now / rest - 1.0
    }
}

#[test]
fn the_swelling_of_a_bellows_converges_at_the_order_of_its_elements() {
    let shell = |along: usize| Shell { along, through: along / 4 };
    for nu in [0.3, 0.49] {
        let [coarse, middle, fine] = [4, 8, 16].map(|along| Family::Hexahedra.gain(shell(along), nu));
        let order = ((middle - coarse) / (fine - middle)).log2();
        // 4.20 and 4.32
        assert!((3.9..4.6).contains(&order), "hexahedra at ν {nu}: {order}");
        let limit = fine + (fine - middle) / (order.exp2() - 1.0);
        let order_of = |family: Family, cells: [usize; 2]| {
            let [coarse, fine] = cells.map(|along| family.gain(shell(along), nu) / limit - 1.0);
            (coarse / fine).log2()
        };
        // Tetrahedra come from below: 3.2 and 2.8 here, 3.7 and 3.5 from 8 to 16 cells; of the first order 1.3 and 0.9 here, 1.7 and 1.3 from
        // 16 to 32 cells, where they still lock by 3 and 9 %.
        let [quadratic, linear] =
            [(Family::Quadratic, [4, 8]), (Family::Linear, [8, 16])].map(|(family, cells)| order_of(family, cells));
        assert!((2.7..4.6).contains(&quadratic) && (0.8..2.2).contains(&linear), "ν {nu}: {quadratic}, {linear}");
    }
}
