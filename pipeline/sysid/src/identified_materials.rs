//! Identified materials: the laws of a fit as a file of TOML, from which another test of the same silicone takes them.

use std::path::Path;

use diagnostics::{Diagnostic, Result, input};
use lab::range::{Checked, violation, within};
use lab::table;
use serde::{Deserialize, Serialize};
use si::{Hertz, Pascal, Second};

/// All laws that were fitted.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct IdentifiedMaterials {
    /// The name of the law that the recordings support.
    pub supported: String,
    /// The laws.
    pub law: Vec<IdentifiedMaterial>,
}

/// The constants of a law.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct IdentifiedMaterial {
    /// Its name.
    pub name: String,
    /// The law of elasticity in `materials`, of which the coefficients are.
    #[serde(default = "yeoh")]
    pub material: String,
    /// Long-term E, Pa.
    pub youngs_modulus: Pascal,
    /// C₂₀/C₁₀ and C₃₀/C₁₀.
    pub stiffening: [f64; 2],
    /// α, 1/s.
    pub mass_damping: Hertz,
    /// β, s.
    pub stiffness_damping: Second,
    /// Relaxation branches: strength over the long-term modulus, and time in s.
    pub branch: Vec<[f64; 2]>,
}

fn yeoh() -> String {
    "yeoh".to_owned()
}

/// The file of the materials that were identified on `name`.
pub(crate) fn file_of(name: &str) -> String {
    format!("real_{name}_materials.toml")
}

impl IdentifiedMaterials {
    /// The materials in the file `path`.
    ///
    /// # Errors
    /// A [`Diagnostic`] when it is not there, is no such file, or names no supported law.
    pub fn read(path: &Path) -> Result<Self> {
        let next = "run `study fit` of the body that identifies the material first, with the same --out";
        let text = input::read_text(path, input::PAGE).map_err(|e| Diagnostic::io(path, e, next))?;
        Self::parse(&text, path)
    }

    /// The materials in `text`; `path` appears only in diagnostics.
    ///
    /// # Errors
    /// A [`Diagnostic`] when a key is unknown, missing or mistyped, a number is out of range, or no law is the supported one.
    pub fn parse(text: &str, path: &Path) -> Result<Self> {
        table::parse(text, path, "`study fit` of the body that identifies the material writes such a file", Self::check)
    }

    fn check(&self) -> Checked {
        for (i, law) in self.law.iter().enumerate() {
            let key = format!("law.{i}");
            if law.name.is_empty() || self.law[..i].iter().any(|other| other.name == law.name) {
                let message = format!("the law `{}` has no name of its own", law.name);
                return violation(
                    &format!("{key}.name"),
                    message,
                    "a page names its law",
                    "give each law its own name",
                );
            }
            law.check(&key)?;
        }
        match self.law.iter().any(|law| law.name == self.supported) {
            true => Ok(()),
            false => {
                let message = format!("there is no law `{}`", self.supported);
                violation("supported", message, "it is the name of one of the laws", "name one of the laws")
            }
        }
    }

    /// The law `name`, or the supported one.
    ///
    /// # Errors
    /// A [`Diagnostic`] that lists the known laws.
    pub fn law(&self, name: Option<&str>) -> Result<&IdentifiedMaterial> {
        let name = name.unwrap_or(&self.supported);
        self.law.iter().find(|law| law.name == name).ok_or_else(|| {
            let names: Vec<&str> = self.law.iter().map(|law| law.name.as_str()).collect();
            let reason = format!("fitted laws: {}", names.join(", "));
            Diagnostic::new(format!("there is no fitted law `{name}`"), reason, "correct `law` on the page")
        })
    }
}

impl IdentifiedMaterial {
    /// Holds every constant to the range that a case allows.
    fn check(&self, key: &str) -> Checked {
        let key = |name: &str| format!("{key}.{name}");
        within(&key("youngs_modulus"), self.youngs_modulus, 1e2..=1e12, "Pa")?;
        self.stiffening.iter().try_for_each(|ratio| within(&key("stiffening"), *ratio, -10.0..=100.0, ""))?;
        within(&key("mass_damping"), self.mass_damping, 0.0..=1e6, "1/s")?;
        within(&key("stiffness_damping"), self.stiffness_damping, 0.0..=1e3, "s")?;
        within(&key("branch"), self.branch.len() as f64, 0.0..=fem::MAX_BRANCHES as f64, "branches")?;
        for (i, [strength, time]) in self.branch.iter().enumerate() {
            within(&key(&format!("branch.{i}.0")), *strength, 0.0..=1e3, "of the long-term modulus")?;
            within(&key(&format!("branch.{i}.1")), *time, 1e-9..=1e9, "s")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = "supported = \"a\"\n[[law]]\nname = \"a\"\nyoungs_modulus = 2.7e5\nstiffening = [-0.2, 0.02]\n\
        mass_damping = 0.1\nstiffness_damping = 1e-3\nbranch = [[0.1, 0.01], [0.2, 1.0]]\n";

    fn refused(text: &str) -> Option<String> {
        IdentifiedMaterials::parse(text, Path::new("bar.toml")).err().map(|refused| refused.to_string())
    }

    #[test]
    fn every_number_is_refused_out_of_its_range_with_file_and_key() {
        assert_eq!(refused(FILE), None);
        for number in diagnostics::table::numbers(FILE) {
            for value in ["nan", "inf", "-inf", "-1", "0", "1e308", "1e18", "18446744073709551615"] {
                let slip = format!("{}{value}{}", &FILE[..number.span.start], &FILE[number.span.end..]);
                let key = number.key.trim_end_matches(|c: char| c == '.' || c.is_ascii_digit());
                match refused(&slip) {
                    Some(text) => assert!(text.starts_with("bar.toml, line") && text.contains(key), "{text}"),
                    None => {
                        let zero = value == "0" && key != "law.0.youngs_modulus";
                        assert!(zero || (value == "-1" && key == "law.0.stiffening"), "{key} = {value} is accepted");
                    }
                }
            }
        }
    }

    #[test]
    fn a_law_has_a_name_of_its_own_and_the_supported_one_is_there() {
        let twice = FILE.to_owned() + FILE.split_once('\n').map_or("", |(_, law)| law);
        assert!(refused(&twice).is_some_and(|text| text.contains("no name of its own")));
        assert!(
            refused(&FILE.replace("name = \"a\"", "name = \"\"")).is_some_and(|text| text.contains("bar.toml, line 3"))
        );
        assert!(refused(&FILE.replacen("\"a\"", "\"b\"", 1)).is_some_and(|text| text.contains("there is no law `b`")));
        let many = format!("branch = [{}]", "[0.1, 0.01], ".repeat(17));
        let many = FILE.replace("branch = [[0.1, 0.01], [0.2, 1.0]]", &many);
        assert!(refused(&many).is_some_and(|text| text.contains("law.0.branch = 17 branches")));
    }

    #[test]
    fn materials_come_back_from_their_file_and_an_unknown_law_is_refused() {
        let law = |name: &str| IdentifiedMaterial {
            name: name.into(),
            material: "yeoh".into(),
            youngs_modulus: 2.7e5,
            stiffening: [-0.2, 0.02],
            mass_damping: 0.0,
            stiffness_damping: 1e-3,
            branch: vec![[0.1, 0.01]],
        };
        let all = IdentifiedMaterials { supported: "b".into(), law: vec![law("a"), law("b")] };
        let back: IdentifiedMaterials = toml::from_str(&toml::to_string(&all).unwrap()).unwrap();
        assert_eq!(back, all);
        assert_eq!(back.law(None).unwrap().name, "b");
        assert!(back.law(Some("c")).unwrap_err().to_string().contains("fitted laws: a, b"));
        let gone = IdentifiedMaterials::read(Path::new("/nowhere.toml")).unwrap_err().to_string();
        assert!(gone.contains("study fit"), "{gone}");
    }
}
