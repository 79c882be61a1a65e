//! Probes: the paths of nodes and markers, and volume and pressure of chambers, as a table of numbers.
//!
//! `level` or `time_s`; for each node and marker its place (`tip_x_m`, …) and its displacement (`tip_ux_m`, …); for each
//! chamber of the case `left_volume_m3` (both halves of one that the plane of symmetry cuts) and `left_pressure_pa` above
//! ambient; for each clamp with a name its force on the body (`grip_fx_n`, …); along a path its stability. Rows are on the disk as soon as they are written.

use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};

use fem::Solver;
use si::{Pascal, Point3};

use super::cannot_write;
use crate::body::Body;
use crate::case::Case;
use crate::reach::Reach;
use diagnostics::Result;

/// A material point of the output.
#[derive(Debug, Clone, PartialEq)]
pub struct Probe {
    /// The prefix of its columns.
    pub name: String,
    /// Nodes, and the part of each.
    pub weights: Vec<(u32, f64)>,
}

/// The nodes and markers of a case's output, in the order of its table.
///
/// # Errors
/// A [`diagnostics::Diagnostic`] when one is not on the body.
pub fn probes(case: &Case, body: &Body) -> Result<Vec<Probe>> {
    let reach = Reach { solid: body.solid, size: body.system.mesh().size() };
    let mut probes = Vec::new();
    for node in &case.output.node {
        let weights = vec![(reach.nearest_node(&format!("`{}`", node.name), node.near)?, 1.0)];
        probes.push(Probe { name: node.name.clone(), weights });
    }
    for marker in &case.output.marker {
        let (spot, apart) = body.solid.embed(marker.at);
        reach.on_body(&format!("`{}`", marker.name), apart)?;
        probes.push(Probe { name: marker.name.clone(), weights: spot.weights });
    }
    Ok(probes)
}

impl Probe {
    /// The sum over its nodes of what `value_of_node` says of each.
    fn weighted_sum(&self, value_of_node: impl Fn(usize) -> Point3) -> Point3 {
        let add = |sum: Point3, (node, w): &(u32, f64)| {
            let value = value_of_node(*node as usize);
            [0, 1, 2].map(|k| sum[k] + w * value[k])
        };
        self.weights.iter().fold([0.0; 3], add)
    }
}

/// A solved state.
pub(super) struct Solved<'a> {
    /// Level, or time in s.
    pub at: f64,
    /// 3 a node, m.
    pub displacement: &'a [f64],
    /// One a chamber of the mesh, Pa.
    pub pressures: &'a [Pascal],
    /// Of a path: the number of negative eigenvalues of the tangent, and the eigenvalue nearest to zero, N/m.
    pub stability: Option<(usize, f64)>,
}

/// The table of a case.
pub(super) struct Table {
    file: File,
    path: PathBuf,
    probes: Vec<Probe>,
}

impl Table {
    /// Begins `<stem>.csv` in `folder`.
    ///
    /// # Errors
    /// A [`Diagnostic`] when a marker is not on the skin, or the file cannot be written.
    pub fn create(case: &Case, body: &Body, folder: &Path, stem: &str) -> Result<Self> {
        let mut head = vec![if case.dynamic.is_some() { "time_s".to_owned() } else { "level".to_owned() }];
        let probes = probes(case, body)?;
        for Probe { name, .. } in &probes {
            head.extend(["x", "y", "z", "ux", "uy", "uz"].map(|axis| format!("{name}_{axis}_m")));
        }
        for (i, chamber) in case.chamber.iter().enumerate() {
            let name = chamber.name.clone().unwrap_or_else(|| format!("chamber_{i}"));
            head.extend([format!("{name}_volume_m3"), format!("{name}_pressure_pa")]);
        }
        for grip in &body.held.grips {
            head.extend(["x", "y", "z"].map(|axis| format!("{}_f{axis}_n", grip.name)));
        }
        if case.statics.as_ref().is_some_and(|set| set.arc_length.is_some()) {
            head.extend(["negative_eigenvalues", "eigenvalue_n_per_m"].map(str::to_owned));
        }
        let path = folder.join(format!("{stem}.csv"));
        let file = File::create(&path).map_err(|e| cannot_write(&path, &e))?;
        let mut table = Self { file, path, probes };
        table.write_line(&head.join(","))?;
        Ok(table)
    }

    /// Writes one row: the level or time, then every probe and chamber.
    ///
    /// # Errors
    /// A [`Diagnostic`] when the file cannot be written.
    pub(crate) fn write_row(&mut self, body: &Body, solver: &Solver, solved: &Solved) -> Result<()> {
        let Solved { at, displacement, pressures, stability } = *solved;
        let nodes = body.solid.nodes();
        let node_displacement = |node: usize| [0, 1, 2].map(|k| displacement[3 * node + k]);
        let mut row = vec![at];
        for probe in &self.probes {
            let (position, node_displacement) =
                (probe.weighted_sum(|node| nodes[node]), probe.weighted_sum(node_displacement));
            row.extend([0, 1, 2].map(|k| position[k] + node_displacement[k]));
            row.extend(node_displacement);
        }
        for &number in &body.numbers {
            let halves = if body.cavities[number].cut { 2.0 } else { 1.0 };
            row.push(halves * body.system.chamber_volume(number, displacement));
            row.push(solver.chamber_pressure(number, displacement, pressures)?);
        }
        for grip in &body.held.grips {
            row.extend(grip.force(solver, (displacement, pressures), body.solid.half())?);
        }
        row.extend(stability.into_iter().flat_map(|(negative, nearest)| [negative as f64, nearest]));
        let words: Vec<String> = row.iter().map(|value| format!("{value:.9e}")).collect();
        self.write_line(&words.join(","))
    }

    fn write_line(&mut self, text: &str) -> Result<()> {
        writeln!(self.file, "{text}").map_err(|e| cannot_write(&self.path, &e))
    }
}
