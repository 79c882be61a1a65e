//! Dory: twelve chambers a side, the softer silicone.
//!
//! Stands on: `shape`'s parametric tail. Never knows: its own hidden moduli.

use shape::tail::Tail;

use crate::specimen::Specimen;

/// The second specimen.
pub const DORY: Specimen = Specimen { name: "dory", tail };

/// Nemo's outer shape and sheet. The walls are set so that 350 mbar on one side move the tip by 17 mm and 500 mbar are borne.
fn tail() -> Tail {
    Tail {
        wall: [3.8e-3; 2],
        rib: 2.5e-3,
        inner_wall: 0.5e-3,
        top_wall: 2.9e-3,
        sheet: 0.69e-3,
        slot_share: 0.3,
        ..Tail::twelve_chambers()
    }
}
