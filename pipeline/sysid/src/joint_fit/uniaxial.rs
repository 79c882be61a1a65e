//! Tests under one stress: a strip that is pulled or a cylinder that is pressed at a constant rate, or one that is held after it; strain by the
//! crosshead, whose compliance is estimated, or by an extensometer.
//!
//! A specimen of incompressible material has F = diag(λ, λ^−½, λ^−½), so that its stress has a closed form in every law. Of a cylinder this asks
//! for plates on which it slides: one that sticks to them bulges, and seems stiffer.

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

/// How a specimen is loaded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Kind {
    /// Pulled, as a rule until it breaks.
    Tension,
    /// Pressed; strain and stress may be recorded with either sign.
    Compression,
    /// Pulled or pressed (with negative strain and stress), and held.
    Relaxation,
}

impl Kind {
    /// That of a page with this `test`.
    pub(super) fn named(test: &str) -> Option<Self> {
        [("tension", Self::Tension), ("compression", Self::Compression), ("relaxation", Self::Relaxation)]
            .into_iter()
            .find_map(|(name, kind)| (name == test).then_some(kind))
    }

    /// The sign of strain and stress where rows have their magnitudes.
    pub(super) fn sign(self) -> f64 {
        if self == Self::Compression { -1.0 } else { 1.0 }
    }
}

/// The page of a test under one stress.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Page {
    /// How it is loaded.
    pub test: Kind,
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
    /// Least and largest strain that are fitted; of a relaxation the times, s after its strain was reached.
    pub fitted: [f64; 2],
    /// Further strains, or times, that are predicted.
    #[serde(default)]
    pub predicted: Vec<f64>,
    /// Standard deviation of the logarithm of its modulus over that of the other tests: batches differ.
    pub batch_sigma: f64,
}

/// A recorded test.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Recording {
    kind: Kind,
    /// Time (s), engineering strain and stress (Pa), row by row; of a compression their magnitudes.
    rows: Vec<[f64; 3]>,
}

/// A state of a specimen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Loaded {
    /// Engineering strain.
    pub strain: f64,
    /// How long it was strained at a constant rate, and then held, s.
    pub ramp: Second,
    pub held: Second,
    /// Engineering stress, Pa.
    pub stress: Pascal,
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
        let (largest, unit) = match self.test {
            Kind::Tension => (10.0, ""),
            Kind::Compression => (0.9, ""),
            Kind::Relaxation => (1e7, "s"),
        };
        within("fitted.0", self.fitted[0], 1e-4..=self.fitted[1], unit)?;
        within("fitted.1", self.fitted[1], 1e-4..=largest, unit)?;
        self.predicted.iter().try_for_each(|at| within("predicted", *at, 1e-4..=largest, unit))
    }

    /// Its recording below `root`.
    ///
    /// # Errors
    /// A [`Diagnostic`] when it lies nowhere, or has no such columns.
    pub(super) fn recording(&self, root: &Path) -> Result<Recording> {
        let path = find(&self.name, &self.folders, &self.files, root)?;
        let text = input::read_text(&path, input::PAGE).map_err(|e| Diagnostic::io(&path, e, "name a CSV"))?;
        let names = [&self.time, &self.strain, &self.stress];
        Recording::parse(&text, self.test, names, self.stress_unit).map_err(|(what, why)| {
            Diagnostic::file(&path, what, why, "correct the names of the columns on the page, or export the test again")
        })
    }
}

impl Recording {
    /// The rows below the header that names the three columns; lines before it are the machine's own. Columns are parted by semicolons, tabs
    /// or commas; with semicolons or tabs, a comma is a decimal point.
    fn parse(text: &str, kind: Kind, names: [&String; 3], unit: Pascal) -> Result<Self, (String, String)> {
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
        if kind == Kind::Compression {
            rows.iter_mut().for_each(|row| *row = [row[0], row[1].abs(), row[2].abs()]);
        }
        // after the break, or when a plate returns, the stress falls, and strains mean nothing
        let strongest = (0..rows.len()).max_by(|a, b| rows[*a][2].total_cmp(&rows[*b][2])).unwrap_or(0);
        rows.truncate(if kind == Kind::Relaxation { rows.len() } else { strongest + 1 });
        if rows.len() < 3 {
            return Err((format!("{} rows of numbers follow its header", rows.len()), "a test has more".into()));
        }
        Ok(Self { kind, rows })
    }

    /// The state at an engineering strain, or of a relaxation at a time after its strain was reached; none outside of the recording.
    pub fn at(&self, place: f64) -> Option<Loaded> {
        if self.kind == Kind::Relaxation {
            let (strain, ramp, reached) = self.hold()?;
            let [_, _, stress] = self.interpolated(0, reached + place)?;
            return Some(Loaded { strain, ramp, held: place, stress });
        }
        let [time, _, stress] = self.interpolated(1, place)?;
        Some(Loaded { strain: place, ramp: time, held: 0.0, stress })
    }

    /// On the line between the two rows between which a `column` reaches a value.
    fn interpolated(&self, column: usize, value: f64) -> Option<[f64; 3]> {
        let next = self.rows.iter().position(|row| row[column] >= value)?;
        let (before, after) = (self.rows.get(next.checked_sub(1)?)?, self.rows[next]);
        let part = (value - before[column]) / (after[column] - before[column]);
        Some([0, 1, 2].map(|k| before[k] + part * (after[k] - before[k])))
    }

    /// The strain that is held, how long it took to reach it from its hundredth on, and when that was, s.
    fn hold(&self) -> Option<(f64, Second, Second)> {
        let mut later: Vec<f64> = self.rows[self.rows.len() / 2..].iter().map(|row| row[1]).collect();
        later.sort_by(f64::total_cmp);
        let strain = *later.get(later.len() / 2)?;
        let reached = self.rows.iter().position(|row| row[1] / strain >= 0.99)?;
        let start = self.rows[..reached].iter().rposition(|row| row[1] / strain <= 0.01).unwrap_or(0);
        // a step that is faster than the log takes its interval
        let begin = if start == reached { reached.checked_sub(1)? } else { start };
        Some((strain, self.rows[reached][0] - self.rows[begin][0], self.rows[reached][0]))
    }
}

/// Times at which the relaxation of a ramp of strain is summed.
const RAMP_POINTS: usize = 16;

/// Engineering stress of a specimen at the stretch λ, which it reached at a constant rate in the time of a `ramp` and was then `held` at, Pa.
#[allow(non_snake_case)]
pub(super) fn uniaxial_stress(
    material: &dyn Material,
    constants: &Constants,
    (stretch, [ramp, held]): (f64, [Second; 2]),
) -> Pascal {
    // the stress of μ at the age of each part of the ramp; in small strains this is Boltzmann's integral
    let age = |k: usize| held + (k as f64 + 0.5) / RAMP_POINTS as f64 * ramp;
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

    fn parsed(text: &str, kind: Kind) -> Recording {
        let [a, b, c] = &names();
        Recording::parse(text, kind, [a, b, c], 1e6).unwrap()
    }

    #[test]
    fn a_pull_is_read_below_its_header_and_ends_at_its_break() {
        let pull = parsed(CSV, Kind::Tension);
        assert_eq!(pull.rows.len(), 3);
        let at = pull.at(0.3).unwrap();
        assert!((at.ramp - 0.25).abs() < 1e-12 && at.held == 0.0 && (at.stress - 5e4).abs() < 1e-6);
        assert!(pull.at(0.45).is_none() && pull.at(0.05).is_none());
        let [a, b, c] = &names();
        assert!(Recording::parse(&CSV.replace("Strain", "Extension"), Kind::Tension, [a, b, c], 1e6).is_err());
    }

    #[test]
    fn a_compression_has_the_same_states_with_either_sign() {
        let negative = CSV
            .replace(";0,1;0,02", ";-0,1;-0,02")
            .replace(";0.2;0.04", ";-0.2;-0.04")
            .replace(";0.4;0.06", ";-0.4;-0.06");
        assert_eq!(parsed(&negative, Kind::Compression), parsed(CSV, Kind::Compression));
        assert_eq!(parsed(CSV, Kind::Compression).at(0.3).unwrap().strain, 0.3);
    }

    #[test]
    fn a_hold_is_found_with_its_strain_its_ramp_and_the_time_after_it() {
        let strain = |time: f64| (0.5 * (time - 1.0)).clamp(0.0, 0.4);
        let row = |k: i32| {
            let time = 0.1 * f64::from(k);
            format!("{time};{};{}\n", strain(time), strain(time) * (1.0 - 0.01 * time))
        };
        let text = "Time (s);Strain;Stress (MPa)\n".to_owned() + &(0..100).map(row).collect::<String>();
        let at = parsed(&text, Kind::Relaxation).at(3.0).unwrap();
        assert!((at.strain - 0.4).abs() < 1e-12 && (at.ramp - 0.8).abs() < 1e-9 && at.held == 3.0, "{at:?}");
        assert!((at.stress - 1e6 * 0.4 * (1.0 - 0.048)).abs() < 1e-3, "{at:?}");
        assert!(parsed(&text, Kind::Relaxation).at(9.0).is_none());
    }

    #[test]
    fn a_strip_of_a_neo_hookean_law_has_its_closed_form_and_small_strains_its_modulus() {
        for law in LAWS {
            let mut point: Vec<f64> = law.parameters().iter().map(|parameter| parameter.start).collect();
            point[1] = 1e-4_f64.ln();
            let constants = law.constants(&point).unwrap();
            let material = fem::materials::by_name(law.material).unwrap();
            let small = uniaxial_stress(material, &constants, (1.0 + 1e-5, [3.0, 0.0])) / 1e-5;
            assert!((small / point[0].exp() - 1.0).abs() < 1e-3, "{}: {small}", law.name);
            if law.terms.is_empty() {
                let large = uniaxial_stress(material, &constants, (1.5, [3.0, 0.0]));
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
        let closed = uniaxial_stress(material, &constants, (stretch, [1e4, 0.0]));
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
