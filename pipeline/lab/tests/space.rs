//! Places in space: a `.c3d` written here byte by byte and a CSV are read to the same metres, and each flaw is refused.
#![allow(clippy::unwrap_used)] // a test may fail where it stands

use std::path::Path;

use lab::space::{self, Trajectories};

/// A file of two markers at 100 frames/s, in the form of an Intel processor with real numbers.
struct Capture {
    unit: &'static str,
    labels: [&'static str; 2],
    /// frames × markers: x, y, z and the fourth word.
    points: Vec<[[f32; 4]; 2]>,
    /// What header and POINT:FRAMES say, where it is not the number of frames.
    announced: Option<u16>,
    /// Whether TRIAL has the numbers of the first and last frame.
    trial: bool,
}

impl Capture {
    /// Two markers that move along x by 1 mm a frame, in mm.
    fn new() -> Self {
        let frame = |k: u8| [[50.0 + f32::from(k), 1.5, 17.0, 3.0], [80.0 + f32::from(k), -2.5, 17.0, 200.0]];
        Self {
            unit: "mm",
            labels: ["m1  ", "tip "],
            points: (0..4).map(frame).collect(),
            announced: None,
            trial: false,
        }
    }

    fn bytes(&self) -> Vec<u8> {
        let frames = self.announced.unwrap_or(self.points.len() as u16);
        let mut header = vec![2, 80];
        for word in [2, 0, 1, frames, 10] {
            header.extend(u16::to_le_bytes(word));
        }
        header.extend((-0.01_f32).to_le_bytes());
        header.extend([3_u16, 0].iter().flat_map(|w| w.to_le_bytes()));
        header.extend(100.0_f32.to_le_bytes());
        let parameters = [vec![0, 0, 1, 84], self.parameters(frames)].concat();
        let mut data: Vec<u8> = self.points.iter().flatten().flatten().flat_map(|x| x.to_le_bytes()).collect();
        data.push(0); // a block stands there even where there is nothing to say
        [header, parameters, data].into_iter().flat_map(whole_blocks).collect()
    }

    fn parameters(&self, frames: u16) -> Vec<u8> {
        let group = [&[5, 0xff][..], b"POINT", &3_u16.to_le_bytes(), &[0]].concat();
        let integer = |name: &str, value: u16| parameter(name, 2, &[], &value.to_le_bytes());
        let real = |name: &str, value: f32| parameter(name, 4, &[], &value.to_le_bytes());
        [
            group,
            integer("USED", 2),
            integer("FRAMES", frames),
            integer("DATA_START", 3),
            real("SCALE", -0.01),
            real("RATE", 100.0),
            parameter("UNITS", 0xff, &[self.unit.len() as u8], self.unit.as_bytes()),
            parameter("LABELS", 0xff, &[4, 2], self.labels.concat().as_bytes()),
            if self.trial { self.fields() } else { Vec::new() },
            vec![0, 0],
        ]
        .concat()
    }

    /// The group TRIAL: numbers of frames in two words each, from 1.
    fn fields(&self) -> Vec<u8> {
        let field = |name: &str, number: u32| {
            let mut entry = parameter(name, 2, &[2], &number.to_le_bytes());
            entry[1] = 3;
            entry
        };
        let group = [&[5, 0xfd][..], b"TRIAL", &3_u16.to_le_bytes(), &[0]].concat();
        let last = self.points.len() as u32;
        [group, field("ACTUAL_START_FIELD", 1), field("ACTUAL_END_FIELD", last)].concat()
    }
}

/// A parameter of the first group.
fn parameter(name: &str, kind: u8, sizes: &[u8], data: &[u8]) -> Vec<u8> {
    let body = [&[kind, sizes.len() as u8][..], sizes, data, &[0]].concat();
    let next = 2 + body.len() as u16;
    [&[name.len() as u8, 1][..], name.as_bytes(), &next.to_le_bytes(), &body].concat()
}

fn whole_blocks(mut bytes: Vec<u8>) -> Vec<u8> {
    bytes.resize(bytes.len().next_multiple_of(512), 0);
    bytes
}

fn read(bytes: &[u8]) -> Result<Trajectories, diagnostics::Diagnostic> {
    space::read(bytes, Path::new("trials/flap/mocap.c3d"))
}

fn diagnostic(capture: &Capture) -> String {
    read(&capture.bytes()).unwrap_err().to_string()
}

#[test]
fn millimetres_of_a_c3d_are_read_in_metres_with_their_times() {
    let space = read(&Capture::new().bytes()).unwrap();
    assert_eq!(space.markers.iter().map(|m| m.name.as_str()).collect::<Vec<_>>(), ["m1", "tip"]);
    assert!((space.time[3] - 0.03).abs() < 1e-12);
    let tip = space.complete("tip", Path::new("a.c3d")).unwrap();
    // single precision holds a place of 0.1 m to some nanometres
    assert!((tip[2][0] - 0.082).abs() < 1e-8 && (tip[2][1] + 0.0025).abs() < 1e-9, "{tip:?}");
}

#[test]
fn a_csv_in_metres_says_the_same_as_a_c3d_in_millimetres() {
    let mut text = String::from("frame,time_s,marker,x_m,y_m,z_m\n");
    for (k, [a, b]) in Capture::new().points.iter().enumerate() {
        for (name, p) in [("m1", a), ("tip", b)] {
            let [x, y, z] = [0, 1, 2].map(|i| f64::from(p[i]) * 1e-3);
            text += &format!("{k},{:.2},{name},{x},{y},{z}\n", k as f64 / 100.0);
        }
    }
    let announced = space::read(text.as_bytes(), Path::new("places.csv")).unwrap();
    for (one, other) in announced.markers.iter().zip(&read(&Capture::new().bytes()).unwrap().markers) {
        for (a, b) in one.at.iter().zip(&other.at) {
            let (a, b) = (a.unwrap(), b.unwrap());
            assert!(one.name == other.name && (0..3).all(|i| (a[i] - b[i]).abs() < 1e-8));
        }
    }
}

#[test]
fn a_plane_s_csv_needs_no_z_and_its_slips_are_refused_with_their_line() {
    let good = "frame,time_s,marker,x_mm,y_mm\n0,0,m1,50,1\n1,0.01,m1,51,1\n";
    let diagnostic = |from: &str, to: &str| {
        assert!(good.contains(from));
        space::read(good.replacen(from, to, 1).as_bytes(), Path::new("places.csv")).unwrap_err().to_string()
    };
    let read = space::read(good.as_bytes(), Path::new("places.csv")).unwrap();
    let [x, y, z] = read.markers[0].at[1].unwrap();
    assert!((x - 0.051).abs() < 1e-15 && (y - 0.001).abs() < 1e-15 && z == 0.0);
    assert!(diagnostic("x_mm", "x").contains("line 1"), "a column without a unit");
    assert!(diagnostic("x_mm", "x_m").contains("one unit"), "columns of two units");
    assert!(
        diagnostic("0.01,m1,51", "0.01,m1,5l").contains("line 3: the places cannot be read\n  why: `5l` is no number")
    );
    assert!(diagnostic("1,0.01", "1,0").contains("line 3"), "a time that stands still");
    assert!(diagnostic("_mm,y_mm\n0,0,m1,50", "_m,y_m\n0,0,m1,50").contains("[50.0, 1.0, 0.0] m in frame 0"));
}

#[test]
fn a_line_of_a_csv_that_is_no_text_is_refused_with_its_number() {
    let text = b"frame,time_s,marker,x_mm,y_mm\n0,0,m1,50,1\n1,0.01,m\xff,51,1\n";
    let message = space::read(text, Path::new("places.csv")).unwrap_err().to_string();
    assert!(message.contains("line 3: the places cannot be read"), "{message}");
}

#[test]
fn a_lost_marker_and_a_number_that_is_none_are_refused_with_their_frame() {
    for point in [[0.0, 0.0, 0.0, -1.0], [f32::NAN, 1.0, 1.0, 3.0]] {
        let mut capture = Capture::new();
        capture.points[2][1] = point;
        let space = read(&capture.bytes()).unwrap();
        let message = space.complete("tip", Path::new("a.c3d")).unwrap_err().to_string();
        assert!(
            message.contains("marker `tip` is lost in frame 2 (0.020 s)") && message.contains("1 of 4 frames"),
            "{message}"
        );
        assert!(space.complete("m1", Path::new("a.c3d")).is_ok());
    }
}

fn fixture(name: &str) -> Vec<u8> {
    std::fs::read(format!("{}/tests/data/{name}", env!("CARGO_MANIFEST_DIR"))).unwrap()
}

/// A file in which a program wrote zeros where a marker was lost.
#[test]
fn a_point_of_zeros_is_a_gap() {
    let space = read(&fixture("zero_gap.c3d")).unwrap();
    let lost: Vec<usize> = space.markers.iter().map(|m| m.at.iter().filter(|at| at.is_none()).count()).collect();
    assert!(lost.iter().any(|count| *count > 0) && lost.iter().all(|count| *count < space.time.len()), "{lost:?}");
    let mut capture = Capture::new();
    capture.points[1][0] = [0.0, 0.0, 0.0, 0.0];
    capture.points[2][0] = [0.0, 0.0, 0.1, 0.0];
    let is_present: Vec<bool> = read(&capture.bytes()).unwrap().markers[0].at.iter().map(Option::is_some).collect();
    assert_eq!(is_present, [true, false, true, true]);
}

/// 90,000 frames, of which the header and POINT:FRAMES can say 65,535 or what is left of the number in two bytes.
#[test]
fn all_frames_of_a_long_recording_are_read() {
    let frame = |k: usize| [[1.0 + k as f32 * 1e-3, 1.5, 17.0, 0.0], [80.0, -2.5, 17.0, 0.0]];
    for (announced, trial) in [(65_535, false), (65_535, true), (24_464, false), (24_464, true)] {
        let points = (0..90_000).map(frame).collect();
        let capture = Capture { points, announced: Some(announced), trial, ..Capture::new() };
        let space = read(&capture.bytes()).unwrap();
        assert_eq!(space.time.len(), 90_000, "{announced} {trial}");
        let last = space.markers[0].at[89_999].unwrap();
        assert!((last[0] - 0.090_999).abs() < 1e-8, "{last:?}");
    }
    let wrapped_count = Capture { points: (0..50_000).map(frame).collect(), announced: Some(24_464), ..Capture::new() };
    let message = diagnostic(&wrapped_count);
    assert!(message.contains("holds 50016 frames, and its header has 24464"), "{message}");
}

/// Vicon writes the subject before its marker.
#[test]
fn a_marker_is_found_behind_the_name_of_its_subject() {
    let path = Path::new("a.c3d");
    let space = read(&fixture("subject_prefix.c3d")).unwrap();
    assert!(space.markers.iter().all(|marker| marker.name.starts_with("fish:")));
    assert_eq!(space.complete("m1", path).unwrap().len(), space.time.len());
    let mut ambiguous = space.clone();
    ambiguous.markers[1].name = "other:m1".into();
    let message = ambiguous.complete("m1", path).unwrap_err().to_string();
    assert!(message.contains("marker `m1` is `fish:m1` or `other:m1`"), "{message}");
}

/// Programs write such numbers where they lost a marker; −9999 mm lies within what an instrument may measure.
#[test]
fn a_number_that_stands_for_a_lost_marker_is_a_gap() {
    for number in [-9999.0, 9_999_999.0, -999.0, -3.697_314e28, f32::NAN] {
        let mut capture = Capture::new();
        capture.points[2][1] = [number, number, number, 0.0];
        let space = read(&capture.bytes()).unwrap();
        assert_eq!(space.markers[1].at[2], None, "{number}");
        assert!(space.markers[1].at[3].is_some());
    }
    let text = "frame,time_s,marker,x_mm,y_mm\n0,0,m1,50,1\n1,0.01,m1,-9999,-9999\n2,0.02,m1,,\n3,0.03,m1,99,99.5\n";
    let is_present: Vec<bool> = space::read(text.as_bytes(), Path::new("places.csv")).unwrap().markers[0]
        .at
        .iter()
        .map(Option::is_some)
        .collect();
    assert_eq!(is_present, [true, false, false, true]);
}

#[test]
fn a_csv_may_have_semicolons_decimal_commas_and_another_encoding() {
    let text = "frame;time_s;marker;x_mm;y_mm\r\n0;0;m1;50,5;1\r\n1;0,01;m1;51,25;1\r\n";
    let wide: Vec<u8> = [0xfeff].into_iter().chain(text.encode_utf16()).flat_map(u16::to_le_bytes).collect();
    for bytes in
        [text.as_bytes().to_vec(), format!("\u{feff}{text}").into_bytes(), wide, text.replace(';', "\t").into_bytes()]
    {
        let space = space::read(&bytes, Path::new("places.csv")).unwrap();
        assert_eq!(space.time, [0.0, 0.01]);
        assert!((space.markers[0].at[1].unwrap()[0] - 0.051_25).abs() < 1e-15);
    }
}

#[test]
fn a_marker_of_another_name_is_refused_with_the_nearest() {
    let message = read(&Capture::new().bytes()).unwrap().complete("tip2", Path::new("a.c3d")).unwrap_err().to_string();
    assert!(
        message.contains("no marker `tip2`") && message.contains("the file has m1, tip") && message.contains("`tip`"),
        "{message}"
    );
}

#[test]
fn a_c3d_without_a_unit_of_length_or_without_points_is_refused() {
    assert!(diagnostic(&Capture { unit: "V ", ..Capture::new() }).contains("POINT:UNITS is `V`"));
    assert!(diagnostic(&Capture { points: Vec::new(), ..Capture::new() }).contains("no point data"));
}

#[test]
fn a_c3d_that_was_cut_is_refused_with_the_frame_at_which_it_ends() {
    let mut capture = Capture::new();
    capture.points = (0..40).map(|_| capture.points[0]).collect();
    let bytes = capture.bytes();
    let message = read(&bytes[..bytes.len() - 512]).unwrap_err().to_string();
    assert!(message.contains("ends in frame 32") && message.contains("its header has 40"), "{message}");
}

#[test]
fn bytes_that_are_no_c3d_are_refused_at_whatever_length() {
    let bytes = Capture::new().bytes();
    for length in [0, 3, 511, 700, 1024] {
        assert!(read(&bytes[..length]).is_err(), "{length}");
    }
    assert!(read("time,force\n0,1\n".repeat(200).as_bytes()).unwrap_err().to_string().contains("no .c3d"));
}

#[test]
fn a_header_that_counts_more_points_than_the_file_holds_is_refused_before_room_is_made_for_them() {
    let mut bytes = Capture::new().bytes();
    bytes[2..4].copy_from_slice(&60_000_u16.to_le_bytes());
    bytes[8..10].copy_from_slice(&50_000_u16.to_le_bytes());
    let message = read(&bytes).unwrap_err().to_string();
    assert!(
        message.contains("60000 points in 50000 frames") && message.contains("the file has 1536 bytes"),
        "{message}"
    );
    bytes[515] = 86; // big-endian: both bytes of each word change places
    for word in [2, 6, 8] {
        bytes[word..word + 2].reverse();
    }
    let message = read(&bytes).unwrap_err().to_string();
    assert!(message.contains("60000 points in 50000 frames"), "{message}");
}

#[test]
fn a_residual_of_255_that_every_camera_saw_is_no_loss_and_minus_one_is() {
    let mut capture = Capture::new();
    capture.points[1][0][3] = f32::from(0x7fff_i16);
    capture.points[2][0][3] = -1.0;
    let space = space::read(&capture.bytes(), Path::new("capture.c3d")).unwrap();
    let is_present: Vec<bool> = space.markers[0].at.iter().map(Option::is_some).collect();
    assert_eq!(is_present, [true, true, false, true]);
    assert!(space.markers[1].at.iter().all(Option::is_some));
}
