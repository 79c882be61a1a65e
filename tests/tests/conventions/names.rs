//! How the names of a crate read, counted: filler among its bindings, functions of one word, and functions that are
//! too long to have one job.
//!
//! A reader translates a binding that is called `found` or `own` and a function that is called `of`; crates that are
//! read with ease have few of them (`fenris`, `fidget` and `ripgrep`: 0 to 4 % of the bindings, 31 to 42 % of the
//! functions). Tests, benches, examples and fuzz targets do not count.

use std::collections::BTreeMap;

use crate::assert_none;
use crate::source::Source;
use crate::tree::{crates, sources};

/// Words that say where a value stands in a sentence, not what it is.
const FILLER: &[&str] = &[
    "of", "at", "by", "on", "in", "with", "from", "to", "off", "over", "beside", "around", "into", "near", "under",
    "after", "before", "between", "along", "across", "here", "there", "until", "apart", "up", "down", "out", "beyond",
    "all", "own", "whole", "one", "other", "others", "said", "met", "seen", "found", "made", "moved", "held", "known",
    "kept", "rest", "left", "place", "what", "why", "most", "least",
];
/// Share of filler among the names that `let` binds, %.
const MAX_FILLER: usize = 4;
/// Share of functions with a name of one word, %.
const MAX_ONE_WORD: usize = 45;
/// Lines of a function.
const MAX_LINES: usize = 40;

/// Crates whose functions may have names of one word, and why.
const ONE_WORD: &[(&str, &str)] = &[(
    "si",
    "its fourteen functions are vector algebra (add, sub, scale, dot, cross, norm) and the accessors of a series",
)];

/// Folders and files that hold tests, or what only those use.
const TEST_FOLDERS: [&str; 4] = ["tests", "benches", "examples", "fuzz"];
const TEST_FILES: [&str; 3] = ["tests.rs", "testing.rs", "conformance.rs"];

/// What is counted in a file or a crate.
#[derive(Debug, Default, PartialEq)]
struct Counts {
    bindings: usize,
    filler: usize,
    functions: usize,
    one_word: usize,
    /// `path:line name` of those above the limit.
    long: Vec<String>,
}

impl Counts {
    fn of_file(source: &Source) -> Self {
        let code = before_tests(&source.code());
        let bindings = names_after(&code, "let");
        let functions = names_after(&code, "fn");
        let is_filler = |(_, name): &&(usize, &str)| FILLER.contains(name);
        let long = functions.iter().filter_map(|(start, name)| {
            let lines = body_lines(&code[*start..])?;
            let line = code[..*start].matches('\n').count() + 1;
            (lines > MAX_LINES)
                .then(|| format!("{}:{line} {name} has {lines} lines; the limit is {MAX_LINES}", source.path))
        });
        Self {
            bindings: bindings.len(),
            filler: bindings.iter().filter(is_filler).count(),
            functions: functions.len(),
            one_word: functions.iter().filter(|(_, name)| !name.contains('_')).count(),
            long: long.collect(),
        }
    }

    fn add(&mut self, other: Self) {
        self.bindings += other.bindings;
        self.filler += other.filler;
        self.functions += other.functions;
        self.one_word += other.one_word;
        self.long.extend(other.long);
    }

    fn defects(&self, name: &str) -> Vec<String> {
        let share = |part: usize, whole: usize| 100.0 * part as f64 / whole.max(1) as f64;
        let (filler, one_word) = (share(self.filler, self.bindings), share(self.one_word, self.functions));
        let is_exempt = ONE_WORD.iter().any(|(exempt, _)| *exempt == name);
        let mut defects = self.long.clone();
        if filler > MAX_FILLER as f64 {
            defects
                .push(format!("{name}: {filler:.1} % of the bindings have filler names; the limit is {MAX_FILLER} %"));
        }
        if one_word > MAX_ONE_WORD as f64 && !is_exempt {
            defects.push(format!(
                "{name}: {one_word:.1} % of the functions have names of one word; the limit is {MAX_ONE_WORD} %"
            ));
        }
        defects
    }
}

/// The code before the first module of tests in a file.
fn before_tests(code: &str) -> String {
    let is_module = |(start, mark): &(usize, &str)| {
        let rest = code[start + mark.len()..].trim_start();
        let name =
            rest.strip_prefix("mod ").map(|rest| rest.trim_start_matches(|c: char| c.is_alphanumeric() || c == '_'));
        name.is_some_and(|rest| rest.starts_with(" {"))
    };
    let end = code.match_indices("#[cfg(test)]").find(is_module).map_or(code.len(), |(start, _)| start);
    code[..end].to_owned()
}

/// The names that follow a keyword, `mut` aside, each with the place of the keyword.
fn names_after<'a>(code: &'a str, keyword: &str) -> Vec<(usize, &'a str)> {
    let in_word = |c: char| c.is_alphanumeric() || c == '_';
    let name = |(start, _): (usize, &str)| {
        let rest = &code[start + keyword.len()..];
        let is_keyword = !code[..start].ends_with(in_word) && rest.starts_with(char::is_whitespace);
        let rest = rest.trim_start();
        let rest = rest.strip_prefix("mut ").map_or(rest, str::trim_start);
        let length = rest.find(|c| !in_word(c)).unwrap_or(rest.len());
        (is_keyword && length > 0).then(|| (start, &rest[..length]))
    };
    code.match_indices(keyword).filter_map(name).collect()
}

/// Lines of a function from its keyword to the end of its body; none of one without a body.
fn body_lines(function: &str) -> Option<usize> {
    let (mut depth, mut brackets) = (0_usize, 0_usize);
    for (i, c) in function.char_indices() {
        match c {
            '[' => brackets += 1,
            ']' => brackets = brackets.saturating_sub(1),
            ';' if depth == 0 && brackets == 0 => return None,
            '{' => depth += 1,
            '}' if depth <= 1 => return Some(function[..i].matches('\n').count() + 1),
            '}' => depth -= 1,
            _ => {}
        }
    }
    None
}

fn is_counted(source: &Source) -> bool {
    let mut parts: Vec<&str> = source.path.split('/').collect();
    let file = parts.pop().unwrap_or_default();
    !TEST_FILES.contains(&file) && !parts.iter().any(|folder| TEST_FOLDERS.contains(folder))
}

/// The counts of each crate of the pipeline.
fn counts_by_crate(sources: &[Source]) -> BTreeMap<String, Counts> {
    let mut by_crate = BTreeMap::<String, Counts>::new();
    for source in sources.iter().filter(|source| is_counted(source)) {
        let name = source.path.split('/').nth(1).unwrap_or_default();
        by_crate.entry(name.to_owned()).or_default().add(Counts::of_file(source));
    }
    by_crate
}

#[test]
fn names_are_nouns_of_the_field_and_functions_have_one_job() {
    let by_crate = counts_by_crate(&sources(&["pipeline"]));
    assert_eq!(by_crate.keys().cloned().collect::<Vec<_>>(), crates());
    assert_none(by_crate.iter().flat_map(|(name, counts)| counts.defects(name)).collect());
}

#[test]
fn every_exemption_is_needed() {
    let by_crate = counts_by_crate(&sources(&["pipeline"]));
    let is_needed = |name: &str| by_crate.get(name).is_some_and(|c| 100 * c.one_word > MAX_ONE_WORD * c.functions);
    let idle = ONE_WORD.iter().filter(|(name, _)| !is_needed(name));
    assert_none(idle.map(|(name, _)| format!("`{name}` needs no exemption")).collect());
}

#[test]
fn filler_and_words_are_counted_outside_of_comments_strings_and_tests() {
    let text = "fn of(x: u8) {\n    let found = x; // let own = 1;\n    let mut held = \"let at = 2\";\n    let outlet = 3;\n}\n\
                fn load_case(let_go: u8);\n#[cfg(test)]\nmod tests {\n    fn by() { let kept = 1; }\n}\n";
    let counts = Counts::of_file(&Source::new("pipeline/fem/src/a.rs", text));
    assert_eq!(counts, Counts { bindings: 3, filler: 2, functions: 2, one_word: 1, long: Vec::new() });
    assert_eq!(counts.defects("fem").len(), 2, "both shares are above their limits");
    assert_eq!(counts.defects("si").len(), 1, "one of them is exempt");
}

#[test]
fn a_line_too_many_is_found_in_a_function_and_none_in_a_signature() {
    let of_lines = |count: usize| format!("fn long(a: [u8; 2]) {{{}}}\n", "\n".repeat(count - 1));
    let long = |text: &str| Counts::of_file(&Source::new("a.rs", text)).long.len();
    assert_eq!((long(&of_lines(MAX_LINES)), long(&of_lines(MAX_LINES + 1))), (0, 1));
    assert_eq!(long(&format!("trait A {{ fn pair(a: [u8; 2]) -> u8; }}\n{}", of_lines(MAX_LINES))), 0);
}

#[test]
fn tests_and_what_they_use_are_left_out() {
    let counted = |path: &str| is_counted(&Source::new(path, ""));
    assert!(counted("pipeline/fem/src/mesh/mod.rs"));
    assert!(!counted("pipeline/fem/tests/contact.rs") && !counted("pipeline/workflow/src/testing.rs"));
}
