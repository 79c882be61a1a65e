//! The loss over the plane of two moduli, with the profile likelihoods of both and the pressures at which walls buckle, between the points of
//! an exhaustive search.

use optimize::Bounds;
use optimize::optimisers::grid;
use si::{Pascal, Point2};

use diagnostics::Result;
use records::{Profile, Surface};
use sysid::{Evaluated, Loss, landscape, uncertainty};

/// The landscape and the profiles, interpolated between the grid's points; given are the points an axis of the grid and of the landscape. A
/// single point without equilibrium is extrapolated from its row; where more are missing, the grid's own losses are kept. Empty where no grid
/// was searched, or not over two moduli.
///
/// # Errors
/// A [`diagnostics::Diagnostic`] when the profiles do not belong to the axes.
pub(super) fn loss_surface(
    loss: &Loss,
    evaluated: &[Evaluated],
    bounds: &Bounds,
    (grid_points, landscape_points): (usize, usize),
) -> Result<(Surface, Vec<Profile>)> {
    let [first, second] = loss.body.materials.as_slice() else {
        return Ok((Surface::default(), Vec::new()));
    };
    if evaluated.is_empty() {
        return Ok((Surface::default(), Vec::new()));
    }
    let [across, up] = [0, 1].map(|k| grid::axis_values(bounds.low[k], bounds.high[k], grid_points));
    let points: Vec<(&[f64], &[Vec<Point2>])> =
        evaluated.iter().map(|t| (t.at.as_slice(), t.markers.as_slice())).collect();
    let Some(full) = landscape::completed(&points, &across, &up) else {
        return Ok((grid_surface(loss, evaluated, &across, &up), Vec::new()));
    };
    let points: Vec<(&[f64], &[Vec<Point2>])> =
        full.iter().map(|(point, m)| (point.as_slice(), m.as_slice())).collect();
    let judge =
        |markers: &[Vec<Point2>]| vec![loss.misfit.loss(markers), loss.misfit.chi_square(markers).unwrap_or(f64::NAN)];
    let fine = landscape::between(&points, landscape_points, &judge);
    let critical = critical_pressures(evaluated, (&across, &up), (&fine.across, &fine.up));
    let moduli = &loss.model.nominal.youngs_moduli;
    let moduli_along = |axis: &[f64], k: usize| axis.iter().map(|x| moduli[k] * x.exp()).collect::<Vec<f64>>();
    let (across, up) = (moduli_along(&fine.across, 0), moduli_along(&fine.up, 1));
    let profiles = uncertainty::profiles([&first.name, &second.name], [&across, &up], &fine.values[1]);
    Ok((Surface { across, up, loss: fine.values[0].clone(), critical }, profiles))
}

fn grid_surface(objective: &Loss, evaluated: &[Evaluated], across: &[f64], up: &[f64]) -> Surface {
    let loss = |x: f64, y: f64| {
        let evaluation = evaluated.iter().find(|t| t.at == [x, y]);
        evaluation.map_or(f64::NAN, |t| objective.misfit.loss(&t.markers))
    };
    Surface {
        across: across.iter().map(|&x| objective.elastic(&[x, 0.0]).youngs_moduli[0]).collect(),
        up: up.iter().map(|&y| objective.elastic(&[0.0, y]).youngs_moduli[1]).collect(),
        loss: up.iter().flat_map(|&y| across.iter().map(move |&x| (x, y))).map(|(x, y)| loss(x, y)).collect(),
        critical: critical_pressures(evaluated, (across, up), (across, up)),
    }
}

/// The pressures at which the slack walls buckle over both moduli, between those of the grid's points, Pa; 0 where one beside it does not.
fn critical_pressures(evaluated: &[Evaluated], coarse: (&[f64], &[f64]), fine: (&[f64], &[f64])) -> Vec<Pascal> {
    let critical_pressure =
        |x: f64, y: f64| evaluated.iter().find(|t| t.at == [x, y]).and_then(|t| t.critical).unwrap_or(f64::NAN);
    landscape::linear(coarse, &critical_pressure, fine).into_iter().map(|p| if p.is_nan() { 0.0 } else { p }).collect()
}
