//! VTK's unstructured grid (`.vtu`): XML with points, cells and data of the cells.
//!
//! Tetrahedra are cell types 10 and 24; type 24 has the house's order of nodes. The tag of a cell is the first of the arrays
//! in [`TAGS`] that the file has. Appended bytes are cut off before the rest is read as XML, which they need not be.
//!
//! Stands on: `arrays`, `draft`, roxmltree. Never knows: a field that is not a tag.

use super::arrays::{Codec, Tail};
use super::draft::{Draft, Malformed, other_solid};
use roxmltree::{Document, Node};

/// Names of arrays that say where a cell belongs, in small letters, the most telling first.
const TAGS: [&str; 9] = [
    "region",
    "regions",
    "gmsh:physical",
    "cellentityids",
    "medit:ref",
    "tetgen:ref",
    "cell_tags",
    "material",
    "gmsh:geometrical",
];
const AGAIN: &str = "save the mesh again";

/// Reads a `.vtu`: text, inline base64, appended raw or base64, whole or in zlib's blocks.
///
/// # Errors
/// [`Malformed`], with the line of the array.
pub fn vtu(bytes: &[u8]) -> Result<Draft, Malformed> {
    let (head, tail) = Tail::cut_off(bytes);
    let head = std::str::from_utf8(head)
        .map_err(|_| Malformed::new("the file is no text before its appended data", "XML is UTF-8", AGAIN))?;
    let closed = if tail.is_some() { format!("{head}</VTKFile>") } else { head.to_owned() };
    let document = Document::parse(&closed).map_err(|fault| {
        let place = format!("line {}: ", fault.pos().row);
        Malformed::new("the file is no XML", fault.to_string(), "save the mesh as .vtu").at(place)
    })?;
    let root = document.root_element();
    if root.attribute("type") != Some("UnstructuredGrid") {
        let what = format!("the file holds {}", root.attribute("type").unwrap_or("no VTK data"));
        return Err(Malformed::new(what, "a solid is an UnstructuredGrid", "save the mesh as .vtu"));
    }
    let codec = Codec::new(root, tail)?;
    let mut draft = Draft::default();
    for piece in root.descendants().filter(|node| node.has_tag_name("Piece")) {
        Piece { node: piece, codec: &codec }.read(&mut draft)?;
    }
    Ok(draft)
}

/// One piece of a file.
struct Piece<'a, 'b> {
    node: Node<'a, 'a>,
    codec: &'b Codec<'b>,
}

impl Piece<'_, '_> {
    fn read(&self, draft: &mut Draft) -> Result<(), Malformed> {
        let first = draft.nodes.len();
        for at in self.array("Points", |_| true, "the points")?.chunks_exact(3) {
            draft.node(draft.nodes.len() as u64, [at[0], at[1], at[2]]);
        }
        let named = |name: &'static str| move |is: &str| is == name;
        let nodes = self.array("Cells", named("connectivity"), "connectivity")?;
        let ends = self.array("Cells", named("offsets"), "offsets")?;
        let types = self.array("Cells", named("types"), "types")?;
        let tags = self.tags()?;
        if types.len() != ends.len() || tags.as_ref().is_some_and(|tags| tags.len() != ends.len()) {
            let what =
                format!("there are {} cells, {} types and {:?} tags", ends.len(), types.len(), tags.map(|t| t.len()));
            return Err(self.refuse(what, "each cell has one of each"));
        }
        let mut begin = 0;
        for (cell, (&end, &kind)) in ends.iter().zip(&types).enumerate() {
            let list = self.whole(end).and_then(|end| nodes.get(begin..end).map(|list| (end, list)));
            let (end, list) =
                list.ok_or_else(|| self.refuse(format!("cell {cell} ends at {end}"), "no node is there"))?;
            begin = end;
            let tag = tags.as_ref().map_or(0, |tags| tags[cell] as i64);
            self.cell(draft, kind as u8, first, list, tag)?;
        }
        Ok(())
    }

    fn cell(&self, draft: &mut Draft, kind: u8, first: usize, list: &[f64], tag: i64) -> Result<(), Malformed> {
        let label = (draft.len() + draft.passed_over) as u64;
        match (kind, list.len()) {
            (10, 4) | (24, 10) => {
                let nodes: Option<Vec<u32>> =
                    list.iter().map(|&node| u32::try_from(self.whole(node)? + first).ok()).collect();
                let nodes =
                    nodes.ok_or_else(|| self.refuse(format!("cell {label} names a broken node"), "it is no count"))?;
                draft.tetrahedron(label, &nodes, tag).map_err(|fault| fault.at(self.place(self.node)))
            }
            // points, lines and faces of VTK, linear and quadratic
            (1..=9 | 21..=23 | 28 | 30 | 34 | 36, _) => {
                draft.passed_over += 1;
                Ok(())
            }
            _ => {
                Err(other_solid(&format!("cells of VTK's type {kind} with {} nodes", list.len()))
                    .at(self.place(self.node)))
            }
        }
    }

    fn whole(&self, value: f64) -> Option<usize> {
        (value >= 0.0 && value.fract() == 0.0 && value < 4e9).then_some(value as usize)
    }

    /// The values of the first array below `part` whose name is chosen.
    fn array(&self, part: &str, chosen: impl Fn(&str) -> bool, what: &str) -> Result<Vec<f64>, Malformed> {
        let found = self.arrays(part).find(|array| chosen(array.attribute("Name").unwrap_or_default()));
        let array = found.ok_or_else(|| self.refuse(format!("{part} has no array for {what}"), "a mesh needs it"))?;
        self.values(array)
    }

    fn tags(&self) -> Result<Option<Vec<f64>>, Malformed> {
        let is = |array: &Node, name: &str| array.attribute("Name").is_some_and(|own| own.to_lowercase() == name);
        let found = TAGS.iter().find_map(|name| self.arrays("CellData").find(|array| is(array, name)));
        let Some(array) = found else { return Ok(None) };
        let tags = self.values(array)?;
        match tags.iter().find(|tag| tag.fract() != 0.0 || tag.abs() > 1e15) {
            Some(tag) => {
                let fault = Malformed::new(format!("a tag is {tag}"), "tags are whole numbers", "number the regions");
                Err(fault.at(self.place(array)))
            }
            None => Ok(Some(tags)),
        }
    }

    fn arrays(&self, part: &str) -> impl Iterator<Item = Node<'_, '_>> {
        let part = self.node.children().find(|node| node.has_tag_name(part));
        part.into_iter().flat_map(|part| part.children()).filter(|node| node.has_tag_name("DataArray"))
    }

    fn values(&self, array: Node) -> Result<Vec<f64>, Malformed> {
        self.codec.values(array).map_err(|fault| fault.at(self.place(array)))
    }

    fn place(&self, node: Node) -> String {
        format!("line {}: ", node.document().text_pos_at(node.range().start).row)
    }

    fn refuse(&self, what: impl Into<String>, why: &str) -> Malformed {
        Malformed::new(what, why, AGAIN).at(self.place(self.node))
    }
}
