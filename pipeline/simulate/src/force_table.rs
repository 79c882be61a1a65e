//! Nodal forces from a CSV table: one line a node, which is named by its number or by a point near it.

use std::path::Path;

use csv::StringRecord;
use diagnostics::{Diagnostic, Result, input};
use si::Point3;

/// A node of the mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum NodeOf {
    /// By its number in the mesh, from 0, as in the written frames.
    Number(usize),
    /// The nearest to a point, m.
    Near(Point3),
}

/// Nodes, the forces on them (N) and the lines on which they stand.
pub type ForceTable = Vec<(usize, NodeOf, Point3)>;

/// The titles of the forces.
const FORCES: [&str; 3] = ["fx_n", "fy_n", "fz_n"];
/// The titles of a point.
const POINT: [&str; 3] = ["x_m", "y_m", "z_m"];
const WHY: &str = "a table of forces has the columns node,fx_n,fy_n,fz_n or x_m,y_m,z_m,fx_n,fy_n,fz_n";

/// The forces in a file.
///
/// # Errors
/// A [`Diagnostic`] when the file cannot be read, a column is missing or a field is no number, with its line.
pub fn read_table(path: &Path) -> Result<ForceTable> {
    let text = input::read_text(path, input::LOG)
        .map_err(|e| Diagnostic::io(path, e, "put the table there, or correct table of the load"))?;
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).trim(csv::Trim::All).from_reader(text.as_bytes());
    let titles = reader.headers().map_err(|e| refused_table(path, 1, e.to_string()))?.clone();
    let columns = Columns::of_titles(&titles).ok_or_else(|| refused_table(path, 1, WHY.to_owned()))?;
    let mut rows = Vec::new();
    for (index, record) in reader.records().enumerate() {
        let record = record.map_err(|e| refused_table(path, index + 2, e.to_string()))?;
        let line = record.position().map_or(index + 2, |p| p.line() as usize);
        let (node, force) = columns.parse_row(&record).map_err(|why| refused_table(path, line, why))?;
        rows.push((line, node, force));
    }
    Ok(rows)
}

fn refused_table(path: &Path, line: usize, reason: String) -> Diagnostic {
    Diagnostic::file(path, "the table of forces cannot be read", reason, "correct the table; SI units").at_line(line)
}

/// Where what stands in a line.
struct Columns {
    node: Option<usize>,
    point: Option<[usize; 3]>,
    force: [usize; 3],
}

impl Columns {
    fn of_titles(titles: &StringRecord) -> Option<Self> {
        let column = |title: &str| titles.iter().position(|t| t == title);
        let three = |all: [&str; 3]| Some([column(all[0])?, column(all[1])?, column(all[2])?]);
        let columns = Self { node: column("node"), point: three(POINT), force: three(FORCES)? };
        (columns.node.is_some() || columns.point.is_some()).then_some(columns)
    }

    fn parse_row(&self, record: &StringRecord) -> std::result::Result<(NodeOf, Point3), String> {
        let number = |k: usize| -> std::result::Result<f64, String> {
            let value = record[k].parse::<f64>().map_err(|_| format!("`{}` is no number", &record[k]))?;
            if value.is_finite() { Ok(value) } else { Err(format!("`{}` is not finite", &record[k])) }
        };
        let three = |at: [usize; 3]| -> std::result::Result<Point3, String> {
            Ok([number(at[0])?, number(at[1])?, number(at[2])?])
        };
        let node = match (self.node, self.point) {
            (Some(node), _) => {
                NodeOf::Number(record[node].parse().map_err(|_| format!("`{}` is no number of a node", &record[node]))?)
            }
            (None, Some(point)) => NodeOf::Near(three(point)?),
            (None, None) => return Err(WHY.to_owned()),
        };
        Ok((node, three(self.force)?))
    }
}
