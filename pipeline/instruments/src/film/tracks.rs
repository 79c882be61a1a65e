//! Tracks of a film: every marker in every frame.

use std::fmt::Write;
use std::path::Path;

use si::Second;
use track::klt::Observation;

/// Every marker in every frame, and when.
#[derive(Debug, Clone, PartialEq)]
pub struct Tracks {
    /// Number of the first frame in the film.
    pub first: usize,
    /// Of each frame, s.
    pub time: Vec<Second>,
    /// Markers × frames.
    pub markers: Vec<Vec<Observation>>,
}

impl Tracks {
    pub(super) fn begin(first: usize) -> Self {
        Self { first, time: Vec::new(), markers: Vec::new() }
    }

    /// One frame: an observation a marker.
    pub(super) fn push_frame(&mut self, time: Second, observations: Vec<Observation>) {
        self.time.push(time);
        self.markers.resize_with(observations.len(), Vec::new);
        self.markers.iter_mut().zip(observations).for_each(|(track, observation)| track.push(observation));
    }

    /// What was tracked, and where the results lie.
    pub fn summary(&self, folder: &Path) -> String {
        let hidden = self.markers.iter().flatten().filter(|o| !o.seen).count();
        let (markers, frames) = (self.markers.len(), self.time.len());
        format!("{markers} markers × {frames} frames, occluded in {hidden}; results in {}", folder.display())
    }

    /// One line a frame and marker.
    pub(super) fn to_csv(&self) -> String {
        let mut text = String::from("frame,time_s,marker,u_px,v_px,uu_px2,uv_px2,vv_px2,residual,seen\n");
        for (frame, t) in self.time.iter().enumerate() {
            for (marker, track) in self.markers.iter().enumerate() {
                let o = &track[frame];
                let ([u, v], [[uu, uv], [_, vv]]) = (o.at, o.covariance);
                let (frame, name, seen) = (self.first + frame, marker + 1, u8::from(o.seen));
                let line = format_args!(
                    "{frame},{t:.6},m{name},{u:.4},{v:.4},{uu:.3e},{uv:.3e},{vv:.3e},{:.2},{seen}",
                    o.residual
                );
                writeln!(text, "{line}").expect("a string takes any text");
            }
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_summary_counts_what_was_occluded() {
        let observation =
            |seen| Observation { at: [1.5, 2.5], covariance: [[0.01, 0.0], [0.0, 0.04]], residual: 1.25, seen };
        let mut tracks = Tracks::begin(7);
        tracks.push_frame(0.25, vec![observation(true), observation(true)]);
        tracks.push_frame(0.5, vec![observation(true), observation(false)]);
        tracks.push_frame(0.75, vec![observation(true), observation(true)]);
        let said = tracks.summary(Path::new("out"));
        assert_eq!(said, "2 markers × 3 frames, occluded in 1; results in out");
        let table = tracks.to_csv();
        assert_eq!(table.lines().count(), 1 + 6);
        let line = "8,0.500000,m2,1.5000,2.5000,1.000e-2,0.000e0,4.000e-2,1.25,0";
        assert_eq!(table.lines().nth(4), Some(line));
    }
}
