//! The lag of a log: how far its clock is ahead of its film's, by the lamp in both.

use super::guess::{Confidence, Guess};
use super::lamp::Lit;
use super::logs::Log;

/// How far a clock is ahead of the film's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Lag {
    /// The log's time of an event less the film's, s.
    pub(super) seconds: f64,
    /// Bound of its error, s.
    pub(super) bound: f64,
}

/// The lag by the lamp, and whether its lighting and its going out agree on it; `seconds` are those of the log in a second of the film.
fn lag_by_lamp(film: &Lit, log: &Log, seconds: f64) -> Option<(Lag, bool)> {
    let [on, off] = log.lit?;
    let [by_on, by_off] = [on - seconds * film.from, off - seconds * film.until];
    // each switch is known to half a frame and half a sample either way
    let bound = seconds * film.step + log.step;
    Some((Lag { seconds: 0.5 * (by_on + by_off), bound }, (by_on - by_off).abs() <= bound))
}

/// The guess of a log's lag about `about`; `pairing` is how sure it belongs to the film.
pub(super) fn lag_guess(about: &str, (film, log): (&Lit, &Log), seconds: f64, pairing: Confidence) -> Option<Guess> {
    let (lag, agrees) = lag_by_lamp(film, log, seconds)?;
    let is_true_rate = (seconds - 1.0).abs() < 0.01;
    let own = if agrees && is_true_rate { Confidence::Certain } else { Confidence::Likely };
    let confidence = own.max(pairing).max(log.clock.1);
    let [on, _] = log.lit?;
    let evidence = format!(
        "s, within {:.3}; the log's clock is ahead: the lamp lights at {on:.3} s of it and at {:.3} s of the film{}",
        lag.bound,
        film.from,
        if agrees { ", and goes out as much later" } else { "; by its going out it is another" },
    );
    Some(Guess::new(confidence, about, format!("{:.3}", lag.seconds), evidence))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::super::logs::Kind;
    use super::*;

    fn log(lit: [f64; 2], sure: Confidence) -> Log {
        let clock = ("s", sure, String::new());
        Log {
            name: "log.csv".to_owned(),
            kind: Kind::Pressure,
            columns: Vec::new(),
            dialect: String::new(),
            clock,
            lit: Some(lit),
            step: 0.005,
        }
    }

    #[test]
    fn the_lag_is_the_log_s_time_less_the_film_s() {
        let film = Lit { from: 0.24, until: 0.89, step: 1.0 / 60.0 };
        let guess = |lit, sure| lag_guess("lag", (&film, &log(lit, sure)), 1.0, Confidence::Certain).unwrap();
        let certain = guess([1.34, 1.992], Confidence::Certain);
        assert_eq!((certain.value.as_deref(), certain.confidence), (Some("1.101"), Confidence::Certain));
        // a unit that the log does not name, and two lamps that are on for different times
        assert_eq!(guess([1.34, 1.99], Confidence::Likely).confidence, Confidence::Likely);
        assert_eq!(guess([1.34, 2.05], Confidence::Certain).confidence, Confidence::Likely);
        let slow = lag_guess("lag", (&film, &log([1.0, 1.08], Confidence::Certain)), 0.125, Confidence::Certain);
        let slow = slow.unwrap();
        assert_eq!((slow.value.as_deref(), slow.confidence), (Some("0.969"), Confidence::Likely));
    }
}
