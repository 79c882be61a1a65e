//! The twin in JavaScript moves as the one in Rust: ten seconds in Chromium or, without it, in Node.
#![allow(clippy::unwrap_used)] // tests

use std::path::{Path, PathBuf};
use std::process::Command;

use twin::example::{LENGTH, beam};
use twin::{SCRIPT, Twin, TwinData, file};

const RATE: usize = 240;
const SECONDS: usize = 10;

/// Pressures of both sides, Pa; the same formula as below.
fn pressures(t: f64) -> [f64; 2] {
    [1.0, -1.0].map(|side| 1e4 * (1.0 - (-5.0 * t).exp()) * (1.0 + side * (12.0 * t).sin()))
}

/// Prints the tip's path as numbers between marks.
const LOOP: &str = "
  const twin = Twin(Uint8Array.from(atob(ARRAYS), (c) => c.charCodeAt(0)).buffer), state = twin.start(), path = [];
  for (let n = 1; n <= RATE * SECONDS; n++) {
    const t = n / RATE, wave = [1, -1].map((side) => 1e4 * (1 - Math.exp(-5 * t)) * (1 + side * Math.sin(12 * t)));
    if (!twin.step(state, wave, 1 / RATE)) throw new Error('no step');
    path.push(twin.output(state, 0), twin.output(state, 1));
  }
  say('path:' + path.join(' ') + ':path');
";

fn script(data: &TwinData) -> String {
    let arrays = base64(&file::bytes(data).unwrap());
    format!("{SCRIPT}\nconst ARRAYS = '{arrays}', RATE = {RATE}, SECONDS = {SECONDS};\n{LOOP}")
}

/// Bytes in base64.
fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let letters = |three: &[u8]| {
        let bits = (0..3).fold(0_u32, |bits, i| bits << 8 | u32::from(three.get(i).copied().unwrap_or(0)));
        let letter = |i: usize| {
            if i > three.len() { '=' } else { char::from(LETTERS[(bits >> (18 - 6 * i) & 63) as usize]) }
        };
        [0, 1, 2, 3].map(letter)
    };
    bytes.chunks(3).flat_map(letters).collect()
}

/// What a program printed; none where it is not installed.
fn printed(program: &str, arguments: &[&str], file: &Path) -> Option<String> {
    let output = Command::new(program).args(arguments).arg(file).output().ok()?;
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).into_owned())
}

/// The output of the script in a browser or in Node; none where there is neither.
fn run(data: &TwinData, folder: &Path) -> Option<String> {
    let (page, plain) = (folder.join("twin.html"), folder.join("twin.js"));
    let script = script(data);
    let say = "const say = (text) => { document.body.textContent = text; };";
    std::fs::write(&page, format!("<!DOCTYPE html><body><script>{say}\n{script}</script></body>")).unwrap();
    std::fs::write(&plain, format!("const say = console.log;\n{script}")).unwrap();
    let headless = ["--headless", "--no-sandbox", "--disable-gpu", "--virtual-time-budget=60000", "--dump-dom"];
    let browsers = ["chromium", "chromium-browser", "google-chrome"];
    browsers.iter().find_map(|browser| printed(browser, &headless, &page)).or_else(|| printed("node", &[], &plain))
}

fn folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("twin-{name}-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

#[test]
fn over_ten_seconds_the_page_moves_the_tip_as_the_crate_does() {
    for wet in [false, true] {
        let (data, folder) = (beam(wet), folder(if wet { "water" } else { "air" }));
        let Some(text) = run(&data, &folder) else {
            println!("neither Chromium nor Node is at hand: the twin of the page was not run");
            return;
        };
        std::fs::remove_dir_all(&folder).unwrap();
        let path = text.split("path:").nth(1).and_then(|rest| rest.split(":path").next()).expect("a path");
        let path: Vec<f64> = path.split(' ').map(|number| number.parse().unwrap()).collect();
        assert_eq!(path.len(), 2 * RATE * SECONDS);
        let twin = Twin::new(data).unwrap();
        let (mut state, mut off, mut far) = (twin.start(), 0.0_f64, 0.0_f64);
        for (n, tip) in (1..).zip(path.chunks_exact(2)) {
            twin.step(&mut state, &pressures(f64::from(n) / RATE as f64), 1.0 / RATE as f64).unwrap();
            off = off.max((tip[0] - twin.output(&state, 0)).hypot(tip[1] - twin.output(&state, 1)));
            far = far.max(tip[1].abs());
        }
        // both solve each step to a millionth of the largest shape
        assert!(far > 0.03 * LENGTH && off < 1e-4 * LENGTH, "off by {off} m, far {far} m");
    }
}
