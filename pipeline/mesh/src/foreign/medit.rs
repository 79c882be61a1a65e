//! MEDIT's `.mesh` as text: keywords, each with a count and its rows; the last number of a row is its reference.
//!
//! Ten-node tetrahedra (`TetrahedraP2`) as gmsh and libMeshb write them by default: middles of 01, 12, 02, 03, 13, 23.

use super::raw_mesh::{MeshFileError, RawMesh, other_solid};
use super::tokens::{Tokens, shortened};

const VERTICES: &str = "Vertices";
/// Solids of other shapes or orders, by their keyword in small letters.
const OTHERS: [&str; 6] = ["hexahedra", "hexaedra", "prisms", "pyramids", "hexahedraq2", "tetrahedrap3"];

/// Reads a text `.mesh`.
///
/// # Errors
/// [`MeshFileError`], with the line.
pub fn medit(bytes: &[u8]) -> Result<RawMesh, MeshFileError> {
    let mut tokens = Tokens::new(bytes, "", Some(b'#'));
    let mut raw = RawMesh::default();
    let first = tokens.next().unwrap_or_default();
    if !first.eq_ignore_ascii_case(b"MeshVersionFormatted") {
        let message = "the file does not begin with MeshVersionFormatted";
        return Err(tokens.error(
            message,
            "text files of MEDIT do; binary ones (.meshb) are not read",
            "save it as text",
        ));
    }
    tokens.next_number::<u32>("the format's version")?;
    while let Some(keyword) = tokens.next() {
        let keyword = String::from_utf8_lossy(keyword).to_lowercase();
        match keyword.as_str() {
            "end" => break,
            "dimension" => read_dimension(&mut tokens)?,
            "vertices" => read_vertices(&mut tokens, &mut raw)?,
            "tetrahedra" => read_tetrahedra::<4>(&mut tokens, &mut raw)?,
            "tetrahedrap2" => read_tetrahedra::<10>(&mut tokens, &mut raw)?,
            "triangles" => read_triangles::<3>(&mut tokens, &mut raw)?,
            "trianglesp2" => read_triangles::<6>(&mut tokens, &mut raw)?,
            solid if OTHERS.contains(&solid) && tokens.peek().is_some_and(|count| count != b"0") => {
                return Err(tokens.with_line(other_solid(solid)));
            }
            word if word.starts_with(|c: char| c.is_ascii_alphabetic()) => skip_numbers(&mut tokens, &mut raw, word),
            word => {
                let why = "a keyword of the format was expected, such as Vertices or Tetrahedra";
                return Err(tokens.error(format!("`{}` is no keyword", shortened(word)), why, "save the mesh again"));
            }
        }
    }
    Ok(raw)
}

fn read_dimension(tokens: &mut Tokens) -> Result<(), MeshFileError> {
    match tokens.next_number::<u32>("the dimension")? {
        3 => Ok(()),
        other => {
            let why = "a solid has 3 dimensions";
            Err(tokens.error(format!("the mesh has {other} dimensions"), why, "save a mesh of the solid"))
        }
    }
}

fn read_vertices(tokens: &mut Tokens, raw: &mut RawMesh) -> Result<(), MeshFileError> {
    let count: u64 = tokens.next_number("the number of vertices")?;
    for label in 1..=count {
        let mut axis = || tokens.next_number::<f64>(VERTICES);
        let coordinates = [axis()?, axis()?, axis()?];
        tokens.next_number::<i64>("the reference of a vertex")?;
        raw.add_node(label, coordinates);
    }
    Ok(())
}

fn read_tetrahedra<const N: usize>(tokens: &mut Tokens, raw: &mut RawMesh) -> Result<(), MeshFileError> {
    let count: u64 = tokens.next_number("the number of tetrahedra")?;
    for _ in 0..count {
        let mut nodes = [0; N];
        for node in &mut nodes {
            *node = counted_from_one(tokens)?;
        }
        let tag = tokens.next_number("the reference of a tetrahedron")?;
        let label = raw.len() as u64 + 1;
        raw.add_tetrahedron(label, &nodes, tag).map_err(|fault| tokens.with_line(fault))?;
    }
    Ok(())
}

fn read_triangles<const N: usize>(tokens: &mut Tokens, raw: &mut RawMesh) -> Result<(), MeshFileError> {
    let count: u64 = tokens.next_number("the number of triangles")?;
    for _ in 0..count {
        let mut nodes = [0; N];
        for node in &mut nodes {
            *node = counted_from_one(tokens)?;
        }
        let tag = tokens.next_number("the reference of a triangle")?;
        raw.add_surface_face(&nodes, tag).map_err(|fault| tokens.with_line(fault))?;
        raw.ignored = raw.ignored.saturating_add(1);
    }
    Ok(())
}

fn counted_from_one(tokens: &mut Tokens) -> Result<u32, MeshFileError> {
    let label: u32 = tokens.next_number("a node of an element")?;
    label
        .checked_sub(1)
        .ok_or_else(|| tokens.error("an element names node 0", "nodes are counted from 1", "save the mesh again"))
}

/// Skips the numbers after a keyword that does not concern solids.
fn skip_numbers(tokens: &mut Tokens, raw: &mut RawMesh, keyword: &str) {
    let is_number = |word: &[u8]| word.first().is_some_and(|c| c.is_ascii_digit() || b"+-.".contains(c));
    let mut count = 0;
    let mut first = true;
    while tokens.peek().is_some_and(is_number) {
        let word = tokens.next().unwrap_or_default();
        if std::mem::take(&mut first) {
            count = std::str::from_utf8(word).ok().and_then(|word| word.parse().ok()).unwrap_or(0);
        }
    }
    if ["edges", "edgesp2", "corners"].contains(&keyword) {
        raw.ignored = raw.ignored.saturating_add(count);
    }
}
