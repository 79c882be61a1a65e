//! A reduced model is trained over ranges, agrees with the whole body there, and what it cannot be trained on is refused.

#![allow(clippy::unwrap_used)] // a test may fail where it stands

use std::path::{Path, PathBuf};

use simulate::{NamedRange, ReduceOptions, reduce};

fn options(out: &str) -> ReduceOptions {
    let case = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/finger.toml");
    ReduceOptions {
        case,
        over: ["E.silicone=1.4e5..2e5", "nu.silicone=0.45..0.48"].map(|text| text.parse().unwrap()).to_vec(),
        pressures: vec!["air=0..8e3".parse().unwrap()],
        tolerance: 5e-3,
        equilibria: 30,
        out: PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(out),
        quiet: true,
    }
}

#[test]
fn a_finger_is_reduced_over_its_constants_and_pressures() {
    let options = options("finger.safetensors");
    let line = reduce(&options).unwrap();
    println!("{line}");
    let bytes = std::fs::read(&options.out).unwrap();
    let header = u64::from_le_bytes(bytes[..8].try_into().unwrap()) as usize;
    let header: serde_json::Value = serde_json::from_slice(&bytes[8..8 + header]).unwrap();
    let training: serde_json::Value =
        serde_json::from_str(header["__metadata__"]["training"].as_str().unwrap()).unwrap();
    assert!(training["largest_difference"].as_f64().unwrap() <= 5e-3 && training["checked"] == 8);
    assert!(training["equilibria"].as_u64().unwrap() <= 30);
    assert_eq!(training["pressures"][0]["high"], 8e3);
    for part in ["modes", "size", "points.0", "weights.0", "points.1", "weights.1"] {
        assert!(header[part]["shape"].is_array(), "{part}");
    }
}

#[test]
fn ranges_of_nothing_in_the_body_are_refused_with_what_there_is() {
    let refused = |change: &dyn Fn(&mut ReduceOptions)| {
        let mut options = options("refused.safetensors");
        change(&mut options);
        let message = reduce(&options).unwrap_err().to_string();
        assert!(!options.out.exists());
        message
    };
    let over = |text: &str| {
        let range: NamedRange = text.parse().unwrap();
        refused(&move |options| options.over = vec![range.clone()])
    };
    assert!(over("E.steel=1e5..2e5").contains("E.silicone, nu.silicone, E.sheet, nu.sheet"));
    assert!(over("nu.silicone=0.45..0.5").contains("0.5"));
    assert!(over("E.silicone=0..1e5").contains("above 0"));
    assert!(over("density.silicone=1..2").contains("E and"));
    let water = |options: &mut ReduceOptions| options.pressures = vec!["water=0..1e3".parse().unwrap()];
    assert!(refused(&water).contains("air"));
    let still = |options: &mut ReduceOptions| options.pressures = vec!["air=1e3..1e3".parse().unwrap()];
    assert!(refused(&still).contains("no pressure varies"));
}

#[test]
fn a_range_that_is_none_is_refused() {
    for text in ["E.body", "E.body=1e5", "E.body=2e5..1e5", "E.body=a..b", "=1..2", "E.body=0..inf"] {
        assert!(text.parse::<NamedRange>().is_err(), "{text}");
    }
    let range: NamedRange = "air = -1e3 .. 2e3".parse().unwrap();
    assert_eq!((range.name.as_str(), range.low, range.high), ("air", -1e3, 2e3));
}
