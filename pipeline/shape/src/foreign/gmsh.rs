//! gmsh's `.msh`, version 4.1, as text or binary: sections of blocks, one block an entity of the geometry.
//!
//! The tag of a tetrahedron is the physical group of its volume (the lowest, if there are several), else the volume's
//! number. gmsh's ten nodes end with the middles of edges 23 and 13; the house has them the other way round.
//!
//! Stands on: `words`, `draft`. Never knows: a geometry.

use super::draft::{Draft, Malformed, other_solid, reordered};
use super::words::{Words, short};
use std::collections::HashMap;

/// Where the house's ten nodes stand in gmsh's list.
const PLACES: [usize; 10] = [0, 1, 2, 3, 4, 5, 6, 7, 9, 8];
const AGAIN: &str = "save the mesh again as version 4.1 (gmsh -format msh41 -save)";

/// Reads a `.msh` of version 4.1.
///
/// # Errors
/// [`Malformed`], with the line.
pub fn gmsh(bytes: &[u8]) -> Result<Draft, Malformed> {
    let mut file = File::open(bytes)?;
    let mut draft = Draft::default();
    while let Some(word) = file.words.next() {
        let section = String::from_utf8_lossy(word).into_owned();
        match section.as_str() {
            "$PhysicalNames" => file.names(&mut draft)?,
            "$Entities" => file.entities()?,
            "$Nodes" => file.nodes(&mut draft)?,
            "$Elements" => file.elements(&mut draft)?,
            other if other.starts_with('$') => {
                file.words.pass(&format!("$End{}", &other[1..]));
                continue;
            }
            other => return Err(file.words.refuse(format!("`{}` is no section", short(other)), "one was due", AGAIN)),
        }
        file.end(&section[1..])?;
    }
    Ok(draft)
}

/// How numbers are written.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Form {
    Text,
    Little,
    Big,
}

struct File<'a> {
    words: Words<'a>,
    form: Form,
    /// Place of each node, by its number.
    places: HashMap<u64, u32>,
    /// Physical group of each volume.
    groups: HashMap<i64, i64>,
}

impl<'a> File<'a> {
    fn open(bytes: &'a [u8]) -> Result<Self, Malformed> {
        let mut words = Words::new(bytes, "", None);
        if words.next() != Some(b"$MeshFormat") {
            let what = "the file does not begin with $MeshFormat";
            return Err(words.refuse(what, "files of gmsh do", AGAIN));
        }
        let version = words.word("the format's version")?;
        if version != "4.1" {
            let what = format!("the file has version {}", short(version));
            return Err(words.refuse(what, "version 4.1 is read", AGAIN));
        }
        let binary = words.number::<u32>("whether the file is binary")? == 1;
        let wide: u32 = words.number("the size of a number")?;
        if wide != 8 {
            return Err(words.refuse(format!("numbers have {wide} bytes"), "8 are read", AGAIN));
        }
        words.rest_of_line();
        let mut file = Self { words, form: Form::Text, places: HashMap::new(), groups: HashMap::new() };
        if binary {
            let one: [u8; 4] = file.words.take("the mark of the byte order")?;
            file.form = if i32::from_le_bytes(one) == 1 { Form::Little } else { Form::Big };
        }
        file.end("MeshFormat")?;
        Ok(file)
    }

    fn end(&mut self, section: &str) -> Result<(), Malformed> {
        let expected = format!("$End{section}");
        match self.words.next() {
            Some(word) if word == expected.as_bytes() => Ok(()),
            _ => Err(self.words.refuse(
                format!("the section {section} does not end where it should"),
                format!("{expected} was expected after the numbers that were announced"),
                AGAIN,
            )),
        }
    }

    /// A whole number of 4 bytes.
    fn int(&mut self, what: &str) -> Result<i64, Malformed> {
        match self.form {
            Form::Text => self.words.number(what),
            Form::Little => Ok(i32::from_le_bytes(self.words.take(what)?).into()),
            Form::Big => Ok(i32::from_be_bytes(self.words.take(what)?).into()),
        }
    }

    /// A count or a number of a node or element, of 8 bytes.
    fn size(&mut self, what: &str) -> Result<u64, Malformed> {
        match self.form {
            Form::Text => self.words.number(what),
            Form::Little => Ok(u64::from_le_bytes(self.words.take(what)?)),
            Form::Big => Ok(u64::from_be_bytes(self.words.take(what)?)),
        }
    }

    fn real(&mut self, what: &str) -> Result<f64, Malformed> {
        match self.form {
            Form::Text => self.words.number(what),
            Form::Little => Ok(f64::from_le_bytes(self.words.take(what)?)),
            Form::Big => Ok(f64::from_be_bytes(self.words.take(what)?)),
        }
    }

    /// Past the line of a section's name, where binary numbers begin.
    fn begin(&mut self) {
        if self.form != Form::Text {
            self.words.rest_of_line();
        }
    }

    /// Names of groups, which are text in binary files too.
    fn names(&mut self, draft: &mut Draft) -> Result<(), Malformed> {
        let count: u64 = self.words.number("the number of names")?;
        for _ in 0..count {
            let dimension: u32 = self.words.number("the dimension of a group")?;
            let tag: i64 = self.words.number("the number of a group")?;
            let line = String::from_utf8_lossy(self.words.rest_of_line()).into_owned();
            if dimension == 3 {
                draft.names.insert(tag, line.trim().trim_matches('"').to_owned());
            }
        }
        Ok(())
    }

    /// Entities of the geometry, of which only the groups of volumes are kept.
    fn entities(&mut self) -> Result<(), Malformed> {
        self.begin();
        let mut counts = [0; 4];
        for count in &mut counts {
            *count = self.size("the number of entities")?;
        }
        for (dimension, count) in counts.into_iter().enumerate() {
            for _ in 0..count {
                self.entity(dimension)?;
            }
        }
        Ok(())
    }

    fn entity(&mut self, dimension: usize) -> Result<(), Malformed> {
        let tag = self.int("the number of an entity")?;
        for _ in 0..if dimension == 0 { 3 } else { 6 } {
            self.real("the bounds of an entity")?;
        }
        let groups = self.size("the number of groups")?;
        for _ in 0..groups {
            let group = self.int("a group of an entity")?;
            if dimension == 3 {
                let kept = self.groups.entry(tag).or_insert(group);
                *kept = group.min(*kept);
            }
        }
        if dimension > 0 {
            for _ in 0..self.size("the number of bounding entities")? {
                self.int("a bounding entity")?;
            }
        }
        Ok(())
    }

    fn nodes(&mut self, draft: &mut Draft) -> Result<(), Malformed> {
        self.begin();
        let blocks = self.size("the number of blocks of nodes")?;
        for what in ["the number of nodes", "the least number of a node", "the greatest number of a node"] {
            self.size(what)?;
        }
        for _ in 0..blocks {
            let dimension = self.int("the dimension of a block")?;
            self.int("the entity of a block")?;
            let parameters = self.int("whether nodes have parameters")? * dimension;
            let count = self.size("the number of nodes in a block")?;
            let mut labels = Vec::new();
            for _ in 0..count {
                labels.push(self.size("the number of a node")?);
            }
            for label in labels {
                let mut at = [0.0; 3];
                for axis in &mut at {
                    *axis = self.real("a coordinate of a node")?;
                }
                for _ in 0..parameters {
                    self.real("a parameter of a node")?;
                }
                self.places.insert(label, draft.nodes.len() as u32);
                draft.node(label, at);
            }
        }
        Ok(())
    }

    fn elements(&mut self, draft: &mut Draft) -> Result<(), Malformed> {
        self.begin();
        let blocks = self.size("the number of blocks of elements")?;
        for what in ["the number of elements", "the least number of an element", "the greatest number of an element"] {
            self.size(what)?;
        }
        for _ in 0..blocks {
            let dimension = self.int("the dimension of a block")?;
            let entity = self.int("the entity of a block")?;
            let kind = self.int("the type of a block's elements")?;
            let count = self.size("the number of elements in a block")?;
            let each = self.nodes_each(dimension, kind)?;
            let tag = self.groups.get(&entity).copied().unwrap_or(entity);
            for _ in 0..count {
                self.element(draft, dimension == 3, each, tag)?;
            }
        }
        Ok(())
    }

    fn element(&mut self, draft: &mut Draft, solid: bool, each: usize, tag: i64) -> Result<(), Malformed> {
        let label = self.size("the number of an element")?;
        let mut nodes = Vec::with_capacity(each);
        for _ in 0..each {
            let node = self.size("a node of an element")?;
            nodes.push(self.places.get(&node).copied().ok_or_else(|| {
                let what = format!("element {label} names node {node}");
                self.words.refuse(what, "the file has no such node", AGAIN)
            })?);
        }
        if solid {
            let placed = draft.tetrahedron(label, &reordered(&nodes, &PLACES), tag);
            return placed.map_err(|fault| self.words.place(fault));
        }
        draft.passed_over += 1;
        Ok(())
    }

    /// Nodes of an element of gmsh's type `kind`.
    fn nodes_each(&self, dimension: i64, kind: i64) -> Result<usize, Malformed> {
        let count = match kind {
            15 => 1,
            1 => 2,
            8 | 2 => 3,
            3 | 4 | 26 => 4,
            27 => 5,
            9 | 28 => 6,
            16 => 8,
            10 => 9,
            11 | 21 => 10,
            _ => 0,
        };
        match (dimension, kind) {
            (3, 4 | 11) => Ok(count),
            (0..=2, _) if count > 0 => Ok(count),
            _ => Err(self.words.place(other_solid(&format!("elements of gmsh's type {kind}")))),
        }
    }
}
