//! Colours by role: a colour has the same meaning in every figure.
//!
//! The hues are those of \[okabe2008\], which remain distinct with the common kinds of colour blindness. The colour map of
//! heat maps is viridis \[vanderwalt2015\]: perceptually uniform, and its lightness increases monotonically.

/// A colour of the screen: red, green, blue, 0 to 255.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Colour(pub u8, pub u8, pub u8);

const BLUE: Colour = Colour(0, 114, 178);
const ORANGE: Colour = Colour(230, 159, 0);
const GREEN: Colour = Colour(0, 158, 115);
const PURPLE: Colour = Colour(204, 121, 167);
const VERMILLION: Colour = Colour(213, 94, 0);
const SKY: Colour = Colour(86, 180, 233);

/// Text, axes and measurements.
pub const BLACK: Colour = Colour(26, 26, 26);
/// Secondary text.
pub const MUTED: Colour = Colour(105, 105, 105);
/// Grid lines.
pub const FAINT: Colour = Colour(228, 228, 228);
/// The paper.
pub const PAPER: Colour = Colour(255, 255, 255);
/// A missing value.
pub(crate) const MISSING: Colour = Colour(200, 200, 200);

/// Measurements.
pub const MEASURED: Colour = BLACK;
/// Simulations.
pub const SIMULATED: Colour = BLUE;
/// The soft body.
pub const BODY: Colour = SKY;
/// The stiff sheet in its middle.
pub const SPINE: Colour = VERMILLION;
/// Air under pressure.
pub const PRESSURE: Colour = ORANGE;
/// A displacement beside a force.
pub const DISPLACEMENT: Colour = SKY;
/// The neural network.
pub const NETWORK: Colour = GREEN;
/// Elongated-body theory.
pub const ELONGATED_BODY: Colour = PURPLE;
/// A trivial baseline.
pub(crate) const BASELINE: Colour = Colour(95, 95, 95);
/// The optimum.
pub const OPTIMUM: Colour = Colour(214, 39, 40);

/// The colour of an optimiser by its name; [`BLACK`] for an unknown one.
pub fn method(name: &str) -> Colour {
    match name {
        "adam" => VERMILLION,
        "grid" => BASELINE,
        "gauss_newton" => GREEN,
        "cma_es" => PURPLE,
        _ => BLACK,
    }
}

/// Colours by index (specimens, pressures); they repeat after six.
pub fn series(index: usize) -> Colour {
    [BLUE, ORANGE, GREEN, PURPLE, VERMILLION, SKY][index % 6]
}

/// Viridis at nine equidistant points, dark to light.
const VIRIDIS: [Colour; 9] = [
    Colour(68, 1, 84),
    Colour(71, 44, 122),
    Colour(59, 81, 139),
    Colour(44, 113, 142),
    Colour(33, 144, 141),
    Colour(39, 173, 129),
    Colour(92, 200, 99),
    Colour(170, 220, 50),
    Colour(253, 231, 37),
];

/// The heat map's colour at a fraction 0 to 1 of the range; low is dark.
pub fn heat(part: f64) -> Colour {
    let position = part.clamp(0.0, 1.0) * (VIRIDIS.len() - 1) as f64;
    let lower = (position.floor() as usize).min(VIRIDIS.len() - 2);
    VIRIDIS[lower].towards(VIRIDIS[lower + 1], position - lower as f64)
}

impl Colour {
    /// Linear interpolation to another colour, 0 to 1.
    pub fn towards(self, other: Self, part: f64) -> Self {
        let mix = |a: u8, b: u8| (f64::from(a) * (1.0 - part) + f64::from(b) * part).round() as u8;
        Self(mix(self.0, other.0), mix(self.1, other.1), mix(self.2, other.2))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Linear light of a colour, 0 to 1.
    fn linear(c: Colour) -> [f64; 3] {
        [c.0, c.1, c.2].map(|v| (f64::from(v) / 255.0).powf(2.2))
    }

    /// The colour as seen without red (or green) cones (Viénot, Brettel and Mollon 1999), in linear light.
    fn seen(c: Colour, matrix: [[f64; 3]; 3]) -> [f64; 3] {
        let l = linear(c);
        matrix.map(|row| (row[0] * l[0] + row[1] * l[1] + row[2] * l[2]).max(0.0).powf(1.0 / 2.2) * 255.0)
    }

    const FULL: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    const NO_RED: [[f64; 3]; 3] = [[0.11238, 0.88762, 0.0], [0.11238, 0.88762, 0.0], [0.00401, -0.00401, 1.0]];
    const NO_GREEN: [[f64; 3]; 3] = [[0.29275, 0.70725, 0.0], [0.29275, 0.70725, 0.0], [-0.02234, 0.02234, 1.0]];

    #[test]
    fn colours_of_one_panel_differ_with_protanopia_and_deuteranopia() {
        let methods = ["grid", "cma_es", "adam", "gauss_newton"].map(method);
        let sets: [&[Colour]; 4] = [
            &[MEASURED, SIMULATED, PRESSURE],
            &[MEASURED, NETWORK, ELONGATED_BODY, DISPLACEMENT],
            &methods,
            &[BODY, SPINE, BLACK],
        ];
        for (set, eye) in sets.iter().flat_map(|s| [FULL, NO_RED, NO_GREEN].map(|eye| (s, eye))) {
            for (i, a) in set.iter().enumerate() {
                for b in &set[i + 1..] {
                    let (p, q) = (seen(*a, eye), seen(*b, eye));
                    let apart = (0..3).map(|k| (p[k] - q[k]).powi(2)).sum::<f64>().sqrt();
                    assert!(apart > 25.0, "{a:?} and {b:?} are {apart:.0} apart");
                }
            }
        }
    }

    #[test]
    fn the_lightness_of_the_heat_map_increases_monotonically() {
        let light = |i: i32| {
            let l = linear(heat(f64::from(i) / 64.0));
            0.2126 * l[0] + 0.7152 * l[1] + 0.0722 * l[2]
        };
        assert!((1..=64).all(|i| light(i) > light(i - 1)));
    }
}
