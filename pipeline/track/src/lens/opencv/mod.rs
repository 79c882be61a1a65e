//! A lens from what OpenCV, ROS and Kalibr write: `camera_matrix` and `distortion_coefficients`, in YAML, JSON or XML.

mod rational;
mod values;

use super::{Distortion, Lens};
use rational::Rational;
use values::Values;

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
    /// A fisheye with more than four numbers.
    #[error(
        "the lens is a fisheye of more than four coefficients\n  why: coefficient {at} of {count} is {value}\n  do:  calibrate it with cv::fisheye::calibrate, or name the ordinary model"
    )]
    Model {
        /// Which coefficient, from 1.
        at: usize,
        /// Of how many.
        count: usize,
        /// Its value.
        value: f64,
    },
    /// A model that no lens here has.
    #[error(
        "the lens has the model `{name}`\n  why: ordinary lenses (plumb_bob, radtan, rational_polynomial) and fisheyes (equidistant) are read\n  do:  calibrate with one of these models"
    )]
    OtherModel {
        /// Its name.
        name: String,
    },
    /// Distortion of more than five numbers that five do not describe.
    #[error(
        "a lens of {count} coefficients is not met by one of five\n  why: the nearest is {off:.2} px off over the picture, as a root mean square; the limit is {limit} px\n  do:  calibrate without CALIB_RATIONAL_MODEL, CALIB_THIN_PRISM_MODEL and CALIB_TILTED_MODEL"
    )]
    NotFitted {
        /// How many it has.
        count: usize,
        /// Root mean square distance, px.
        off: f64,
        /// The limit, px.
        limit: f64,
    },
    /// A file of several cameras.
    #[error(
        "the file has {cameras} cameras\n  why: a film is of one\n  do:  keep the camera of this film, and delete the others"
    )]
    Cameras {
        /// How many.
        cameras: usize,
    },
}

/// Numbers of the distortion that a lens here has: k₁ k₂ p₁ p₂ k₃.
const BENDS: usize = 5;
/// Numbers of coefficients that OpenCV writes.
const COUNTS: [usize; 5] = [4, 5, 8, 12, 14];
/// Largest distance of a lens of five numbers from one of more, as a root mean square over the picture, px: below it is lost in the errors of corners.
const FITTED: f64 = 0.1;

/// Names of both in messages.
const MATRIX: &str = "camera_matrix";
const COEFFICIENTS: &str = "distortion_coefficients";

/// Names of both in files.
const MATRICES: [&str; 7] = ["camera_matrix", "Camera_Matrix", "cameraMatrix", "camera_mtx", "mtx", "K", "k"];
const BENT: [&str; 10] = [
    "distortion_coefficients",
    "Distortion_Coefficients",
    "distCoeffs",
    "dist_coeffs",
    "dist_coeff",
    "dist_coefs",
    "distortion_coeffs",
    "dist",
    "D",
    "d",
];

/// A lens of a file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KnownLens {
    /// It.
    pub lens: Lens,
    /// Root mean square distance from the file's lens over the picture, px, where that has more numbers than ours.
    pub fitted_px: Option<f64>,
    /// Width and height of the pictures that it is of, px, where the file says so.
    pub size: Option<[usize; 2]>,
}

/// The lens in a text of OpenCV (YAML, JSON, XML), ROS, ROS 2 or Kalibr; four coefficients are a fisheye's when `fisheye` is set or the text names
/// that model.
///
/// # Errors
/// [`YamlError`] when a matrix is missing or the distortion is of another kind.
pub fn read(text: &str, fisheye: bool) -> Result<KnownLens, YamlError> {
    let values = Values::new(text);
    // first the model: that of others has other numbers, and they would be missed
    let fisheye = is_fisheye(&values)? || fisheye;
    let matrix = camera_matrix(&values)?;
    check_matrix(&matrix)?;
    let mut coefficients = values.numbers_of(&BENT).unwrap_or_default();
    if coefficients.is_empty() && values.word_of(&["distortion_model"]) == Some("none") {
        coefficients = vec![0.0; BENDS];
    }
    if !COUNTS.contains(&coefficients.len()) {
        return Err(YamlError::Values { key: COEFFICIENTS, found: coefficients.len(), wanted: "4, 5, 8, 12 or 14" });
    }
    if let Some((at, &value)) = coefficients.iter().enumerate().find(|(_, value)| !value.is_finite()) {
        return Err(YamlError::Number { key: COEFFICIENTS, at: at + 1, value, wanted: "coefficients are finite" });
    }
    let [fx, _, cx, _, fy, cy, ..] = matrix;
    let limit = if fisheye { 4 } else { BENDS };
    let unsupported_coefficient = coefficients.iter().enumerate().skip(limit).find(|(_, value)| **value != 0.0);
    match unsupported_coefficient {
        Some((at, value)) if fisheye => Err(YamlError::Model { at: at + 1, count: coefficients.len(), value: *value }),
        Some(_) => fit_lens([fx, fy, cx, cy], &coefficients, &values),
        None => {
            let distortion = if fisheye { Distortion::Fisheye } else { Distortion::BrownConrady };
            let fifth = if fisheye { 0.0 } else { coefficients.get(4).copied().unwrap_or(0.0) };
            let lens = Lens { distortion, ..Lens::default() };
            let [a, b, c, d, ..] = coefficients[..] else {
                return Err(YamlError::Values { key: COEFFICIENTS, found: 0, wanted: "4" });
            };
            let lens = lens.with_values([fx, fy, cx, cy, a, b, c, d, fifth]);
            Ok(KnownLens { lens, fitted_px: None, size: picture_size(&values) })
        }
    }
}

/// The nine numbers of the matrix, or Kalibr's four.
fn camera_matrix(values: &Values) -> Result<[f64; 9], YamlError> {
    // a file of several cameras names each its own
    let cameras = values.count_key("intrinsics");
    if cameras > 1 {
        return Err(YamlError::Cameras { cameras });
    }
    if let Some([fx, fy, cx, cy]) = values.numbers_of(&["intrinsics"]).as_deref() {
        return Ok([*fx, 0.0, *cx, 0.0, *fy, *cy, 0.0, 0.0, 1.0]);
    }
    let numbers = values.numbers_of(&MATRICES).unwrap_or_default();
    let found = numbers.len();
    numbers.try_into().map_err(|_| YamlError::Values { key: MATRIX, found, wanted: "9" })
}

/// Words for the two kinds of lens, in lower case, and keys under which they stand.
const FISHEYE: [&str; 4] = ["equidistant", "fisheye", "kannala_brandt", "opencv_fisheye"];
const ORDINARY: [&str; 9] = [
    "plumb_bob",
    "rational_polynomial",
    "radtan",
    "radial-tangential",
    "brown_conrady",
    "pinhole",
    "thin_prism",
    "none",
    "opencv",
];
/// Keys that name a model alone, and those that may name other things too.
const MODELS: [&str; 2] = ["distortion_model", "camera_model"];
const HINTS: [&str; 2] = ["lens", "model"];

/// Whether the file names a fisheye.
fn is_fisheye(values: &Values) -> Result<bool, YamlError> {
    let word = |key: &&str| values.word_of(&[*key]).map(str::to_ascii_lowercase);
    let named: Vec<String> = MODELS.iter().filter_map(word).collect();
    let is_known = |word: &String| FISHEYE.contains(&word.as_str()) || ORDINARY.contains(&word.as_str());
    // a model of another kind, such as Kalibr's `omni`, has numbers that mean something else
    if let Some(other) = named.iter().find(|word| !is_known(word)) {
        return Err(YamlError::OtherModel { name: other.clone() });
    }
    let mut words = named.into_iter().chain(HINTS.iter().filter_map(word));
    let is_flagged = values.word_of(&["fisheye_model"]).is_some_and(|word| word != "0");
    Ok(is_flagged || words.any(|word| FISHEYE.contains(&word.as_str())))
}

/// The size of the pictures, px, where the file has it.
fn picture_size(values: &Values) -> Option<[usize; 2]> {
    let side =
        |keys: &[&str]| values.word_of(keys).and_then(|word| word.parse::<usize>().ok()).filter(|side| *side > 0);
    // length: two numbers, not lists
    let sides = side(&["image_width", "width"]).zip(side(&["image_height", "height"]));
    let kalibr = || values.numbers_of(&["resolution"]).filter(|sides| sides.len() == 2);
    sides
        .map(|(width, height)| [width, height])
        .or_else(|| kalibr().map(|sides| [sides[0] as usize, sides[1] as usize]))
}

/// The nearest lens here to one of more coefficients.
fn fit_lens(camera: [f64; 4], coefficients: &[f64], values: &Values) -> Result<KnownLens, YamlError> {
    let numbers = std::array::from_fn(|i| coefficients.get(i).copied().unwrap_or(0.0));
    let size = picture_size(values);
    let [_, _, cx, cy] = camera;
    let picture = size.map_or([2.0 * cx + 1.0, 2.0 * cy + 1.0], |size| size.map(|side| side as f64));
    match (Rational { numbers }).nearest_lens(camera, picture) {
        Some((lens, off)) if off <= FITTED => Ok(KnownLens { lens, fitted_px: Some(off), size }),
        fit => Err(YamlError::NotFitted {
            count: coefficients.len(),
            off: fit.map_or(f64::INFINITY, |(_, off)| off),
            limit: FITTED,
        }),
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "%YAML:1.0\n---\nimage_width: 1920\ncamera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: [ 1.473e+03, 0., 9.69e+02, 0., 1.478e+03,\n       5.41e+02, 0., 0., 1. ]\ndistortion_coefficients: !!opencv-matrix\n   rows: 1\n   cols: 5\n   dt: d\n   data: [ -2.5e-01, 7.0e-02, 1.0e-03,\n       -5.0e-04, 3.0e-01 ]\n";

    #[test]
    fn a_lens_that_opencv_wrote_is_read() {
        let KnownLens { lens, fitted_px, size } = read(TEXT, false).unwrap();
        assert_eq!((fitted_px, size), (None, None), "its height is not said");
        assert_eq!(lens.values(), [1473.0, 1478.0, 969.0, 541.0, -0.25, 0.07, 1e-3, -5e-4, 0.3]);
        assert_eq!(lens.distortion, Distortion::BrownConrady);
    }

    #[test]
    fn four_coefficients_of_an_equidistant_lens_are_a_fisheye_s() {
        let four = TEXT.replace(", 3.0e-01 ]", ",\n 0. ]").replace("---", "---\ndistortion_model: equidistant");
        let four = four.replace("-5.0e-04,\n 0. ]", "-5.0e-04 ]");
        let lens = read(&four, false).unwrap().lens;
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
    fn json_xml_ros_and_kalibr_say_the_same_and_a_comment_says_nothing() {
        let known = [983.177, 986.516, 648.217, 361.83, -0.109478, 0.03375, 0.00034266, -0.000190545, 0.0];
        let matrix = "983.177, 0.0, 648.217, 0.0, 986.516, 361.83, 0.0, 0.0, 1.0";
        let bent = "-0.109478, 0.03375, 0.00034266, -0.000190545";
        let dashes = |list: &str| list.split(", ").map(|word| format!("- {word}\n")).collect::<String>();
        let blanks = |list: &str| list.replace(',', "");
        for text in [
            format!("%YAML:1.0\n---\n# not the fisheye of the other camera\ncamera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: [ {matrix} ]\ndistortion_coefficients: !!opencv-matrix\n   rows: 1\n   cols: 4\n   dt: d\n   data: [ {bent} ]\n"),
            format!("{{\"camera_matrix\": {{\"type_id\": \"opencv-matrix\", \"rows\": 3, \"cols\": 3, \"dt\": \"d\", \"data\": [ {matrix} ]}}, \"distortion_coefficients\": {{\"rows\": 1, \"data\": [ {bent} ]}}}}"),
            "{\"camera_matrix\": [[983.177, 0.0, 648.217], [0.0, 986.516, 361.83], [0.0, 0.0, 1.0]], \"dist_coeff\": [[-0.109478, 0.03375, 0.00034266, -0.000190545]]}".to_owned(),
            format!("<?xml version=\"1.0\"?>\n<opencv_storage>\n<camera_matrix type_id=\"opencv-matrix\">\n<rows>3</rows><cols>3</cols><dt>d</dt><data>\n{}</data></camera_matrix>\n<distortion_coefficients type_id=\"opencv-matrix\"><rows>1</rows><data>{}</data></distortion_coefficients>\n</opencv_storage>", blanks(matrix), blanks(bent)),
            format!("header:\n  frame_id: camera\nheight: 720\nwidth: 1280\ndistortion_model: plumb_bob\nd:\n{}k:\n{}r:\n- 1.0\np:\n- 2.0\n---\n", dashes(bent), dashes(matrix)),
            format!("image_width: 1280\nimage_height: 720\ncamera_name: narrow\ncamera_matrix:\n  rows: 3\n  cols: 3\n  data: [{matrix}]\ndistortion_model: plumb_bob\ndistortion_coefficients:\n  rows: 1\n  cols: 4\n  data: [{bent}]\n"),
            format!("cam0:\n  camera_model: pinhole\n  distortion_coeffs: [{bent}]\n  distortion_model: radtan\n  intrinsics: [983.177, 986.516, 648.217, 361.83]\n  resolution: [1280, 720]\n"),
        ] {
            let lens = read(&text, false).unwrap_or_else(|error| panic!("{text}: {error}")).lens;
            assert_eq!((lens.values(), lens.distortion), (known, Distortion::BrownConrady), "{text}");
        }
    }

    #[test]
    fn models_are_taken_by_their_key_and_others_refused() {
        let kalibr = "cam0:\n  camera_model: pinhole\n  distortion_coeffs: [0.1, 0.2, 0.3, 0.4]\n  distortion_model: equidistant\n  intrinsics: [900, 901, 640, 360]\n";
        assert_eq!(read(kalibr, false).unwrap().lens.distortion, Distortion::Fisheye);
        let sized = read(&format!("{kalibr}  resolution: [1280, 720]\n"), false).unwrap();
        assert_eq!(sized.size, Some([1280, 720]));
        let omni = read(&kalibr.replace("pinhole", "omni"), false).unwrap_err();
        assert!(matches!(&omni, YamlError::OtherModel { name } if name == "omni"), "{omni}");
        let intrinsics = "intrinsics: [1.2, 900, 901, 640, 360]";
        let five = kalibr.replace("pinhole", "omni").replace("intrinsics: [900, 901, 640, 360]", intrinsics);
        assert!(matches!(read(&five, false), Err(YamlError::OtherModel { .. })));
        let none = kalibr.replace("equidistant", "none").replace("[0.1, 0.2, 0.3, 0.4]", "[]");
        let straight = read(&none, false).unwrap().lens;
        assert_eq!(straight.values(), [900.0, 901.0, 640.0, 360.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        let two = read(&format!("{kalibr}{}", kalibr.replace("cam0", "cam1")), false).unwrap_err();
        assert!(matches!(two, YamlError::Cameras { cameras: 2 }), "{two}");
        let sample = TEXT.replace("---", "---\nfisheye_model: 0");
        assert_eq!(read(&sample, false).unwrap().lens.distortion, Distortion::BrownConrady);
    }

    #[test]
    fn lenses_of_more_coefficients_are_fitted_where_they_can_be_and_others_refused() {
        let rational = TEXT
            .replace("3.0e-01 ]", "3.0e-01, 0.02, 0., 0. ]")
            .replace("image_width: 1920", "image_width: 1920\nimage_height: 1080");
        let fit = read(&rational, false).unwrap();
        assert!(fit.fitted_px.is_some_and(|off| off < 0.1) && (fit.lens.fx - 1473.0).abs() < 5.0, "{fit:?}");
        for zeros in [", 0., 0., 0.", ", 0., 0., 0., 0., 0., 0., 0.", ", 0., 0., 0., 0., 0., 0., 0., 0., 0."] {
            let more = TEXT.replace("3.0e-01 ]", &format!("3.0e-01{zeros} ]"));
            assert_eq!(read(&more, false).unwrap(), read(TEXT, false).unwrap());
        }
        let wild = rational.replace("0.02, 0., 0.", "3.0, -2.0, 9.0");
        assert!(matches!(read(&wild, false), Err(YamlError::NotFitted { count: 8, .. })));
        assert!(matches!(read(&rational, true), Err(YamlError::Model { .. })));
        assert!(matches!(
            read(&TEXT.replace("3.0e-01 ]", "3.0e-01, 0. ]"), false),
            Err(YamlError::Values { found: 6, .. })
        ));
        assert!(matches!(read("a: 1", false), Err(YamlError::Values { key: "camera_matrix", .. })));
    }
}
