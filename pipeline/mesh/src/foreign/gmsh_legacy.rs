//! gmsh's `.msh` of version 2.2, as text or binary: a list of nodes and a list of elements with their tags.
//!
//! The first tag of an element is its physical group, 0 for none, the second its entity of the geometry.

use super::gmsh::File;
use super::gmsh_groups::Groups;
use super::raw_mesh::{MeshFileError, RawMesh};
use super::stream::Form;

/// Dimension of each of gmsh's types of elements; solids that are no tetrahedra have three as well.
fn element_dimension(kind: i64) -> i64 {
    match kind {
        15 => 0,
        1 | 8 | 26..=28 => 1,
        2 | 3 | 9 | 10 | 16 | 20..=25 => 2,
        _ => 3,
    }
}

impl File<'_> {
    pub(super) fn legacy_nodes(&mut self, raw: &mut RawMesh) -> Result<(), MeshFileError> {
        let count: u64 = self.from.tokens.next_number("the number of nodes")?;
        self.from.begin_section();
        for _ in 0..count {
            let label = self.from.read_int("the number of a node")? as u64;
            let mut coordinates = [0.0; 3];
            for axis in &mut coordinates {
                *axis = self.from.read_real("a coordinate of a node")?;
            }
            self.add_node(raw, label, coordinates);
        }
        Ok(())
    }

    pub(super) fn legacy_elements(&mut self, raw: &mut RawMesh) -> Result<(), MeshFileError> {
        let count: u64 = self.from.tokens.next_number("the number of elements")?;
        self.from.begin_section();
        let mut done = 0;
        while done < count {
            done += match self.from.form {
                Form::Text => self.legacy_element(raw)?,
                Form::Little | Form::Big => self.legacy_block(raw)?,
            };
        }
        Ok(())
    }

    /// An element of a text file; returns how many it is.
    fn legacy_element(&mut self, raw: &mut RawMesh) -> Result<u64, MeshFileError> {
        let label = self.from.read_int("the number of an element")?;
        let kind = self.from.read_int("the type of an element")?;
        let tags = self.from.read_int("the number of an element's tags")?;
        let tag = self.read_tag(tags)?;
        self.legacy_corners(raw, (label as u64, kind), tag)?;
        Ok(1)
    }

    /// A block of elements of one type of a binary file; returns how many they are.
    fn legacy_block(&mut self, raw: &mut RawMesh) -> Result<u64, MeshFileError> {
        let kind = self.from.read_int("the type of a block's elements")?;
        let count = self.from.read_int("the number of elements in a block")?.max(1) as u64;
        let tags = self.from.read_int("the number of an element's tags")?;
        for _ in 0..count {
            let label = self.from.read_int("the number of an element")? as u64;
            let tag = self.read_tag(tags)?;
            self.legacy_corners(raw, (label, kind), tag)?;
        }
        Ok(count)
    }

    fn read_tag(&mut self, count: i64) -> Result<i64, MeshFileError> {
        let (mut group, mut entity) = (0, 0);
        for k in 0..count {
            let tag = self.from.read_int("a tag of an element")?;
            match k {
                0 => group = tag,
                1 => entity = tag,
                _ => {}
            }
        }
        Ok(Groups::legacy_tag(group, entity))
    }

    fn legacy_corners(&mut self, raw: &mut RawMesh, (label, kind): (u64, i64), tag: i64) -> Result<(), MeshFileError> {
        let dimension = element_dimension(kind);
        let each = self.nodes_each(dimension, kind)?;
        let mut nodes = Vec::with_capacity(each);
        for _ in 0..each {
            let node = self.from.read_int("a node of an element")? as u64;
            nodes.push(self.node_place(label, node)?);
        }
        self.add_element(raw, dimension, (label, &nodes), &[tag])
    }
}
