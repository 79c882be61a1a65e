//! Nemo: nine chambers a side, the softer silicone.
//!
//! Stands on: `shape`'s parametric tail. Never knows: its own hidden moduli.

use shape::tail::Tail;

use crate::specimen::Specimen;

/// The first specimen.
pub const NEMO: Specimen = Specimen { name: "nemo", tail };

/// The outer shape is the lab's tail; the walls are set so that about 200 mbar on one side moves the tip by about 20 mm.
fn tail() -> Tail {
    Tail { wall: [3.5e-3; 2], rib: 3.0e-3, ..Tail::nine_chambers() }
}
