//! The report of `study mesh`.

use std::fmt;

use diagnostics::Diagnostic;
use mesh::{Chosen, Curving, Measures, Method, RegionMeasures};
use workflow::runner::peak_memory;

use super::options::MeshSurfaces;

/// Columns of the longest bar of a histogram.
const BAR: usize = 40;
/// The class of dihedral angles, degrees, and of scaled Jacobians.
const ANGLE_CLASS: f64 = 7.06;
const JACOBIAN_CLASS: f64 = 0.1;

/// A mesh with its measures.
pub(super) struct Measured<'a> {
    pub(super) chosen: &'a Chosen,
    pub(super) measures: &'a Measures,
    pub(super) options: &'a MeshSurfaces,
    pub(super) chambers: usize,
    /// Wall time of the meshing.
    pub(super) seconds: f64,
}

impl fmt::Display for Measured<'_> {
    fn fmt(&self, out: &mut fmt::Formatter) -> fmt::Result {
        let (report, measures, edge) = (&self.chosen.report, self.measures, self.options.edge);
        writeln!(
            out,
            "elements    {} quadratic tetrahedra, {} nodes, {} of them corners; edge {:.3} mm; {:.1} s{}",
            report.tets,
            report.quadratic_nodes,
            report.nodes,
            edge * 1e3,
            self.seconds,
            peak_memory().map_or(String::new(), |memory| format!(", at most {memory:.0} MiB"))
        )?;
        writeln!(out, "method      {}", self.method_text())?;
        report.repairs.iter().try_for_each(|repair| writeln!(out, "repaired    {repair}"))?;
        if let Some(Curving { curved, straight }) = self.chosen.curving {
            writeln!(out, "middles     {curved} on curved surfaces, {straight} off them on straight edges")?;
        }
        let [least, largest] = measures.dihedral_range_deg;
        let usual = measures.dihedral_quantile_deg;
        writeln!(out, "dihedral    {least:.2}° to {largest:.2}°; 99.9 % of the elements have {usual:.2}° and more")?;
        write_bars(out, &measures.dihedral_histogram, (ANGLE_CLASS, 1, "°"))?;
        writeln!(out, "jacobian    least scaled {:.4}", measures.least_jacobian)?;
        write_bars(out, &measures.jacobian_histogram, (JACOBIAN_CLASS, 1, ""))?;
        measures.regions.iter().enumerate().try_for_each(|(number, region)| write_volume(out, number, region))?;
        let [there, back] = [measures.surfaces_to_mesh, measures.mesh_to_surfaces].map(|d| d / edge);
        writeln!(out, "hausdorff   {there:.4} of the edge from the surfaces to the mesh, {back:.4} back")?;
        writeln!(out, "skin        {} outer, {} chambers", count_text(measures.shells, "shell"), self.chambers)?;
        for chamber in &report.chambers {
            let [x, y, z] = chamber.centroid.map(|c| c * 1e3);
            writeln!(out, "chamber     {:.2} mm³ at ({x:.2}, {y:.2}, {z:.2}) mm", chamber.volume * 1e9)?;
        }
        for interface in &measures.interfaces {
            let ([a, b], area) = (interface.regions, interface.area * 1e6);
            writeln!(out, "interface   {area:.3} mm² in {} faces between regions {a} and {b}", interface.faces)?;
        }
        Ok(())
    }
}

impl Measured<'_> {
    /// Which it was, and why.
    fn method_text(&self) -> String {
        match (&self.chosen.not_columns, Method::from(self.options.method)) {
            (Some(why), _) => format!("general, since {}", Diagnostic::from(why.clone()).what),
            (None, Method::General) => "general, as it was asked for".to_owned(),
            (None, Method::Columns) => "columns, as it was asked for".to_owned(),
            (None, Method::Auto) => "columns, which divide the body".to_owned(),
        }
    }
}

fn count_text(count: usize, noun: &str) -> String {
    if count == 1 { format!("1 {noun}") } else { format!("{count} {noun}s") }
}

fn write_volume(out: &mut fmt::Formatter, number: usize, region: &RegionMeasures) -> fmt::Result {
    let (elements, volume) = (region.elements, region.volume * 1e9);
    write!(out, "region {number:<5}{elements} elements, {volume:.3} mm³")?;
    match region.expected {
        Some(expected) => {
            writeln!(out, ", {:+.3} % of what the surfaces hold", 100.0 * (region.volume / expected - 1.0))
        }
        None => writeln!(out, "; the surfaces are open or overlap in part: no volume to compare with"),
    }
}

/// A line a class of a histogram, from the first that is not empty.
fn write_bars(out: &mut fmt::Formatter, counts: &[usize], (class, digits, unit): (f64, usize, &str)) -> fmt::Result {
    let largest = counts.iter().copied().max().unwrap_or(0).max(1);
    for (number, count) in counts.iter().enumerate().skip_while(|(_, count)| **count == 0) {
        let [from, to] = [number, number + 1].map(|k| k as f64 * class);
        let bar = "#".repeat((BAR * count).div_ceil(largest));
        writeln!(out, "    {from:5.digits$} to {to:5.digits$}{unit:<1} {count:>9} {bar}")?;
    }
    Ok(())
}
