//! Spikes of an amplifier: samples of a force that are no force.
//!
//! A converter that is read while it converts, or whose input is open for a moment, gives its full scale, 2ⁿ − 1 or −2ⁿ, or some other
//! number far from all others, for a sample or two. The value is left out: the line between its neighbours stands for it, so that the clock stays even. A
//! step, a tap and its ringing, and an input that stays at full scale have neighbours that moved too, and are kept.

use std::path::Path;

use diagnostics::Diagnostic;
use serde::{Deserialize, Serialize};

use super::Rows;
use super::parabola::fit_parabola;

/// A sample that is left out.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Spike {
    /// Its line.
    pub line: usize,
    /// The number in the file.
    pub value: f64,
    /// Bits of the converter whose full scale it is; none of a lone jump.
    pub bits: Option<u32>,
}

/// What of the second column of a log is no reading.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) enum Spikes {
    /// Everything is a reading.
    #[default]
    None,
    /// Numbers at full scale alone: a tap may be as short as a sample.
    FullScale,
    /// Those, and lone jumps.
    LoneJumps,
}

/// Bits of converters, with a sign and without, whose full scale no reading meets by chance.
const BITS: [u32; 6] = [16, 18, 20, 22, 24, 32];
/// Every bit of a word that is read from an open line.
const OPEN: f64 = -1.0;
/// Samples that a spike lasts at most; a tap may be as long.
const LONGEST: usize = 2;
/// The same at full scale: five spikes among 600 samples stand three in a row in one log of 5,000.
const LONGEST_AT_FULL_SCALE: usize = 3;
/// Samples on either side that must not have moved: a fixture rings for longer after a tap.
const QUIET: usize = 6;
/// A lone jump exceeds the standard deviation of the noise by so many times, and all that the other samples span: one reading in 10⁹ does.
const JUMP: f64 = 6.0;
/// How far neighbours may have moved, of the jump.
const MOVED: f64 = 0.1;
/// Second differences after a tap exceed those before it by so many times: of a beat of forty samples they grow less within [`QUIET`].
const ONSET: f64 = 3.0;
/// Lone jumps among the samples of a log at most, no unit: what comes more often belongs to what was measured.
const RARE: f64 = 0.02;

impl Spikes {
    /// Leaves spikes out of the second column of rows, which has `factor` times the file's numbers.
    pub(super) fn leave_out(self, rows: &mut [Vec<f64>], lines: &[usize], factor: f64) -> Vec<Spike> {
        if self == Self::None {
            return Vec::new();
        }
        let values: Vec<f64> = rows.iter().map(|row| row[1] / factor).collect();
        let mut bits = full_scales(&values);
        let is_counts = values.iter().all(|v| is_whole(*v));
        let is_open = |v: &f64| is_counts && v.round() == OPEN;
        // length: a number of bits for each value
        let mut left_out: Vec<bool> = bits.iter().zip(&values).map(|(bits, v)| bits.is_some() || is_open(v)).collect();
        let at_full_scale = left_out.clone();
        let is_short = |run: &std::ops::Range<usize>| {
            run.len() <= LONGEST_AT_FULL_SCALE && stands_out(&values, &at_full_scale, run)
        };
        left_out.fill(false);
        marked_runs(&at_full_scale).filter(is_short).for_each(|run| left_out[run].fill(true));
        // length: a number of bits and a mark for each value
        bits.iter_mut().zip(&left_out).filter(|(_, is_out)| !**is_out).for_each(|(bits, _)| *bits = None);
        if self == Self::LoneJumps {
            lone_jumps(&values, &left_out).into_iter().for_each(|i| left_out[i] = true);
        }
        bridge_runs(rows, &left_out);
        let value = |i: usize| if is_whole(values[i]) { values[i].round() } else { values[i] };
        let spike = |i: usize| Spike { line: lines[i], value: value(i), bits: bits[i] };
        (0..left_out.len()).filter(|i| left_out[*i]).map(spike).collect()
    }
}

/// Refuses a force whose readings stay at full scale, or at the number by which a program marks readings that it lacks: what it was is not known.
/// The second column of `rows` has `factor` times the file's numbers; `path` appears only in diagnostics.
///
/// # Errors
/// [`Diagnostic`] with the first line and the number of readings.
pub(super) fn check_saturation(spikes: Spikes, rows: &Rows, (path, factor): (&Path, f64)) -> Result<(), Diagnostic> {
    if spikes != Spikes::LoneJumps {
        return Ok(());
    }
    let values: Vec<f64> = rows.rows.iter().map(|row| row[1] / factor).collect();
    let is_saturated: Vec<bool> = full_scales(&values).iter().map(Option::is_some).collect();
    let is_missing: Vec<bool> = values.iter().map(|v| is_placeholder(*v)).collect();
    let run_of = |marked: &[bool], longest: usize| {
        marked_runs(marked).find(|run| run.len() > longest && run.clone().all(|i| values[i] == values[run.start]))
    };
    let (run, reason) = match (run_of(&is_saturated, LONGEST_AT_FULL_SCALE), run_of(&is_missing, LONGEST)) {
        (Some(run), _) => (run, "that is the full scale of the amplifier: the force was beyond it, or its cable open"),
        (None, Some(run)) => (run, "such a number stands for a reading that is missing"),
        (None, None) => return Ok(()),
    };
    let defect = format!("the force stays at {} for {} samples", values[run.start].round(), run.len());
    let action = "cut the log there, or record the trial again";
    Err(Diagnostic::file(path, defect, reason, action).at_line(rows.lines[run.start]))
}

/// Whether a number is one by which programs mark what is missing: nines alone.
fn is_placeholder(value: f64) -> bool {
    let digits = value.abs().round().to_string();
    is_whole(value) && digits.len() >= 4 && digits.bytes().all(|digit| digit == b'9')
}

/// Whether a number that was scaled and divided by its scale is whole but for rounding.
fn is_whole(value: f64) -> bool {
    (value - value.round()).abs() <= 1e-9 * value.abs().max(1.0)
}

/// Of each value the bits of the converter whose full scale it is: in a column of whole numbers none of which lies beyond.
fn full_scales(values: &[f64]) -> Vec<Option<u32>> {
    if !values.iter().all(|v| is_whole(*v)) {
        return vec![None; values.len()];
    }
    let span = |fold: fn(f64, f64) -> f64| values.iter().copied().fold(0.0, fold).round();
    let ends = [span(f64::max), span(f64::min)];
    let scales = |bits: u32| {
        let half = 2_f64.powi(bits as i32 - 1);
        [half - 1.0, 2.0 * half - 1.0, -half]
    };
    let bits = |v: f64| BITS.into_iter().find(|bits| scales(*bits).contains(&v.round()) && ends.contains(&v.round()));
    values.iter().map(|v| bits(*v)).collect()
}

/// Runs of marked samples.
fn marked_runs(marked: &[bool]) -> impl Iterator<Item = std::ops::Range<usize>> {
    let is_start = |i: usize| marked[i] && (i == 0 || !marked[i - 1]);
    let run_end = |start: usize| start + marked[start..].iter().take_while(|mark| **mark).count();
    (0..marked.len()).filter(move |i| is_start(*i)).map(move |start| start..run_end(start))
}

/// Places around a run that are not marked.
fn neighbour_places(count: usize, marked: &[bool], run: &std::ops::Range<usize>) -> Vec<usize> {
    let preceding = (0..run.start).rev().filter(|i| !marked[*i]).take(QUIET);
    let following = (run.end..count).filter(|i| !marked[*i]).take(QUIET);
    preceding.chain(following).collect()
}

/// Values around a run that are not marked.
fn neighbour_values(values: &[f64], marked: &[bool], run: &std::ops::Range<usize>) -> Vec<f64> {
    neighbour_places(values.len(), marked, run).into_iter().map(|i| values[i]).collect()
}

/// Whether the values beside a run stay on their course, against its jump: that of a level, or of the parabola through them, which a beat
/// follows over so few samples. A step and what rings have none.
fn stands_out(values: &[f64], marked: &[bool], run: &std::ops::Range<usize>) -> bool {
    let neighbours = neighbour_places(values.len(), marked, run);
    let level = median_value(neighbours.iter().map(|i| values[*i]).collect());
    let keep_course = |course: &dyn Fn(usize) -> f64| {
        let jump = run.clone().map(|i| (values[i] - course(i)).abs()).fold(f64::INFINITY, f64::min);
        neighbours.iter().all(|i| (values[*i] - course(*i)).abs() <= MOVED * jump) && jump > 0.0
    };
    let place = |i: usize| i as f64 - run.start as f64;
    keep_course(&|_| level)
        || has_both_sides(&neighbours, run)
            && fit_parabola(neighbours.iter().map(|i| (place(*i), values[*i])))
                .is_some_and(|[a, b, c]| keep_course(&|i| a + place(i) * (b + place(i) * c)))
}

/// A parabola beyond its samples is a guess.
fn has_both_sides(neighbours: &[usize], run: &std::ops::Range<usize>) -> bool {
    let preceding = neighbours.iter().filter(|i| **i < run.start).count();
    preceding >= QUIET / 2 && neighbours.len() - preceding >= QUIET / 2
}

/// Samples that jump alone; `left_out` is left out already.
fn lone_jumps(values: &[f64], left_out: &[bool]) -> Vec<usize> {
    let sigma = noise_sigma(values, left_out);
    let threshold = JUMP * sigma;
    let height = |i: usize| (values[i] - median_value(neighbour_values(values, left_out, &(i..i + 1)))).abs();
    // where neither neighbour is far, nothing jumps
    let is_edge = |i: usize| {
        i > 0 && i + 1 < values.len() && [i - 1, i + 1].iter().any(|j| (values[i] - values[*j]).abs() > 0.5 * threshold)
    };
    let jumps: Vec<bool> = (0..values.len()).map(|i| !left_out[i] && is_edge(i) && height(i) > threshold).collect();
    let marked: Vec<bool> = jumps.iter().zip(left_out).map(|(jumps, left_out)| *jumps || *left_out).collect();
    let quiet = values.iter().zip(&marked).filter(|(_, marked)| !**marked).map(|(v, _)| *v);
    let [low, high] = quiet.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v), high.max(v)]);
    // ringing has other jumps beside it, of other heights; a converter that fails twice gives the same number
    let is_ringing = |run: &std::ops::Range<usize>| {
        let window = run.start.saturating_sub(QUIET)..(run.end + QUIET).min(values.len());
        let is_other = |j: &usize| jumps[*j] && !run.contains(j) && values[*j] != values[run.start];
        window.filter(is_other).any(|j| height(j) > MOVED * height(run.start))
    };
    let exceeding: Vec<bool> = (0..values.len()).map(|i| jumps[i] && height(i) > high - low).collect();
    let is_lone = |run: &std::ops::Range<usize>| {
        // a jump of its own kind beside it is another failure, and no ringing
        let is_other = |j: usize| left_out[j] || height(j) > MOVED * height(run.start);
        let is_tap = is_ringing(run) || rings_after(values, &is_other, run, sigma);
        run.len() <= LONGEST && !is_tap && stands_out(values, &marked, run)
    };
    let spikes: Vec<usize> = marked_runs(&exceeding).filter(is_lone).flatten().collect();
    if spikes.len() as f64 <= (RARE * values.len() as f64).max(1.0) { spikes } else { Vec::new() }
}

/// Whether the values ring after a run, however little against its jump, and did not before: what was struck moves on, and an amplifier that failed
/// has no memory. Of second differences, so that a beat below counts little; `sigma` is the standard deviation of the noise.
fn rings_after(values: &[f64], is_other: &dyn Fn(usize) -> bool, run: &std::ops::Range<usize>, sigma: f64) -> bool {
    let largest = |range: std::ops::Range<usize>| {
        let is_kept = |i: &usize| !(*i..*i + 3).any(is_other);
        let starts = (range.start..range.end.saturating_sub(2)).filter(is_kept);
        starts.map(|i| (values[i] - 2.0 * values[i + 1] + values[i + 2]).abs()).fold(0.0, f64::max)
    };
    let preceding = largest(run.start.saturating_sub(QUIET)..run.start);
    let following = largest(run.end..(run.end + QUIET).min(values.len()));
    following > (JUMP * 6_f64.sqrt() * sigma).max(ONSET * preceding)
}

/// Standard deviation of the noise, from the median of the second differences of what is not left out.
fn noise_sigma(values: &[f64], left_out: &[bool]) -> f64 {
    let present: Vec<f64> = values.iter().zip(left_out).filter(|(_, left_out)| !**left_out).map(|(v, _)| *v).collect();
    let second_difference = |samples: &[f64]| (samples[0] - 2.0 * samples[1] + samples[2]).abs();
    median_value(present.windows(3).map(second_difference).collect()) * 1.4826 / 6_f64.sqrt()
}

fn median_value(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}

/// Sets what is left out onto the line between its neighbours in time.
fn bridge_runs(rows: &mut [Vec<f64>], left_out: &[bool]) {
    for run in marked_runs(left_out).collect::<Vec<_>>() {
        let preceding = run.start.checked_sub(1).map(|i| [rows[i][0], rows[i][1]]);
        let following = rows.get(run.end).map(|row| [row[0], row[1]]);
        let Some(([t0, v0], [t1, v1])) = preceding.or(following).zip(following.or(preceding)) else { continue };
        for row in &mut rows[run] {
            let fraction = if t1 > t0 { (row[0] - t0) / (t1 - t0) } else { 0.0 };
            row[1] = v0 + fraction * (v1 - v0);
        }
    }
}

impl std::fmt::Display for Spike {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { line, value, bits } = self;
        let reason =
            bits.map_or("a jump of a sample alone".to_owned(), |bits| format!("the full scale of {bits} bits"));
        write!(out, "line {line}: {value} is {reason}, and is left out")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is left out of readings, by their places.
    fn left_out(readings: &[f64], spikes: Spikes) -> Vec<usize> {
        let mut rows: Vec<Vec<f64>> = readings.iter().enumerate().map(|(i, v)| vec![i as f64, *v]).collect();
        let lines: Vec<usize> = (0..readings.len()).collect();
        spikes.leave_out(&mut rows, &lines, 1.0).iter().map(|spike| spike.line).collect()
    }

    /// Repeatable noise of 50 counts about a level.
    fn noise(count: usize, level: f64) -> Vec<f64> {
        (0..count)
            .map(|i| (level + 50.0 * (i as f64 * 12.9898).sin() + 30.0 * (i as f64 * 78.233).sin()).round())
            .collect()
    }

    #[test]
    fn full_scale_is_left_out_alone_and_in_pairs_and_kept_where_the_input_stays_there() {
        let mut readings = noise(200, 300.0);
        for (i, code) in [(0, 8_388_607.0), (50, -8_388_608.0), (51, 8_388_607.0), (199, 8_388_607.0)] {
            readings[i] = code;
        }
        assert_eq!(left_out(&readings, Spikes::FullScale), [0, 50, 51, 199]);
        assert_eq!(left_out(&readings, Spikes::None), Vec::<usize>::new());
        let mut three = readings.clone();
        (three[120], three[121], three[122]) = (-8_388_608.0, 8_388_607.0, 8_388_607.0);
        assert_eq!(left_out(&three, Spikes::LoneJumps), [0, 50, 51, 120, 121, 122, 199]);
        readings[100..104].fill(8_388_607.0);
        assert_eq!(left_out(&readings, Spikes::LoneJumps), [0, 50, 51, 199]);
        readings[70] = 8_388_606.0;
        readings[71] = 8_388_607.0;
        assert!(!left_out(&readings, Spikes::LoneJumps).contains(&71), "a tap that reaches full scale");
    }

    #[test]
    fn the_number_of_full_scale_is_a_reading_where_others_lie_beyond_it() {
        let mut readings: Vec<f64> = (0..200).map(|i| 32_668.0 + f64::from(i)).collect();
        assert_eq!(left_out(&readings, Spikes::LoneJumps), Vec::<usize>::new());
        readings.truncate(100);
        assert_eq!(left_out(&readings, Spikes::LoneJumps), Vec::<usize>::new(), "the last of a ramp");
    }

    #[test]
    fn a_lone_jump_is_left_out_whatever_its_number() {
        let mut readings: Vec<f64> = noise(200, 84_000.0).iter().map(|v| 1e-6 * v).collect();
        (readings[20], readings[60], readings[63]) = (0.5, -1e-6, -1e-6);
        assert_eq!(left_out(&readings, Spikes::LoneJumps), [20, 60, 63]);
        assert_eq!(left_out(&readings, Spikes::FullScale), Vec::<usize>::new(), "a tap may be a sample long");
        assert_eq!(left_out(&noise(200, 0.0), Spikes::LoneJumps), Vec::<usize>::new());
    }

    /// Free vibration of a fixture after a tap, at frequencies from slow to that of half the samples.
    #[test]
    fn taps_steps_and_beats_are_kept() {
        let ring = |f: f64, i: usize| {
            if i < 90 { 0.0 } else { (-0.05 * (i - 90) as f64).exp() * (f * (i - 90) as f64 + 0.9).sin() }
        };
        for k in 1..=30 {
            let frequency = 0.1 * f64::from(k);
            let tap: Vec<f64> =
                noise(300, 0.0).iter().enumerate().map(|(i, v)| v + (2e4 * ring(frequency, i)).round()).collect();
            assert_eq!(left_out(&tap, Spikes::LoneJumps), Vec::<usize>::new(), "{frequency}");
        }
        let step: Vec<f64> =
            noise(300, 0.0).iter().enumerate().map(|(i, v)| v + if i < 150 { 0.0 } else { 1e5 }).collect();
        let beat: Vec<f64> = (0..300).map(|i| if i % 25 == 0 { 1e4 } else { f64::from(i % 3) }).collect();
        let late: Vec<f64> = step[..151].to_vec();
        for kept in [step, beat, late] {
            assert_eq!(left_out(&kept, Spikes::LoneJumps), Vec::<usize>::new());
        }
    }

    /// A hammer of one sample whose ringing is a twelfth of it, and a converter that fails for one.
    #[test]
    fn a_tap_of_one_sample_that_rings_faintly_is_kept() {
        for k in 1..=30 {
            let frequency = 0.1 * f64::from(k);
            let ring = |i: usize| match i.checked_sub(90) {
                None => 0.0,
                Some(0) => 4e4,
                Some(n) => 3.4e3 * (-0.05 * n as f64).exp() * (frequency * n as f64 + 0.9).sin(),
            };
            let tap: Vec<f64> = noise(300, 0.0).iter().enumerate().map(|(i, v)| v + ring(i).round()).collect();
            let is_visible = frequency >= 0.8;
            assert!(!is_visible || left_out(&tap, Spikes::LoneJumps).is_empty(), "{frequency}");
        }
        let mut failed = noise(300, 0.0);
        failed[90] = 4e4;
        assert_eq!(left_out(&failed, Spikes::LoneJumps), [90]);
    }

    #[test]
    fn the_line_between_the_neighbours_stands_for_what_is_left_out() {
        let mut rows: Vec<Vec<f64>> = (0..40).map(|i| vec![0.5 * f64::from(i), f64::from(10 * i)]).collect();
        (rows[7][1], rows[8][1], rows[39][1]) = (8_388_607.0, -8_388_608.0, 8_388_607.0);
        Spikes::FullScale.leave_out(&mut rows, &[0; 40], 1.0);
        assert_eq!([rows[7][1], rows[8][1], rows[39][1]], [70.0, 80.0, 380.0]);
    }
}
