//! What stages and figures may touch: no file, no path, no screen; and who may see the hidden truth.

use crate::assert_none;
use crate::contents::places;
use crate::source::Source;
use crate::tree::sources;

/// The one stage that compares with the hidden truth.
const RECOVERY: &str = "pipeline/study/src/stages/recovery/";

/// The truth, said in code or in a string.
fn sees_the_truth(source: &Source) -> Vec<String> {
    let view = source.without_comments().to_lowercase();
    if source.path.starts_with(RECOVERY) { vec![] } else { places(source, &view, &["truth".to_owned()]) }
}

/// A field that a stage reads and that its record is not keyed by: the key is the serialised part of the card and the settings.
fn reads_past_its_key(source: &Source) -> Vec<String> {
    places(source, &source.without_comments(), &["serde(skip".to_owned(), "skip_serializing".to_owned()])
}

/// Files, the screen or paths in a file that may use none.
fn reaches_outside(source: &Source) -> Vec<String> {
    let words = ["std::fs", "fs::", "File::", "println!", "eprintln!", "print!", "eprint!", "PathBuf::"];
    let mut found = places(source, &source.outside_tests(&source.code()), &words.map(str::to_owned));
    let view = source.outside_tests(&source.without_comments());
    found.extend(
        view.lines()
            .enumerate()
            .filter(|(_, line)| builds_a_path(line))
            .map(|(i, line)| format!("{}:{} builds a path: {}", source.path, i + 1, line.trim())),
    );
    found
}

/// Whether a line joins something other than words with a separator (`.join(", ")` has no letter in its quotes).
fn builds_a_path(line: &str) -> bool {
    line.split(".join(").skip(1).any(|after| {
        let separator = after.strip_prefix('"').and_then(|rest| rest.split_once("\")"));
        let bare = |quoted: &str| quoted.replace("\\n", "").replace("\\t", "");
        separator.is_none_or(|(quoted, _)| bare(quoted).chars().any(char::is_alphanumeric))
    })
}

fn pure_files() -> Vec<Source> {
    sources(&["pipeline/study/src/stages", "pipeline/study/src/figures"])
}

#[test]
fn only_recovery_sees_the_truth() {
    assert_none(sources(&["pipeline/study"]).iter().flat_map(sees_the_truth).collect());
}

#[test]
fn stages_and_figures_open_no_file_print_nothing_and_build_no_path() {
    assert_none(pure_files().iter().flat_map(reaches_outside).collect());
}

#[test]
fn every_field_that_a_stage_reads_is_part_of_its_key() {
    assert_none(
        sources(&["pipeline/study/src/stages", "pipeline/lab/src/card"]).iter().flat_map(reads_past_its_key).collect(),
    );
    let bad = "struct Card {\n    #[serde(skip)]\n    readout: f64,\n}\n";
    assert_eq!(reads_past_its_key(&Source::new("pipeline/study/src/stages/clock.rs", bad)).len(), 1);
}

#[test]
fn a_stage_that_reads_the_truth_is_found_and_a_word_about_it_is_not() {
    let bad = "//! Not about the truth.\nlet t = lab::truth::read(bytes)?;\n";
    let found = sees_the_truth(&Source::new("pipeline/study/src/stages/identify.rs", bad));
    assert_eq!(found, ["pipeline/study/src/stages/identify.rs:2 says truth"]);
    assert!(sees_the_truth(&Source::new(&format!("{RECOVERY}walls.rs"), bad)).is_empty());
    assert_eq!(sees_the_truth(&Source::new("pipeline/study/src/run.rs", "read(\"truth.toml\")")).len(), 1);
}

#[test]
fn a_stage_that_opens_prints_or_joins_is_found() {
    let found = |text: &str| reaches_outside(&Source::new("pipeline/study/src/stages/track.rs", text)).len();
    for bad in [
        "use std::fs;",
        "let f = File::open(p)?;",
        "eprintln!(\"done\");",
        "let p = folder.join(\"video.mp4\");",
        "let p = folder.join(name);",
        "let p = PathBuf::from(\"data\");",
    ] {
        assert_eq!(found(bad), 1, "{bad}");
    }
}

#[test]
fn a_stage_that_joins_words_or_tests_itself_is_left_alone() {
    let found = |text: &str| reaches_outside(&Source::new("pipeline/study/src/stages/track.rs", text)).len();
    assert_eq!(found("let list = names.join(\", \") + &lines.join(\"\\n\");"), 0);
    assert_eq!(found("// println! is for the runner\nlet f = RawFile::new(word);"), 0);
    assert_eq!(found("#[cfg(test)]\nmod tests { fn a() { println!(\"x\"); } }\n"), 0);
}
