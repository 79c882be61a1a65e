//! A lens from the YAML that OpenCV and ROS write: `camera_matrix` and `distortion_coefficients`.

use super::{Distortion, Lens};

/// Why a text is no lens.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum YamlError {
    /// A matrix that is not there, or has another number of values.
    #[error(
        "the lens has no usable `{key}`\n  why: {found} numbers stand in its data, {wanted} are needed\n  do:  write it with cv::FileStorage, or as camera_calibration of ROS does"
    )]
    Values {
        /// Which matrix.
        key: &'static str,
        /// Numbers found.
        found: usize,
        /// Numbers needed.
        wanted: &'static str,
    },
    /// Distortion that neither kind of lens here has.
    #[error(
        "the lens has a rational, thin-prism or tilted distortion\n  why: coefficient {at} of {count} is {value}; those beyond the fifth must be 0\n  do:  calibrate without CALIB_RATIONAL_MODEL, CALIB_THIN_PRISM_MODEL and CALIB_TILTED_MODEL"
    )]
    Model {
        /// Which coefficient, from 1.
        at: usize,
        /// Of how many.
        count: usize,
        /// Its value.
        value: f64,
    },
}

/// Numbers of the distortion that are read: k₁ k₂ p₁ p₂ k₃.
const BENDS: usize = 5;

/// The lens in a text; four coefficients are a fisheye's when `fisheye` is set or the text names that model.
///
/// # Errors
/// [`YamlError`] when a matrix is missing or the distortion is of another kind.
pub fn read(text: &str, fisheye: bool) -> Result<Lens, YamlError> {
    let matrix = data(text, &["camera_matrix", "Camera_Matrix", "cameraMatrix", "K"]).unwrap_or_default();
    let [fx, _, cx, _, fy, cy, ..] = matrix[..] else {
        return Err(YamlError::Values { key: "camera_matrix", found: matrix.len(), wanted: "9" });
    };
    let keys = ["distortion_coefficients", "Distortion_Coefficients", "distCoeffs", "dist_coeffs", "D"];
    let coefficients = data(text, &keys).unwrap_or_default();
    let fisheye = fisheye || ["equidistant", "fisheye"].iter().any(|name| text.contains(name));
    let beyond = |limit: usize| coefficients.iter().enumerate().skip(limit).find(|(_, value)| **value != 0.0);
    let limit = if fisheye { 4 } else { BENDS };
    if let Some((at, value)) = beyond(limit) {
        return Err(YamlError::Model { at: at + 1, count: coefficients.len(), value: *value });
    }
    if coefficients.len() < 4 {
        return Err(YamlError::Values {
            key: "distortion_coefficients",
            found: coefficients.len(),
            wanted: "4 or more",
        });
    }
    let distortion = if fisheye { Distortion::Fisheye } else { Distortion::BrownConrady };
    let fifth = if fisheye { 0.0 } else { coefficients.get(4).copied().unwrap_or(0.0) };
    let lens = Lens { distortion, ..Lens::default() };
    Ok(lens.with([fx, fy, cx, cy, coefficients[0], coefficients[1], coefficients[2], coefficients[3], fifth]))
}

/// The numbers in the `data: […]` that follows one of the keys.
fn data(text: &str, keys: &[&str]) -> Option<Vec<f64>> {
    let after = |key: &&str| {
        let title = format!("{key}:");
        let at =
            text.match_indices(&title).map(|(at, _)| at).find(|at| *at == 0 || text[..*at].ends_with(['\n', ' ']))?;
        Some(&text[at + key.len() + 1..])
    };
    let rest = keys.iter().find_map(after)?;
    let open = rest.find('[')?;
    let close = open + rest[open..].find(']')?;
    let words = rest[open + 1..close].split([',', ' ', '\n', '\r', '\t']).filter(|word| !word.is_empty());
    words.map(|word| word.trim_end_matches('.').parse().ok()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "%YAML:1.0\n---\nimage_width: 1920\ncamera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: [ 1.473e+03, 0., 9.69e+02, 0., 1.478e+03,\n       5.41e+02, 0., 0., 1. ]\ndistortion_coefficients: !!opencv-matrix\n   rows: 1\n   cols: 5\n   dt: d\n   data: [ -2.5e-01, 7.0e-02, 1.0e-03,\n       -5.0e-04, 3.0e-01 ]\n";

    #[test]
    fn a_lens_that_opencv_wrote_is_read() {
        let lens = read(TEXT, false).unwrap();
        assert_eq!(lens.values(), [1473.0, 1478.0, 969.0, 541.0, -0.25, 0.07, 1e-3, -5e-4, 0.3]);
        assert_eq!(lens.distortion, Distortion::BrownConrady);
    }

    #[test]
    fn four_coefficients_of_an_equidistant_lens_are_a_fisheye_s() {
        let four = TEXT.replace(", 3.0e-01 ]", ",\n 0. ]").replace("---", "---\ndistortion_model: equidistant");
        let four = four.replace("-5.0e-04,\n 0. ]", "-5.0e-04 ]");
        let lens = read(&four, false).unwrap();
        assert_eq!((lens.distortion, lens.k3, lens.k4, lens.p1), (Distortion::Fisheye, 1e-3, -5e-4, 0.0));
    }

    #[test]
    fn a_rational_lens_and_a_text_without_one_are_refused() {
        let rational = TEXT.replace("3.0e-01 ]", "3.0e-01, 0.02, 0., 0. ]");
        assert!(matches!(read(&rational, false), Err(YamlError::Model { at: 6, count: 8, .. })));
        assert!(matches!(read("a: 1", false), Err(YamlError::Values { key: "camera_matrix", .. })));
    }
}
