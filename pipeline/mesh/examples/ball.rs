//! A ball, given as triangles, in tetrahedra: volume against the formula, and the worst angle between two faces of an element.

use mesh::{ElementChoice, Method, Settings, Surface, mesh_chosen};

const RADIUS: f64 = 0.02;
const ROWS: u32 = 24;
const COLUMNS: u32 = 48;

/// The ball's surface: rings of points between two poles, normals outwards.
fn surface() -> Surface {
    let point = |row: u32, column: u32| {
        let [polar, turn] = [(row, ROWS, 0.5), (column, COLUMNS, 1.0)]
            .map(|(number, count, part)| part * std::f64::consts::TAU * f64::from(number) / f64::from(count));
        [RADIUS * polar.sin() * turn.cos(), RADIUS * polar.sin() * turn.sin(), RADIUS * polar.cos()]
    };
    let rings = (1..ROWS).flat_map(|row| (0..COLUMNS).map(move |column| point(row, column)));
    let points: Vec<[f64; 3]> = [point(0, 0), point(ROWS, 0)].into_iter().chain(rings).collect();
    let number = |row: u32, column: u32| 2 + (row - 1) * COLUMNS + column % COLUMNS;
    let caps = (0..COLUMNS)
        .flat_map(|c| [[0, number(1, c), number(1, c + 1)], [1, number(ROWS - 1, c + 1), number(ROWS - 1, c)]]);
    let squares = (1..ROWS - 1).flat_map(|row| (0..COLUMNS).map(move |column| (row, column)));
    let halves = squares.flat_map(|(row, c)| {
        let [a, b, d, e] = [number(row, c), number(row + 1, c), number(row + 1, c + 1), number(row, c + 1)];
        [[a, b, d], [a, d, e]]
    });
    Surface { points, faces: caps.chain(halves).collect() }
}

/// # Errors
/// When the ball cannot be meshed.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let settings = Settings { method: Method::General, use_symmetry: false, ..Settings::new(5e-3) };
    let ball = mesh_chosen(&surface(), None, &settings, ElementChoice::Tetrahedra)?;
    let volume = 4.0 / 3.0 * std::f64::consts::PI * RADIUS.powi(3);
    let (elements, angle) = (ball.solid.elements.len(), ball.report.min_dihedral_deg);
    println!(
        "{elements} elements, volume {:.4} of the ball's, smallest angle {angle:.1}°",
        ball.report.volume_body / volume
    );
    // the surface is a polyhedron inside the ball
    assert!((ball.report.volume_body / volume - 1.0).abs() < 0.02 && angle > 5.0);
    Ok(())
}
