//! Settings: what a reader of the paper could question, one section a stage, from `study.toml`.
//!
//! Plain sections are the paper profile; a section under `[quick]` overrides single keys of it. Nothing else differs
//! between the two profiles.
//!
//! Stands on: toml. Never knows: what a setting means.

use serde::de::DeserializeOwned;
use toml::{Table, Value};

use crate::fault::{Fault, Outcome};

/// Which set of settings, and so which folders.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Profile {
    /// Full resolution; its figures and tables are tracked.
    Paper,
    /// Coarse and short, for a first look and for continuous integration; lives under `target/quick`.
    Quick,
}

impl Profile {
    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Profile::Paper => "paper",
            Profile::Quick => "quick",
        }
    }
}

/// The settings of one profile.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    sections: Table,
}

impl Settings {
    /// Reads `study.toml` for a profile; `sections` are the names that may stand in it.
    ///
    /// # Errors
    /// A [`Fault`] that names the line, or the unknown section and the nearest known ones.
    pub fn read(text: &str, profile: Profile, sections: &[&str]) -> Outcome<Self> {
        let mut table: Table = text.parse().map_err(|e| {
            Fault::new("study.toml cannot be read", format!("{e}").trim_end(), "correct the line that it names")
        })?;
        let quick = table.remove("quick");
        if let (Profile::Quick, Some(Value::Table(over))) = (profile, quick) {
            lay_over(&mut table, over);
        }
        match table.keys().find(|name| !sections.contains(&name.as_str())) {
            Some(name) => Err(unknown_section(name, sections)),
            None => Ok(Self { sections: table }),
        }
    }

    /// One stage's section as its own type.
    ///
    /// # Errors
    /// A [`Fault`] when a key is unknown, missing or of another type.
    pub fn section<T: DeserializeOwned>(&self, name: &str) -> Outcome<T> {
        let section = self.sections.get(name).cloned().unwrap_or_else(|| Value::Table(Table::new()));
        section.try_into().map_err(|e: toml::de::Error| {
            Fault::new(
                format!("study.toml, [{name}] is not understood"),
                e.to_string().trim_end(),
                "correct the key; CONTRIBUTING.md says where each section's keys are documented",
            )
        })
    }
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

fn unknown_section(name: &str, known: &[&str]) -> Fault {
    Fault::new(
        format!("study.toml has a section [{name}] that no stage reads"),
        format!("known sections: {}", known.join(", ")),
        "rename or remove it",
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde::Deserialize;

    #[derive(Deserialize, PartialEq, Debug)]
    #[serde(deny_unknown_fields)]
    struct Mesh {
        edge: f64,
        keep: bool,
    }

    const TEXT: &str = "[mesh]\nedge = 0.002\nkeep = true\n[quick.mesh]\nedge = 0.004\n";

    #[test]
    fn the_quick_profile_overrides_single_keys_only() {
        let quick = Settings::read(TEXT, Profile::Quick, &["mesh"]).unwrap();
        let paper = Settings::read(TEXT, Profile::Paper, &["mesh"]).unwrap();
        assert_eq!(quick.section::<Mesh>("mesh").unwrap(), Mesh { edge: 0.004, keep: true });
        assert_eq!(paper.section::<Mesh>("mesh").unwrap(), Mesh { edge: 0.002, keep: true });
    }

    #[test]
    fn an_unknown_section_or_key_is_refused_by_name() {
        let section = Settings::read("[mush]\n", Profile::Paper, &["mesh"]).unwrap_err();
        assert!(section.what.contains("[mush]"));
        let key = Settings::read("[mesh]\nedge = 1.0\nkeep = true\nhedge = 2.0\n", Profile::Paper, &["mesh"]).unwrap();
        assert!(key.section::<Mesh>("mesh").unwrap_err().what.contains("hedge"));
    }
}
