//! Comparison of a film's pictures with those by which its camera was calibrated.

/// Pictures of two sizes, of a film and of the calibration of its camera, which may be a film or a file: focal lengths and the optical axis are in pixels of one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("the film has pictures of {} × {} px, the calibration of {} × {} px\n  why: {}\n  do:  {}", .film[0], .film[1], .calibration[0], .calibration[1], self.why(), self.action())]
pub struct OtherSize {
    /// Width and height of the film's pictures, px.
    pub film: [usize; 2],
    /// Of those of the calibration, px.
    pub calibration: [usize; 2],
}

impl OtherSize {
    fn why(&self) -> String {
        let [ratio, other] = [0, 1].map(|k| self.film[k] as f64 / self.calibration[k] as f64);
        match self.film == [self.calibration[1], self.calibration[0]] {
            true => {
                "one of them is turned by a quarter: the camera was held, or a program saved it, on its side".into()
            }
            false if (ratio / other - 1.0).abs() < 1e-2 => {
                format!("the film is scaled by {ratio:.3}; a lens holds for one size and cut of the picture")
            }
            false => "one of them is cut; a lens holds for one size and cut of the picture".into(),
        }
    }

    fn action(&self) -> &'static str {
        "film board and specimen with the same settings of the camera, and give both as the camera saved them"
    }
}

/// Whether a film has pictures of the calibration's size, px.
///
/// # Errors
/// [`OtherSize`] with both.
pub fn check(calibration: [usize; 2], film: [usize; 2]) -> Result<(), OtherSize> {
    if film == calibration { Ok(()) } else { Err(OtherSize { film, calibration }) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn another_size_is_refused_with_both_and_what_was_done() {
        assert_eq!(check([1920, 1080], [1920, 1080]), Ok(()));
        for (film, word) in
            [([1440, 810], "scaled by 0.750"), ([1080, 1920], "turned by a quarter"), ([1920, 800], "cut")]
        {
            let said = check([1920, 1080], film).unwrap_err().to_string();
            let sizes = format!("{} × {} px, the calibration of 1920 × 1080 px", film[0], film[1]);
            assert!(said.contains(&sizes) && said.contains(word), "{said}");
        }
    }
}
