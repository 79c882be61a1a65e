//! Ranges of constants and pressures over which a reduced model is trained, as they are written on a command line.

use std::str::FromStr;

use fem::Parameter;
use serde::Serialize;

use crate::body::Body;
use crate::case::Case;
use diagnostics::{Diagnostic, Result};

/// A range with its name: `E.body=1e5..3e5`, `nu.body=0.45..0.49`, `air=0..3e4`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NamedRange {
    /// What varies.
    pub name: String,
    /// Its least value.
    pub low: f64,
    /// Its greatest value.
    pub high: f64,
}

impl FromStr for NamedRange {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parts = text.split_once('=').and_then(|(name, range)| Some((name.trim(), range.split_once("..")?)));
        let number = |part: &str| part.trim().parse::<f64>().ok().filter(|value| value.is_finite());
        let (name, (low, high)) = parts.ok_or("write NAME=LOW..HIGH")?;
        let (Some(low), Some(high)) = (number(low), number(high)) else {
            return Err("LOW and HIGH are numbers, in Pa for moduli and pressures".into());
        };
        if low > high || name.is_empty() {
            return Err("LOW is at most HIGH, and NAME is not empty".into());
        }
        Ok(Self { name: name.into(), low, high })
    }
}

impl NamedRange {
    /// The value at `part` (0 to 1) of the range.
    pub(super) fn value_at(&self, part: f64) -> f64 {
        self.low + part * (self.high - self.low)
    }

    /// The constant of the body that it is of.
    ///
    /// # Errors
    /// A [`Diagnostic`] when there is no such region, or the range leaves what a solid can have.
    pub(super) fn as_parameter(&self, body: &Body) -> Result<Parameter> {
        let (kind, region) = self.name.split_once('.').unwrap_or((&self.name, ""));
        let is_named = |region_of_mesh: &mesh::foreign::Region| {
            region_of_mesh.name.as_deref() == Some(region)
                || region_of_mesh.tag.to_string() == region
                || region.is_empty() && body.regions.len() == 1
        };
        let names = || {
            body.regions
                .iter()
                .map(|region_of_mesh| region_of_mesh.name.clone().unwrap_or_else(|| region_of_mesh.tag.to_string()))
        };
        let refused = |reason: String| {
            let choices: Vec<String> = names().flat_map(|name| [format!("E.{name}"), format!("nu.{name}")]).collect();
            let action = format!("give one of {}", choices.join(", "));
            Diagnostic::new(format!("a reduced model is not trained over `{}`", self.name), reason, action)
        };
        let index = body.regions.iter().position(is_named).ok_or_else(|| refused("no region has this name".into()))?;
        match kind {
            "E" if self.low > 0.0 => Ok(Parameter::YoungsModulus(index)),
            "E" => Err(refused(format!("a modulus of {} Pa is not above 0", self.low))),
            "nu" if self.low > -1.0 && self.high < 0.5 => Ok(Parameter::PoissonsRatio(index)),
            "nu" => Err(refused("Poisson's ratio lies between -1 and 0.5".into())),
            _ => Err(refused("constants are moduli E and Poisson's ratios nu".into())),
        }
    }
}

/// The range of pressures of each chamber of the mesh; of those that `given` does not name, none but 0.
///
/// # Errors
/// A [`Diagnostic`] when the case has no chamber of that name.
pub(super) fn by_chamber(given: &[NamedRange], case: &Case, body: &Body) -> Result<Vec<NamedRange>> {
    let unmoved = |number: usize| NamedRange { name: number.to_string(), low: 0.0, high: 0.0 };
    let mut ranges: Vec<NamedRange> = (0..body.cavities.len()).map(unmoved).collect();
    for range in given {
        let named = case.chamber.iter().zip(&body.numbers);
        let mut of_case =
            named.filter(|(chamber, _)| chamber.name.as_ref() == Some(&range.name)).map(|(_, number)| *number);
        let by_number = || range.name.parse::<usize>().ok().filter(|number| *number < ranges.len());
        let number = of_case.next().or_else(by_number).ok_or_else(|| {
            let known_names: Vec<&str> = case.chamber.iter().filter_map(|chamber| chamber.name.as_deref()).collect();
            let reason = format!("the case names {}, and the mesh closes {}", known_names.join(", "), ranges.len());
            Diagnostic::new(
                format!("there is no chamber `{}`", range.name),
                reason,
                "give its name, or its number in the mesh",
            )
        })?;
        ranges[number] = range.clone();
    }
    Ok(ranges)
}
