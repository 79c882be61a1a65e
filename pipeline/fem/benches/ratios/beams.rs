//! Two hollow beams with ribs, chambers on both sides and a stiff sheet in the middle plane; their upper halves.

use crate::Outcome;
use fem::{Clamps, Mesh, RegionProperties, System, box_mesh, materials};

/// Boundaries of the long beam's layers across, m: wall, chamber, silicone, sheet, silicone, chamber, wall.
const ACROSS: [f64; 10] = [-0.010, -0.008, -0.0045, -0.001, -0.00025, 0.00025, 0.001, 0.0045, 0.008, 0.010];
/// And upwards from the middle, m: channel, chamber, wall.
const UP: [f64; 6] = [0.0, 0.002, 0.006, 0.010, 0.014, 0.016];

/// Nine pitches of 10 mm, each of so many cells: for 10-node elements, one through each layer.
pub fn slender(cells: usize) -> Mesh {
    let along = 9 * cells + 1;
    let air = move |[i, j, k]: [usize; 3]| {
        let side = (1..3).contains(&j) || (6..8).contains(&j);
        side && k < 4 && i > 0 && i + 1 < along && (!i.is_multiple_of(cells) || k < 1)
    };
    let place = move |at: [f64; 3]| {
        let x = at[0] * along as f64;
        let (pitch, step) = ((x / cells as f64).floor(), x % cells as f64);
        let inside = if step <= 1.0 { 0.0025 * step } else { 0.0025 + 0.0075 * (step - 1.0) / (cells as f64 - 1.0) };
        [0.010 * pitch + inside, ACROSS[(9.0 * at[1]).round() as usize], UP[(5.0 * at[2]).round() as usize]]
    };
    let region = move |cell: [usize; 3]| if air(cell) { None } else { Some(u16::from(cell[1] == 4)) };
    box_mesh::grid([along, 9, 5], true, place, region)
}

/// Boundaries of the fine beam's layers across and upwards from the middle, m.
const FINE_ACROSS: [f64; 16] = [
    -0.0120, -0.0110, -0.0100, -0.0078, -0.0056, -0.0034, -0.0012, -0.00025, 0.00025, 0.0012, 0.0034, 0.0056, 0.0078,
    0.0100, 0.0110, 0.0120,
];
const FINE_UP: [f64; 10] = [0.0, 0.0016, 0.0032, 0.0048, 0.0064, 0.0080, 0.0096, 0.0112, 0.0126, 0.0140];
/// A rib, and seven cells of chamber.
const PITCH: usize = 8;
const CELL: f64 = 0.00125;

/// Eleven chambers a side in cells of about 2 mm: for 4-node elements, the size that DiffPD was measured at.
pub fn fine() -> Mesh {
    let along = 11 * PITCH + 1;
    let air = move |[i, j, k]: [usize; 3]| {
        let side = (2..6).contains(&j) || (9..13).contains(&j);
        let inside = k < 7 && i > 0 && i + 1 < along;
        side && inside && (!i.is_multiple_of(PITCH) || k < 2)
    };
    let place = move |at: [f64; 3]| {
        let (y, z) = ((15.0 * at[1]).round() as usize, (9.0 * at[2]).round() as usize);
        [CELL * along as f64 * at[0], FINE_ACROSS[y], FINE_UP[z]]
    };
    let region = move |cell: [usize; 3]| if air(cell) { None } else { Some(u16::from(cell[1] == 7)) };
    box_mesh::grid([along, 15, 9], true, place, region)
}

/// A beam of silicone with a sheet `ratio` times as stiff, clamped at its end.
pub fn system(mesh: Mesh, ratio: f64) -> Outcome<System> {
    let material = materials::by_name("corotated").ok_or("no such material")?;
    let silicone = RegionProperties::elastic(material, 2e5, 0.45, 1070.0);
    let sheet =
        RegionProperties { youngs_modulus: ratio * 2e5, poissons_ratio: 0.37, density: 1410.0, ..silicone.clone() };
    let clamps = Clamps::below_x(&mesh, 1e-9);
    Ok(System::new(mesh, vec![silicone, sheet], clamps)?)
}
