//! A torus of 60 mm with edges of 4 mm: number of tetrahedra, smallest angle, volume against 2 π² R r².

use std::f64::consts::TAU;

use tetrahedralize::{Fill, Part, Refusal, Settings, tetrahedralize};

fn torus(large: f64, small: f64, [around, across]: [u32; 2]) -> Part {
    let place = |i: u32, j: u32| {
        let (u, v) = (TAU * f64::from(i) / f64::from(around), TAU * f64::from(j) / f64::from(across));
        let radius = large + small * v.cos();
        [radius * u.cos(), radius * u.sin(), small * v.sin()]
    };
    let number = |i: u32, j: u32| (i % around) * across + j % across;
    let points = (0..around).flat_map(|i| (0..across).map(move |j| place(i, j))).collect();
    let quads = (0..around).flat_map(|i| (0..across).map(move |j| [i, j]));
    let halves = |[i, j]: [u32; 2]| {
        let [a, b, c, d] = [number(i, j), number(i + 1, j), number(i + 1, j + 1), number(i, j + 1)];
        [[a, b, c], [a, c, d]]
    };
    Part { points, faces: quads.flat_map(halves).collect(), fill: Fill::Region(0) }
}

#[allow(clippy::print_stdout)]
fn main() -> Result<(), Refusal> {
    let (large, small) = (0.022, 0.008);
    let solid = tetrahedralize(&[torus(large, small, [96, 48])], &Settings::new(4e-3))?;
    let least = solid.smallest_angles().into_iter().fold(f64::INFINITY, f64::min).to_degrees();
    let exact = TAU * std::f64::consts::PI * large * small * small;
    println!(
        "{} tetrahedra, smallest angle {least:.1}°, volume {:.4} of 2π²Rr²",
        solid.tets.len(),
        solid.volume(0) / exact
    );
    Ok(())
}
