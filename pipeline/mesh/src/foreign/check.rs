//! Checks of a raw mesh: the result is a mesh with a skin, or the first defect.

use super::boundary::{Face, find_skin};
use super::defect::MeshDefect;
use super::jacobian::volume_and_least;
use super::raw_mesh::RawMesh;
use super::surfaces::NamedSurface;
use crate::cavities::{Cavity, cavities};
use crate::columns::symmetry::is_symmetric;
use crate::quadratic::EDGES;
use crate::{QuadraticElements, QuadraticFace, QuadraticMesh, Skin, SkinFace, Solid, Surface, TetMesh};
use si::vec3::{norm, sub};
use si::{CubicMetre, Metre, Point3};
use std::collections::{BTreeSet, HashMap};

/// Volume over the cube of the longest edge, of the flattest element allowed.
const FLATTEST: f64 = 1e-7;
/// Nodes that agree when they are rounded to this part of the size lie at the same place.
const SAME: f64 = 1e-8;
const REGIONS: usize = 1000;

/// A region as the file has it.
#[derive(Debug, Clone, PartialEq)]
pub struct Region {
    /// The file's tag.
    pub tag: i64,
    /// The file's name for it.
    pub name: Option<String>,
    /// Its elements.
    pub elements: usize,
    /// Its volume at rest, m³.
    pub volume: CubicMetre,
}

/// A mesh of another program, checked.
#[derive(Debug, Clone, PartialEq)]
pub struct ForeignMesh {
    /// Nodes in metres, elements, regions 0.. in rising order of the file's tags, and the skin.
    pub solid: Solid,
    /// Tags and names of the regions in the file.
    pub regions: Vec<Region>,
    /// The surfaces that the file names or numbers.
    pub surfaces: Vec<NamedSurface>,
    /// The chambers, by the skin's numbers.
    pub cavities: Vec<Cavity>,
    /// For each node of the file its number here; `u32::MAX` where no element uses it.
    pub numbering: Vec<u32>,
    /// What was repaired, and what could be simplified.
    pub notes: Vec<String>,
}

impl RawMesh {
    /// Checks a draft whose coordinates are in `unit` (m); with `half`, it is the half z ≥ 0 of a body.
    ///
    /// # Errors
    /// [`MeshDefect`], which names the node, element, face or edge.
    pub fn check(mut self, unit: Metre, half: bool) -> Result<ForeignMesh, MeshDefect> {
        if self.is_empty() {
            return Err(MeshDefect::Empty { ignored: self.ignored });
        }
        if [8, 20].contains(&self.each) {
            return self.check_hexahedral_solid(unit, half);
        }
        self.check_finite()?;
        self.check_repeated()?;
        let (note, numbering) = self.drop_unused();
        let mut notes: Vec<String> = note.into_iter().collect();
        let size = self.scale_to_metres(unit)?;
        notes.extend(self.reorient_elements());
        let volumes = self.element_volumes()?;
        self.check_duplicates()?;
        self.check_shared_middles(4, &EDGES)?;
        self.check_coincident_nodes(size)?;
        if half {
            self.move_to_symmetry_plane(size)?;
        }
        let faces = find_skin(&self, half, size)?;
        if half && !faces.iter().any(|face| face.1 == Skin::Symmetry) {
            return Err(MeshDefect::NoSymmetryPlane);
        }
        let (regions, numbers) = self.number_regions(&volumes)?;
        notes.extend((!half && self.mirrors_itself(&faces, size)).then(|| MIRRORS.to_owned()));
        let surfaces = self.named_surfaces();
        let solid = self.build_solid(numbers, faces, half);
        Ok(ForeignMesh { cavities: cavities(&solid), solid, regions, surfaces, numbering, notes })
    }

    pub(super) fn check_finite(&self) -> Result<(), MeshDefect> {
        match self.nodes.iter().position(|at| at.iter().any(|x| !x.is_finite())) {
            Some(node) => Err(MeshDefect::NotFinite { node: self.node_labels[node], at: self.nodes[node] }),
            None => Ok(()),
        }
    }

    /// No element may name a node twice.
    pub(super) fn check_repeated(&self) -> Result<(), MeshDefect> {
        for (index, &element) in self.labels.iter().enumerate() {
            let nodes = self.element(index);
            if let Some(node) = (1..nodes.len()).find(|&place| nodes[..place].contains(&nodes[place])) {
                return Err(MeshDefect::RepeatedNode { element, node: self.node_labels[nodes[node] as usize] });
            }
        }
        Ok(())
    }

    /// The places of an element's nodes, m.
    pub(super) fn node_places(&self, element: usize) -> Vec<Point3> {
        self.element(element).iter().map(|&node| self.nodes[node as usize]).collect()
    }

    /// Volume of each element, m³.
    fn element_volumes(&self) -> Result<Vec<CubicMetre>, MeshDefect> {
        let mut volumes = Vec::with_capacity(self.len());
        for (index, &element) in self.labels.iter().enumerate() {
            let places = self.node_places(index);
            let (volume, least) = volume_and_least(&places);
            let longest = EDGES.iter().map(|&[a, b]| norm(sub(places[b], places[a]))).fold(0.0, f64::max);
            let ratio = volume / longest.powi(3);
            if ratio.is_nan() || ratio.abs() < FLATTEST {
                return Err(MeshDefect::DegenerateElement { element, at: places[0], volume, ratio });
            }
            if least <= 0.0 {
                return Err(MeshDefect::InvertedElement { element, volume, least });
            }
            volumes.push(volume);
        }
        Ok(volumes)
    }

    /// No two elements may have the same corners.
    fn check_duplicates(&self) -> Result<(), MeshDefect> {
        let mut labels_by_corners = HashMap::new();
        for (index, &second) in self.labels.iter().enumerate() {
            let mut corners: Vec<u32> = self.element(index)[..4].to_vec();
            corners.sort_unstable();
            if let Some(first) = labels_by_corners.insert(corners, second) {
                return Err(MeshDefect::DuplicateElement { first, second });
            }
        }
        Ok(())
    }

    /// Elements that share an edge must share its mid-edge node; these follow the corners, in the order of `edges`.
    pub(super) fn check_shared_middles(&self, corners: usize, edges: &[[usize; 2]]) -> Result<(), MeshDefect> {
        let mut middles = HashMap::new();
        let label = |node: u32| self.node_labels[node as usize];
        for nodes in self.corners.chunks_exact(self.each).filter(|nodes| nodes.len() > corners) {
            for (&[a, b], &middle) in edges.iter().zip(&nodes[corners..]) {
                let edge = [nodes[a].min(nodes[b]), nodes[a].max(nodes[b])];
                let first_middle = *middles.entry(edge).or_insert(middle);
                if first_middle != middle {
                    let (first, second) = (label(first_middle), label(middle));
                    return Err(MeshDefect::SplitEdge { edge: edge.map(label), first, second });
                }
            }
        }
        Ok(())
    }

    /// No two nodes may lie at the same place.
    pub(super) fn check_coincident_nodes(&self, size: Metre) -> Result<(), MeshDefect> {
        // Two nodes on either side of a cell's border are missed; the equal numbers that meshers write for unmerged
        // parts are not.
        let cell = |at: &Point3| at.map(|x| (x / (SAME * size)).round() as i64);
        let mut nodes_by_cell = HashMap::new();
        let pairs: Vec<[usize; 2]> = (0..self.nodes.len())
            .filter_map(|node| nodes_by_cell.insert(cell(&self.nodes[node]), node).map(|first| [first, node]))
            .collect();
        match pairs.iter().min() {
            Some(pair) => {
                let [first, second] = pair.map(|node| self.node_labels[node]);
                Err(MeshDefect::CoincidentNodes { first, second, count: pairs.len() })
            }
            None => Ok(()),
        }
    }

    /// The regions, and the number of each element's.
    pub(super) fn number_regions(&self, volumes: &[CubicMetre]) -> Result<(Vec<Region>, Vec<u16>), MeshDefect> {
        let tags: Vec<i64> = self.tags.iter().copied().collect::<BTreeSet<_>>().into_iter().collect();
        if tags.len() > REGIONS {
            return Err(MeshDefect::TooManyRegions { count: tags.len() });
        }
        let name = |tag: i64| self.names.get(&tag).cloned();
        let mut named = HashMap::new();
        for &tag in &tags {
            if let Some((first, name)) = name(tag).and_then(|name| Some((named.insert(name.clone(), tag)?, name))) {
                return Err(MeshDefect::RegionName { name, first, second: tag });
            }
        }
        let mut regions: Vec<Region> =
            tags.iter().map(|&tag| Region { tag, name: name(tag), elements: 0, volume: 0.0 }).collect();
        let mut numbers = Vec::with_capacity(self.len());
        for (tag, volume) in self.tags.iter().zip(volumes) {
            let number = tags.partition_point(|known| known < tag);
            regions[number].elements += 1;
            regions[number].volume += volume;
            numbers.push(number as u16);
        }
        Ok((regions, numbers))
    }

    /// Whether the solid is its own mirror image about z = 0.
    fn mirrors_itself(&self, faces: &[Face], size: Metre) -> bool {
        let mut surface = Surface::default();
        for nodes in faces.iter().map(|(nodes, _)| &nodes[..3]) {
            let first = surface.points.len() as u32;
            surface.points.extend(nodes.iter().map(|&node| self.nodes[node as usize]));
            surface.faces.push([first, first + 1, first + 2]);
        }
        is_symmetric(&surface, 1e-4 * size)
    }

    fn build_solid(&self, regions: Vec<u16>, faces: Vec<Face>, half: bool) -> Solid {
        let nodes = self.nodes.clone();
        let linear = |nodes: &[u32]| [0, 1, 2].map(|k| nodes[k]);
        if self.each == 4 {
            let skin = faces.into_iter().map(|(nodes, on)| SkinFace { nodes: linear(&nodes), on }).collect();
            let tets = self.corners.chunks_exact(4).map(|n| [n[0], n[1], n[2], n[3]]).collect();
            return Solid::Linear(TetMesh { nodes, tets, regions, skin, half });
        }
        let six = |nodes: &[u32]| std::array::from_fn(|k| nodes[k]);
        let skin = faces.into_iter().map(|(nodes, on)| QuadraticFace::triangle(six(&nodes), on)).collect();
        let tets = self.corners.chunks_exact(10).map(|n| std::array::from_fn(|k| n[k])).collect();
        let elements = QuadraticElements::Tetrahedra(tets);
        Solid::Quadratic(QuadraticMesh { nodes, elements, regions, skin, half })
    }
}

const MIRRORS: &str = "the mesh is symmetric about z = 0: if clamps and loads are symmetric too, a model of the half z ≥ 0 is sufficient (half = true)";
