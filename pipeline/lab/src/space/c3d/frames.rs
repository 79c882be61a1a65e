//! The number of frames of a `.c3d`, of which its header holds two bytes.
//!
//! Longer recordings have it in TRIAL:ACTUAL_START_FIELD and ACTUAL_END_FIELD, or in POINT:LONG_FRAMES; their header then says 65,535, or what is left of
//! the number in two bytes. The length of the file decides which of the numbers is meant, and a file that fits none is refused.

use super::parameters::Parameters;

/// Bytes after the last frame at most: the data end with a block, and some programs add another.
const PADDING: usize = 1024;
/// A count that could go no further.
const SATURATED: usize = 65_535;
/// After so many, a count of two bytes begins anew.
const WRAP: usize = 65_536;

/// What a file says of its frames, and what it holds.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Announced {
    /// Numbers of frames, the most trusted first.
    pub counts: Vec<usize>,
    /// Bytes of a frame.
    pub frame: usize,
    /// Bytes from the first frame to the end of the file.
    pub bytes: usize,
    /// Zeros at the end of the file.
    pub zeros: usize,
}

impl Announced {
    /// Counts of the parameters, then that of the header.
    pub(super) fn counts(parameters: &Parameters, header: usize) -> Vec<usize> {
        let single = |name| parameters.number_list("POINT", name).first().map(|count| *count as usize);
        let long = |name| match parameters.number_list("TRIAL", name)[..] {
            [low, high] => Some(low as usize + WRAP * high as usize),
            _ => None,
        };
        let trial = long("ACTUAL_END_FIELD").zip(long("ACTUAL_START_FIELD"));
        let trial = trial.and_then(|(last, first)| (last + 1).checked_sub(first));
        [trial, single("LONG_FRAMES"), single("FRAMES"), Some(header)].into_iter().flatten().collect()
    }

    /// The number of frames, where the file has that many and no more; else how many it has.
    ///
    /// # Errors
    /// Frames that are announced and frames that the file holds.
    pub(super) fn frame_count(&self) -> Result<usize, (usize, usize)> {
        let capacity = self.bytes.checked_div(self.frame).unwrap_or(0);
        let padding_frames = PADDING / self.frame.max(1);
        let fits = |count: usize| (capacity.saturating_sub(padding_frames)..=capacity).contains(&count);
        let unwrap_count = |count: usize| count + WRAP * (capacity.saturating_sub(count) / WRAP);
        let exact = self.counts.iter().copied().find(|count| fits(*count) && *count != SATURATED);
        if let Some(count) =
            exact.or_else(|| self.counts.iter().map(|c| unwrap_count(*c)).find(|c| fits(*c) && *c > SATURATED))
        {
            return Ok(count);
        }
        match self.counts.contains(&SATURATED) {
            // what fills the last block are no frames
            true if capacity >= SATURATED => Ok(capacity - padding_frames.min(self.zeros / self.frame.max(1))),
            _ => Err((self.counts.first().copied().unwrap_or_default(), capacity)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame_count(counts: &[usize], held: usize, padding: usize) -> Result<usize, (usize, usize)> {
        Announced { counts: counts.to_vec(), frame: 32, bytes: 32 * held + padding, zeros: padding }.frame_count()
    }

    #[test]
    fn the_count_that_the_file_bears_out_is_taken() {
        assert_eq!(frame_count(&[400, 400], 400, 300), Ok(400));
        assert_eq!(frame_count(&[400], 410, 0), Ok(400), "a block of zeros");
        assert_eq!(frame_count(&[90_000, 65_535, 65_535], 90_000, 100), Ok(90_000));
        assert_eq!(frame_count(&[24_464, 24_464], 90_000, 0), Ok(90_000), "what is left of it in two bytes");
        assert_eq!(frame_count(&[65_535, 65_535], 90_000, 0), Ok(90_000));
        assert_eq!(frame_count(&[65_535, 65_535], 90_000, 96), Ok(90_000), "zeros that fill the block");
        assert_eq!(frame_count(&[24_464, 65_535], 90_003, 0), Ok(90_000));
        assert_eq!(frame_count(&[65_535], 65_535, 0), Ok(65_535));
        assert_eq!(frame_count(&[0], 3, 31), Ok(0));
    }

    #[test]
    fn a_file_that_was_cut_or_holds_more_fits_no_count() {
        assert_eq!(frame_count(&[40, 40], 32, 0), Err((40, 32)));
        assert_eq!(frame_count(&[24_464], 50_000, 0), Err((24_464, 50_000)));
        assert_eq!(frame_count(&[90_000, 65_535], 60_000, 0), Err((90_000, 60_000)));
    }
}
