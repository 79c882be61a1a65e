//! Raw meshes of hexahedra of 8 or 20 nodes: the checks of tetrahedra, on the sides of a cube.
//!
//! Nodes are in the order of VTK: four corners of one side, counterclockwise as seen from the inside, then those of the opposite side; a
//! quadratic element then has the nodes between the ends of [`EDGES`], in their order.

use super::check::Region;
use super::defect::MeshDefect;
use super::hexahedral_chambers::{EDGES, HexahedralChamber, SIDES};
use super::raw_mesh::RawMesh;
use si::vec3::{add, cross, dot, norm, scale, sub};
use si::{CubicMetre, Metre, Point3};
use std::collections::HashMap;

/// Volume over the cube of the longest edge, of the flattest element allowed.
const FLATTEST: f64 = 1e-7;
/// Corners of the cube [0, 1]³.
const CORNERS: [[f64; 3]; 8] = [
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [1.0, 1.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [1.0, 0.0, 1.0],
    [1.0, 1.0, 1.0],
    [0.0, 1.0, 1.0],
];
/// Gauss's points on [0, 1], exact to degree 3 along each axis: for the volume of a trilinear element.
const GAUSS: [f64; 2] = [0.211_324_865_405_187_13, 0.788_675_134_594_812_9];

/// A mesh of hexahedra, checked.
#[derive(Debug, Clone, PartialEq)]
pub struct HexahedralMesh {
    /// m
    pub nodes: Vec<Point3>,
    /// Node numbers.
    pub hexahedra: Vec<[u32; 8]>,
    /// The nodes between the corners of each quadratic element; empty of the first order.
    pub middles: Vec<[u32; 12]>,
    /// The number of each element's region.
    pub numbers: Vec<u16>,
    /// Tags and names of the regions.
    pub regions: Vec<Region>,
    /// Whether it is the half z ≥ 0 of a symmetric body.
    pub half: bool,
    /// Corners of the sides that belong to one element alone, normals out of the solid; without those of chambers.
    pub skin: Vec<[u32; 4]>,
    /// Closed cavities.
    pub chambers: Vec<HexahedralChamber>,
    /// The sides of each chamber with the nodes between their corners; empty of the first order.
    pub walls: Vec<Vec<[u32; 8]>>,
    /// For each node of the file its number here; `u32::MAX` where no element uses it.
    pub numbering: Vec<u32>,
    /// What was repaired.
    pub notes: Vec<String>,
}

/// A side: its corners in rising order, the element, and which of its six sides.
type Side = ([u32; 4], u32, u8);

impl RawMesh {
    /// Checks a draft of hexahedra, as [`RawMesh::check`] does one of tetrahedra.
    ///
    /// # Errors
    /// [`MeshDefect`], which names the node, element, face or edge.
    pub fn check_hexahedra(mut self, unit: Metre, half: bool) -> Result<HexahedralMesh, MeshDefect> {
        if self.is_empty() || ![8, 20].contains(&self.each) {
            return Err(MeshDefect::Empty { ignored: self.ignored });
        }
        self.check_finite()?;
        self.check_repeated()?;
        let (note, numbering) = self.drop_unused();
        let size = self.scale_to_metres(unit)?;
        let mut notes: Vec<String> = note.into_iter().chain(self.turn_right()).collect();
        let volumes = self.hexahedron_volumes()?;
        self.check_duplicate_hexahedra()?;
        self.check_shared_middles(8, &EDGES)?;
        self.check_coincident_nodes(size)?;
        if half {
            self.move_to_symmetry_plane(size)?;
        }
        let skin = self.quadrilateral_skin(half)?;
        let on_plane = |face: &[u32; 4]| face.iter().all(|&node| self.nodes[node as usize][2] == 0.0);
        if half && !skin.iter().any(on_plane) {
            return Err(MeshDefect::NoSymmetryPlane);
        }
        let (regions, numbers) = self.number_regions(&volumes)?;
        let (skin, chambers) = self.divide_skin(skin.into_iter().filter(|face| !(half && on_plane(face))), half);
        let walls = self.chamber_walls(&chambers, &mut notes);
        let (hexahedra, middles) = self.split_elements();
        let nodes = self.nodes;
        Ok(HexahedralMesh {
            nodes,
            hexahedra,
            middles,
            numbers,
            regions,
            half,
            skin,
            chambers,
            walls,
            numbering,
            notes,
        })
    }

    /// The corners of each element, and the nodes between them where it is quadratic.
    fn split_elements(&self) -> (Vec<[u32; 8]>, Vec<[u32; 12]>) {
        let elements = (0..self.len()).map(|element| self.element(element));
        let corners = elements.clone().map(|nodes| std::array::from_fn(|corner| nodes[corner])).collect();
        let quadratic = elements.filter(|nodes| nodes.len() == 20);
        (corners, quadratic.map(|nodes| std::array::from_fn(|edge| nodes[8 + edge])).collect())
    }

    /// Turns all elements over when all are left-handed.
    fn turn_right(&mut self) -> Option<String> {
        if !(0..self.len()).all(|element| volume_and_least(&self.node_places(element)).0 < 0.0) {
            return None;
        }
        // length: an element has 8 nodes, or 20
        for nodes in self.corners.chunks_exact_mut(self.each) {
            let (corners, middles) = nodes.split_at_mut(8);
            let (lower, upper) = corners.split_at_mut(4);
            lower.swap_with_slice(upper);
            if let Some((lower, upright)) = middles.split_at_mut_checked(4) {
                lower.swap_with_slice(&mut upright[..4]);
            }
        }
        Some("the file's elements are left-handed; their nodes are reordered".to_owned())
    }

    fn hexahedron_volumes(&self) -> Result<Vec<CubicMetre>, MeshDefect> {
        let volume = |(index, &element): (usize, &u64)| {
            let places = self.node_places(index);
            let (volume, least) = volume_and_least(&places);
            let longest = EDGES.iter().map(|&[a, b]| norm(sub(places[b], places[a]))).fold(0.0, f64::max);
            let ratio = volume / longest.powi(3);
            if ratio.is_nan() || ratio.abs() < FLATTEST {
                return Err(MeshDefect::DegenerateElement { element, at: places[0], volume, ratio });
            }
            if least <= 0.0 { Err(MeshDefect::InvertedElement { element, volume, least }) } else { Ok(volume) }
        };
        self.labels.iter().enumerate().map(volume).collect()
    }

    fn check_duplicate_hexahedra(&self) -> Result<(), MeshDefect> {
        let mut labels_by_corners = HashMap::new();
        for (index, &second) in self.labels.iter().enumerate() {
            let mut corners: [u32; 8] = std::array::from_fn(|corner| self.element(index)[corner]);
            corners.sort_unstable();
            if let Some(first) = labels_by_corners.insert(corners, second) {
                return Err(MeshDefect::DuplicateElement { first, second });
            }
        }
        Ok(())
    }

    /// Free sides in the elements' order; each edge of them, but for those on the plane of a half model, joins two.
    fn quadrilateral_skin(&self, half: bool) -> Result<Vec<[u32; 4]>, MeshDefect> {
        let mut sides: Vec<Side> = Vec::with_capacity(6 * self.len());
        for element in 0..self.len() {
            for side in 0..SIDES.len() {
                let mut corners = self.side_corners(element, side);
                corners.sort_unstable();
                sides.push((corners, element as u32, side as u8));
            }
        }
        sides.sort_unstable();
        let mut free = Vec::new();
        for group in sides.chunk_by(|a, b| a.0 == b.0) {
            match group {
                [one] => free.push(*one),
                [one, other] if self.turns_forward(one) != self.turns_forward(other) => {}
                _ => return Err(self.crowded_side(group)),
            }
        }
        free.sort_unstable_by_key(|side| (side.1, side.2));
        let faces: Vec<[u32; 4]> = free.iter().map(|side| self.side_corners(side.1 as usize, side.2.into())).collect();
        self.check_closed(&faces, half).map(|()| faces)
    }

    fn side_corners(&self, element: usize, side: usize) -> [u32; 4] {
        let nodes = self.element(element);
        SIDES[side].map(|place| nodes[place])
    }

    /// Whether a side goes from its lowest corner to the lower one of the two beside it.
    fn turns_forward(&self, side: &Side) -> bool {
        let corners = self.side_corners(side.1 as usize, side.2.into());
        let lowest = (0..4).min_by_key(|&corner| corners[corner]).unwrap_or(0);
        corners[(lowest + 1) % 4] < corners[(lowest + 3) % 4]
    }

    fn crowded_side(&self, group: &[Side]) -> MeshDefect {
        let label = |side: &Side| self.labels[side.1 as usize];
        let face = std::array::from_fn(|corner| self.node_labels[group[0].0[corner] as usize]);
        MeshDefect::NonManifoldFace { face, count: group.len(), first: label(&group[0]), second: label(&group[1]) }
    }

    fn check_closed(&self, faces: &[[u32; 4]], half: bool) -> Result<(), MeshDefect> {
        let mut edges: Vec<[u32; 2]> = Vec::with_capacity(4 * faces.len());
        for face in faces {
            edges.extend((0..4).map(|k| [face[k].min(face[(k + 1) % 4]), face[k].max(face[(k + 1) % 4])]));
        }
        edges.sort_unstable();
        let on_plane = |edge: &[u32; 2]| half && edge.iter().all(|&node| self.nodes[node as usize][2] == 0.0);
        match edges.chunk_by(|a, b| a == b).find(|group| group.len() != 2 && !on_plane(&group[0])) {
            Some(group) => {
                let edge = group[0].map(|node| self.node_labels[node as usize]);
                Err(MeshDefect::NonManifoldEdge { edge, count: group.len() })
            }
            None => Ok(()),
        }
    }
}

/// Volume of a hexahedron, m³, and the least determinant at its corners and Gauss's points, m³.
fn volume_and_least(places: &[Point3]) -> (CubicMetre, f64) {
    let mut volume = 0.0;
    let mut least_determinant = f64::INFINITY;
    for x in GAUSS {
        for y in GAUSS {
            for z in GAUSS {
                let determinant = jacobian_determinant(places, [x, y, z]);
                volume += determinant / 8.0;
                least_determinant = least_determinant.min(determinant);
            }
        }
    }
    (volume, CORNERS.iter().map(|&at| jacobian_determinant(places, at)).fold(least_determinant, f64::min))
}

/// det ∂x/∂ξ at ξ of the cube [0, 1]³.
fn jacobian_determinant(places: &[Point3], point: Point3) -> f64 {
    let derivative_by = |axis: usize| {
        CORNERS.iter().zip(places).fold([0.0; 3], |sum, (corner, place)| {
            let linear_share = |k: usize| if corner[k] == 1.0 { point[k] } else { 1.0 - point[k] };
            let sign = 2.0 * corner[axis] - 1.0;
            let product: f64 = (0..3).filter(|&k| k != axis).map(linear_share).product();
            add(sum, scale(*place, sign * product))
        })
    };
    dot(cross(derivative_by(0), derivative_by(1)), derivative_by(2))
}
