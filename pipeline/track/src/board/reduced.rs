//! A smaller copy of a large picture: boards are looked for in it, and their points refined in the picture itself.

use crate::Gray;
use si::Point2;

/// Pixels above which a picture is reduced, and pixels that it has then at most: a board that fills a fifth of its width is still seen.
const LARGE: usize = 4_000_000;
const REDUCED: usize = 2_000_000;

/// A picture of which each pixel is the mean of a block.
#[derive(Debug, Clone, PartialEq)]
pub struct Reduced {
    /// The means.
    pub picture: Gray,
    /// Side of a block, px of the whole picture.
    pub block: usize,
}

impl Reduced {
    /// The copy of a picture that is too large to be searched as a whole.
    pub(super) fn of_large_picture(picture: &Gray) -> Option<Self> {
        (picture.pixels.len() > LARGE).then(|| Self::with_at_most(picture, REDUCED))
    }

    /// The copy of at most `pixels` pixels, in whole blocks; what is left at the right and the lower end is left out.
    pub fn with_at_most(picture: &Gray, pixels: usize) -> Self {
        let block = (picture.pixels.len() as f64 / pixels as f64).sqrt().ceil().max(1.0) as usize;
        let (width, height) = ((picture.width / block).max(1), (picture.height / block).max(1));
        let mut levels = Vec::with_capacity(width * height);
        let area = (block * block) as u32;
        for rows in picture.pixels.chunks_exact(picture.width * block).take(height) {
            // length: the last columns and rows that fill no block are left out
            let mut sums = vec![0_u32; width];
            for row in rows.chunks_exact(picture.width) {
                for (sum, levels) in sums.iter_mut().zip(row.chunks_exact(block)) {
                    *sum += levels.iter().map(|level| u32::from(*level)).sum::<u32>();
                }
            }
            levels.extend(sums.iter().map(|sum| ((sum + area / 2) / area) as u8));
        }
        Self { picture: Gray { width, height, pixels: levels }, block }
    }

    /// The middle of a block's pixels, px of the whole picture, for a place in the copy.
    pub(crate) fn to_picture(&self, place: Point2) -> Point2 {
        place.map(|c| c * self.block as f64 + 0.5 * (self.block as f64 - 1.0))
    }

    /// A place of the whole picture in the copy.
    pub fn to_copy(&self, place: Point2) -> Point2 {
        place.map(|c| (c - 0.5 * (self.block as f64 - 1.0)) / self.block as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_block_becomes_its_mean_at_its_middle() {
        let picture = Gray::from_fn(7, 5, |x, y| (10 * y + x) as f64);
        let reduced = Reduced::with_at_most(&picture, 9);
        assert_eq!((reduced.block, reduced.picture.width, reduced.picture.height), (2, 3, 2));
        // 2, 3, 12 and 13; 20, 21, 30 and 31, rounded
        assert_eq!((reduced.picture.pixels[1], reduced.picture.pixels[3]), (8, 26));
        assert_eq!(reduced.to_picture([1.0, 0.0]), [2.5, 0.5]);
        assert_eq!(reduced.to_copy([2.5, 0.5]), [1.0, 0.0]);
        assert!(Reduced::of_large_picture(&picture).is_none());
    }
}
