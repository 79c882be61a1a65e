//! The page of an inflation test: recordings with their pressures, case, markers, and the material's source.

use std::path::{Path, PathBuf};

use diagnostics::{Diagnostic, input};
use lab::range::{Checked, violation, within};
use lab::table;
use serde::Deserialize;
use si::{Metre, Pascal, Second};

use crate::free_vibration::page::Marker;
use simulate::case::{Axis, History, check_history};

/// The kind of test that a page names; a page that names none is that of a free vibration.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Test {
    /// A chamber is inflated in a step and its pressure held, or follows a history.
    Inflation,
}

/// The contents of a page.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Page {
    /// `inflation`.
    pub test: Test,
    /// Name of the results.
    pub name: String,
    /// The case, with one region, one chamber, and adaptive `[dynamic]` steps for a history; relative to the page. Its surface lies in one of `folders`.
    pub case: String,
    /// The body whose fit identified the material.
    pub material: String,
    /// The law of that fit, as whose parameters this test begins; the supported one when it is not said.
    pub law: Option<String>,
    /// Folders of recordings and surfaces, relative to the project's folder; the first that has them is used.
    pub folders: Vec<PathBuf>,
    /// The axis along which the markers' displacement is compared.
    pub along: Axis,
    /// Duration at the beginning during which the pressure is ambient, s.
    pub held: Second,
    /// Time in which a step of the pressure rises, s.
    pub rise: Second,
    /// Time constant with which the pressure of a step settles after that, s. What is missing of it at first is then fitted as well, the same
    /// for every recording.
    #[serde(default)]
    pub settling: Option<Second>,
    /// The interval after the hold's begin whose mean displacement is compared and fitted, s.
    pub early: [Second; 2],
    /// Duration at the end of the hold whose mean displacement is compared, s.
    pub late: Second,
    /// Standard deviation of an offset of all walls of the chambers, m, where they are not known to better: a joint fit identifies it.
    #[serde(default)]
    pub wall_sigma: Option<Metre>,
    /// Ratios by which the chambers' sections are scaled about their centroids, to find what the walls' thickness explains.
    #[serde(default)]
    pub sections: Vec<f64>,
    /// Inflations.
    pub recording: Vec<Recording>,
    /// Markers on the body and on its holder.
    pub marker: Vec<Marker>,
}

/// One inflation.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Recording {
    /// Its name in results.
    pub name: String,
    /// Tracks as `.csv` or `.c3d`; the first that lies there is read.
    pub files: Vec<String>,
    /// Pressure during the hold, Pa, which rises in a step; or its history, s after the hold's begin.
    pub pressure: History,
    /// Begin and end of the hold, s.
    pub hold: [Second; 2],
    /// Whether the modulus alone is fitted to it; it is predicted otherwise.
    #[serde(default)]
    pub fitted: bool,
}

/// How the air reaches the pressure of a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Supply {
    /// Time in which the step rises, s.
    pub rise: Second,
    /// Time constant with which what is missing after it vanishes, s.
    pub settling: Second,
    /// What is missing of the pressure at first, Pa.
    pub missing: Pascal,
}

impl Supply {
    /// The time since the middle of the rise, of a time after its begin (s): a step there creeps as the rise does.
    pub(crate) fn time_since_rise(&self, time: Second) -> Second {
        time - 0.5 * self.rise.min(time)
    }

    /// The pressure at a time after a step to `held`, Pa.
    pub(super) fn step_pressure(&self, held: Pascal, time: Second) -> Pascal {
        (held - self.missing * (-time / self.settling).exp()) * (time / self.rise).clamp(0.0, 1.0)
    }
}

impl Recording {
    /// The pressure at a time since the hold's begin, Pa: a step is as the air line makes it, a history as the page says.
    pub(crate) fn pressure_at(&self, time: Second, supply: &Supply) -> Pascal {
        match &self.pressure {
            History::Constant(held) => supply.step_pressure(*held, time),
            wave => wave.value_at(time),
        }
    }

    /// Of the hold, s.
    pub(crate) fn duration(&self) -> Second {
        self.hold[1] - self.hold[0]
    }
}

impl Page {
    /// The air line that lacks `missing` (Pa) of a step's pressure at first.
    pub(crate) fn supply(&self, missing: Pascal) -> Supply {
        Supply { rise: self.rise, settling: self.settling.unwrap_or(f64::INFINITY), missing }
    }

    /// The middles of the two intervals whose mean displacements are compared, s after the step.
    pub(crate) fn feature_times(&self, recording: &Recording) -> [Second; 2] {
        [0.5 * (self.early[0] + self.early[1]), recording.duration() - 0.5 * self.late]
    }

    /// The page in the file `path`.
    ///
    /// # Errors
    /// [`Diagnostic`] when it cannot be read, has an unknown or missing key, or an invalid number.
    pub fn read(path: &Path) -> Result<Self, Diagnostic> {
        let text = input::read_text(path, input::PAGE).map_err(|e| Diagnostic::io(path, e, "name a page of TOML"))?;
        Self::parse(&text, path)
    }

    /// The page in `text`; `path` appears only in diagnostics.
    ///
    /// # Errors
    /// [`Diagnostic`] when it has an unknown or missing key, or an invalid number.
    pub fn parse(text: &str, path: &Path) -> Result<Self, Diagnostic> {
        table::parse(text, path, SEE, Self::check_page)
    }

    fn check_page(&self) -> Checked {
        self.first_invalid()
            .map_or(Ok(()), |slip| violation("", slip, "no prediction is possible with it", "correct the page"))?;
        self.check_ranges()
    }

    /// Holds every number to the range of a test on a bench: a slip of a unit lies outside.
    fn check_ranges(&self) -> Checked {
        let times = [("held", self.held), ("rise", self.rise), ("late", self.late)];
        for (key, time) in times.into_iter().chain(self.settling.map(|time| ("settling", time))) {
            within(key, time, 1e-3..=3600.0, "s")?;
        }
        self.early.iter().try_for_each(|time| within("early", *time, 0.0..=3600.0, "s"))?;
        self.wall_sigma.iter().try_for_each(|sigma| within("wall_sigma", *sigma, 1e-6..=0.01, "m"))?;
        self.sections.iter().try_for_each(|ratio| within("sections", *ratio, 0.1..=1.5, ""))?;
        for (i, recording) in self.recording.iter().enumerate() {
            let key = format!("recording.{i}.pressure");
            match &recording.pressure {
                History::Constant(held) => within(&key, *held, -1e5..=1e7, "Pa")?,
                wave => check_history(&key, wave)?,
            }
            let times = &mut recording.hold.iter();
            times.try_for_each(|time| within(&format!("recording.{i}.hold"), *time, 0.0..=3600.0, "s"))?;
        }
        for (i, marker) in self.marker.iter().enumerate() {
            let places: &[(&str, &[Metre])] = &[("at", &marker.at), ("on", marker.on.as_ref().map_or(&[], |on| on))];
            for (key, place) in places {
                place.iter().try_for_each(|x| within(&format!("marker.{i}.{key}"), *x, -10.0..=10.0, "m"))?;
            }
        }
        Ok(())
    }

    /// The first invalid entry.
    fn first_invalid(&self) -> Option<&'static str> {
        let short = |r: &Recording| {
            let [begin, end] = r.hold;
            begin < self.held || end - begin < self.early[1] + self.late
        };
        let history = |r: &Recording| !matches!(r.pressure, History::Constant(_));
        let rules = [
            (
                self.settling.is_some() && self.recording.iter().any(history),
                "`settling` belongs to steps of the pressure, not to a history",
            ),
            (self.folders.is_empty(), "`folders` names none"),
            (self.recording.is_empty(), "there is no [[recording]]"),
            (self.recording.iter().any(|r| r.files.is_empty()), "a [[recording]] has no `files`"),
            (self.recording.iter().any(|r| r.name.trim().is_empty()), "a [[recording]] has an empty `name`"),
            (has_duplicate_names(&self.recording), "two [[recording]]s have one `name`"),
            (!self.recording.iter().any(|r| r.fitted), "no [[recording]] is fitted"),
            (self.marker.iter().any(|m| m.names.is_empty()), "a [[marker]] has no `names`"),
            (!self.marker.iter().any(|m| m.compared && m.on.is_some()), "no [[marker]] on the body is compared"),
            (self.marker.len() < 3, "fewer than three [[marker]]s do not define a frame of reference"),
            (
                !(self.early[0] >= self.rise && self.early[1] > self.early[0]),
                "`early` is not two times after `rise`, s",
            ),
            (self.recording.iter().any(short), "`held`, `hold`, `early` and `late` do not follow one another"),
        ];
        rules.iter().find(|(broken, _)| *broken).map(|(_, message)| *message)
    }
}

/// Whether two recordings have one name: their results could not be told apart.
fn has_duplicate_names(recordings: &[Recording]) -> bool {
    recordings.iter().enumerate().any(|(i, recording)| recordings[..i].iter().any(|other| other.name == recording.name))
}

const SEE: &str = "pipeline/sysid/examples/real has a page with every key";

#[cfg(test)]
mod tests {
    use super::*;

    const PAGE: &str = include_str!("../../examples/real/arm_ds10.toml");

    #[test]
    fn what_is_missing_of_a_step_vanishes_with_the_time_constant() {
        let supply = Supply { rise: 0.1, settling: 2.0, missing: 1e3 };
        assert!((supply.step_pressure(1e4, 0.05) - 0.5 * (1e4 - 1e3 * (-0.025_f64).exp())).abs() < 1e-9);
        assert!((supply.step_pressure(1e4, 2.0) - (1e4 - 1e3 * (-1.0_f64).exp())).abs() < 1e-9);
        let whole = Page::parse(&PAGE.replace("settling", "# settling"), Path::new("page.toml")).unwrap().supply(0.0);
        assert!((whole.step_pressure(1e4, 0.2) - 1e4).abs() < 1e-9);
    }

    /// Keys of numbers that may be negative.
    const SIGNED: &[&str] = &["at", "on", "pressure"];

    #[test]
    fn every_number_is_refused_out_of_its_range_with_file_and_key() {
        let refusal = |text: &str| Page::parse(text, Path::new("page.toml")).err().map(|refusal| refusal.to_string());
        crate::free_vibration::testing::hold_every_number(PAGE, SIGNED, refusal);
    }

    #[test]
    fn the_page_that_comes_along_is_read_and_a_slip_of_the_pen_is_refused() {
        assert_eq!(Page::parse(PAGE, Path::new("page.toml")).unwrap().name, "arm_ds10");
        let slips = [
            ("rise = ", "rises = ", "rises"),
            ("settling = ", "settling = -", "out of range"),
            (
                "pressure = 1.0e4",
                "pressure = { table = { times = [0.0, 1.0], values = [0.0, 1.0e4] } }",
                "steps of the pressure",
            ),
            ("pressure = 1.0e4", "pressure = 1.0e9", "out of range"),
            ("hold = [0.59, 3.53]", "hold = [3.53, 0.59]", "do not follow one another"),
            ("hold = [0.59, 3.53]", "hold = [0.59]", "length 1"),
            ("fitted = true", "fitted = false", "is fitted"),
            ("name = \"100mbar\"", "name = \" \"", "empty `name`"),
            ("name = \"200mbar\"", "name = \"100mbar\"", "have one `name`"),
            ("compared = true", "compared = false", "is compared"),
            ("early = [", "early = [-", "two times after"),
            ("test = \"inflation\"", "test = \"torsion\"", "torsion"),
        ];
        let refused = |page: &str, (from, to, expected): (&str, &str, &str)| {
            assert!(page.contains(from), "{from}");
            let said = Page::parse(&page.replace(from, to), Path::new("page.toml")).unwrap_err().to_string();
            assert!(said.contains(expected) && said.contains("do:"), "{said}");
        };
        slips.into_iter().for_each(|slip| refused(PAGE, slip));
        let falling = "pressure = { table = { times = [1.0, 0.0], values = [0.0, 1.0e4] } }";
        let of_histories = PAGE.replace("settling", "# settling");
        refused(&of_histories, ("pressure = 1.0e4", falling, "times of a table rise"));
    }
}
