//! gmsh's `.msh`, version 4.1, as text or binary: sections of blocks, one block an entity of the geometry. Of version 2.2 the sections
//! of nodes and elements are lists.
//!
//! Triangles are kept with their physical groups, as named surfaces. The tag of a tetrahedron is the physical group of its volume (the lowest, if there are several); [`Groups`]
//! has what stands for it where there is none. The ten nodes of gmsh end with the middles of edges 23 and 13, those of this module with 13 and 23.

use super::gmsh_groups::Groups;
use super::raw_mesh::{MeshFileError, RawMesh, hexahedron_of_gmsh, other_solid, reorder_nodes};
use super::stream::{AGAIN, Form, Stream};
use super::tokens::{Tokens, shortened};
use si::Point3;
use std::collections::HashMap;

/// The places of this module's ten nodes in gmsh's list.
const PLACES: [usize; 10] = [0, 1, 2, 3, 4, 5, 6, 7, 9, 8];

/// Reads a `.msh` of version 4.1 or 2.2.
///
/// # Errors
/// [`MeshFileError`], with the line.
pub fn gmsh(bytes: &[u8]) -> Result<RawMesh, MeshFileError> {
    let mut file = File::open_file(bytes)?;
    let mut raw = RawMesh::default();
    while let Some(word) = file.from.tokens.next() {
        let section = String::from_utf8_lossy(word).into_owned();
        match section.as_str() {
            "$PhysicalNames" => file.read_names()?,
            "$Entities" => file.read_entities(false)?,
            "$PartitionedEntities" => file.read_entities(true)?,
            "$Nodes" if file.legacy => file.legacy_nodes(&mut raw)?,
            "$Elements" if file.legacy => file.legacy_elements(&mut raw)?,
            "$Nodes" => file.read_nodes(&mut raw)?,
            "$Elements" => file.read_elements(&mut raw)?,
            other if other.starts_with('$') => {
                file.from.tokens.skip_to(&format!("$End{}", &other[1..]));
                continue;
            }
            other => {
                return Err(file.from.tokens.error(
                    format!("`{}` is no section", shortened(other)),
                    "a section was expected",
                    AGAIN,
                ));
            }
        }
        file.from.end_section(&section[1..])?;
    }
    file.groups.name_tags(&mut raw);
    Ok(raw)
}

/// A file that is being read.
pub(super) struct File<'a> {
    pub(super) from: Stream<'a>,
    /// Whether its version is 2.2.
    legacy: bool,
    /// Place of each node, by its number.
    places: HashMap<u64, u32>,
    pub(super) groups: Groups,
}

impl<'a> File<'a> {
    fn open_file(bytes: &'a [u8]) -> Result<Self, MeshFileError> {
        let mut tokens = Tokens::new(bytes, "", None);
        if tokens.next() != Some(b"$MeshFormat") {
            let message = "the file does not begin with $MeshFormat";
            return Err(tokens.error(message, "files of gmsh do", AGAIN));
        }
        let version = tokens.next_word("the format's version")?;
        let legacy = version == "2.2";
        if version != "4.1" && !legacy {
            let message = format!("the file has version {}", shortened(version));
            return Err(tokens.error(message, "versions 4.1 and 2.2 are read", AGAIN));
        }
        let binary = tokens.next_number::<u32>("whether the file is binary")? == 1;
        let wide: u32 = tokens.next_number("the size of a number")?;
        if wide != 8 {
            return Err(tokens.error(format!("numbers have {wide} bytes"), "8 are read", AGAIN));
        }
        tokens.rest_of_line();
        let mut stream = Stream { tokens, form: Form::Text };
        if binary {
            stream.find_form()?;
        }
        stream.end_section("MeshFormat")?;
        Ok(Self { from: stream, legacy, places: HashMap::new(), groups: Groups::default() })
    }

    fn read_nodes(&mut self, raw: &mut RawMesh) -> Result<(), MeshFileError> {
        self.from.begin_section();
        let blocks = self.from.read_size("the number of blocks of nodes")?;
        for quantity in ["the number of nodes", "the least number of a node", "the greatest number of a node"] {
            self.from.read_size(quantity)?;
        }
        for _ in 0..blocks {
            let dimension = self.from.read_int("the dimension of a block")?;
            self.from.read_int("the entity of a block")?;
            let parameters = if self.from.read_int("whether nodes have parameters")? == 0 { 0 } else { dimension };
            let count = self.from.read_size("the number of nodes in a block")?;
            let mut labels = Vec::new();
            for _ in 0..count {
                labels.push(self.from.read_size("the number of a node")?);
            }
            for label in labels {
                let mut coordinates = [0.0; 3];
                for axis in &mut coordinates {
                    *axis = self.from.read_real("a coordinate of a node")?;
                }
                for _ in 0..parameters {
                    self.from.read_real("a parameter of a node")?;
                }
                self.add_node(raw, label, coordinates);
            }
        }
        Ok(())
    }

    pub(super) fn add_node(&mut self, raw: &mut RawMesh, label: u64, at: Point3) {
        self.places.insert(label, raw.nodes.len() as u32);
        raw.add_node(label, at);
    }

    /// The place of a node that an element names.
    pub(super) fn node_place(&self, element: u64, node: u64) -> Result<u32, MeshFileError> {
        self.places.get(&node).copied().ok_or_else(|| {
            let message = format!("element {element} names node {node}");
            self.from.tokens.error(message, "the file has no such node", AGAIN)
        })
    }

    /// A solid element, or the face of a surface; anything but solid elements is counted.
    pub(super) fn add_element(
        &self,
        raw: &mut RawMesh,
        dimension: i64,
        (label, nodes): (u64, &[u32]),
        tags: &[i64],
    ) -> Result<(), MeshFileError> {
        let lowest = tags.iter().min().copied().unwrap_or(0);
        let placed = match (dimension, nodes.len()) {
            (3, _) => {
                return self.with_place(raw.add_tetrahedron(
                    label,
                    &hexahedron_of_gmsh(&reorder_nodes(nodes, &PLACES)),
                    lowest,
                ));
            }
            (2, 3 | 4 | 6 | 8 | 9) => tags.iter().try_for_each(|tag| raw.add_surface_face(nodes, *tag)),
            _ => Ok(()),
        };
        raw.ignored += 1;
        self.with_place(placed)
    }

    fn with_place(&self, result: Result<(), MeshFileError>) -> Result<(), MeshFileError> {
        result.map_err(|fault| self.from.tokens.with_line(fault))
    }

    fn read_elements(&mut self, raw: &mut RawMesh) -> Result<(), MeshFileError> {
        self.from.begin_section();
        let blocks = self.from.read_size("the number of blocks of elements")?;
        for quantity in
            ["the number of elements", "the least number of an element", "the greatest number of an element"]
        {
            self.from.read_size(quantity)?;
        }
        for _ in 0..blocks {
            let dimension = self.from.read_int("the dimension of a block")?;
            let entity = self.from.read_int("the entity of a block")?;
            let kind = self.from.read_int("the type of a block's elements")?;
            let count = self.from.read_size("the number of elements in a block")?;
            let each = self.nodes_each(dimension, kind)?;
            let tags = self.groups.entity_tags((dimension as usize, entity));
            for _ in 0..count {
                self.read_element(raw, dimension, each, &tags)?;
            }
        }
        Ok(())
    }

    fn read_element(
        &mut self,
        raw: &mut RawMesh,
        dimension: i64,
        each: usize,
        tags: &[i64],
    ) -> Result<(), MeshFileError> {
        let label = self.from.read_size("the number of an element")?;
        let mut nodes = Vec::with_capacity(each);
        for _ in 0..each {
            let node = self.from.read_size("a node of an element")?;
            nodes.push(self.node_place(label, node)?);
        }
        self.add_element(raw, dimension, (label, &nodes), tags)
    }

    /// Nodes of an element of gmsh's type `kind`.
    pub(super) fn nodes_each(&self, dimension: i64, kind: i64) -> Result<usize, MeshFileError> {
        let count = match kind {
            15 => 1,
            1 => 2,
            8 | 2 => 3,
            3 | 4 | 26 => 4,
            27 => 5,
            9 | 28 => 6,
            5 | 16 => 8,
            10 => 9,
            11 | 21 => 10,
            17 => 20,
            12 => 27,
            _ => 0,
        };
        match (dimension, kind) {
            (3, 4 | 5 | 11 | 12 | 17) => Ok(count),
            (0..=2, _) if count > 0 => Ok(count),
            _ => Err(self.from.tokens.with_line(other_solid(&format!("elements of gmsh's type {kind}")))),
        }
    }
}
