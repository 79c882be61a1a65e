//! Cuts in a film: the scene of a frame has nothing in common with that of the frame before.
//!
//! Two frames of one scene correlate whatever moves in it, since most of a picture is background; two scenes do not. Brightness and contrast
//! do not enter a correlation.

use crate::Gray;

/// Blocks along the longer side into which a picture is averaged.
const BLOCKS: usize = 48;
/// Correlation of two successive frames below which the scene has changed.
const LIMIT: f64 = 0.5;
/// Least correlation of frames of one scene before a cut: in a film that flickers no cut is discernible.
const STEADY: f64 = 0.8;

/// Looks for a cut from frame to frame.
#[derive(Debug, Clone, Default)]
pub struct SceneCuts {
    before: Option<Vec<f64>>,
    steady: bool,
}

impl SceneCuts {
    /// Whether the scene was cut between the frame of the last call and this one.
    pub fn is_cut(&mut self, picture: &Gray) -> bool {
        let now = block_deviations(picture);
        let correlation = self.before.as_ref().filter(|b| b.len() == now.len()).map(|b| correlation(b, &now));
        self.before = Some(now);
        let cut = self.steady && correlation.is_some_and(|c| c < LIMIT);
        self.steady = correlation.is_some_and(|c| c > STEADY);
        cut
    }
}

/// Means of square blocks, less the mean of all.
fn block_deviations(picture: &Gray) -> Vec<f64> {
    let side = (picture.width.max(picture.height) / BLOCKS).max(1);
    let band_count = picture.height / side;
    let bands = picture.pixels.chunks_exact(side * picture.width).take(band_count);
    let means: Vec<f64> = bands.flat_map(|band| band_means(band, picture.width, side)).collect();
    let mean = means.iter().sum::<f64>() / means.len().max(1) as f64;
    means.into_iter().map(|level| level - mean).collect()
}

/// Means of the blocks in a band of `side` lines. Line by line, so that sums of neighbouring bytes are formed in vector registers.
fn band_means(band: &[u8], width: usize, side: usize) -> Vec<f64> {
    let mut sums = vec![0_u64; width / side];
    for line in band.chunks_exact(width) {
        let row = |block: &[u8]| block.iter().map(|&p| u32::from(p)).sum::<u32>();
        sums.iter_mut().zip(line.chunks_exact(side)).for_each(|(sum, block)| *sum += u64::from(row(block)));
    }
    sums.into_iter().map(|sum| sum as f64 / (side * side) as f64).collect()
}

fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    dot(a, b) / (dot(a, a) * dot(b, b)).sqrt().max(1e-9)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene(seed: f64, ball: f64) -> Gray {
        Gray::from_fn(320, 240, |u, v| {
            let ground = 120.0 + 60.0 * ((u as f64 * 0.031 * seed).sin() * (v as f64 * 0.023 * seed).cos());
            if (u as f64 - ball).hypot(v as f64 - 120.0) < 40.0 { 20.0 } else { ground }
        })
    }

    #[test]
    fn a_cut_is_found_at_its_frame_and_a_moving_ball_is_none() {
        let mut cuts = SceneCuts::default();
        let found: Vec<bool> = (0..20)
            .map(|k| cuts.is_cut(&if k < 12 { scene(1.0, 60.0 + 8.0 * f64::from(k)) } else { scene(2.7, 200.0) }))
            .collect();
        assert_eq!(found.iter().position(|cut| *cut), Some(12));
        assert_eq!(found.iter().filter(|cut| **cut).count(), 1);
    }

    #[test]
    fn light_that_goes_out_is_no_cut() {
        let mut cuts = SceneCuts::default();
        let dimmed = |k: u32| {
            let bright = scene(1.0, 100.0);
            if k < 5 { bright } else { Gray::from_fn(320, 240, |u, v| 0.4 * bright.pixel_level(u, v)) }
        };
        assert!((0..10).all(|k| !cuts.is_cut(&dimmed(k))));
    }

    #[test]
    fn blocks_are_means_of_squares_less_the_mean_of_all() {
        // 96 × 6 px: blocks of 2 × 2 px, the column of a pixel as its level
        let picture = Gray::from_fn(96, 6, |u, _| u as f64);
        let found = block_deviations(&picture);
        assert_eq!(found.len(), 48 * 3);
        // the first block has the levels 0 and 1, the mean of all is 47.5
        assert!((found[0] + 47.0).abs() < 1e-12 && (found[47] - 47.0).abs() < 1e-12, "{found:?}");
        assert_eq!(found[..48], found[48..96]);
        assert_eq!(band_means(&[1, 3, 10, 20, 5, 7, 30, 40], 4, 2), [4.0, 25.0]);
    }

    #[test]
    fn frames_correlate_from_minus_one_to_one() {
        let (a, b) = ([1.0, -1.0, 2.0, -2.0], [2.0, -2.0, 4.0, -4.0]);
        assert!((correlation(&a, &b) - 1.0).abs() < 1e-12);
        assert!((correlation(&a, &b.map(|x| -x)) + 1.0).abs() < 1e-12);
        // by hand: (1 + 0 + 2 + 0)/√(10 · 2)
        assert!((correlation(&a, &[1.0, 0.0, 1.0, 0.0]) - 3.0 / 20f64.sqrt()).abs() < 1e-12);
    }
}
