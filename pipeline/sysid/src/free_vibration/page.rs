//! The page of a free vibration test: recordings, case, and the compared quantities.

use std::path::{Path, PathBuf};

use diagnostics::{Diagnostic, input};
use lab::range::{Checked, violation, within};
use lab::table;
use serde::Deserialize;
use si::{Pascal, Point3, Second};

use simulate::case::Axis;

/// The contents of a page.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Page {
    /// Name of the results.
    pub name: String,
    /// The case, with `[static]`, whose loads act once the body is released; relative to the page. Recordings may have their own.
    pub case: String,
    /// The time after loading to which Young's modulus belongs, s.
    pub modulus_time: Second,
    /// Bounds of Young's modulus, Pa.
    pub range: [Pascal; 2],
    /// Folders of the recordings, relative to the project's folder; the first that has them is used.
    pub folders: Vec<PathBuf>,
    /// The axis along which the body falls.
    pub along: Axis,
    /// Duration at the beginning during which it is held straight, s.
    pub held: Second,
    /// Duration at the end during which it is at rest, s.
    pub settled: Second,
    /// The interval of the vibration that is compared, s after the release.
    pub swing: [Second; 2],
    /// Step of the simulated motion, s.
    pub step: Second,
    /// Standard deviation of a measured displacement, m.
    pub sigma: f64,
    /// Films or tracks of the same release.
    pub recording: Vec<Recording>,
    /// Markers on the body and on its holder.
    pub marker: Vec<Marker>,
    /// Published values.
    pub published: Option<Published>,
}

/// One release.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Recording {
    /// Tracks as `.csv` or `.c3d`; the first that lies there is read.
    pub files: Vec<String>,
    /// Time of the release, s.
    pub release: Second,
    /// Its own case, in the place of the page's.
    pub case: Option<String>,
    /// Whether the laws are fitted to it; they predict it otherwise.
    #[serde(default = "yes")]
    pub fitted: bool,
    /// Where the last of `files` can be downloaded.
    pub source: Option<String>,
    /// Its BLAKE3.
    pub blake3: Option<String>,
}

fn yes() -> bool {
    true
}

impl Recording {
    /// The name of its first file, without the ending.
    pub fn name(&self) -> &str {
        let file = self.files.first().map_or("", String::as_str);
        file.rsplit_once('.').map_or(file, |(stem, _)| stem)
    }
}

/// A tracked marker.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Marker {
    /// Its names in the recordings.
    pub names: Vec<String>,
    /// Its position while the body is held, m.
    pub at: Point3,
    /// The point of the body that carries it, m; none on what holds the body.
    pub on: Option<Point3>,
    /// Whether its displacement is compared: not for a marker at a distance from the body that moves with the body's rotation.
    #[serde(default)]
    pub compared: bool,
}

/// Published numbers.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Published {
    /// E, Pa.
    pub youngs_modulus: Pascal,
    /// Where.
    pub source: String,
}

impl Page {
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
            .map_or(Ok(()), |slip| violation("", slip, "no fit is possible with it", "correct the page"))?;
        self.check_ranges()
    }

    /// Holds every number to the range of a test on a bench: a slip of a unit lies outside.
    fn check_ranges(&self) -> Checked {
        within("held", self.held, 1e-3..=3600.0, "s")?;
        within("modulus_time", self.modulus_time, 1e-3..=1e6, "s")?;
        within("settled", self.settled, 1e-3..=3600.0, "s")?;
        within("step", self.step, 1e-6..=1.0, "s")?;
        within("sigma", self.sigma, 1e-9..=0.1, "m")?;
        self.range.iter().try_for_each(|end| within("range", *end, 1e2..=1e12, "Pa"))?;
        self.swing.iter().try_for_each(|time| within("swing", *time, 0.0..=3600.0, "s"))?;
        for (i, recording) in self.recording.iter().enumerate() {
            within(&format!("recording.{i}.release"), recording.release, 0.0..=3600.0, "s")?;
        }
        for (i, marker) in self.marker.iter().enumerate() {
            marker.at.iter().try_for_each(|x| within(&format!("marker.{i}.at"), *x, -10.0..=10.0, "m"))?;
            marker.on.iter().flatten().try_for_each(|x| within(&format!("marker.{i}.on"), *x, -10.0..=10.0, "m"))?;
        }
        let mut published = self.published.iter();
        published.try_for_each(|p| within("published.youngs_modulus", p.youngs_modulus, 1e2..=1e12, "Pa"))
    }

    /// The first invalid entry.
    fn first_invalid(&self) -> Option<String> {
        let [low, high] = self.range;
        let rules = [
            (!(low > 0.0 && high > low), "`range` is not two rising moduli, Pa"),
            (self.folders.is_empty(), "`folders` names none"),
            (self.recording.iter().any(|r| r.files.is_empty()), "a [[recording]] has no `files`"),
            (self.marker.iter().any(|m| m.names.is_empty()), "a [[marker]] has no `names`"),
            (self.recording.is_empty(), "there is no [[recording]]"),
            (!self.recording.iter().any(|r| r.fitted), "no [[recording]] is fitted"),
            (!self.marker.iter().any(|m| m.compared && m.on.is_some()), "no [[marker]] on the body is compared"),
            (self.marker.len() < 3, "fewer than three [[marker]]s do not define a frame of reference"),
            (!(self.held > 0.0 && self.settled > 0.0), "`held` and `settled` are not positive times, s"),
            (!(self.step > 0.0 && self.sigma > 0.0), "`step` and `sigma` are not positive"),
            (!(self.swing[0] >= 0.0 && self.swing[1] > self.swing[0]), "`swing` is not two rising times, s"),
        ];
        rules.iter().find(|(broken, _)| *broken).map(|(_, message)| (*message).to_owned())
    }
}

const SEE: &str = "pipeline/sysid/examples/real has a page with every key";

#[cfg(test)]
mod tests {
    use super::*;

    const PAGE: &str = include_str!("../../examples/real/beam_ds10.toml");

    /// The diagnostic of the page with one text replaced by another.
    fn said(name: &str, from: &str, to: &str) -> String {
        let path = std::env::temp_dir().join(format!("page-{name}-{}.toml", std::process::id()));
        std::fs::write(&path, PAGE.replace(from, to)).unwrap();
        let read = Page::read(&path);
        std::fs::remove_file(&path).unwrap();
        read.map(|page| page.name).unwrap_or_else(|diagnostic| diagnostic.to_string())
    }

    #[test]
    fn the_page_that_comes_along_is_read() {
        assert_eq!(said("whole", "", ""), "beam_ds10");
    }

    /// Keys of numbers that may be negative.
    const SIGNED: &[&str] = &["at", "on"];

    #[test]
    fn every_number_is_refused_out_of_its_range_with_file_and_key() {
        let refusal = |text: &str| Page::parse(text, Path::new("page.toml")).err().map(|refusal| refusal.to_string());
        super::super::testing::hold_every_number(PAGE, SIGNED, refusal);
    }

    #[test]
    fn a_slip_of_the_pen_is_refused_with_what_it_is() {
        let slips = [
            ("sigma = 1e-4", "sigmaa = 1e-4", "sigmaa"),
            ("range = [5e4, 2e6]", "range = [2e6, 5e4]", "two rising moduli"),
            ("step = 0.00125", "step = 0.0", "not positive"),
            ("at = [0.1, -0.006, 0.024]", "at = [0.1, -1e308, 0.006]", "marker.1.at = -1e308 m is out of range"),
            ("sigma = 1e-4", "sigma = inf", "sigma = inf is not a finite number"),
            ("release = 0.71", "release = -1.0", "the range is 0 to 3600 s"),
            ("names = [\"base_1\", \"Base - 1\"]", "names = []", "has no `names`"),
            ("swing = [0.1, 1.4]", "swing = [1.4, 0.1]", "two rising times"),
            ("compared = true", "compared = false", "is compared"),
            ("along = \"z\"", "along = \"w\"", "w"),
        ];
        for (i, (from, to, expected)) in slips.into_iter().enumerate() {
            let said = said(&i.to_string(), from, to);
            assert!(said.contains(expected) && said.contains("do:"), "{said}");
        }
    }
}
