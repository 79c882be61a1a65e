//! Recorded displacements of the markers after a release, in the body's frame.
//!
//! The frame is found by the least squares turn and shift of the markers' mean places, while the body is held, onto those of the
//! page. [kabsch1976] Displacements count from there, so that an error of the frame enters them by its reduced turn alone.

use std::path::{Path, PathBuf};

use nalgebra::Vector3;
use si::{Metre, Point3, Second, Series};
use signal::wave;

use super::page::{Marker, Page, Recording};
use crate::rigid;
use diagnostics::{Diagnostic, Result, input};

/// One recorded release.
pub struct Recorded {
    /// Its file's name.
    pub name: String,
    /// Mean displacement of the compared markers along the page's axis since the release, m.
    pub fall: Series,
    /// Displacement of each compared marker at rest, m.
    pub settled: Vec<Metre>,
}

impl Recorded {
    /// Mean displacement at rest, m.
    pub(super) fn deflection(&self) -> Metre {
        self.settled.iter().sum::<f64>() / self.settled.len() as f64
    }
}

/// A free vibration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FreeVibration {
    /// Hz.
    pub frequency: f64,
    /// Its standard deviation, Hz.
    pub frequency_sigma: f64,
    /// 1/s.
    pub decay: f64,
    /// First extremum of the displacement, m.
    pub lowest: Metre,
    /// When, s after the release.
    pub when: Second,
}

/// Reads every recording of a page from the first folder below `root` that has them.
///
/// # Errors
/// A [`Diagnostic`] when one lies nowhere, is refused, or is shorter than the page says.
pub fn read(page: &Page, root: &Path) -> Result<Vec<Recorded>> {
    page.recording
        .iter()
        .map(|recording| read_recording(page, recording, &find(&page.name, &page.folders, &recording.files, root)?))
        .collect()
}

/// A file of the test `name` in the first of `folders` below `root` that has one of `files`.
///
/// # Errors
/// A [`Diagnostic`] with the searched folders and the command that downloads it.
pub(crate) fn find(name: &str, folders: &[PathBuf], files: &[String], root: &Path) -> Result<PathBuf> {
    let candidates = folders.iter().flat_map(|folder| files.iter().map(move |f| root.join(folder).join(f)));
    candidates.clone().find(|candidate| candidate.is_file()).ok_or_else(|| {
        let tried: Vec<String> = candidates.map(|candidate| candidate.display().to_string()).collect();
        let next =
            format!("study fetch {name} downloads it from its public source; or put it into one of these folders");
        Diagnostic::new(format!("a recording of `{name}` is not there"), format!("searched {}", tried.join(", ")), next)
    })
}

fn read_recording(page: &Page, recording: &Recording, path: &Path) -> Result<Recorded> {
    let (rate, tracks) = marker_tracks(&page.marker, path)?;
    let frames = tracks[0].len();
    let phases =
        Phases::of(page, recording, rate, frames).ok_or_else(|| phase_diagnostic(path, frames as f64 / rate))?;
    let displacements = compared_displacements(page, &tracks, phases.held);
    let mean = |i: usize| displacements.iter().map(|m| m[i]).sum::<f64>() / displacements.len() as f64;
    let fall = (phases.release..tracks[0].len()).map(mean).collect();
    let settled =
        displacements.iter().map(|m| m[phases.rest..].iter().sum::<f64>() / (m.len() - phases.rest) as f64).collect();
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    Ok(Recorded { name, fall: Series::new(0.0, rate, fall)?, settled })
}

/// Frames a second, and the place of each of the page's markers in each frame, m.
///
/// # Errors
/// A [`Diagnostic`] when the file is refused, or has no such marker in every frame.
pub(crate) fn marker_tracks(markers: &[Marker], path: &Path) -> Result<(f64, Vec<Vec<Point3>>)> {
    let bytes = input::read(path, input::MESH)
        .map_err(|e| Diagnostic::io(path, e, "name a file of tracks, .csv or .c3d, on the page"))?;
    let space = lab::space::read(&bytes, path)?;
    let track = |marker: &Marker| -> Result<Vec<Point3>> {
        let is_recorded = |name: &&String| space.markers.iter().any(|recorded| recorded.name.trim() == name.trim());
        let name = marker.names.iter().find(is_recorded).unwrap_or(&marker.names[0]);
        space.complete(name, path)
    };
    let rate = (space.time.len() - 1) as f64 / (space.time[space.time.len() - 1] - space.time[0]);
    Ok((rate, markers.iter().map(track).collect::<Result<_>>()?))
}

/// Frames at which the phases of a recording begin or end.
struct Phases {
    held: usize,
    release: usize,
    rest: usize,
}

impl Phases {
    /// Of a recording of `frames` frames, `rate` a second; none where they do not follow one another within it.
    fn of(page: &Page, recording: &Recording, rate: f64, frames: usize) -> Option<Self> {
        let frame = |time: Second| ((time * rate).round() as usize).min(frames);
        let (held, release) = (frame(page.held), frame(recording.release));
        let settled_start = frames - frame(page.settled);
        let in_order = held > 0 && held <= release && settled_start > frame(recording.release + page.swing[1]);
        in_order.then_some(Self { held, release, rest: settled_start })
    }
}

fn phase_diagnostic(path: &Path, duration: Second) -> Diagnostic {
    Diagnostic::new(
        format!("{} holds {duration:.2} s", path.display()),
        "held, release, swing and settled do not fit into it in this order",
        "correct the page's times",
    )
}

/// Displacement of each compared marker along the page's axis from its position while `held`, m.
fn compared_displacements(page: &Page, tracks: &[Vec<Point3>], held: usize) -> Vec<Vec<Metre>> {
    let displacements = marker_displacements(&page.marker, tracks, held);
    let component = |displacement: Vec<Vector3<f64>>| displacement.iter().map(|u| u[page.along as usize]).collect();
    displacements
        .into_iter()
        .zip(&page.marker)
        .filter(|(_, marker)| marker.compared)
        .map(|(displacement, _)| component(displacement))
        .collect()
}

/// Displacement of each marker from its mean position during the first `held` frames, in the body's frame, m: markers × frames.
pub(crate) fn marker_displacements(markers: &[Marker], tracks: &[Vec<Point3>], held: usize) -> Vec<Vec<Vector3<f64>>> {
    let mean =
        |track: &Vec<Point3>| track[..held].iter().map(|p| Vector3::from(*p)).sum::<Vector3<f64>>() / held as f64;
    let initial: Vec<Vector3<f64>> = tracks.iter().map(mean).collect();
    let places: Vec<Vector3<f64>> = markers.iter().map(|marker| Vector3::from(marker.at)).collect();
    let turn = rigid::best_rotation(&initial, &places);
    let relative_displacement = |(track, initial_position): (&Vec<Point3>, &Vector3<f64>)| {
        track.iter().map(|p| turn * (Vector3::from(*p) - initial_position)).collect()
    };
    tracks.iter().zip(&initial).map(relative_displacement).collect()
}

/// The free vibration in the window of the page.
///
/// # Errors
/// A [`Diagnostic`] when no decaying vibration fits it.
pub fn vibration(page: &Page, fall: &Series) -> Result<FreeVibration> {
    let sample = |time: Second| ((time * fall.rate()).round() as usize).min(fall.values().len() - 1);
    let [first, last] = page.swing.map(sample);
    let window = Series::new(0.0, fall.rate(), fall.values()[first..=last].to_vec())?;
    let (when, lowest) = first_turn(fall);
    let fit = wave::free_vibration(&window, 0.5 / (second_turn(fall, when) - when))?;
    let Some(wave) = fit.waves.first() else {
        return Err(Diagnostic::new(
            "there is no free vibration",
            "the fit found no decaying wave",
            "correct the page's `swing`",
        ));
    };
    Ok(FreeVibration {
        frequency: wave.frequency,
        frequency_sigma: wave.frequency_sigma,
        decay: wave.decay,
        lowest,
        when,
    })
}

/// When the displacement is furthest from its first extremum, at the time `first`, before the extremum after next, s. The time between
/// both is half a period, however long the release took.
fn second_turn(fall: &Series, first: Second) -> Second {
    let values = fall.values();
    let extremum = ((first * fall.rate()).round() as usize).min(values.len() - 1);
    // To 2.6 times the first extremum's time: after a sudden release the second follows at twice, the third at three
    // times.
    let end = (extremum + 8 * extremum / 5).min(values.len() - 1);
    let distance = |i: &usize| (values[*i] - values[extremum]).abs();
    let farthest = (extremum + 1..=end).max_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(end);
    fall.time(farthest)
}

/// The first extremum of a displacement: time (s) and value (m), by the parabola through the three samples around.
fn first_turn(fall: &Series) -> (Second, Metre) {
    let values = fall.values();
    let largest = values.iter().fold(0.0, |largest: f64, v| largest.max(v.abs()));
    let turns = |i: &usize| {
        let [a, b, c] = [values[i - 1], values[*i], values[i + 1]];
        // Noise turns as well while the body is still close to its straight shape.
        b.abs() > 0.5 * largest && (b - a) * (c - b) <= 0.0
    };
    let extremum = (1..values.len() - 1).find(turns).unwrap_or(1);
    let [a, b, c] = [values[extremum - 1], values[extremum], values[extremum + 1]];
    let bend = a - 2.0 * b + c;
    let offset = if bend == 0.0 { 0.0 } else { 0.5 * (a - c) / bend };
    ((extremum as f64 + offset) / fall.rate(), b - 0.25 * (a - c) * offset)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::free_vibration::testing;

    #[test]
    fn a_known_vibration_is_identified() {
        let (omega, decay): (f64, f64) = (std::f64::consts::TAU * 7.73, 2.4);
        let at = |t: f64| -6.4e-3 * (1.0 - (-decay * t).exp() * (omega * t).cos());
        let fall = Series::new(0.0, 100.0, (0..300).map(|i| at(f64::from(i) / 100.0)).collect()).unwrap();
        let (when, lowest) = first_turn(&fall);
        let turn = (std::f64::consts::PI - (decay / omega).atan()) / omega;
        // a parabola through samples a thirteenth of a turn apart misses the turn by a hundredth of their distance
        assert!((when - turn).abs() < 3e-4 && (lowest - at(turn)).abs() < 3e-5, "{when} {turn} {lowest} {}", at(turn));
    }

    #[test]
    fn the_first_extremum_of_a_cosine_is_half_a_period_on_and_the_second_a_whole_one() {
        let period = 0.5;
        let at = |i: i32| (std::f64::consts::TAU * f64::from(i) / 100.0 / period).cos();
        let wave = |frames: i32| Series::new(0.0, 100.0, (0..frames).map(at).collect()).unwrap();
        let (when, lowest) = first_turn(&wave(200));
        assert!((when - 0.25).abs() < 1e-9 && (lowest + 1.0).abs() < 1e-9, "{when} {lowest}");
        assert!((second_turn(&wave(200), when) - 0.5).abs() < 1e-9);
        assert!((second_turn(&wave(26), 0.25) - 0.25).abs() < 1e-9, "a recording that ends there has no further one");
    }

    /// However slowly the hand lets go: the turn after next is no longer in the interval.
    #[test]
    fn the_second_extremum_is_that_before_the_one_after_it() {
        // rises until 0.5 s, then turns every 0.3 s; what comes later is further away
        let turns = [(0.0, 0.0), (0.5, -1.0), (0.8, -0.5), (1.1, -1.2), (1.4, -0.7), (1.6, 3.0)];
        let at = |t: f64| {
            let next = turns.iter().position(|turn| turn.0 >= t - 1e-9).unwrap().max(1);
            let ([from, to], [a, b]) = ([turns[next - 1].0, turns[next].0], [turns[next - 1].1, turns[next].1]);
            a + (b - a) * (t - from) / (to - from)
        };
        let fall = Series::new(0.0, 100.0, (0..=160).map(|i| at(f64::from(i) / 100.0)).collect()).unwrap();
        assert!((second_turn(&fall, 0.5) - 0.8).abs() < 1e-9, "within 0.5 s and 8/5 of it");
    }

    #[test]
    fn a_window_beyond_the_recording_ends_with_it() {
        let page = Page { swing: [0.1, 9.0], ..testing::page() };
        let wave = |t: f64| 1.0 - (-2.0 * t).exp() * (std::f64::consts::TAU * 5.0 * t).cos();
        let fall = Series::new(0.0, 100.0, (0..250).map(|i| -0.01 * wave(f64::from(i) / 100.0)).collect()).unwrap();
        let found = vibration(&page, &fall).unwrap();
        assert!((found.frequency - 5.0).abs() < 1e-3 && (found.decay - 2.0).abs() < 0.02, "{found:?}");
    }

    #[test]
    fn phases_that_do_not_follow_one_another_within_a_recording_are_refused() {
        let page = testing::page();
        let of = |held: f64, settled: f64, frames| {
            let page = Page { held, settled, ..page.clone() };
            let phases = Phases::of(&page, &page.recording[0], 100.0, frames);
            phases.map(|phases| [phases.held, phases.release, phases.rest])
        };
        // held for 0.2 s, released at 0.3 s, vibrating until 1.5 s, at rest for the last 0.5 s
        assert_eq!(of(0.2, 0.5, 280), Some([20, 30, 230]));
        assert_eq!(of(0.31, 0.5, 280), None, "held after the release");
        assert_eq!(of(0.004, 0.5, 280), None, "held for no frame");
        assert_eq!(of(0.2, 0.5, 200), None, "at rest when the vibration ends");
        assert_eq!(of(0.2, 0.5, 201), Some([20, 30, 151]));
    }

    #[test]
    fn a_recording_that_is_too_short_for_the_page_is_refused_with_its_duration() {
        let folder = std::env::temp_dir().join(format!("short-{}", std::process::id()));
        std::fs::create_dir_all(folder.join("recordings")).unwrap();
        let page = testing::page();
        // held for 0.3 s, and 1.2 s of the vibration and the rest
        std::fs::write(folder.join("recordings/a.csv"), testing::tracks(&page, &[-0.01; 120])).unwrap();
        let said = read(&page, &folder).err().map(|error| error.to_string()).unwrap_or_default();
        std::fs::remove_dir_all(&folder).unwrap();
        assert!(said.contains("a.csv holds 1.50 s") && said.contains("in this order"), "{said}");
    }

    #[test]
    fn a_recording_settles_at_its_mean_at_rest_in_the_body_s_frame() {
        let folder = std::env::temp_dir().join(format!("recorded-{}", std::process::id()));
        std::fs::create_dir_all(folder.join("recordings")).unwrap();
        // at rest the tip is in turn 9 and 11 mm below where it was held
        let fall: Vec<f64> = (0..250).map(|i| if i % 2 == 0 { -0.009 } else { -0.011 }).collect();
        let page = testing::page();
        ["a.csv", "b.csv", "c.csv"].iter().for_each(|file| {
            std::fs::write(folder.join("recordings").join(file), testing::tracks(&page, &fall)).unwrap();
        });
        let all = read(&page, &folder).unwrap();
        std::fs::remove_dir_all(&folder).unwrap();
        assert_eq!(all.iter().map(|r| r.name.as_str()).collect::<Vec<_>>(), ["a.csv", "b.csv", "c.csv"]);
        for recorded in all {
            assert!(
                recorded.settled.len() == 1 && (recorded.settled[0] + 0.010).abs() < 1e-8,
                "{:?}",
                recorded.settled
            );
            assert!(recorded.fall.values().iter().zip(&fall).all(|(found, is)| (found - is).abs() < 1e-8));
            assert_eq!((recorded.fall.rate() * 1e6).round(), 100.0 * 1e6);
        }
    }
}
