//! Bodies of equal cubes: their surface as an STL, and their tetrahedra as a mesh file.

use std::collections::BTreeMap;
use std::fmt::Write;

use mesh::Surface;

/// The reference of the end x = 0 in a mesh file.
pub const HELD: u32 = 5;

/// A body of cubes: which of them are solid, and of which material.
pub struct Voxels {
    /// Side of a cube, mm.
    pub side: f64,
    /// Number along x, y and z.
    pub count: [usize; 3],
    /// Tag of the material of a cube; none where it is empty.
    pub tag: fn([usize; 3]) -> Option<u32>,
}

/// A corner of cubes, in sides.
type Corner = [usize; 3];

/// The six tetrahedra of a cube around its diagonal, as the axes of its three steps from corner to corner: right-handed ones first.
const PATHS: [[usize; 3]; 6] = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]];

impl Voxels {
    fn cubes(&self) -> impl Iterator<Item = (Corner, u32)> + '_ {
        let [nx, ny, nz] = self.count;
        let all = (0..nx).flat_map(move |i| (0..ny).flat_map(move |j| (0..nz).map(move |k| [i, j, k])));
        all.filter_map(|at| Some((at, (self.tag)(at)?)))
    }

    /// A place in mm: the body begins at x = 0 and lies symmetric about the x axis.
    pub fn place(&self, at: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|k| self.side * (at[k] - if k == 0 { 0.0 } else { 0.5 * self.count[k] as f64 }))
    }

    fn corner(&self, at: Corner) -> [f64; 3] {
        self.place(at.map(|x| x as f64))
    }

    fn neighbour(&self, at: Corner, axis: usize, up: bool) -> Option<u32> {
        let mut next = at;
        next[axis] = if up { at[axis] + 1 } else { at[axis].checked_sub(1)? };
        (next[axis] < self.count[axis]).then(|| (self.tag)(next)).flatten()
    }

    /// The surface between cubes and air, in mm, normals outwards; its inner shells are the chambers.
    pub fn surface(&self) -> Surface {
        let (mut points, mut faces) = (Vec::new(), Vec::new());
        let mut numbers: BTreeMap<Corner, u32> = BTreeMap::new();
        for (at, _) in self.cubes() {
            for (axis, up) in (0..3).flat_map(|axis| [(axis, false), (axis, true)]) {
                if self.neighbour(at, axis, up).is_some() {
                    continue;
                }
                let (a, b) = ((axis + 1) % 3, (axis + 2) % 3);
                let corner = |s: usize, t: usize| {
                    let mut corner = at;
                    corner[axis] += usize::from(up);
                    corner[a] += s;
                    corner[b] += t;
                    corner
                };
                let mut ring = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
                if !up {
                    ring.reverse();
                }
                let ring = ring.map(|c| {
                    *numbers.entry(c).or_insert_with(|| {
                        points.push(self.corner(c));
                        points.len() as u32 - 1
                    })
                });
                faces.extend([[ring[0], ring[1], ring[2]], [ring[0], ring[2], ring[3]]]);
            }
        }
        Surface { points, faces }
    }

    /// The tetrahedra in the format of MEDIT, in mm; the triangles of the end x = 0 have the reference [`HELD`].
    pub fn medit(&self) -> String {
        let (mut points, mut tets) = (String::new(), String::new());
        let mut numbers: BTreeMap<Corner, usize> = BTreeMap::new();
        let mut count = 0;
        for (at, tag) in self.cubes() {
            for (number, path) in PATHS.into_iter().enumerate() {
                let mut here = at;
                let mut corners = vec![here];
                for axis in path {
                    here[axis] += 1;
                    corners.push(here);
                }
                if number >= PATHS.len() / 2 {
                    corners.swap(1, 2);
                }
                for corner in corners {
                    let next = numbers.len() + 1;
                    let number = *numbers.entry(corner).or_insert_with(|| {
                        let [x, y, z] = self.corner(corner);
                        writeln!(points, "{x} {y} {z} 0").unwrap();
                        next
                    });
                    write!(tets, "{number} ").unwrap();
                }
                writeln!(tets, "{tag}").unwrap();
                count += 1;
            }
        }
        let (mut ends, mut held) = (String::new(), 0);
        for (at, _) in self.cubes().filter(|(at, _)| at[0] == 0) {
            for axis in [1, 2] {
                let (mut side, far) = (at, [0, at[1] + 1, at[2] + 1]);
                side[axis] += 1;
                let corners = [at, side, far].map(|corner| numbers[&corner]);
                writeln!(ends, "{} {} {} {HELD}", corners[0], corners[1], corners[2]).unwrap();
                held += 1;
            }
        }
        let head = "MeshVersionFormatted 2\nDimension 3\n";
        format!("{head}Vertices\n{}\n{points}Triangles\n{held}\n{ends}Tetrahedra\n{count}\n{tets}End\n", numbers.len())
    }
}
