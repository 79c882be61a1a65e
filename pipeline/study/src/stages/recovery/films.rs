//! Errors of what was measured in films: pixels, positions, motions and clocks.

use lab::truth::{TrueTrack, TrueTrial};
use si::{Point2, Second};

use records::{Markers, Motion, Path, Recovered, Tracks};
use workflow::needs::Every;
use workflow::subject::Name;

/// Records of all films: pixels, positions, motions.
pub(super) type Films = (Every<Tracks>, Every<Markers>, Every<Motion>);

/// Updates the largest errors with those of a trial.
pub(super) fn judge_films(
    recovered: &mut Recovered,
    trial: &Name,
    (truth, true_tracks): (&TrueTrial, &[TrueTrack]),
    (Every(tracks), Every(places), Every(motions)): &Films,
) {
    let is_trial = |t: &Name| t == trial;
    for (_, tracks) in tracks.iter().filter(|(t, _)| is_trial(t)) {
        let pixels = |t: &TrueTrack, i: usize| t.pixel[i];
        let estimated = Estimated { paths: &tracks.markers, time: &tracks.time };
        let worst_error = estimated.worst_rms(true_tracks, &pixels);
        estimated.count_coverage(&mut recovered.track_coverage, true_tracks, &pixels);
        if worst_error > recovered.track_rms_px {
            (recovered.track_rms_px, recovered.track_worst) = (worst_error, trial.0.clone());
        }
        if worst_error > LARGEST_TRACK_ERROR {
            recovered.track_strayed.push(format!("{} ({worst_error:.2} px)", trial.0.clone()));
        }
    }
    for (_, places) in places.iter().filter(|(t, _)| is_trial(t)) {
        recovered.marker_place_mm = recovered.marker_place_mm.max(1e3 * error_at_rest(&places.markers, true_tracks));
    }
    for (_, motion) in motions.iter().filter(|(t, _)| is_trial(t)) {
        let displacement = |t: &TrueTrack, i: usize| [t.at[i][0] - t.at[0][0], t.at[i][1] - t.at[0][1]];
        let estimated = Estimated { paths: &motion.markers, time: &motion.time };
        let worst_error = estimated.worst_rms(true_tracks, &displacement);
        estimated.count_coverage(&mut recovered.marker_coverage, true_tracks, &displacement);
        recovered.marker_rms_mm = recovered.marker_rms_mm.max(1e3 * worst_error);
        recovered.clock_error_ms = recovered.clock_error_ms.max(1e3 * clock_error(motion, truth));
    }
}

/// A marker whose root mean square error is larger has been swapped or lost, px.
const LARGEST_TRACK_ERROR: f64 = 1.0;

/// Largest distance of a marker's first position from the true one, m.
fn error_at_rest(paths: &[Path], truth: &[TrueTrack]) -> f64 {
    let marker_error = |path: &Path| {
        let track = truth.iter().find(|t| t.marker == path.name)?;
        let (found, real) = (path.at.first()?, track.at.first()?);
        Some((found[0] - real[0]).hypot(found[1] - real[1]))
    };
    paths.iter().filter_map(marker_error).fold(0.0, f64::max)
}

/// The 95 % quantile of χ² with two degrees of freedom.
const ELLIPSE_95: f64 = 5.991;

/// Estimated positions of a film's markers.
#[derive(Clone, Copy)]
struct Estimated<'a> {
    paths: &'a [Path],
    /// Times of the frames, s.
    time: &'a [Second],
}

impl Estimated<'_> {
    /// Root mean square distance from the truth, of the marker with the largest.
    fn worst_rms(&self, truth: &[TrueTrack], true_place: &dyn Fn(&TrueTrack, usize) -> Point2) -> f64 {
        let Self { paths, time } = *self;
        let marker_rms = |path: &Path| {
            let Some(track) = truth.iter().find(|t| t.marker == path.name) else {
                return f64::INFINITY;
            };
            let squares = time.iter().zip(&path.at).map(|(&t, p)| {
                let q = true_place(track, frame_at(&track.time, t));
                (p[0] - q[0]).powi(2) + (p[1] - q[1]).powi(2)
            });
            (squares.sum::<f64>() / path.at.len().max(1) as f64).sqrt()
        };
        paths.iter().map(marker_rms).fold(0.0, f64::max)
    }

    /// Counts the positions whose 95 % ellipse contains the true one.
    fn count_coverage(
        &self,
        [inside, count]: &mut [usize; 2],
        truth: &[TrueTrack],
        true_place: &dyn Fn(&TrueTrack, usize) -> Point2,
    ) {
        let Self { paths, time } = *self;
        for (path, track) in paths.iter().filter_map(|p| Some((p, truth.iter().find(|t| t.marker == p.name)?))) {
            for ((t, p), [xx, xy, yy]) in time.iter().zip(&path.at).zip(&path.spread) {
                let q = true_place(track, frame_at(&track.time, *t));
                let [x, y] = [p[0] - q[0], p[1] - q[1]];
                let square = (yy * x * x - 2.0 * xy * x * y + xx * y * y) / (xx * yy - xy * xy);
                *inside += usize::from(square < ELLIPSE_95);
                *count += 1;
            }
        }
    }
}

/// The true frame nearest in time.
pub(super) fn frame_at(times: &[Second], t: Second) -> usize {
    let right = times.partition_point(|&s| s < t).min(times.len() - 1);
    if right > 0 && t - times[right - 1] < times[right] - t { right - 1 } else { right }
}

/// Largest difference of found from true log time over the film, s.
fn clock_error(motion: &Motion, truth: &TrueTrial) -> Second {
    let error_at = |t: Second| {
        let (found, truth) = (motion.clock.offset + motion.clock.scale * t, truth.clock_offset + truth.clock_scale * t);
        (found - truth).abs()
    };
    motion.time.iter().map(|&t| error_at(t)).fold(0.0, f64::max)
}
