//! A lens from twelve views of a checkerboard: its corners are projected through a known lens, calibration finds that lens, and says how well.

use track::board::Board;
use track::calibrate::{View, calibrate};
use track::lens::{Distortion, Lens};
use track::pose::Pose;

const SIZE: (usize, usize) = (1280, 720);

/// # Errors
/// When the views do not determine the lens.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let board = Board { columns: 9, rows: 6, square: 0.012 };
    let hidden = Lens { fx: 980.0, fy: 983.0, cx: 646.0, cy: 361.0, k1: -0.11, k2: 0.03, ..Lens::default() };
    let corners = board.corner_points();
    // poses 0.2 m before the board, tilted by a quarter of a radian to all sides; noise of some hundredths of a pixel
    let view = |number: usize| {
        let turn = std::f64::consts::TAU * number as f64 / 12.0;
        let pose = Pose::from_vector([0.25 * turn.cos(), 0.25 * turn.sin(), 0.1 * turn], [-0.04, -0.025, 0.2]);
        let noise =
            |corner: usize, axis: usize| 0.05 * (12.9 * (corner + 7 * axis) as f64 + 78.2 * number as f64).sin();
        let seen = |(corner, &at)| {
            let [x, y] = hidden.project(pose.apply(at))?;
            Some([x + noise(corner, 0), y + noise(corner, 1)])
        };
        Some(View::of_whole_board(corners.iter().enumerate().map(seen).collect::<Option<_>>()?))
    };
    let views: Vec<View> = (0..12).map(view).collect::<Option<_>>().ok_or("a corner is not seen")?;
    let calibration = calibrate(&views, &corners, Distortion::default(), SIZE)?;
    let (found, sigma) = (calibration.lens, calibration.sigma());
    println!("fx = {:.2} ± {:.2} px (hidden {})", found.fx, sigma[0], hidden.fx);
    println!("k1 = {:.4} ± {:.4} (hidden {})", found.k1, sigma[4], hidden.k1);
    assert!(
        (found.fx - hidden.fx).abs() < 2.0 && (found.cx - hidden.cx).abs() < 2.0 && (found.k1 - hidden.k1).abs() < 0.01
    );
    Ok(())
}
