//! TetGen's `.node` and `.ele`: a line a node and a line a tetrahedron; the first attribute of a tetrahedron is its tag.
//!
//! Nodes are counted from whatever number the first of them has (0 or 1). With `-o2`, TetGen writes the middles of edges
//! 23, 03, 01, 12, 13, 02.

use super::raw_mesh::{MeshFileError, RawMesh, reorder_nodes};
use super::tokens::Tokens;

/// The places of this module's ten nodes in TetGen's list.
const PLACES: [usize; 10] = [0, 1, 2, 3, 6, 7, 9, 5, 8, 4];

/// How the place of an error in the file of the nodes begins, before the line.
pub(super) const NODES: &str = ".node file, ";

/// Reads the text of both files.
///
/// # Errors
/// [`MeshFileError`], with the file and the line.
pub fn tetgen(node: &[u8], ele: &[u8]) -> Result<RawMesh, MeshFileError> {
    let mut raw = RawMesh::default();
    let first = read_nodes(Tokens::new(node, NODES, Some(b'#')), &mut raw)?;
    read_elements(Tokens::new(ele, ".ele file, ", Some(b'#')), first, &mut raw)?;
    Ok(raw)
}

/// The nodes; returns the number of the first one.
fn read_nodes(mut tokens: Tokens, raw: &mut RawMesh) -> Result<u64, MeshFileError> {
    let count: u64 = tokens.next_number("the number of nodes")?;
    let dimension: u32 = tokens.next_number("the dimension")?;
    if dimension != 3 {
        let message = format!("the nodes have {dimension} coordinates");
        return Err(tokens.error(message, "a solid has 3 dimensions", "give the files of a solid"));
    }
    let attributes: usize = tokens.next_number("the number of attributes")?;
    let more = attributes.saturating_add(tokens.next_number("the number of marks")?);
    let mut first = 0;
    for row in 0..count {
        let label: u64 = tokens.next_number("the number of a node")?;
        first = if row == 0 { label } else { first };
        if label.checked_sub(first) != Some(row) {
            let message = format!("node {label} stands where node {} was expected", first.saturating_add(row));
            return Err(tokens.error(message, "nodes are counted on by one", "save the mesh again"));
        }
        let mut axis = || tokens.next_number::<f64>("a coordinate of a node");
        let coordinates = [axis()?, axis()?, axis()?];
        for _ in 0..more {
            tokens.next_word("an attribute of a node")?;
        }
        raw.add_node(label, coordinates);
    }
    Ok(first)
}

fn read_elements(mut tokens: Tokens, first: u64, raw: &mut RawMesh) -> Result<(), MeshFileError> {
    let count: u64 = tokens.next_number("the number of tetrahedra")?;
    let each: usize = tokens.next_number("the number of nodes a tetrahedron")?;
    let attributes: usize = tokens.next_number("the number of attributes")?;
    if each != 4 && each != 10 {
        let message = format!("tetrahedra have {each} nodes");
        return Err(tokens.error(message, "4 or 10 are read", "write the mesh with order 1 or 2"));
    }
    for _ in 0..count {
        let label: u64 = tokens.next_number("the number of a tetrahedron")?;
        let mut nodes = Vec::with_capacity(each);
        for _ in 0..each {
            nodes.push(read_node(&mut tokens, label, first)?);
        }
        let tag = read_tag(&mut tokens, attributes)?;
        raw.add_tetrahedron(label, &reorder_nodes(&nodes, &PLACES), tag).map_err(|fault| tokens.with_line(fault))?;
    }
    Ok(())
}

fn read_node(tokens: &mut Tokens, element: u64, first: u64) -> Result<u32, MeshFileError> {
    let label: u64 = tokens.next_number("a node of a tetrahedron")?;
    label.checked_sub(first).and_then(|place| u32::try_from(place).ok()).ok_or_else(|| {
        let message = format!("element {element} names node {label}");
        tokens.error(
            message,
            format!("the first node is {first}"),
            "give the .node file that was written with this .ele",
        )
    })
}

/// The first attribute of a row as a whole number.
fn read_tag(tokens: &mut Tokens, attributes: usize) -> Result<i64, MeshFileError> {
    let mut tag = 0;
    for place in 0..attributes {
        let value: f64 = tokens.next_number("an attribute of a tetrahedron")?;
        if place == 0 && (value.fract() != 0.0 || value.abs() > 1e15) {
            let why = "the first attribute is the region's number";
            return Err(tokens.error(format!("the attribute is {value}"), why, "number the regions"));
        }
        tag = if place == 0 { value as i64 } else { tag };
    }
    Ok(tag)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_region_is_the_first_attribute_and_the_others_may_be_fractions() {
        let of = |text: &str, attributes| read_tag(&mut Tokens::new(text.as_bytes(), "", None), attributes);
        assert_eq!((of("", 0).unwrap(), of("3", 1).unwrap(), of("3 7.5", 2).unwrap()), (0, 3, 3));
        for refused in ["2.5", "2e15", "-2e15"] {
            assert!(of(refused, 1).unwrap_err().to_string().contains("the attribute is"), "{refused}");
        }
    }
}
