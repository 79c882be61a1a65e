//! VTK's unstructured grid (`.vtu`): XML with points, cells and data of the cells.
//!
//! Tetrahedra are cell types 10, 24 and 71, Lagrange's of any order, of which orders 1 and 2 are read, hexahedra 12; tetrahedra of ten nodes
//! have the order of this module. The tag of a cell is the first of the arrays
//! in [`TAGS`] that the file has. Appended bytes are cut off before the rest is read as XML, which they need not be.

use super::arrays::{Codec, Tail};
use super::raw_mesh::{MeshFileError, RawMesh};
use super::vtk_cells::{TAGS, add_cell, whole_number};
use roxmltree::{Document, Node};

const AGAIN: &str = "save the mesh again";

/// Reads a `.vtu`: text, inline base64, appended raw or base64, whole or in zlib's blocks.
///
/// # Errors
/// [`MeshFileError`], with the line of the array.
pub fn vtu(bytes: &[u8]) -> Result<RawMesh, MeshFileError> {
    let (head, tail) = Tail::cut_off(bytes);
    let head = std::str::from_utf8(head)
        .map_err(|_| MeshFileError::new("the file is no text before its appended data", "XML is UTF-8", AGAIN))?;
    bounded_attributes(head)?;
    let closed = if tail.is_some() { format!("{head}</VTKFile>") } else { head.to_owned() };
    let document = Document::parse(&closed).map_err(|fault| {
        let line = format!("line {}: ", fault.pos().row);
        MeshFileError::new("the file is no XML", fault.to_string(), "save the mesh as .vtu")
            .at_place(line)
            .caused_by(fault)
    })?;
    let root = document.root_element();
    if root.attribute("type") != Some("UnstructuredGrid") {
        let message = format!("the file holds {}", root.attribute("type").unwrap_or("no VTK data"));
        return Err(MeshFileError::new(message, "a solid is an UnstructuredGrid", "save the mesh as .vtu"));
    }
    let codec = Codec::new(root, tail)?;
    let mut raw = RawMesh::default();
    for piece in root.descendants().filter(|node| node.has_tag_name("Piece")) {
        Piece { node: piece, codec: &codec }.read_piece(&mut raw)?;
    }
    Ok(raw)
}

/// Limit of the attributes of one element; VTK writes about ten. The XML parser compares each with all others.
const MAX_ATTRIBUTES: usize = 256;

/// Refuses an element with so many attributes that they would be parsed in quadratic time.
fn bounded_attributes(text: &str) -> Result<(), MeshFileError> {
    let mut line = 1;
    for tag in text.split('<') {
        let count = tag.split('>').next().unwrap_or_default().bytes().filter(|byte| *byte == b'=').count();
        if count > MAX_ATTRIBUTES {
            let message = format!("an element has {count} attributes");
            return Err(MeshFileError::new(message, format!("the limit is {MAX_ATTRIBUTES}"), AGAIN)
                .at_place(format!("line {line}: ")));
        }
        line += tag.bytes().filter(|byte| *byte == b'\n').count();
    }
    Ok(())
}

/// One piece of a file.
struct Piece<'a, 'b> {
    node: Node<'a, 'a>,
    codec: &'b Codec<'b>,
}

impl Piece<'_, '_> {
    fn read_piece(&self, raw: &mut RawMesh) -> Result<(), MeshFileError> {
        let first = raw.nodes.len();
        for point in self.named_array("Points", |_| true, "the points")?.chunks_exact(3) {
            raw.add_node(raw.nodes.len() as u64, [point[0], point[1], point[2]]);
        }
        let named = |name: &'static str| move |is: &str| is == name;
        let nodes = self.named_array("Cells", named("connectivity"), "connectivity")?;
        let ends = self.named_array("Cells", named("offsets"), "offsets")?;
        let types = self.named_array("Cells", named("types"), "types")?;
        let tags = self.read_tags()?;
        if types.len() != ends.len() || tags.as_ref().is_some_and(|tags| tags.len() != ends.len()) {
            let message =
                format!("there are {} cells, {} types and {:?} tags", ends.len(), types.len(), tags.map(|t| t.len()));
            return Err(self.error(message, "each cell has one of each"));
        }
        let mut begin = 0;
        for (cell, (&end, &kind)) in ends.iter().zip(&types).enumerate() {
            let list = whole_number(end).and_then(|end| nodes.get(begin..end).map(|list| (end, list)));
            let (end, list) =
                list.ok_or_else(|| self.error(format!("cell {cell} ends at {end}"), "no node is there"))?;
            begin = end;
            let tag = tags.as_ref().map_or(0, |tags| tags[cell] as i64);
            add_cell(raw, first, (kind, list), tag).map_err(|fault| fault.at_place(self.line_of(self.node)))?;
        }
        Ok(())
    }

    /// The values of the first array below `part` whose name is chosen.
    fn named_array(
        &self,
        part: &str,
        chosen: impl Fn(&str) -> bool,
        quantity: &str,
    ) -> Result<Vec<f64>, MeshFileError> {
        let candidate = self.data_arrays(part).find(|array| chosen(array.attribute("Name").unwrap_or_default()));
        let array =
            candidate.ok_or_else(|| self.error(format!("{part} has no array for {quantity}"), "a mesh needs it"))?;
        self.array_values(array)
    }

    fn read_tags(&self) -> Result<Option<Vec<f64>>, MeshFileError> {
        let is = |array: &Node, name: &str| {
            array.attribute("Name").is_some_and(|attribute| attribute.to_lowercase() == name)
        };
        let candidate = TAGS.iter().find_map(|name| self.data_arrays("CellData").find(|array| is(array, name)));
        let Some(array) = candidate else { return Ok(None) };
        let tags = self.array_values(array)?;
        match tags.iter().find(|tag| tag.fract() != 0.0 || tag.abs() > 1e15) {
            Some(tag) => {
                let fault =
                    MeshFileError::new(format!("a tag is {tag}"), "tags are whole numbers", "number the regions");
                Err(fault.at_place(self.line_of(array)))
            }
            None => Ok(Some(tags)),
        }
    }

    fn data_arrays(&self, part: &str) -> impl Iterator<Item = Node<'_, '_>> {
        let part = self.node.children().find(|node| node.has_tag_name(part));
        part.into_iter().flat_map(|part| part.children()).filter(|node| node.has_tag_name("DataArray"))
    }

    fn array_values(&self, array: Node) -> Result<Vec<f64>, MeshFileError> {
        self.codec.array_values(array).map_err(|fault| fault.at_place(self.line_of(array)))
    }

    fn line_of(&self, node: Node) -> String {
        format!("line {}: ", node.document().text_pos_at(node.range().start).row)
    }

    fn error(&self, what: impl Into<String>, why: &str) -> MeshFileError {
        MeshFileError::new(what, why, AGAIN).at_place(self.line_of(self.node))
    }
}
