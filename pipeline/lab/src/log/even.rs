//! An uneven log on an even clock: by linear interpolation with its error bound, or, where its samples were taken evenly and stamped late, as
//! it is.

use si::Second;

use super::evenness::{EvenClock, taken_evenly};
use super::sampling::{InterpolationBound, Method, Sampling, Stamps};
use super::{ColumnFormat, LogFormat};

/// Rows (time first) of a log on an even clock, of which `sampling` then says rate, method and error bounds.
pub(super) fn onto_even_clock(
    rows: Vec<Vec<f64>>,
    (format, stamps): (&LogFormat, &Stamps),
    sampling: &mut Sampling,
) -> Vec<Vec<f64>> {
    if sampling.method == Method::AsStamped {
        return rows;
    }
    match taken_evenly(&rows, format, stamps) {
        Some(clock) => restamp_rows(rows, clock, sampling),
        None => interpolate_rows(&rows, format, sampling),
    }
}

/// The samples as they are, on the clock on which they were taken.
fn restamp_rows(mut rows: Vec<Vec<f64>>, clock: EvenClock, sampling: &mut Sampling) -> Vec<Vec<f64>> {
    (sampling.method, sampling.rate_hz) = (Method::EvenSampling, 1.0 / clock.step);
    rows.iter_mut().enumerate().for_each(|(i, row)| row[0] = clock.sample_time(i));
    rows
}

/// The samples between the stamped ones, on the even clock of `sampling`, which gains the error bounds of the columns.
///
/// Linear interpolation neither overshoots nor changes a signal that is held; the mean of a log keeps to second order.
fn interpolate_rows(rows: &[Vec<f64>], format: &LogFormat, sampling: &mut Sampling) -> Vec<Vec<f64>> {
    let continuous = format.columns.iter().enumerate().skip(1).filter(|(_, column)| !column.held);
    sampling.bounds = continuous.map(|(k, column)| interpolation_bound(rows, k, &column.title)).collect();
    let start = rows[0][0];
    let step = 1.0 / sampling.rate_hz;
    let mut right = 1;
    let row = |i: usize| {
        let time = start + i as f64 * step;
        while right + 1 < rows.len() && rows[right][0] < time {
            right += 1;
        }
        interpolated_row([&rows[right - 1], &rows[right]], &format.columns, time)
    };
    (0..rows.len()).map(row).collect()
}

/// The row at `time` (s) between two rows, constant outside of them.
fn interpolated_row([left, right]: [&[f64]; 2], columns: &[ColumnFormat], time: Second) -> Vec<f64> {
    let fraction = ((time - left[0]) / (right[0] - left[0])).clamp(0.0, 1.0);
    let value_at = |k: usize| match columns[k].held {
        // A command changed somewhere between two samples: half way on average, wherever the jitter put them.
        true => (if fraction < 0.5 { left } else { right })[k],
        // exact where both are equal: a held pressure stays what it is
        false => left[k] + fraction * (right[k] - left[k]),
    };
    std::iter::once(time).chain((1..columns.len()).map(value_at)).collect()
}

/// h²/8 |f″| of a column.
fn interpolation_bound(rows: &[Vec<f64>], k: usize, column: &str) -> InterpolationBound {
    let slope = |pair: &[Vec<f64>]| (pair[1][k] - pair[0][k]) / (pair[1][0] - pair[0][0]);
    let step_bound = |samples: &[Vec<f64>]| {
        let longest_step = (samples[1][0] - samples[0][0]).max(samples[2][0] - samples[1][0]);
        let curvature = 2.0 * (slope(&samples[1..]) - slope(&samples[..2])) / (samples[2][0] - samples[0][0]);
        0.125 * longest_step * longest_step * curvature.abs()
    };
    let bounds: Vec<f64> = rows.windows(3).map(step_bound).collect();
    let sum_of_squares: f64 = bounds.iter().map(|b| b * b).sum();
    InterpolationBound {
        column: column.to_owned(),
        rms: (sum_of_squares / bounds.len().max(1) as f64).sqrt(),
        max: bounds.iter().copied().fold(0.0, f64::max),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_command_is_that_of_the_nearest_sample_and_a_measured_quantity_is_interpolated() {
        let range = (0.0, 1e5, "Pa");
        let columns = [ColumnFormat::time(), ColumnFormat::command("a", range), ColumnFormat::measured("b", range)];
        let at = |time| interpolated_row([&[1.0, 10.0, 10.0], &[3.0, 20.0, 20.0]], &columns, time);
        assert_eq!([at(1.5), at(2.5)], [[1.5, 10.0, 12.5], [2.5, 20.0, 17.5]]);
        assert_eq!([at(0.0), at(4.0)], [[0.0, 10.0, 10.0], [4.0, 20.0, 20.0]]);
    }

    #[test]
    fn the_error_of_interpolation_is_bounded_by_the_curvature_over_the_longer_step() {
        // 3 t² has f″ = 6: h²/8 · 6 with the longer step beside each inner sample, 2 s, 2 s and 3 s
        let rows: Vec<Vec<f64>> =
            [10.0_f64, 11.0, 13.0, 14.0, 17.0].iter().map(|t| vec![*t, 7.0, 3.0 * t * t]).collect();
        let found = interpolation_bound(&rows, 2, "force_n");
        assert!((found.max - 6.75).abs() < 1e-9, "{found:?}");
        assert!((found.rms - ((9.0 + 9.0 + 6.75 * 6.75) / 3.0_f64).sqrt()).abs() < 1e-9, "{found:?}");
        // a line is interpolated without error, however uneven the steps
        let line = interpolation_bound(&rows, 1, "force_n");
        assert_eq!((line.max, line.rms, line.column.as_str()), (0.0, 0.0, "force_n"));
    }
}
