//! The page beside a reduced tail's file: all that a stranger needs to step it, with any language that reads safetensors.

use crate::data::{Chamber, Output, TwinData};
use crate::error::TwinError;
use crate::layout::{Array, Counts};
use crate::twin::Twin;

/// Fraction of a chamber's highest pressure at which the page states where outputs go.
const PART: f64 = 0.1;
/// Steps, and their length (s), in which that pressure is reached and held.
const STEPS: (usize, f64) = (100, 0.05);

impl TwinData {
    /// The page of the tail: axes, chambers with their ranges and what each moves, outputs, equations, integrator, arrays, provenance.
    ///
    /// # Errors
    /// [`TwinError`] when the arrays do not belong together, or the tail finds no step to a tenth of its pressures.
    pub fn page(&self) -> Result<String, TwinError> {
        let line = |array: &Array| {
            format!("{:20} {:14} {:20} {}\n", array.name, format!("{:?}", array.shape), array.unit, array.meaning)
        };
        let arrays: String = Counts::of_data(self).arrays().iter().map(line).collect();
        let provenance: String = self.provenance.iter().map(|(key, value)| format!("  {key}: {value}\n")).collect();
        let regions: Vec<&str> = self.regions.iter().map(|region| &*region.name).collect();
        Ok(format!(
            "A reduced tail: arrays of 64-bit floating-point numbers in SI units, rows first.\n\nPROVENANCE\n{provenance}\n\
             {AXES}{}\nCHAMBERS\n{}\nOUTPUTS, at rest (m)\n{}\nREGIONS, in the order of their arrays: {}\n\n{EQUATIONS}\n{}\n{INTEGRATOR}\n\
             ARRAYS\n{:20} {:14} {:20} meaning\n{arrays}",
            symmetry(self.half),
            self.chamber_lines()?,
            self.outputs.iter().map(output_line).collect::<String>(),
            regions.join(", "),
            medium(self.sections.len()),
            "array",
            "shape",
            "unit",
        ))
    }

    /// A line for each chamber: number, name, range, and how far a tenth of its highest pressure moves the last point.
    fn chamber_lines(&self) -> Result<String, TwinError> {
        let twin = Twin::new(Self { sections: Vec::new(), ..self.clone() })?;
        let line = |(number, chamber): (usize, &Chamber)| {
            let [low, high] = chamber.range;
            let range = match chamber.range == Chamber::UNLIMITED {
                true => "no range is known".to_owned(),
                false => format!("reduced under {low} to {high} Pa; {}", effect(&twin, number, PART * high)?),
            };
            Ok(format!("  {number}  {}: {range}\n", chamber.name))
        };
        self.chambers.iter().enumerate().map(line).collect()
    }
}

/// Where a lasting pressure (Pa) in one chamber moves the last two outputs, in words.
fn effect(twin: &Twin, chamber: usize, pressure: f64) -> Result<String, TwinError> {
    let (mut state, mut pressures) = (twin.start(), vec![0.0; twin.chambers.len()]);
    let (steps, duration) = STEPS;
    for step in 1..=steps {
        pressures[chamber] = pressure * (2.0 * step as f64 / steps as f64).min(1.0);
        twin.step(&mut state, &pressures, duration)?;
    }
    let outputs: Vec<&str> = twin.outputs().collect();
    let last = outputs.len().saturating_sub(2)..outputs.len();
    let moved = last.map(|number| format!("{} by {:+.3} mm", outputs[number], 1e3 * twin.output(&state, number)));
    Ok(format!("{pressure:.0} Pa held move {}", moved.collect::<Vec<_>>().join(" and ")))
}

fn output_line(output: &Output) -> String {
    format!("  {:12} {:+.6}\n", output.name, output.at_rest)
}

fn symmetry(half: bool) -> &'static str {
    if half {
        "  Half of a symmetric body is modelled: volumes of chambers and forces of the water are those of the half.\n"
    } else {
        ""
    }
}

fn medium(sections: usize) -> &'static str {
    if sections == 0 {
        "  This tail moves in air: there are no sections, and Q = 0.\n"
    } else {
        "  This tail moves in still water. In air, leave the sections out: Q = 0.\n"
    }
}

const AXES: &str = "\
AXES
  x from the clamp along the tail, y across it in the plane of the film, z out of that plane; metres. An output is the displacement of its
  point along the axis that its name ends in.
";

/// The equations that the arrays belong to.
const EQUATIONS: &str = "\
EQUATIONS

  M q'' + sum_points w G^T P(F) = sum_chambers p dV/dq + Q          F = I + G q

  P   stress dpsi/dF of the energy psi = mu/2 x + C20 x^2 + C30 x^3 + lambda/2 (ln J)^2 with x = tr(F^T F) - 3 - 2 ln J, J = det F:
      P = (mu + 4 C20 x + 6 C30 x^2) (F - F^-T) + lambda ln J F^-T, and the overstress of the branches, F H
  H   of Maxwell branches: S = I - (F^T F)^-1 drives each, Q_b' + Q_b/time = strength dS/dt, H = mu sum_b Q_b
  V   volume of a chamber: at_rest + linear q + quadratic q q / 2 + cubic q q q / 6; row (i, j) of cubic, i <= j in the order 00, 01, .. 0r, 11, ..,
      holds the third derivatives by q_i, q_j and each q
  Q   of still water: with tangent t = (1, 0) + slope q, normal n = (-t_y, t_x), velocity v = value q', w = v.n, u = v.t, sum over sections of
      value^T (-d/dt(by_0 w n) - by_1 |w| w n + by_3 (u w n - w^2 t / 2)) - slope^T by_2 (u w n - w^2 t / 2)

Column c of F, rows r: entry 3 c + r of each nine. Pressures are in Pa, one per chamber; displacements are outputs times q, in m.
";

const INTEGRATOR: &str = "\
HOW TO STEP
  From rest, q = q' = 0 and all Q_b = 0. With even steps h: q'_n = (3 q_n - 4 q_n-1 + q_n-2) / 2h and the same for q'' from q' and for the rate
  of the water's momentum (BDF2); the first step is implicit Euler's, (q_1 - q_0) / h. The pressures of a step are those at its end.
  Over a step Q_b <- d Q_b + a (S_n - S_n-1) with d = exp(-h/time), a = strength (1 - d) time / h.
  The equations at the end of a step are solved for q_n by Newton's method until no entry of q changes by more than 1e-6 size.
  240 steps a second were compared with the whole body; a controller may take 1000.
  Pressures outside the range of a chamber are refused: the shapes that they give were never seen. `excursion` of the crate is the largest
  entry of q over size: above 1 the tail is larger than anything it was reduced from.

HOW TO BUILD
  On x86-64 the crate needs AVX2 and FMA, for its speed and so that each build gives the same bits: `.cargo/config.toml` beside it has the
  flags. A crate that depends on it takes them into a `.cargo/config.toml` of its own; the build says so where they are missing.
  `c/` has a header and a shared library for C; Python: softfish.Twin(\"tail.safetensors\").
";

#[cfg(test)]
mod tests {
    use crate::example::beam;

    #[test]
    fn the_page_names_every_array_chamber_and_output_and_what_pressure_does() {
        let page = beam(true).page().unwrap();
        let lines = [
            "region0.gradients    [80, 7, 9]",
            "sections.by          [13, 4]",
            "  tip_x        +0.100000",
            "still water",
        ];
        for line in lines.into_iter().chain(["  0  left: reduced under 0 to 80000 Pa; 8000 Pa held move tip_x by"]) {
            assert!(page.contains(line), "{line}\n{page}");
        }
        let sign = |chamber: &str| page.lines().find(|line| line.contains(chamber)).unwrap().contains("tip_y by +");
        assert!(sign("0  left") && !sign("1  right"), "a pressure in either chamber bends the beam away from it");
    }
}
