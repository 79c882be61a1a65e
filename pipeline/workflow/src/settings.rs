//! Settings from `study.toml`, one section a stage.
//!
//! Plain sections are the paper profile; a section under `[quick]` or `[population]` overrides single keys of it. Nothing else differs
//! between the profiles.

use std::path::Path;

use serde::Deserialize;
use serde::de::DeserializeOwned;
use toml::{Table, Value};

use diagnostics::{Diagnostic, Result, table};

/// Which set of settings, and so which folders.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Profile {
    /// Full resolution; its figures and tables are tracked.
    Paper,
    /// Coarse and short, for tests and continuous integration; its folders are under `target/quick`.
    Quick,
    /// Coarse, for many specimens of one design; its folders are under `target/population`.
    Population,
}

impl Profile {
    /// Every profile.
    pub const ALL: [Profile; 3] = [Profile::Paper, Profile::Quick, Profile::Population];

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Profile::Paper => "paper",
            Profile::Quick => "quick",
            Profile::Population => "population",
        }
    }
}

/// The settings of one profile.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    sections: Table,
    renamed: &'static [Renamed],
}

/// The allowed sections and keys.
#[derive(Debug, Clone, Copy)]
pub struct Schema<'a> {
    /// The names of the sections.
    pub sections: &'a [&'a str],
    /// Sections and keys under their former names, which are refused with the new one.
    pub renamed: &'static [Renamed],
}

/// A section or key that has another name now.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Renamed {
    /// The section, by its present name; empty for a section itself.
    pub section: &'static str,
    /// The former name.
    pub old: &'static str,
    /// The present name.
    pub new: &'static str,
}

/// The name under which the settings are refused.
pub const FILE: &str = "study.toml";
/// Where their keys are explained.
pub const SEE: &str = "CONTRIBUTING.md says where each section's keys are documented";

impl Settings {
    /// Reads `study.toml` for a profile; `schema` lists its sections.
    ///
    /// # Errors
    /// A [`Diagnostic`] that names the line, a number of any profile that is not finite, or the unknown section and the nearest known ones.
    pub fn read(text: &str, profile: Profile, schema: Schema) -> Result<Self> {
        let mut table: Table = toml::from_str(text).map_err(|e| table::toml_error(text, Path::new(FILE), &e, SEE))?;
        table::check_finite(text, Path::new(FILE), SEE)?;
        for other_profile in Profile::ALL.into_iter().filter(|p| *p != Profile::Paper) {
            match table.remove(other_profile.name()) {
                Some(Value::Table(overrides)) if other_profile == profile => lay_over(&mut table, overrides),
                Some(Value::Table(_)) | None => {}
                Some(value) => return Err(no_section(other_profile, &value)),
            }
        }
        match table.keys().find(|name| !schema.sections.contains(&name.as_str())) {
            Some(name) => Err(unknown_section(name, schema)),
            None => Ok(Self { sections: table, renamed: schema.renamed }),
        }
    }

    /// One stage's section as its own type.
    ///
    /// # Errors
    /// A [`Diagnostic`] when a key is unknown, missing or of another type.
    pub fn section<T: DeserializeOwned>(&self, name: &str) -> Result<T> {
        let section = self.sections.get(name).cloned().unwrap_or_else(|| Value::Table(Table::new()));
        if let Some(renamed) = self.renamed.iter().find(|r| r.section == name && section.get(r.old).is_some()) {
            let Renamed { old, new, .. } = renamed;
            let problem = format!("study.toml, [{name}] has the key `{old}`");
            return Err(Diagnostic::new(problem, format!("it is called `{new}`"), format!("rename it to `{new}`")));
        }
        section.try_into().map_err(|e: toml::de::Error| {
            Diagnostic::new(
                format!("study.toml, [{name}] is not understood"),
                e.to_string().trim_end(),
                format!("correct the key; {SEE}"),
            )
        })
    }
}

/// A profile that is no section.
fn no_section(profile: Profile, value: &Value) -> Diagnostic {
    let name = profile.name();
    let problem = format!("{FILE}: `{name}` is no section, but of the type {}", value.type_str());
    let reason = format!("[{name}] has sections, whose keys stand for those of the paper profile");
    Diagnostic::new(problem, reason, format!("name the section of the key, as in [{name}.mesh]"))
}

fn lay_over(below: &mut Table, above: Table) {
    for (key, value) in above {
        match (below.get_mut(&key), value) {
            (Some(Value::Table(old)), Value::Table(new)) => lay_over(old, new),
            (_, value) => {
                below.insert(key, value);
            }
        }
    }
}

fn unknown_section(name: &str, schema: Schema) -> Diagnostic {
    let problem = format!("study.toml has a section [{name}] that no stage reads");
    match schema.renamed.iter().find(|r| r.section.is_empty() && r.old == name) {
        Some(Renamed { new, .. }) => {
            Diagnostic::new(problem, format!("it is called [{new}]"), format!("rename it to [{new}]"))
        }
        None => {
            Diagnostic::new(problem, format!("known sections: {}", schema.sections.join(", ")), "rename or remove it")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Deserialize, PartialEq, Debug)]
    #[serde(deny_unknown_fields)]
    struct Mesh {
        edge: f64,
        keep: bool,
    }

    const SCHEMA: Schema = Schema {
        sections: &["mesh"],
        renamed: &[
            Renamed { section: "", old: "grid", new: "mesh" },
            Renamed { section: "mesh", old: "size", new: "edge" },
        ],
    };
    const TEXT: &str =
        "[mesh]\nedge = 0.002\nkeep = true\n[quick.mesh]\nedge = 0.004\n[population.mesh]\nkeep = false\n";

    #[test]
    fn other_profiles_than_the_paper_s_override_single_keys_only() {
        let mesh = |profile| Settings::read(TEXT, profile, SCHEMA).unwrap().section::<Mesh>("mesh").unwrap();
        assert_eq!(mesh(Profile::Quick), Mesh { edge: 0.004, keep: true });
        assert_eq!(mesh(Profile::Paper), Mesh { edge: 0.002, keep: true });
        assert_eq!(mesh(Profile::Population), Mesh { edge: 0.002, keep: false });
    }

    #[test]
    fn a_profile_that_is_no_section_is_refused_in_every_profile() {
        for text in ["quick = 3\n", "population = \"coarse\"\n", "[[quick]]\nedge = 1.0\n"] {
            for profile in Profile::ALL {
                let refused = Settings::read(text, profile, SCHEMA).unwrap_err().to_string();
                assert!(refused.contains("[quick.mesh]") || refused.contains("[population.mesh]"), "{refused}");
            }
        }
    }

    #[test]
    fn an_unknown_section_or_key_is_refused_by_name() {
        let section = Settings::read("[mush]\n", Profile::Paper, SCHEMA).unwrap_err();
        assert!(section.what.contains("[mush]"));
        let key = Settings::read("[mesh]\nedge = 1.0\nkeep = true\nhedge = 2.0\n", Profile::Paper, SCHEMA).unwrap();
        assert!(key.section::<Mesh>("mesh").unwrap_err().why.contains("hedge"));
    }

    #[test]
    fn a_number_that_is_not_finite_is_refused_in_every_profile() {
        for number in ["nan", "inf", "-inf", "1e400"] {
            let text = TEXT.replace("0.004", number);
            for profile in Profile::ALL {
                let refused = Settings::read(&text, profile, SCHEMA).unwrap_err().to_string();
                assert!(refused.starts_with("study.toml, line 5: quick.mesh.edge"), "{refused}");
            }
        }
    }

    #[test]
    fn a_wrong_line_and_a_value_of_a_wrong_type_are_refused_with_file_and_key() {
        let line = Settings::read(&TEXT.replace("0.004", "["), Profile::Paper, SCHEMA).unwrap_err().to_string();
        assert!(line.starts_with("study.toml, line "), "{line}");
        let typed = Settings::read(&TEXT.replace("0.002", "'x'"), Profile::Paper, SCHEMA).unwrap();
        let typed = typed.section::<Mesh>("mesh").unwrap_err().to_string();
        assert!(typed.contains("study.toml") && typed.contains("`edge`"), "{typed}");
    }

    #[test]
    fn a_former_name_is_refused_with_the_new_one() {
        let section = Settings::read("[grid]\n", Profile::Paper, SCHEMA).unwrap_err();
        assert!(section.action.contains("[mesh]"), "{section}");
        let key = Settings::read("[mesh]\nsize = 1.0\nkeep = true\n", Profile::Paper, SCHEMA).unwrap();
        assert!(key.section::<Mesh>("mesh").unwrap_err().action.contains("`edge`"));
    }
}
