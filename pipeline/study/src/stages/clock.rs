//! Clock: the edges of the lamp in film and log put motion and pressure onto the video's clock. Markers in space without a film are on
//! the log's clock by the `start` of their `[tracks.space]`.
//! Paper: section IV, synchronisation by an LED.

use std::path::Path as FilePath;

use lab::log::Method;
use lab::pressure::Layout;
use lab::{Logged, PressureLog, Sampling};
use serde::{Deserialize, Serialize};
use si::{Point2, Second};
use signal::clock::Clock as Match;
use signal::edge::{self, Edge, Window};
use track::shutter::Shutter;

use diagnostics::{Diagnostic, Result};
use records::subject::Trial;
use records::{self, Camera, Covariance2, CovarianceParts, Gauge, Markers, Motion, Path, Tracks};
use workflow::needs::Maybe;
use workflow::stage::{RawFile, Stage, StageContext};
use workflow::subject::Part;

/// The stage.
pub struct Clock;

/// `[clock]` in `study.toml`.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// How long the shutter is open, as a part of the time between frames.
    exposure: f64,
    /// Fraction of its sampling interval over which the log's lamp column is averaged; 0 for an instant.
    log_averaging: f64,
    /// Frames before the first command that count as rest, at least.
    rest_frames: usize,
}

/// What it reads of the card.
#[derive(Debug, Serialize)]
pub struct Card {
    chambers: Vec<Chamber>,
    /// The channels of the log.
    channels: Vec<String>,
    /// The lamp's row in the picture, px; none where nothing was filmed.
    lamp_row: Option<f64>,
    /// How long a picture's rows take to be read, s.
    readout: Second,
    /// From the first command to the end of the last, s; none where the card ends the film before.
    duration: Option<Second>,
    /// How the log is written.
    log: lab::card::Log,
}

/// A chamber and its channel in the log.
#[derive(Debug, Serialize)]
struct Chamber {
    name: String,
    channel: String,
}

impl Part<Trial> for Card {
    fn part_of(of: &Trial) -> Self {
        let chamber = |c: &lab::card::Chamber| Chamber { name: c.name.clone(), channel: c.channel.clone() };
        Self {
            chambers: of.card.chamber.iter().map(chamber).collect(),
            channels: of.card.channels(),
            lamp_row: of.card.led.as_ref().filter(|_| of.trial.video.is_some()).map(|led| led.centre[1]),
            readout: of.card.camera.as_ref().map_or(0.0, |camera| camera.readout),
            duration: of.trial.last_frame.is_none().then(|| of.trial.experiment.duration()),
            log: of.card.log.clone(),
        }
    }
}

impl Stage for Clock {
    type Settings = Settings;
    type Card = Card;
    type Needs = (Maybe<Camera>, Maybe<Tracks>, Markers);
    type Makes = Motion;
    const DESCRIPTION: &'static str = "the LED's edges synchronise film and logs";
    const VERSION: u32 = 7;

    fn raw(of: &Trial) -> Vec<RawFile> {
        vec![RawFile::new("pressure", &of.card.name, &of.trial.pressure)]
    }

    fn run(
        card: &Self::Card,
        set: &Settings,
        (Maybe(camera), Maybe(tracks), markers): Self::Needs,
        context: &dyn StageContext,
    ) -> Result<Motion> {
        let logged = read_log(card, context)?;
        let shutter = |c: Camera| Shutter { readout: card.readout, height: c.size_px[1] };
        let row_delay = camera.zip(card.lamp_row).map_or(0.0, |(c, row)| shutter(c).row_delay(row));
        let synchronisation = Synchronisation { card, set, context };
        let synchronised = synchronisation.synchronise(tracks.as_ref(), row_delay, &logged)?;
        synchronisation.check_coverage(tracks.as_ref().map_or(&markers.time, |tracks| &tracks.time), &synchronised)?;
        let rest_frames = synchronisation.rest_frames(&markers.time, &synchronised)?;
        let Synchronised { clock, lamp, sigma, log_time, gauges } = synchronised;
        let rest_positions: Vec<Point2> = markers.markers.iter().map(|m| m.mean(0..rest_frames)).collect();
        let paths = markers.markers.iter().zip(&markers.parts).zip(&rest_positions);
        let displacements =
            paths.map(|((path, parts), rest)| displaced_path(path, parts, *rest, rest_frames)).collect();
        let clock = records::Clock { offset: clock.offset, scale: clock.scale, lamp, sigma };
        Ok(Motion {
            time: markers.time,
            markers: displacements,
            rest: rest_positions,
            gauges,
            log_time,
            clock,
            sampling: logged.sampling,
        })
    }
}

/// Film and log on the film's clock.
struct Synchronised {
    clock: Match,
    lamp: Second,
    sigma: Second,
    log_time: Vec<Second>,
    gauges: Vec<Gauge>,
}

/// Synchronisation of the film and the log of one trial.
pub struct Synchronisation<'a> {
    /// What is read of the card.
    pub card: &'a Card,
    /// The settings.
    pub set: &'a Settings,
    /// Gives the log.
    pub context: &'a dyn StageContext,
}

impl Synchronisation<'_> {
    /// Checks that the lamp's edges in a film, in pictures of `height` rows, and in its log match, with enough rest before the first
    /// command; the motion of a trial without markers.
    ///
    /// # Errors
    /// A [`Diagnostic`] that names which of the two has no edge, or where they disagree.
    pub fn check(&self, tracks: &Tracks, height: usize) -> Result<Motion> {
        let shutter = Shutter { readout: self.card.readout, height };
        let row_delay = self.card.lamp_row.map_or(0.0, |row| shutter.row_delay(row));
        let logged = read_log(self.card, self.context)?;
        let synchronised = self.synchronise(Some(tracks), row_delay, &logged)?;
        self.check_coverage(&tracks.time, &synchronised)?;
        self.rest_frames(&tracks.time, &synchronised)?;
        let Synchronised { clock, lamp, sigma, log_time, gauges } = synchronised;
        let clock = records::Clock { offset: clock.offset, scale: clock.scale, lamp, sigma };
        let (time, sampling) = (tracks.time.clone(), logged.sampling);
        Ok(Motion { time, markers: Vec::new(), rest: Vec::new(), gauges, log_time, clock, sampling })
    }

    /// Holds that film and log last until the trial on the card has ended: a truncated recording would pass
    /// unnoticed. The trial begins when the lamp lights.
    fn check_coverage(&self, film: &[Second], synchronised: &Synchronised) -> Result<()> {
        let Some(end) = self.card.duration.map(|duration| synchronised.lamp + duration) else { return Ok(()) };
        for (word, time) in [(self.card.measured_in(), film), ("the log", &synchronised.log_time)] {
            let last = time[time.len() - 1];
            // The last sample stands for the time until the next.
            let step = (last - time[0]) / (time.len() - 1) as f64;
            if last + step < end {
                return Err(Diagnostic::new(
                    format!("{word} of {} ends at {last:.3} s", self.context.display_path("pressure")),
                    format!("by the card, the trial lasts until {end:.3} s"),
                    "copy the recording again, correct the trial, or set its last_frame on the card",
                ));
            }
        }
        Ok(())
    }

    fn synchronise(
        &self,
        tracks: Option<&Tracks>,
        row_delay: Second,
        logged: &Logged<PressureLog>,
    ) -> Result<Synchronised> {
        let log = &logged.log;
        let gauges: Vec<Gauge> = self.card.chambers.iter().map(|chamber| chamber_gauge(chamber, log)).collect();
        let matched = match tracks {
            Some(tracks) => match_clocks(tracks, row_delay, logged, self.set),
            // Without a film the log's clock is that of all, and the trial begins with its first command.
            None => Ok((Match { offset: 0.0, scale: 1.0 }, first_command(&log.time, &gauges), 0.0)),
        };
        let (clock, lamp, sigma) = matched.map_err(|e| clock_mismatch(self.context, e))?;
        let log_time = log.time.iter().map(|&t| clock.here(t)).collect();
        Ok(Synchronised { clock, lamp, sigma, log_time, gauges })
    }

    /// Frames, at `time` (s), before the first command of any chamber.
    fn rest_frames(&self, time: &[Second], synchronised: &Synchronised) -> Result<usize> {
        let (least, first) = (self.set.rest_frames, first_command(&synchronised.log_time, &synchronised.gauges));
        let frames = time.iter().take_while(|&&t| t < first).count();
        if frames >= least {
            return Ok(frames);
        }
        Err(Diagnostic::new(
            format!(
                "{} commands pressure after {frames} frames of {}",
                self.context.display_path("pressure"),
                self.card.measured_in()
            ),
            format!("rest is known from at least {least} frames (study.toml, [clock] rest_frames)"),
            "let the recording begin earlier, before the first command",
        ))
    }
}

impl Card {
    /// What the motion was measured in.
    fn measured_in(&self) -> &'static str {
        if self.lamp_row.is_some() { "the film" } else { "the markers in space" }
    }
}

/// Time of the first command of any chamber, s; infinity where there is none.
fn first_command(log_time: &[Second], gauges: &[Gauge]) -> Second {
    let is_commanded = |i: &usize| gauges.iter().any(|g| g.command[*i] > 0.0);
    (0..log_time.len()).find(is_commanded).map_or(f64::INFINITY, |i| log_time[i])
}

fn read_log(card: &Card, context: &dyn StageContext) -> Result<Logged<PressureLog>> {
    let log_path = context.display_path("pressure");
    let text = lab::log::decoded(context.bytes("pressure")?, FilePath::new(&log_path))?;
    let layout = Layout { channels: &card.channels, lamp: card.lamp_row.is_some(), log: &card.log };
    lab::pressure::parse_as(&text, FilePath::new(&log_path), layout)
}

/// The samples of a chamber's channel.
fn chamber_gauge(chamber: &Chamber, log: &PressureLog) -> Gauge {
    let channel = log.channel(&chamber.channel).cloned().unwrap_or_default();
    Gauge { chamber: chamber.name.clone(), command: channel.command, measured: channel.measured }
}

/// A sample whose time is the middle of its averaging interval.
fn centred_window(width: Second) -> Window {
    Window { lead: 0.5 * width, width }
}

/// The video's clock against the log's, when the lamp lights in the film, and the largest deviation of the clock in it; the
/// lamp's rows are read `late` s after a frame's time.
fn match_clocks(
    tracks: &Tracks,
    row_delay: Second,
    Logged { log, sampling }: &Logged<PressureLog>,
    set: &Settings,
) -> Result<(Match, Second, Second)> {
    let time: Vec<Second> = tracks.time.iter().map(|t| t + row_delay).collect();
    let frame_interval = time.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min);
    let in_film = edge::edges_at(&time, &tracks.led, |_| centred_window(set.exposure * frame_interval));
    let in_film = in_film.map_err(|e| Diagnostic::from(e).while_doing("the lamp in the film"))?;
    let in_log = edge::edges(&log.series(&log.led), centred_window(set.log_averaging / log.rate()));
    let in_log = in_log.map_err(|e| Diagnostic::from(e).while_doing("the lamp in the log"))?;
    let times = |edges: &[Edge]| -> Vec<Second> { edges.iter().map(|e| e.time).collect() };
    let lit_in_film = times(&in_film);
    let clock = Match::from_edges(&lit_in_film, &times(&in_log))?;
    let sigma: Vec<Second> =
        in_film.iter().zip(&in_log).map(|(a, b)| a.sigma.hypot(b.sigma).hypot(sampling_sigma(sampling))).collect();
    let sigma_at_ends =
        [tracks.time[0], tracks.time[tracks.time.len() - 1]].map(|t| Match::sigma(&lit_in_film, &sigma, t));
    Ok((clock, lit_in_film[0], sigma_at_ends[0].max(sigma_at_ends[1])))
}

/// Standard deviation of an edge in a log whose samples were taken unevenly, s; 0 in any other. Over what time such a sample is averaged is
/// not known: the edge lies anywhere between two of them.
fn sampling_sigma(sampling: &Sampling) -> Second {
    match sampling.method {
        Method::LinearInterpolation => 1.0 / (12f64.sqrt() * sampling.rate_hz),
        Method::AsStamped | Method::EvenSampling => 0.0,
    }
}

/// Displacements from the mean of the first frames, with the noise of both and the shared errors.
fn displaced_path(path: &Path, parts: &CovarianceParts, rest: Point2, rest_frames: usize) -> Path {
    let displacements = path.at.iter().map(|p| [p[0] - rest[0], p[1] - rest[1]]).collect();
    let share = 1.0 / (rest_frames * rest_frames) as f64;
    let rest_covariance: Covariance2 =
        [0, 1, 2].map(|k| share * parts.noise[..rest_frames].iter().map(|s| s[k]).sum::<f64>());
    let total_covariance =
        |(noise, shared): (&Covariance2, &Covariance2)| [0, 1, 2].map(|k| noise[k] + shared[k] + rest_covariance[k]);
    Path {
        name: path.name.clone(),
        at: displacements,
        spread: parts.noise.iter().zip(&parts.shared).map(total_covariance).collect(),
    }
}

fn clock_mismatch(context: &dyn StageContext, error: Diagnostic) -> Diagnostic {
    error.while_doing(format!("{} and its film do not match", context.display_path("pressure")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_edge_in_an_uneven_log_lies_anywhere_between_two_samples() {
        let of = |method| sampling_sigma(&Sampling { rate_hz: 100.0, method, ..Sampling::default() });
        // the standard deviation of a uniform distribution over 10 ms
        assert!((of(Method::LinearInterpolation) - 0.01 / 12f64.sqrt()).abs() < 1e-15);
        assert_eq!((of(Method::AsStamped), of(Method::EvenSampling)), (0.0, 0.0));
    }
}
