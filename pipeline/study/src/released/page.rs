//! The page of a release: which recordings, which case, what is compared.
//!
//! Stands on: serde, lab (its refusals). Never knows: a solver, a recording's numbers.

use std::path::{Path, PathBuf};

use lab::Refusal;
use lab::table::refused;
use serde::Deserialize;
use si::{Pascal, Point3, Second};

use crate::case::Axis;

/// Everything that a page says.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Page {
    /// What the results are called.
    pub name: String,
    /// The case, with `[static]`, whose loads act once the body is let go; relative to the page.
    pub case: String,
    /// Laws that are fitted, one after the other, to the case's first region.
    pub laws: Vec<String>,
    /// Lowest and highest Young's modulus that is tried, Pa.
    pub range: [Pascal; 2],
    /// Where recordings may lie, relative to the project's folder; the first place that has them is taken.
    pub folders: Vec<PathBuf>,
    /// The axis along which the body falls.
    pub along: Axis,
    /// It is held straight for so long at the beginning, s.
    pub held: Second,
    /// It rests for so long at the end, s.
    pub settled: Second,
    /// The swing that is compared, from and to, s after the release.
    pub swing: [Second; 2],
    /// Step of the simulated motion, s.
    pub step: Second,
    /// Deviation of a measured displacement, m.
    pub sigma: f64,
    /// Films or tracks of the same release.
    pub recording: Vec<Recording>,
    /// What is seen on the body and on what holds it.
    pub marker: Vec<Marker>,
    /// What was published of it.
    pub published: Option<Published>,
}

/// One release.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Recording {
    /// Tracks as `.csv` or `.c3d`; the first that lies there is read.
    pub files: Vec<String>,
    /// When the body is let go, s.
    pub release: Second,
    /// Where the last of `files` can be fetched.
    pub source: Option<String>,
    /// Its BLAKE3.
    pub blake3: Option<String>,
}

/// A mark that is followed.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Marker {
    /// Its names in the recordings.
    pub names: Vec<String>,
    /// Where it is while the body is held, m.
    pub at: Point3,
    /// The point of the body that carries it, m; none on what holds the body.
    pub on: Option<Point3>,
    /// Whether its fall is compared: not where the body's turning moves a mark that stands off it.
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
    /// [`Refusal`] when it cannot be read, has an unknown or missing key, or a number that makes no sense.
    pub fn read(path: &Path) -> Result<Self, Refusal> {
        let text = std::fs::read_to_string(path).map_err(|e| Refusal::io(path, &e, "name a page of TOML"))?;
        let page: Self = toml::from_str(&text).map_err(|e| refused(&text, path, &e, SEE))?;
        match page.slip() {
            Some(slip) => Err(Refusal::file(path, slip, "nothing could be fitted so", "correct the page")),
            None => Ok(page),
        }
    }

    /// The first thing that makes no sense.
    fn slip(&self) -> Option<String> {
        let [low, high] = self.range;
        let rules = [
            (!(low > 0.0 && high > low), "`range` is not two rising moduli, Pa"),
            (self.laws.is_empty(), "`laws` names none"),
            (self.recording.is_empty(), "there is no [[recording]]"),
            (!self.marker.iter().any(|m| m.compared && m.on.is_some()), "no [[marker]] on the body is compared"),
            (self.marker.len() < 3, "fewer than three [[marker]]s tell no frame of reference"),
            (!(self.held > 0.0 && self.settled > 0.0), "`held` and `settled` are not positive times, s"),
            (!(self.step > 0.0 && self.sigma > 0.0), "`step` and `sigma` are not positive"),
            (!(self.swing[0] >= 0.0 && self.swing[1] > self.swing[0]), "`swing` is not two rising times, s"),
        ];
        rules.iter().find(|(broken, _)| *broken).map(|(_, what)| (*what).to_owned())
    }
}

const SEE: &str = "pipeline/study/examples/real holds a page with every key";

#[cfg(test)]
mod tests {
    use super::*;

    const PAGE: &str = include_str!("../../examples/real/beam_ds10.toml");

    /// What is said of the page with one text in place of another.
    fn said(name: &str, from: &str, to: &str) -> String {
        let path = std::env::temp_dir().join(format!("page-{name}-{}.toml", std::process::id()));
        std::fs::write(&path, PAGE.replace(from, to)).unwrap();
        let read = Page::read(&path);
        std::fs::remove_file(&path).unwrap();
        read.map(|page| page.name).unwrap_or_else(|refusal| refusal.to_string())
    }

    #[test]
    fn the_page_that_comes_along_is_read() {
        assert_eq!(said("whole", "", ""), "beam_ds10");
    }

    #[test]
    fn a_slip_of_the_pen_is_refused_with_what_it_is() {
        let slips = [
            ("sigma = 1e-4", "sigmaa = 1e-4", "sigmaa"),
            ("range = [5e4, 2e6]", "range = [2e6, 5e4]", "two rising moduli"),
            ("step = 0.0025", "step = 0.0", "not positive"),
            ("swing = [0.1, 1.4]", "swing = [1.4, 0.1]", "two rising times"),
            ("compared = true", "compared = false", "is compared"),
            ("along = \"z\"", "along = \"w\"", "w"),
        ];
        for (i, (from, to, told)) in slips.into_iter().enumerate() {
            let said = said(&i.to_string(), from, to);
            assert!(said.contains(told) && said.contains("do:"), "{said}");
        }
    }
}
