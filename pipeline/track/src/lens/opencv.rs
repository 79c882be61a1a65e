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
    /// A matrix that no lens has.
    #[error(
        "the lens has no usable `{key}`\n  why: number {at} is {value}; {wanted}\n  do:  write it with cv::FileStorage, or as camera_calibration of ROS does"
    )]
    Number {
        /// Which matrix.
        key: &'static str,
        /// Which number of its data, from 1.
        at: usize,
        /// Its value.
        value: f64,
        /// What it should be.
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
/// Numbers of coefficients that OpenCV writes.
const COUNTS: [usize; 5] = [4, 5, 8, 12, 14];
/// Keys of a matrix that may stand before its data.
const BEFORE_DATA: [&str; 4] = ["rows", "cols", "dt", "data"];

/// Names of both in messages.
const MATRIX: &str = "camera_matrix";
const COEFFICIENTS: &str = "distortion_coefficients";

/// The lens in a text; four coefficients are a fisheye's when `fisheye` is set or the text names that model.
///
/// # Errors
/// [`YamlError`] when a matrix is missing or the distortion is of another kind.
pub fn read(text: &str, fisheye: bool) -> Result<Lens, YamlError> {
    let matrix = data(text, &["camera_matrix", "Camera_Matrix", "cameraMatrix", "K"]).unwrap_or_default();
    let [fx, _, cx, _, fy, cy, _, _, _] = matrix[..] else {
        return Err(YamlError::Values { key: MATRIX, found: matrix.len(), wanted: "9" });
    };
    check_matrix(&matrix)?;
    let keys = ["distortion_coefficients", "Distortion_Coefficients", "distCoeffs", "dist_coeffs", "D"];
    let coefficients = data(text, &keys).unwrap_or_default();
    let fisheye = fisheye || ["equidistant", "fisheye"].iter().any(|name| text.contains(name));
    let beyond = |limit: usize| coefficients.iter().enumerate().skip(limit).find(|(_, value)| **value != 0.0);
    let limit = if fisheye { 4 } else { BENDS };
    if let Some((at, value)) = beyond(limit) {
        return Err(YamlError::Model { at: at + 1, count: coefficients.len(), value: *value });
    }
    if !COUNTS.contains(&coefficients.len()) {
        return Err(YamlError::Values { key: COEFFICIENTS, found: coefficients.len(), wanted: "4, 5, 8, 12 or 14" });
    }
    if let Some((at, &value)) = coefficients.iter().enumerate().find(|(_, value)| !value.is_finite()) {
        return Err(YamlError::Number { key: COEFFICIENTS, at: at + 1, value, wanted: "coefficients are finite" });
    }
    let distortion = if fisheye { Distortion::Fisheye } else { Distortion::BrownConrady };
    let fifth = if fisheye { 0.0 } else { coefficients.get(4).copied().unwrap_or(0.0) };
    let lens = Lens { distortion, ..Lens::default() };
    Ok(lens.with([fx, fy, cx, cy, coefficients[0], coefficients[1], coefficients[2], coefficients[3], fifth]))
}

/// Whether nine numbers are [fx 0 cx; 0 fy cy; 0 0 1] with focal lengths above 0.
fn check_matrix(matrix: &[f64]) -> Result<(), YamlError> {
    for (at, &value) in matrix.iter().enumerate() {
        let wanted = match at {
            _ if !value.is_finite() => "every one is finite",
            0 | 4 if value <= 0.0 => "focal lengths are above 0",
            1 | 3 | 6 | 7 if value != 0.0 => "a lens here has no skew, and the last row is 0 0 1",
            8 if value != 1.0 => "the last row is 0 0 1",
            _ => continue,
        };
        return Err(YamlError::Number { key: MATRIX, at: at + 1, value, wanted });
    }
    Ok(())
}

/// The numbers in the `data: […]` that follows one of the keys; none where another key comes first, whose data it would be.
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
    // from the second line on: the first may name a type
    let keys = rest[..open].lines().skip(1).filter_map(|line| line.split_once(':'));
    if keys.map(|(key, _)| key.trim()).any(|key| !BEFORE_DATA.contains(&key)) {
        return None;
    }
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
    fn a_matrix_that_no_lens_has_is_refused_with_its_number() {
        for (from, to, number) in [
            ("1.473e+03", "-1.473e+03", 1),
            ("1.473e+03", "nan", 1),
            ("1.473e+03, 0.", "1.473e+03, 3.", 2),
            ("1.478e+03", "0.", 5),
            ("5.41e+02", "inf", 6),
            ("0., 1. ]", "0., 2. ]", 9),
        ] {
            let error = read(&TEXT.replace(from, to), false).unwrap_err();
            assert!(matches!(error, YamlError::Number { key: "camera_matrix", at, .. } if at == number), "{error}");
        }
        let error = read(&TEXT.replace("7.0e-02", "nan"), false).unwrap_err();
        assert!(error.to_string().contains("`distortion_coefficients`\n  why: number 2 is NaN"), "{error}");
        let more = TEXT.replace("0., 1. ]", "0., 1., 4. ]");
        assert!(matches!(read(&more, false), Err(YamlError::Values { found: 10, .. })));
    }

    #[test]
    fn the_data_of_the_next_key_are_not_those_of_a_key_without_any() {
        let first =
            TEXT.replacen("   data: [ 1.473e+03, 0., 9.69e+02, 0., 1.478e+03,\n       5.41e+02, 0., 0., 1. ]\n", "", 1);
        let nine = first.replace("3.0e-01 ]", "0., 0., 0., 0., 0. ]");
        assert!(matches!(read(&nine, false), Err(YamlError::Values { key: "camera_matrix", found: 0, .. })));
    }

    #[test]
    fn a_rational_lens_and_a_text_without_one_are_refused() {
        let rational = TEXT.replace("3.0e-01 ]", "3.0e-01, 0.02, 0., 0. ]");
        assert!(matches!(read(&rational, false), Err(YamlError::Model { at: 6, count: 8, .. })));
        assert!(matches!(
            read(&TEXT.replace("3.0e-01 ]", "3.0e-01, 0. ]"), false),
            Err(YamlError::Values { found: 6, .. })
        ));
        assert!(matches!(read("a: 1", false), Err(YamlError::Values { key: "camera_matrix", .. })));
    }
}
