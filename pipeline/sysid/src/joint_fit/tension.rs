//! A tensile test: a strip is pulled at a constant rate; strain by the crosshead, whose compliance is estimated, or by an extensometer.
//!
//! A strip of incompressible material is in uniaxial tension, F = diag(λ, λ^−½, λ^−½), so that its stress has a closed form in every law.

use std::path::{Path, PathBuf};

use diagnostics::{Diagnostic, Result, input};
use fem::material::{Material, Moduli};
use nalgebra::{Matrix3, Vector3};
use serde::Deserialize;
use si::{Pascal, Second};

use super::laws::Constants;
use crate::free_vibration::recorded::find;

/// How a machine measures strain.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Strain {
    /// By its crosshead: grips and ends of the strip yield as well.
    Crosshead,
    /// On the strip.
    Extensometer,
}

/// The page of a tensile test.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Page {
    /// `tension`.
    pub test: String,
    /// Name of the results.
    pub name: String,
    /// Folders of the recording, relative to the project's folder.
    pub folders: Vec<PathBuf>,
    /// CSV as the machine wrote it; the first that lies there is read.
    pub files: Vec<String>,
    /// Names of the columns: time (s), engineering strain (no unit) and engineering stress.
    pub time: String,
    /// See `time`.
    pub strain: String,
    /// See `time`.
    pub stress: String,
    /// Pa in one unit of the stress.
    pub stress_unit: Pascal,
    /// How strain is measured.
    pub measured_by: Strain,
    /// Least and largest strain that are fitted.
    pub fitted: [f64; 2],
    /// Further strains that are predicted.
    #[serde(default)]
    pub predicted: Vec<f64>,
    /// Standard deviation of the logarithm of its modulus over that of the other tests: batches differ.
    pub batch_sigma: f64,
}

/// A recorded pull.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Pull {
    /// Time (s), engineering strain and stress (Pa), row by row.
    rows: Vec<[f64; 3]>,
}

impl Page {
    /// The page in the file `path`.
    ///
    /// # Errors
    /// A [`Diagnostic`] when it cannot be read, a key is unknown or missing, or a number is out of range.
    pub(super) fn read(path: &Path) -> Result<Self> {
        let text = input::read_text(path, input::PAGE).map_err(|e| Diagnostic::io(path, e, "name a page of TOML"))?;
        lab::table::parse(&text, path, "pipeline/sysid/examples/real has a page with every key", Self::check)
    }

    fn check(&self) -> lab::range::Checked {
        use lab::range::within;
        within("stress_unit", self.stress_unit, 1e-3..=1e9, "Pa")?;
        within("batch_sigma", self.batch_sigma, 1e-3..=3.0, "")?;
        within("fitted.0", self.fitted[0], 1e-4..=self.fitted[1], "")?;
        within("fitted.1", self.fitted[1], 1e-4..=10.0, "")?;
        self.predicted.iter().try_for_each(|strain| within("predicted", *strain, 1e-4..=10.0, ""))
    }

    /// Its recording below `root`.
    ///
    /// # Errors
    /// A [`Diagnostic`] when it lies nowhere, or has no such columns.
    pub(super) fn recording(&self, root: &Path) -> Result<Pull> {
        let path = find(&self.name, &self.folders, &self.files, root)?;
        let text = input::read_text(&path, input::PAGE).map_err(|e| Diagnostic::io(&path, e, "name a CSV"))?;
        Pull::parse(&text, [&self.time, &self.strain, &self.stress], self.stress_unit).map_err(|(what, why)| {
            Diagnostic::file(&path, what, why, "correct the names of the columns on the page, or export the test again")
        })
    }
}

impl Pull {
    /// The rows below the header that names the three columns; lines before it are the machine's own. Columns are parted by semicolons, tabs
    /// or commas; with semicolons or tabs, a comma is a decimal point.
    fn parse(text: &str, names: [&String; 3], unit: Pascal) -> Result<Self, (String, String)> {
        let separators = [';', '\t', ','];
        let cells = |line: &str, separator: char| -> Vec<String> {
            line.split(separator).map(|cell| cell.trim().trim_matches('"').to_owned()).collect()
        };
        let header = text.lines().enumerate().find_map(|(number, line)| {
            let separator = *separators.iter().find(|separator| line.contains(**separator))?;
            let row = cells(line, separator);
            let columns: Vec<usize> =
                names.iter().filter_map(|name| row.iter().position(|cell| cell == *name)).collect();
            (columns.len() == 3).then_some((number, separator, columns))
        });
        let Some((number, separator, columns)) = header else {
            return Err((
                format!("no line names the columns {names:?}"),
                "its header is looked for in every line".into(),
            ));
        };
        let value = |cell: &String| {
            let decimal = if separator == ',' { cell.clone() } else { cell.replace(',', ".") };
            decimal.parse::<f64>().ok().filter(|value| value.is_finite())
        };
        let row = |line: &str| -> Option<[f64; 3]> {
            let cells = cells(line, separator);
            let [time, strain, stress] = [0, 1, 2].map(|k| cells.get(columns[k]).and_then(value));
            Some([time?, strain?, unit * stress?])
        };
        let mut rows: Vec<[f64; 3]> = text.lines().skip(number + 1).filter_map(row).collect();
        // after the break the stress falls, and strains mean nothing
        let strongest = (0..rows.len()).max_by(|a, b| rows[*a][2].total_cmp(&rows[*b][2])).unwrap_or(0);
        rows.truncate(strongest + 1);
        if rows.len() < 3 {
            return Err((format!("{} rows of numbers follow its header", rows.len()), "a test has more".into()));
        }
        Ok(Self { rows })
    }

    /// Time (s) and stress (Pa) at an engineering strain, on the line between two rows; none outside of the recording.
    pub fn at(&self, strain: f64) -> Option<(Second, Pascal)> {
        let next = self.rows.iter().position(|row| row[1] >= strain)?;
        let (before, after) = (self.rows.get(next.checked_sub(1)?)?, self.rows[next]);
        let part = (strain - before[1]) / (after[1] - before[1]);
        Some((before[0] + part * (after[0] - before[0]), before[2] + part * (after[2] - before[2])))
    }
}

/// Times at which the relaxation of a ramp of strain is summed.
const RAMP_POINTS: usize = 16;

/// Engineering stress of a strip at the stretch λ, which it reached at a constant rate in `time`, Pa.
#[allow(non_snake_case)]
pub(super) fn strip_stress(material: &dyn Material, constants: &Constants, (stretch, time): (f64, Second)) -> Pascal {
    // the stress of μ at the age of each part of the ramp; in small strains this is Boltzmann's integral
    let age = |k: usize| (k as f64 + 0.5) / RAMP_POINTS as f64 * time;
    let mean = (0..RAMP_POINTS).map(|k| constants.relaxation.modulus(age(k))).sum::<f64>() / RAMP_POINTS as f64;
    let mu = constants.youngs_modulus / 3.0;
    let stiffening = constants.stiffening.map(|ratio| 0.5 * ratio * mu);
    let lateral_stretch = stretch.powf(-0.5);
    let F = Matrix3::from_diagonal(&Vector3::new(stretch, lateral_stretch, lateral_stretch));
    let P = material.energy_and_stress(&F, Moduli { mu: mu * mean, lambda: 0.0, stiffening }).1;
    // the pressure that keeps its sides free of stress
    P[(0, 0)] - P[(1, 1)] * lateral_stretch / stretch
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::joint_fit::laws::LAWS;

    const CSV: &str =
        "Machine;Instron\n;;\nTime (s);Strain;Stress (MPa)\n0,1;0,1;0,02\n0.2;0.2;0.04\n0.3;0.4;0.06\n0.4;0.5;0.01\n";

    fn names() -> [String; 3] {
        ["Time (s)", "Strain", "Stress (MPa)"].map(str::to_owned)
    }

    #[test]
    fn a_pull_is_read_below_its_header_and_ends_at_its_break() {
        let [a, b, c] = &names();
        let pull = Pull::parse(CSV, [a, b, c], 1e6).unwrap();
        assert_eq!(pull.rows.len(), 3);
        let (time, stress) = pull.at(0.3).unwrap();
        assert!((time - 0.25).abs() < 1e-12 && (stress - 5e4).abs() < 1e-6);
        assert!(pull.at(0.45).is_none() && pull.at(0.05).is_none());
        assert!(Pull::parse(&CSV.replace("Strain", "Extension"), [a, b, c], 1e6).is_err());
    }

    #[test]
    fn a_strip_of_a_neo_hookean_law_has_its_closed_form_and_small_strains_its_modulus() {
        for law in LAWS {
            let mut point: Vec<f64> = law.parameters().iter().map(|parameter| parameter.start).collect();
            point[1] = 1e-4_f64.ln();
            let constants = law.constants(&point).unwrap();
            let material = fem::materials::by_name(law.material).unwrap();
            let small = strip_stress(material, &constants, (1.0 + 1e-5, 3.0)) / 1e-5;
            assert!((small / point[0].exp() - 1.0).abs() < 1e-3, "{}: {small}", law.name);
            if law.terms.is_empty() {
                let large = strip_stress(material, &constants, (1.5, 3.0));
                let should = point[0].exp() / 3.0 * (1.5 - 1.0 / 2.25);
                assert!((large / should - 1.0).abs() < 1e-3, "{large} {should}");
            }
        }
    }

    /// A bar of finite elements on rollers, pulled by a dead load, is as long as the closed form says.
    #[test]
    fn a_bar_of_finite_elements_has_the_stress_of_the_closed_form() {
        use fem::{Clamps, Forces, RegionProperties, StaticSettings, System, box_mesh};
        let [length, width, depth] = [0.03, 0.006, 0.003];
        let mesh = box_mesh::quadratic([length, width, depth], [2, 1, 1]);
        let mut clamps = Clamps::none();
        for (node, at) in mesh.nodes.iter().enumerate() {
            clamps.constrain(node as u32, at.map(|x| x.abs() < 1e-12));
        }
        let law = LAWS.iter().find(|law| law.name == "ogden").unwrap();
        let point = [2e5_f64.ln(), 1e-4_f64.ln(), 0.3, 0.0, 0.2, 0.1];
        let constants = law.constants(&point).unwrap();
        let material = fem::materials::by_name(law.material).unwrap();
        let region = RegionProperties {
            stiffening: constants.stiffening,
            ..RegionProperties::elastic(material, constants.youngs_modulus, 0.4995, 1e3)
        };
        let system = System::new(mesh, vec![region], clamps).unwrap();
        let mesh = system.mesh();
        let is_end = |node: &usize| (mesh.nodes[*node][0] - length).abs() < 1e-12;
        let pull = 6e4;
        // on a face of four triangles of second order, a uniform traction acts on the middles of edges alone
        let mut forces = Forces::none(mesh);
        let corners: Vec<usize> = (0..mesh.nodes.len()).filter(is_end).collect();
        for face in end_faces(mesh, &corners) {
            forces = forces.on_face(&face, [pull, 0.0, 0.0]).unwrap();
        }
        let mut solver = system.solver();
        solver.set_forces(forces.as_slice()).unwrap();
        let equilibrium = solver.equilibrium(&[], None, &StaticSettings::default()).unwrap();
        let stretch = 1.0 + equilibrium.displacement[3 * corners[0]] / length;
        assert!(stretch > 1.3, "{stretch}");
        let closed = strip_stress(material, &constants, (stretch, 1e4));
        assert!((closed / pull - 1.0).abs() < 5e-3, "{closed} {stretch}");
    }

    /// The sides of elements whose six nodes all lie among `nodes`.
    fn end_faces(mesh: &fem::Mesh, nodes: &[usize]) -> Vec<[u32; 6]> {
        const SIDES: [[usize; 6]; 4] = [[0, 1, 2, 4, 5, 6], [0, 1, 3, 4, 8, 7], [1, 2, 3, 5, 9, 8], [0, 2, 3, 6, 9, 7]];
        let elements = (0..mesh.elements.len()).map(|element| mesh.elements.nodes(element));
        let sides = elements.flat_map(|element| SIDES.map(|side| side.map(|k| element[k])));
        sides.filter(|side| side.iter().all(|node| nodes.contains(&(*node as usize)))).collect()
    }
}
