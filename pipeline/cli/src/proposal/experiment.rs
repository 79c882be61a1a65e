//! What was done in a trial, from the commands in its pressure log: a staircase with its levels, or flapping with its frequency.

/// An interval of a command, on the log's clock.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Pulse {
    pub(super) channel: usize,
    /// First and last time, s.
    pub(super) from: f64,
    pub(super) until: f64,
    /// In the command's own unit.
    pub(super) level: f64,
}

/// What was done.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Experiment {
    /// Levels in the command's unit; hold and pause, s; of a single level no pause is seen.
    Staircase { levels: Vec<f64>, hold: f64, pause: Option<f64> },
    /// Amplitude in the command's unit, frequency in Hz, full cycles.
    Flapping { amplitude: f64, frequency: f64, cycles: usize },
}

/// A command below this share of the largest is none.
const LEAST: f64 = 0.02;

/// The pulses of commands (channels × samples) in the order of their beginnings.
pub(super) fn pulses(time: &[f64], commands: &[&[f64]]) -> Vec<Pulse> {
    let largest = commands.iter().flat_map(|command| command.iter()).fold(0.0, |l: f64, v| l.max(*v));
    let mut pulses = Vec::new();
    for (channel, command) in commands.iter().enumerate() {
        let mut open: Option<Pulse> = None;
        // length: a time for each sample of a command
        for (&time, &level) in time.iter().zip(command.iter()) {
            let is_same = open.is_some_and(|pulse| (pulse.level - level).abs() < LEAST * largest);
            if !is_same {
                pulses.extend(open.take().map(|pulse| Pulse { until: time, ..pulse }));
                open = (level > LEAST * largest).then_some(Pulse { channel, from: time, until: time, level });
            }
        }
        pulses.extend(open.map(|pulse| Pulse { until: time[time.len() - 1], ..pulse }));
    }
    pulses.sort_by(|a, b| a.from.total_cmp(&b.from));
    pulses
}

/// The channels that are driven, in the order in which they begin, and what is done with them; none where nothing is commanded.
pub(super) fn experiment(pulses: &[Pulse]) -> Option<(Vec<usize>, Experiment)> {
    let mut channels: Vec<usize> = Vec::new();
    pulses.iter().for_each(|pulse| {
        if !channels.contains(&pulse.channel) {
            channels.push(pulse.channel);
        }
    });
    let first: Vec<&Pulse> = pulses.iter().filter(|pulse| Some(&pulse.channel) == channels.first()).collect();
    let lengths: Vec<f64> = first.iter().map(|pulse| pulse.until - pulse.from).collect();
    let hold = median(&lengths)?;
    let in_turn = channels.len() > 1 && pulses.windows(2).all(|pair| pair[1].from > pair[0].from + 0.5 * hold);
    let amplitude = median(&first.iter().map(|pulse| pulse.level).collect::<Vec<_>>())?;
    let is_alike = first.iter().all(|pulse| (pulse.level - amplitude).abs() < 0.05 * amplitude);
    if in_turn || is_alike && first.len() >= 3 {
        // of a single cycle the pulse is an equal part of it, of one channel half
        let parts = channels.len().max(2) as f64;
        let span = first[first.len() - 1].from - first[0].from;
        let period = if first.len() > 1 { span / (first.len() - 1) as f64 } else { parts * hold };
        let flapping = Experiment::Flapping { amplitude, frequency: 1.0 / period, cycles: first.len() };
        return Some((channels, flapping));
    }
    let pauses: Vec<f64> = first.windows(2).map(|pair| pair[1].from - pair[0].until).collect();
    let levels = first.iter().map(|pulse| pulse.level).collect();
    Some((channels, Experiment::Staircase { levels, hold, pause: median(&pauses).map(|pause| pause.max(0.0)) }))
}

fn median(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let upper = *sorted.get(sorted.len() / 2)?;
    Some(if sorted.len().is_multiple_of(2) { 0.5 * (upper + sorted[sorted.len() / 2 - 1]) } else { upper })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn time() -> Vec<f64> {
        (0..400).map(|k| 0.01 * f64::from(k)).collect()
    }

    fn command(level: impl Fn(f64) -> f64) -> Vec<f64> {
        time().into_iter().map(level).collect()
    }

    #[test]
    fn a_staircase_has_its_levels_hold_and_pause() {
        let stairs = command(|t| {
            let (step, within) = ((t - 0.495).div_euclid(1.0), (t - 0.495).rem_euclid(1.0));
            if (0.0..3.0).contains(&step) && within < 0.7 { 50.0 * (step + 1.0) } else { 0.0 }
        });
        let rest = command(|_| 0.0);
        let (channels, experiment) = experiment(&pulses(&time(), &[&rest, &stairs])).unwrap();
        let Experiment::Staircase { levels, hold, pause } = experiment else { panic!("{experiment:?}") };
        assert_eq!((channels, levels), (vec![1], vec![50.0, 100.0, 150.0]));
        assert!(
            (hold - 0.7).abs() < 0.011 && pause.is_some_and(|pause| (pause - 0.3).abs() < 0.011),
            "{hold} {pause:?}"
        );
    }

    #[test]
    fn channels_in_turn_flap_at_their_frequency() {
        let half = |shift: f64| {
            command(move |t| {
                let within = (t - 0.495 - shift).rem_euclid(0.5);
                if (0.495..3.495).contains(&t) && within < 0.25 { 200.0 } else { 0.0 }
            })
        };
        let (left, right) = (half(0.0), half(0.25));
        let (channels, experiment) = experiment(&pulses(&time(), &[&left, &right])).unwrap();
        let Experiment::Flapping { amplitude, frequency, cycles } = experiment else { panic!("{experiment:?}") };
        assert_eq!((channels, amplitude, cycles), (vec![0, 1], 200.0, 6));
        assert!((frequency - 2.0).abs() < 0.02, "{frequency}");
    }

    #[test]
    fn a_log_without_a_command_is_no_experiment() {
        assert_eq!(experiment(&pulses(&time(), &[&command(|_| 0.0)])), None);
    }
}
