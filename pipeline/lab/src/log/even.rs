//! Linear interpolation of a log onto an even clock, with its error bound.

use si::Second;

use super::LogFormat;
use super::sampling::{InterpolationBound, Method, Sampling};

/// Resamples rows (time first) of an uneven log onto the even clock of `sampling`, which gains the error bounds of the columns.
///
/// Linear interpolation neither overshoots nor changes a signal that is held; the mean of a log keeps to second order.
pub(super) fn onto_even_clock<const N: usize>(
    rows: Vec<[f64; N]>,
    form: &LogFormat<N>,
    sampling: &mut Sampling,
) -> Vec<[f64; N]> {
    if sampling.method == Method::AsStamped {
        return rows;
    }
    sampling.bounds = (1..N).filter(|k| !form.held[*k]).map(|k| bound(&rows, k, form.columns[k])).collect();
    let start = rows[0][0];
    let step = 1.0 / sampling.rate_hz;
    let mut right = 1;
    let row = |i: usize| {
        let time = start + i as f64 * step;
        while right + 1 < rows.len() && rows[right][0] < time {
            right += 1;
        }
        between([&rows[right - 1], &rows[right]], &form.held, time)
    };
    (0..rows.len()).map(row).collect()
}

/// The row at `time` (s) between two rows, constant outside of them.
fn between<const N: usize>([left, right]: [&[f64; N]; 2], held: &[bool; N], time: Second) -> [f64; N] {
    let part = ((time - left[0]) / (right[0] - left[0])).clamp(0.0, 1.0);
    let at = |k: usize| match held[k] {
        // A command changed somewhere between two samples: half way on average, wherever the jitter put them.
        true => (if part < 0.5 { left } else { right })[k],
        // exact where both are equal: a held pressure stays what it is
        false => left[k] + part * (right[k] - left[k]),
    };
    let mut row = [time; N];
    (1..N).for_each(|k| row[k] = at(k));
    row
}

/// h²/8 |f″| of a column.
fn bound<const N: usize>(rows: &[[f64; N]], k: usize, column: &str) -> InterpolationBound {
    let slope = |pair: &[[f64; N]]| (pair[1][k] - pair[0][k]) / (pair[1][0] - pair[0][0]);
    let one = |three: &[[f64; N]]| {
        let long = (three[1][0] - three[0][0]).max(three[2][0] - three[1][0]);
        let second = 2.0 * (slope(&three[1..]) - slope(&three[..2])) / (three[2][0] - three[0][0]);
        0.125 * long * long * second.abs()
    };
    let each: Vec<f64> = rows.windows(3).map(one).collect();
    let square: f64 = each.iter().map(|b| b * b).sum();
    InterpolationBound {
        column: column.to_owned(),
        rms: (square / each.len().max(1) as f64).sqrt(),
        max: each.iter().copied().fold(0.0, f64::max),
    }
}
