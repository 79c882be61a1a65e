//! Interpolation of a track over the frames in which the marker was hidden.

use super::Observation;
use si::Point2;

/// Fills the frames in which a marker was hidden, in place: a cubic from the places and speeds on either side.
///
/// How far a marker may leave that cubic in n frames grows with its acceleration: a n₁ n₂ / 2 with n₁, n₂ frames to either side
/// and a the root mean square of the second differences of what was seen, and no less than the covariance of the observations.
pub fn fill_gaps(track: &mut [Observation]) {
    let bend = rms_acceleration(track);
    let mut frame = 0;
    while frame < track.len() {
        if track[frame].seen {
            frame += 1;
            continue;
        }
        let next_seen = (frame..track.len()).find(|k| track[*k].seen);
        if let (Some(last_seen), Some(next_seen)) = (frame.checked_sub(1), next_seen) {
            bridge_gap(track, last_seen, next_seen, bend);
        }
        frame = next_seen.unwrap_or(track.len());
    }
}

/// Root mean square of second differences along each axis, px a frame².
fn rms_acceleration(track: &[Observation]) -> Point2 {
    let (mut sum, mut count) = ([0.0; 2], 0.0_f64);
    for three in track.windows(3).filter(|three| three.iter().all(|s| s.seen)) {
        [0, 1].iter().for_each(|&k| sum[k] += (three[0].at[k] - 2.0 * three[1].at[k] + three[2].at[k]).powi(2));
        count += 1.0;
    }
    sum.map(|s| (s / count.max(1.0)).sqrt())
}

fn bridge_gap(track: &mut [Observation], before: usize, after: usize, bend: Point2) {
    let (start, end) = (track[before], track[after]);
    let seen = |k: Option<usize>| k.and_then(|k| track.get(k)).filter(|s| s.seen).map(|s| s.at);
    let length = (after - before) as f64;
    let mean = [0, 1].map(|k| (end.at[k] - start.at[k]) / length);
    let speed = |near: Point2, far: Option<Point2>, sign: f64| {
        far.map_or(mean, |far| [0, 1].map(|k| sign * (near[k] - far[k])))
    };
    let leaves = speed(start.at, seen(before.checked_sub(1)), 1.0);
    let arrives = speed(end.at, seen(Some(after + 1)), -1.0);
    for (n, filled) in track[before + 1..after].iter_mut().enumerate() {
        let frames_since = (n + 1) as f64;
        let s = frames_since / length;
        filled.at = [0, 1].map(|k| {
            let (a, b) = (length * (leaves[k] - mean[k]), length * (mean[k] - arrives[k]));
            start.at[k] + s * (end.at[k] - start.at[k]) + s * (1.0 - s) * (a * (1.0 - s) + b * s)
        });
        let variance = bend.map(|a| (0.5 * a * frames_since * (length - frames_since)).powi(2));
        let [[xx, xy], [yx, yy]] = end.covariance;
        filled.covariance = [[xx + variance[0], xy], [yx, yy + variance[1]]];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_swing_hidden_for_a_third_of_a_second_is_bridged_within_three_deviations() {
        let place = |k: usize| [100.0 + 2.0 * k as f64, 90.0 + 30.0 * (0.21 * k as f64).sin()];
        let seen = |k: usize| Observation {
            at: if (30..50).contains(&k) { place(29) } else { place(k) },
            covariance: [[1e-4, 0.0], [0.0, 1e-4]],
            residual: 1.0,
            seen: !(30..50).contains(&k),
        };
        let mut track: Vec<Observation> = (0..90).map(seen).collect();
        fill_gaps(&mut track);
        for (k, here) in track.iter().enumerate() {
            let miss = [0, 1].map(|i| here.at[i] - place(k)[i]);
            let allowed = [0, 1].map(|i| 3.0 * here.covariance[i][i].sqrt());
            assert!(miss[0].abs() < allowed[0] && miss[1].abs() < allowed[1], "{k}: {miss:?} {allowed:?}");
        }
    }

    #[test]
    fn a_parabola_is_bridged_to_the_size_of_its_differences() {
        let place = |k: usize| [0.02 * (k * k) as f64, 1.0];
        let seen = |k: usize| Observation {
            at: place(k),
            covariance: [[0.0; 2]; 2],
            residual: 0.0,
            seen: !(9..14).contains(&k),
        };
        let mut track: Vec<Observation> = (0..30).map(seen).collect();
        (9..14).for_each(|k| track[k].at = [0.0; 2]);
        fill_gaps(&mut track);
        // speeds from differences of one frame are off by half a second difference, 0.02 px a frame, over a quarter of 6 frames
        assert!((9..14).all(|k| (track[k].at[0] - place(k)[0]).abs() < 0.03 + 1e-9), "{:?}", &track[9..14]);
    }
}
