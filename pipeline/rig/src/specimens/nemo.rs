//! Nemo: nine chambers a side, the softer silicone.
//!
//! Stands on: `shape`'s parametric tail. Never knows: its own hidden moduli.

use shape::tail::Tail;

use crate::specimen::Specimen;

/// The first specimen.
pub const NEMO: Specimen = Specimen { name: "nemo", tail };

/// The outer shape is the lab's tail. The walls are set so that 200 mbar on one side move the tip by about 20 mm at
/// E = 0.16 MPa, and so that the slack wall of the other side does not buckle at the moduli that a search may try.
fn tail() -> Tail {
    Tail { wall: [3.5e-3; 2], rib: 3.0e-3, ..Tail::nine_chambers() }
}
