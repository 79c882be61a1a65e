//! Identified materials: the laws of a fit as a file of TOML, from which another test of the same silicone takes them.

use std::path::Path;

use diagnostics::{Diagnostic, Result, input};
use lab::table::toml_error;
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
        toml::from_str(&text).map_err(|e| toml_error(&text, path, &e, next))
    }

    /// The law `name`, or the supported one.
    ///
    /// # Errors
    /// A [`Diagnostic`] that lists the known laws.
    pub fn law(&self, name: Option<&str>) -> Result<&IdentifiedMaterial> {
        let name = name.unwrap_or(&self.supported);
        self.law.iter().find(|law| law.name == name).ok_or_else(|| {
            let known: Vec<&str> = self.law.iter().map(|law| law.name.as_str()).collect();
            let why = format!("fitted laws: {}", known.join(", "));
            Diagnostic::new(format!("there is no fitted law `{name}`"), why, "correct `law` on the page")
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn materials_come_back_from_their_file_and_an_unknown_law_is_refused() {
        let law = |name: &str| IdentifiedMaterial {
            name: name.into(),
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
