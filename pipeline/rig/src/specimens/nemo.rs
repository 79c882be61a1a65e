//! Nemo: nine chambers a side, the softer silicone.
//!
//! Stands on: `shape`'s parametric tail. Never knows: its own hidden moduli.

use shape::tail::Tail;

use crate::specimen::Specimen;

/// The first specimen.
pub const NEMO: Specimen = Specimen { name: "nemo", tail };

/// The outer shape is the lab's tail. Walls and sheet are set so that 200 mbar on one side move the tip by 18 mm, and 500 mbar do
/// so by 15 mm in the stiffer silicone. The first chamber is longer than the others: near the clamp its slack wall
/// leaves its shape from 250 mbar on, and there is a shape up to 290 mbar.
pub fn tail() -> Tail {
    Tail {
        wall: [1.85e-3; 2],
        rib: 3.0e-3,
        inner_wall: 0.5e-3,
        top_wall: 1.85e-3,
        sheet: 0.69e-3,
        slot_share: 0.3,
        first_longer: 3.0e-3,
        ..Tail::nine_chambers()
    }
}
