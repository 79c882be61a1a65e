//! The command line of `study mesh`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use simulate::case::Unit;

/// Options of `study mesh`.
#[derive(Debug, Args)]
pub struct MeshSurfaces {
    /// The body's STL file, and those of inserts, which lie in it or touch it: regions 0, 1, 2, …
    #[arg(required = true, num_args = 1.., value_name = "BODY.stl [INSERT.stl]")]
    pub surfaces: Vec<PathBuf>,
    /// A cavity's STL file, where the body's own surface does not show it; once for each.
    #[arg(long, value_name = "CAVITY.stl")]
    pub cavity: Vec<PathBuf>,
    /// Length of edges, m, or with a unit: 0.004 or 4mm. Edges are shorter in thin walls and at small features.
    #[arg(long, value_name = "LENGTH", value_parser = parse_length)]
    pub edge: f64,
    /// Largest distance between the files' surfaces and the mesh, as --edge is written; 2 % of an edge when not given. With this option and the
    /// next two, auto is the general method.
    #[arg(long, value_name = "LENGTH", value_parser = parse_length)]
    pub envelope: Option<f64>,
    /// Shortest edges: smaller features are followed within the envelope only; a sixteenth of an edge when not given.
    #[arg(long, value_name = "LENGTH", value_parser = parse_length)]
    pub smallest: Option<f64>,
    /// Elements through a wall, where edges need not be shorter than the shortest; one, five times as wide as the wall is thick, when not given.
    #[arg(long, value_name = "NUMBER", value_parser = clap::value_parser!(u32).range(1..=8))]
    pub layers: Option<u32>,
    /// Unit of the numbers in the files: mm, cm, m or inch.
    #[arg(long, default_value = "mm", value_parser = parse_unit)]
    pub unit: Unit,
    /// How tetrahedra are made.
    #[arg(long, value_enum, default_value_t = MeshMethod::Auto)]
    pub method: MeshMethod,
    /// Where the mesh goes, in m: .msh (gmsh 2.2), .vtu or .mesh (MEDIT). Without it there is the report alone.
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Write the mesh's own surface: closed, consistent, within 2 % of an edge of the files.
    #[arg(long, value_name = "FILE.stl")]
    pub repair_to: Option<PathBuf>,
    /// Draw the mesh cut open, and its worst elements; of surfaces that are refused, their faces and the place.
    #[arg(long, value_name = "FILE.svg")]
    pub picture: Option<PathBuf>,
}

/// The methods of meshing on the command line.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum MeshMethod {
    /// In columns: a body that is a stack of layers, with a sheet or without.
    Columns,
    /// Any closed surfaces.
    General,
    /// In columns where they divide the body in elements of 5° and more, else by the general method.
    Auto,
}

impl From<MeshMethod> for mesh::Method {
    fn from(method: MeshMethod) -> Self {
        match method {
            MeshMethod::Columns => Self::Columns,
            MeshMethod::General => Self::General,
            MeshMethod::Auto => Self::Auto,
        }
    }
}

/// A length in m, or with its unit, from 1 µm to 1 m.
fn parse_length(text: &str) -> Result<f64, String> {
    let number = text.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    let unit = match &text[number.len()..] {
        "" => 1.0,
        word => parse_unit(word)?.metres(),
    };
    let length: f64 = number.trim().parse().map_err(|e| format!("`{text}` is not a length: {e}"))?;
    let within = (1e-6..=1.0).contains(&(length * unit));
    within
        .then_some(length * unit)
        .ok_or_else(|| format!("{text} is not between 1e-6 m and 1 m; mm are written as 4mm"))
}

fn parse_unit(word: &str) -> Result<Unit, String> {
    match word.to_ascii_lowercase().as_str() {
        "m" => Ok(Unit::M),
        "mm" => Ok(Unit::Mm),
        "cm" => Ok(Unit::Cm),
        "in" | "inch" => Ok(Unit::Inch),
        _ => Err(format!("`{word}` is none of the units mm, cm, m and inch")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_length_is_in_metres_or_has_a_unit() {
        assert_eq!(
            [parse_length("0.004"), parse_length("4mm"), parse_length("0.4 cm")],
            [Ok(0.004), Ok(0.004), Ok(0.004)]
        );
        for (text, said) in [("4", "4mm"), ("four", "none of the units"), ("mm", "not a length"), ("4ft", "none of")] {
            assert!(parse_length(text).is_err_and(|why| why.contains(said)), "{text}");
        }
    }
}
