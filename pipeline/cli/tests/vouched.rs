//! What `study doctor` vouches for: where it says "0 to fix", `study run` reads all of the specimen; and inputs of the kinds that laboratories
//! bring are read, or refused by both.
#![allow(clippy::unwrap_used)]

mod specimen;
mod vouch;

use specimen::{LOG, card, changed, log};
use vouch::{Input, Verdict, check};

/// The card with a lens of its own.
fn with_lens(file: &str) -> String {
    changed(&card(), "frame_every =", &format!("coefficients = \"{file}\"\nframe_every ="))
}

const PLAIN: &str = "camera/lens.yml";

/// OpenCV's YAML of a pinhole for the pictures of the specimen.
fn plain_lens() -> String {
    opencv_yaml(&["0."; 5])
}

fn opencv_yaml(coefficients: &[&str]) -> String {
    format!(
        "%YAML:1.0\n---\nimage_width: 320\nimage_height: 240\ncamera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   \
         data: [ 384., 0., 159.5, 0., 384., 119.5, 0., 0., 1. ]\ndistortion_coefficients: !!opencv-matrix\n   rows: 1\n   cols: {}\n   dt: d\n   data: [ {} ]\n",
        coefficients.len(),
        coefficients.join(", ")
    )
}

/// A form of the log; `keys` follow the card.
fn log_input(name: &'static str, bytes: Vec<u8>, keys: &str, verdict: Verdict) -> Input {
    Input { name, file: LOG, bytes, card: format!("{}\n{keys}", with_lens(PLAIN)), verdict }
}

/// The log with every line changed; the first is that of the titles.
fn lines(change: impl Fn(usize, &str) -> String) -> String {
    log().lines().enumerate().map(|(k, line)| change(k, line) + "\n").collect()
}

/// A clock in another unit on the card.
fn clock(unit: &str) -> String {
    format!("[[log.columns]]\nquantity = \"time_s\"\ncolumn = \"time_s\"\nunit = \"{unit}\"\n")
}

fn log_inputs() -> Vec<Input> {
    let utf_16: Vec<u8> = [0xfeff].into_iter().chain(log().encode_utf16()).flat_map(u16::to_le_bytes).collect();
    let degrees = lines(|k, line| format!("{line},{}", if k == 0 { "T_\u{b0}C" } else { "21" }));
    let windows: Vec<u8> = degrees.chars().map(|c| u8::try_from(u32::from(c)).unwrap()).collect();
    let excel = format!("sep=;\n{}", log().replace(',', ";").replace('.', ","));
    let units = lines(|k, line| if k == 0 { format!("{line}\ns,mbar,mbar,mbar,mbar,1") } else { line.to_owned() });
    let labview =
        format!("LabVIEW Measurement\t\nDate\t2024/05/01\n***End_of_Header***\t\n\n{}", log().replace(',', "\t"));
    let stamp = |line: &str| {
        let (time, rest) = line.split_once(',').unwrap();
        let seconds: f64 = time.parse().unwrap();
        format!("12:00:{:07.4},{rest}", seconds + 3.0)
    };
    let time_of_day = lines(|k, line| if k == 0 { line.to_owned() } else { stamp(line) });
    let wrapped = lines(|k, line| match (k, line.split_once(',')) {
        (1.., Some((time, rest))) => {
            let micros = (4_294_500_000.0 + 1e6 * time.parse::<f64>().unwrap()) as u64 % (1 << 32);
            format!("{micros},{rest}")
        }
        _ => line.to_owned(),
    });
    let twice = lines(|k, line| format!("{line},{}", if k == 0 { "left_mbar" } else { "0.00" }));
    let backwards = lines(|k, line| if k == 41 { log().lines().nth(20).unwrap().to_owned() } else { line.to_owned() });
    let texts = [
        ("as the guide has it", log(), String::new(), Verdict::Read),
        (
            "a byte-order mark and CRLF",
            format!("\u{feff}{}", log().replace('\n', "\r\n")),
            String::new(),
            Verdict::Read,
        ),
        ("sep=; with decimal commas", excel, String::new(), Verdict::Read),
        ("a line of units", units, String::new(), Verdict::Read),
        ("runs of spaces", log().replace(',', "   "), String::new(), Verdict::Read),
        ("a LabVIEW head", labview, String::new(), Verdict::Read),
        ("CR alone", log().replace('\n', "\r"), String::new(), Verdict::Read),
        ("times of day", time_of_day, clock("iso8601"), Verdict::Read),
        ("micros() that wraps", wrapped, clock("us"), Verdict::Read),
        ("two columns of one name", twice, String::new(), Verdict::Refused),
        ("a line out of order", backwards, String::new(), Verdict::Refused),
        ("titles alone", "time_s,left_command_mbar\n".to_owned(), String::new(), Verdict::Refused),
    ];
    let bytes = [("UTF-16", utf_16), ("Windows-1252", windows)];
    let inputs = bytes.into_iter().map(|(name, bytes)| log_input(name, bytes, "", Verdict::Read));
    let of_texts =
        texts.into_iter().map(|(name, text, keys, verdict)| log_input(name, text.into_bytes(), &keys, verdict));
    inputs.chain(of_texts).collect()
}

#[test]
fn logs_of_every_form_that_the_doctor_vouches_for_are_read_by_run() {
    let mut inputs = log_inputs();
    inputs.insert(0, lens_input("the lens of the others", PLAIN, plain_lens(), Verdict::Read));
    check("vouched-logs", "clock", inputs);
}

fn lens_input(name: &'static str, file: &'static str, text: String, verdict: Verdict) -> Input {
    Input { name, file, bytes: text.into_bytes(), card: with_lens(file), verdict }
}

#[test]
fn lens_files_of_every_form_that_the_doctor_vouches_for_are_read_by_run() {
    let json = "{ \"image_width\": 320, \"image_height\": 240, \"camera_matrix\": { \"type_id\": \"opencv-matrix\", \"rows\": 3, \"cols\": 3, \"dt\": \"d\", \
                \"data\": [ 384.0, 0.0, 159.5, 0.0, 384.0, 119.5, 0.0, 0.0, 1.0 ] }, \"distortion_coefficients\": { \"type_id\": \"opencv-matrix\", \
                \"rows\": 1, \"cols\": 5, \"dt\": \"d\", \"data\": [ 0.0, 0.0, 0.0, 0.0, 0.0 ] } }";
    let xml = "<?xml version=\"1.0\"?>\n<opencv_storage>\n<image_width>320</image_width><image_height>240</image_height>\n<camera_matrix type_id=\"opencv-matrix\"><rows>3</rows><cols>3</cols><dt>d</dt>\
               <data>384. 0. 159.5 0. 384. 119.5 0. 0. 1.</data></camera_matrix>\n<distortion_coefficients type_id=\"opencv-matrix\"><rows>1</rows><cols>5</cols>\
               <dt>d</dt><data>0. 0. 0. 0. 0.</data></distortion_coefficients>\n</opencv_storage>\n";
    let kalibr = "cam0:\n  camera_model: pinhole\n  distortion_coeffs: [0.0, 0.0, 0.0, 0.0]\n  distortion_model: radtan\n  \
                  intrinsics: [384.0, 384.0, 159.5, 119.5]\n  resolution: [320, 240]\n";
    let commented = plain_lens().replacen("---\n", "---\n# not a fisheye\n", 1);
    let larger = plain_lens().replace("320", "1280").replace("240", "960");
    check(
        "vouched-lenses",
        "clock",
        vec![
            lens_input("OpenCV's YAML", "camera/lens.yml", plain_lens(), Verdict::Read),
            lens_input(
                "eight coefficients",
                "camera/lens.yml",
                opencv_yaml(&["0.01", "0.", "0.", "0.", "0.", "0.", "0.", "0."]),
                Verdict::Read,
            ),
            lens_input("OpenCV's JSON", "camera/lens.json", json.to_owned(), Verdict::Read),
            lens_input("OpenCV's XML", "camera/lens.xml", xml.to_owned(), Verdict::Read),
            lens_input("Kalibr's", "camera/kalibr.yaml", kalibr.to_owned(), Verdict::Read),
            lens_input("a comment with a model's name", "camera/lens.yml", commented, Verdict::Read),
            lens_input("of pictures of another size", "camera/lens.yml", larger, Verdict::Refused),
            lens_input("no lens", "camera/lens.yml", "a: 1\n".to_owned(), Verdict::Refused),
        ],
    );
}

#[test]
fn imported_tracks_that_the_doctor_vouches_for_are_read_by_run() {
    const FILE: &str = "trials/static_left/dlc.csv";
    let keys = format!("[[tracks]]\ntrial = \"static_left\"\nfile = \"{FILE}\"\nsigma = 0.5\n");
    let single = "scorer,net,net,net\nbodyparts,m1,m1,m1\ncoords,x,y,likelihood\n";
    let several = "scorer,net,net,net\nindividuals,fish,fish,fish\nbodyparts,m1,m1,m1\ncoords,x,y,likelihood\n";
    let rows = |change: fn(usize) -> [f64; 2]| -> String {
        let row = |k: usize| format!("{k},{:.2},{:.2},0.99\n", change(k)[0], change(k)[1]);
        (0..66).map(row).collect()
    };
    let true_places = |k: usize| [200.0 + 0.25 * k as f64, 120.0];
    let far = |k: usize| [200.0 + 0.25 * k as f64 + if k == 30 { 90.0 } else { 0.0 }, 120.0];
    let tracked = |name, text: String, verdict| {
        let card = format!("{}\n{keys}", with_lens(PLAIN));
        Input { name, file: FILE, bytes: text.into_bytes(), card, verdict }
    };
    let shuffled = rows(true_places).replacen(
        "0,200.00,120.00,0.99\n1,200.25,120.00,0.99\n",
        "1,200.25,120.00,0.99\n0,200.00,120.00,0.99\n",
        1,
    );
    check(
        "vouched-tracks",
        "clock",
        vec![
            lens_input("the lens of the others", PLAIN, plain_lens(), Verdict::Read),
            tracked("one animal", single.to_owned() + &rows(true_places), Verdict::Read),
            tracked("several animals", several.to_owned() + &rows(true_places), Verdict::Read),
            tracked("a point far away", single.to_owned() + &rows(far), Verdict::Refused),
            tracked("frames out of order", single.to_owned() + &shuffled, Verdict::Refused),
            tracked("a film's half", single.to_owned() + &rows(true_places)[..900], Verdict::Refused),
        ],
    );
}
