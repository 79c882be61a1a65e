//! MEDIT's `.mesh` as text: keywords, each with a count and its rows; the last number of a row is its reference.
//!
//! Ten-node tetrahedra (`TetrahedraP2`) as gmsh and libMeshb write them by default: middles of 01, 12, 02, 03, 13, 23.
//!
//! Stands on: `words`, `draft`. Never knows: what a reference means.

use super::draft::{Draft, Malformed, other_solid};
use super::words::{Words, short};

const VERTICES: &str = "Vertices";
/// Solids of other shapes or orders, by their keyword in small letters.
const OTHERS: [&str; 6] = ["hexahedra", "hexaedra", "prisms", "pyramids", "hexahedraq2", "tetrahedrap3"];

/// Reads a text `.mesh`.
///
/// # Errors
/// [`Malformed`], with the line.
pub fn medit(bytes: &[u8]) -> Result<Draft, Malformed> {
    let mut words = Words::new(bytes, "", Some(b'#'));
    let mut draft = Draft::default();
    let first = words.next().unwrap_or_default();
    if !first.eq_ignore_ascii_case(b"MeshVersionFormatted") {
        let what = "the file does not begin with MeshVersionFormatted";
        return Err(words.refuse(what, "text files of MEDIT do; binary ones (.meshb) are not read", "save it as text"));
    }
    words.number::<u32>("the format's version")?;
    while let Some(keyword) = words.next() {
        let keyword = String::from_utf8_lossy(keyword).to_lowercase();
        match keyword.as_str() {
            "end" => break,
            "dimension" => dimension(&mut words)?,
            "vertices" => vertices(&mut words, &mut draft)?,
            "tetrahedra" => tetrahedra::<4>(&mut words, &mut draft)?,
            "tetrahedrap2" => tetrahedra::<10>(&mut words, &mut draft)?,
            solid if OTHERS.contains(&solid) && words.peek().is_some_and(|count| count != b"0") => {
                return Err(words.place(other_solid(solid)));
            }
            word if word.starts_with(|c: char| c.is_ascii_alphabetic()) => pass_over(&mut words, &mut draft, word),
            word => {
                let why = "a keyword of the format was expected, such as Vertices or Tetrahedra";
                return Err(words.refuse(format!("`{}` is no keyword", short(word)), why, "save the mesh again"));
            }
        }
    }
    Ok(draft)
}

fn dimension(words: &mut Words) -> Result<(), Malformed> {
    match words.number::<u32>("the dimension")? {
        3 => Ok(()),
        other => {
            let why = "a solid has 3 dimensions";
            Err(words.refuse(format!("the mesh has {other} dimensions"), why, "save a mesh of the solid"))
        }
    }
}

fn vertices(words: &mut Words, draft: &mut Draft) -> Result<(), Malformed> {
    let count: u64 = words.number("the number of vertices")?;
    for label in 1..=count {
        let mut axis = || words.number::<f64>(VERTICES);
        let at = [axis()?, axis()?, axis()?];
        words.number::<i64>("the reference of a vertex")?;
        draft.node(label, at);
    }
    Ok(())
}

fn tetrahedra<const N: usize>(words: &mut Words, draft: &mut Draft) -> Result<(), Malformed> {
    let count: u64 = words.number("the number of tetrahedra")?;
    for _ in 0..count {
        let mut nodes = [0; N];
        for node in &mut nodes {
            *node = counted_from_one(words)?;
        }
        let tag = words.number("the reference of a tetrahedron")?;
        let label = draft.len() as u64 + 1;
        draft.tetrahedron(label, &nodes, tag).map_err(|fault| words.place(fault))?;
    }
    Ok(())
}

fn counted_from_one(words: &mut Words) -> Result<u32, Malformed> {
    let label: u32 = words.number("a node of a tetrahedron")?;
    label
        .checked_sub(1)
        .ok_or_else(|| words.refuse("a tetrahedron names node 0", "nodes are counted from 1", "save the mesh again"))
}

/// Passes the numbers behind a keyword that says nothing of solids.
fn pass_over(words: &mut Words, draft: &mut Draft, keyword: &str) {
    let is_number = |word: &[u8]| word.first().is_some_and(|c| c.is_ascii_digit() || b"+-.".contains(c));
    let mut count = 0;
    let mut first = true;
    while words.peek().is_some_and(is_number) {
        let word = words.next().unwrap_or_default();
        if std::mem::take(&mut first) {
            count = std::str::from_utf8(word).ok().and_then(|word| word.parse().ok()).unwrap_or(0);
        }
    }
    if ["edges", "edgesp2", "triangles", "trianglesp2", "corners"].contains(&keyword) {
        draft.passed_over = draft.passed_over.saturating_add(count);
    }
}
