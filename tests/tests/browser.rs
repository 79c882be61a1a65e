//! The page in a real browser, from disk: the tail is drawn, inflates, turns, is cut open and coloured, and nothing goes wrong on
//! the way. Where the machine has no Chromium there is nothing to try it in; continuous integration installs one.

#![allow(clippy::unwrap_used)]

use std::path::PathBuf;
use std::process::Command;

use publish::page::{Body, Page, Surface};
use serde_json::Value;
use sysid::surfaces::Bounds;

/// Plays the reader's part and writes what was seen into the page.
const READER: &str = include_str!("browser.js");

/// The first Chromium on the PATH.
fn browser() -> Option<PathBuf> {
    let folders: Vec<PathBuf> = std::env::split_paths(&std::env::var_os("PATH")?).collect();
    let names = ["chromium", "chromium-browser", "google-chrome", "chrome"];
    names.iter().flat_map(|name| folders.iter().map(move |f| f.join(name))).find(|program| program.is_file())
}

/// A wedge, as the upper half of a body, that rises and bends in its second shape.
fn wedge(name: &str, rise: f64) -> Body {
    let rest = vec![[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.0, 0.05, 0.0], [0.02, 0.02, 0.04]];
    let bent = rest.iter().map(|&[x, y, z]| [x, y + 5.0 * x * x, z * (1.0 + rise)]).collect();
    let skin = vec![[0, 1, 3], [1, 2, 3], [2, 0, 3]];
    let surface = |on: Bounds, faces| Surface { colour: on.colour(), inside: on.is_cut(), faces };
    let surfaces = vec![surface(Bounds::Body, skin), surface(Bounds::CutBody, vec![[0, 2, 1]])];
    Body { name: name.into(), half: true, levels: vec![0.0, 250.0], points: vec![rest, bent], surfaces }
}

/// What the reader saw.
fn seen(program: PathBuf) -> Value {
    let page = Page { bodies: vec![wedge("nemo", 0.5), wedge("dory", 0.1)], ..Page::default() };
    let folder = std::env::temp_dir().join(format!("browser-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let file = folder.join("index.html");
    std::fs::write(&file, page.html().replace("<body>", &format!("<body><script>{READER}</script>"))).unwrap();
    let quiet = ["--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking"];
    let run = Command::new(program)
        .args(quiet)
        .arg(format!("--user-data-dir={}", folder.join("profile").display()))
        .args(["--window-size=900,900", "--virtual-time-budget=20000", "--dump-dom"])
        .arg(format!("file://{}", file.display()))
        .output()
        .unwrap();
    let dom = String::from_utf8_lossy(&run.stdout).into_owned();
    std::fs::remove_dir_all(&folder).unwrap();
    let answer = dom.split("<pre id=\"seen\">").nth(1).and_then(|rest| rest.split("</pre>").next());
    serde_json::from_str(answer.unwrap_or_else(|| panic!("the page wrote nothing:\n{dom}"))).unwrap()
}

#[test]
fn a_reader_inflates_turns_cuts_and_colours_the_tail() {
    let Some(program) = browser() else {
        println!("no Chromium on the PATH: the page was not opened");
        return;
    };
    let seen = seen(program);
    assert_eq!(seen["errors"], Value::Array(Vec::new()), "{seen}");
    assert_eq!(seen["pressures"], serde_json::json!(["250 mbar", "0 mbar", "125 mbar"]), "{seen}");
    assert!(seen["dots"].as_u64().unwrap() > 1000, "the tail covers {} dots", seen["dots"]);
    for act in ["inflated", "turned", "nearer", "cut", "coloured", "another"] {
        assert_eq!(seen[act], Value::Bool(true), "`{act}` changed nothing: {seen}");
    }
}
