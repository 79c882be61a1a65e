//! Errors of an inflated model's walls.

use lab::truth;
use mesh::wall::{Walls, buckling_pressure};
use si::Pascal;

use super::{Virtual, true_relaxation};
use diagnostics::Result;
use records::{Identified, Inflation, WallErrors};
use workflow::needs::Every;
use workflow::subject::Name;

/// Walls of a true body by pressure, Pa, and the errors of its model's.
pub(super) type WallComparison = (Vec<(Pascal, Walls)>, Option<WallErrors>);

/// The walls of the true body by pressure, Pa, and the errors of those of the model; none where a wall of either does not buckle.
// The true shapes are those after all relaxation. A shape follows from pressure over modulus, the sheet's share aside, so under that multiple
// of its pressure each is also the shape at the time of the identified moduli.
pub(super) fn wall_comparison(
    specimen: &Virtual,
    truth: &truth::Truth,
    (Every(identified), inflated): (&Every<Identified>, &[(Name, Inflation)]),
) -> Result<WallComparison> {
    let identified = identified.iter().find(|(s, _)| s.0 == specimen.name);
    let inflation = inflated.iter().find(|(s, _)| s.0 == specimen.name);
    let hidden = truth.inflation.iter().find(|inflation| Some(&inflation.channel) == specimen.inflated.as_ref());
    let (Some((_, identified)), Some((_, inflation)), Some(hidden)) = (identified, inflation, hidden) else {
        return Ok(Default::default());
    };
    let stiffer = true_relaxation(&truth.body)?.modulus(identified.modulus_time);
    let pressures: Vec<Pascal> = hidden.pressure.iter().map(|p| stiffer * p).collect();
    let (dent, x, bulge) = (&hidden.dent, &hidden.dent_at, &hidden.bulge);
    let walls_at = |i: usize| Walls { dent_m: dent[i], dent_at: [x[i], 0.0, 0.0], bulge_m: bulge[i] };
    let true_walls = pressures.iter().enumerate().map(|(i, pressure)| (*pressure, walls_at(i))).collect();
    let highest = inflation.shapes.iter().rfind(|shape| pressures.last().is_some_and(|top| shape.pressure() <= *top));
    let critical = (inflation.buckling_pressure(), buckling_pressure(&pressures, &hidden.dent));
    let ((Some(model), Some(body)), Some(shape)) = (critical, highest) else { return Ok((true_walls, None)) };
    let at_shape = |values: &[f64]| interpolated(&pressures, values, shape.pressure());
    let errors = WallErrors {
        critical_pressure_pa: model - body,
        hidden_critical_pressure_pa: body,
        dent: shape.walls.dent_m / at_shape(&hidden.dent) - 1.0,
        dent_at_m: shape.walls.dent_at[0] - at_shape(&hidden.dent_at),
        bulge: shape.walls.bulge_m / at_shape(&hidden.bulge) - 1.0,
        rotation: shape.rotation - at_shape(&hidden.rotation),
    };
    Ok((true_walls, Some(errors)))
}

/// The value of `values` at pressure `p` (Pa) between two of the rising `pressures`.
fn interpolated(pressures: &[Pascal], values: &[f64], p: Pascal) -> f64 {
    let above = pressures.partition_point(|q| *q < p).clamp(1, pressures.len() - 1);
    let fraction = (p - pressures[above - 1]) / (pressures[above] - pressures[above - 1]);
    values[above - 1] + fraction * (values[above] - values[above - 1])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hidden_value_is_read_linearly_between_pressures() {
        let (pressures, values) = ([0.0, 100.0, 300.0], [1.0, 3.0, 11.0]);
        let read = [0.0, 50.0, 100.0, 150.0, 300.0].map(|p| interpolated(&pressures, &values, p));
        assert_eq!(read, [1.0, 2.0, 3.0, 5.0, 11.0]);
    }
}
