//! A shallow arch of two bars (von Mises' truss) under a force on its top: the path through both limit points, at which the arch would snap, against the
//! exact ones at the heights ± h/√3.

use continuation::{CriticalKind, PathSettings, Problem, follow};

/// Half span and height (m), stiffness E A / l₀³ times half span squared is of no matter: forces are over it.
const HEIGHT: f64 = 0.1;

/// One unknown: the descent of the top, m. To third order its force is u (h − u)(2h − u), here over that at the first limit.
struct Arch {
    tangent: f64,
}

impl Arch {
    fn limit() -> f64 {
        let descent = HEIGHT * (1.0 - 1.0 / 3.0_f64.sqrt());
        descent * (HEIGHT - descent) * (2.0 * HEIGHT - descent)
    }
}

impl Problem for Arch {
    fn dofs(&self) -> usize {
        1
    }

    fn size(&self) -> f64 {
        HEIGHT
    }

    fn start(&self) -> Vec<f64> {
        vec![0.0]
    }

    fn residual(&mut self, u: &[f64], load_factor: f64) -> Option<Vec<f64>> {
        Some(vec![u[0] * (HEIGHT - u[0]) * (2.0 * HEIGHT - u[0]) / Self::limit() - load_factor])
    }

    fn load(&mut self, _: &[f64], _: f64) -> Vec<f64> {
        vec![1.0]
    }

    fn factorise(&mut self, u: &[f64], _: f64, _: Option<&[f64]>) -> Option<usize> {
        self.tangent = (3.0 * u[0].powi(2) - 6.0 * HEIGHT * u[0] + 2.0 * HEIGHT.powi(2)) / Self::limit();
        (self.tangent != 0.0).then_some(usize::from(self.tangent < 0.0))
    }

    fn solve(&mut self, x: &mut [f64]) {
        x[0] /= self.tangent;
    }
}

/// # Errors
/// When the path cannot be followed.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let settings = PathSettings { load_factors: [0.0, 2.0], ..PathSettings::default() };
    let path = follow(&mut Arch { tangent: 1.0 }, &settings, &mut |_| {})?;
    let limits: Vec<_> = path.critical.iter().filter(|point| point.kind == CriticalKind::LimitPoint).collect();
    limits.iter().for_each(|point| {
        println!("limit at {:+.6} of the load, descent {:.6} m", point.load_factor, point.displacement[0])
    });
    assert!(
        limits.len() == 2 && (limits[0].load_factor - 1.0).abs() < 1e-6 && (limits[1].load_factor + 1.0).abs() < 1e-6
    );
    Ok(())
}
