//! Homotopies: families of loads that begin where an equilibrium is known, at s = 0, and end with the load asked for, at
//! s = 1 [allgower2003].

use crate::inputs::AppliedLoad;
use crate::newton::potential::Inertia;
use si::Pascal;

/// A family of loads that ends with these pressures (Pa) and the whole dead load.
pub(super) enum Homotopy<'a> {
    /// From rest, load stepping: s times all loads.
    Rest(&'a [Pascal]),
    /// From any shape, the Newton homotopy: all loads less (1 − s) times the force that is unbalanced at that shape
    /// (3 entries per node, N).
    Shape(&'a [Pascal], Vec<f64>),
}

/// The loads at one s.
pub(super) struct Loads {
    pub pressures: Vec<Pascal>,
    load_factor: f64,
    added: Option<Inertia>,
}

impl Homotopy<'_> {
    /// The loads at `s`.
    pub(crate) fn loads_at(&self, s: f64) -> Loads {
        match self {
            Self::Rest(pressures) => {
                let pressures = pressures.iter().map(|pressure| s * pressure).collect();
                Loads { pressures, load_factor: s, added: None }
            }
            Self::Shape(pressures, unbalanced) => {
                let history = unbalanced.iter().map(|force| (s - 1.0) * force).collect();
                let centre = vec![0.0; unbalanced.len()];
                let added = (s < 1.0).then_some(Inertia { rate: 0.0, centre, history });
                Loads { pressures: pressures.to_vec(), load_factor: 1.0, added }
            }
        }
    }
}

impl Loads {
    pub(crate) fn applied_load(&self) -> AppliedLoad<'_> {
        AppliedLoad { pressures: &self.pressures, load_factor: self.load_factor, added: self.added.as_ref() }
    }
}
