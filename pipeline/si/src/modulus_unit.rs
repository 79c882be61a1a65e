//! The unit in which a modulus is printed.

use crate::Pascal;

/// Moduli from here on are printed in GPa: elastomers lie below, plastics above.
const STIFF: Pascal = 1e8;

/// The unit in which a modulus is printed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModulusUnit {
    /// One Pa in it.
    pub scale: f64,
    /// "MPa" or "GPa".
    pub unit: &'static str,
}

impl ModulusUnit {
    /// Of a modulus.
    pub fn of(modulus: Pascal) -> Self {
        if modulus < STIFF { Self { scale: 1e-6, unit: "MPa" } } else { Self { scale: 1e-9, unit: "GPa" } }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn silicone_is_printed_in_mpa_and_acetal_in_gpa() {
        assert_eq!([2e5, 4e9].map(|modulus| ModulusUnit::of(modulus).unit), ["MPa", "GPa"]);
    }
}
