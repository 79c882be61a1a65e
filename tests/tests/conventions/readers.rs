//! Readers: what comes from a file is not cut to what was expected of it.
//!
//! `chunks_exact` drops a rest, `zip` what the longer side has beyond the shorter one, and `take_while` all that follows the first miss: a cut or
//! odd file is then read as another one. A reader is a function that takes the content of a file (bytes, tables or files of a record,
//! safetensors; a text where its name says that it reads) and may refuse it, with the functions of the same file that it calls. In a reader, each of the
//! three stands after a comparison of lengths or shapes, or under a comment `length:` that says why none is needed.

use std::collections::BTreeSet;

use crate::assert_none;
use crate::source::Source;
use crate::tree::sources;

/// What cuts in silence.
const CUTS: [&str; 4] = ["chunks_exact(", "chunks_exact::<", ".zip(", ".take_while("];
/// Types of a file's content.
const CONTENT: [&str; 5] = ["&[u8]", "&RecordFiles", "&Columns", "&SafeTensors", "impl BufRead"];
/// Words at the begin of a function's name that make a text the content of a file.
const READS: [&str; 4] = ["read", "parse", "unpack", "from_"];
/// A comparison of lengths or shapes, in the code before a cut.
const COMPARISONS: [&str; 7] =
    [".len() !=", ".len() ==", ".len() <", ".len() >", ".shape() !=", ".shape() ==", ".len().is_multiple_of("];
/// How a reason begins, and how many lines above a cut it may begin.
const REASON: &str = "length:";
const ABOVE: usize = 4;

/// A function: its name, signature and body, with the body's place in the file.
struct Function<'a> {
    name: &'a str,
    signature: &'a str,
    body: &'a str,
    start: usize,
}

/// The functions of blanked code.
fn functions(code: &str) -> Vec<Function<'_>> {
    let function_at = |(at, _): (usize, &str)| {
        let preceding = code[..at].chars().next_back();
        let remainder = &code[at + 3..];
        let length = remainder.find(|c: char| !(c.is_alphanumeric() || c == '_'))?;
        let open = at + 3 + opening(remainder)?;
        let close = open + closing(&code[open..]);
        let is_word = preceding.is_some_and(|c| c.is_alphanumeric() || c == '_');
        let function =
            Function { name: &remainder[..length], signature: &code[at..open], body: &code[open..close], start: open };
        (!is_word && length > 0).then_some(function)
    };
    code.match_indices("fn ").filter_map(function_at).collect()
}

/// Where the body of a signature opens; none where it has none.
fn opening(rest: &str) -> Option<usize> {
    let mut depth = 0;
    for (i, c) in rest.char_indices() {
        match c {
            '(' | '[' => depth += 1,
            ')' | ']' => depth -= 1,
            '{' if depth == 0 => return Some(i),
            ';' if depth == 0 => return None,
            _ => {}
        }
    }
    None
}

/// The length of a block with its braces.
fn closing(block: &str) -> usize {
    let mut depth = 0;
    for (i, c) in block.char_indices() {
        depth += i32::from(c == '{') - i32::from(c == '}');
        if depth == 0 {
            return i + 1;
        }
    }
    block.len()
}

/// Whether a function takes the content of a file and may refuse it.
fn takes_content(function: &Function) -> bool {
    let (parameters, returned) = function.signature.rsplit_once("->").unwrap_or((function.signature, ""));
    let refuses = returned.contains("Result<") || returned.contains("Option<");
    let is_text = parameters.contains("&str") && READS.iter().any(|word| function.name.starts_with(word));
    refuses && (is_text || CONTENT.iter().any(|kind| parameters.contains(kind)))
}

/// Whether `body` calls a function of the same file by this name.
fn calls(body: &str, name: &str) -> bool {
    body.match_indices(name).any(|(at, _)| {
        let (before, after) = (&body[..at], &body[at + name.len()..]);
        let ends = after.starts_with(['(', ')', ',']) || after.starts_with("::<");
        let begins = !before.ends_with(|c: char| c.is_alphanumeric() || c == '_' || c == '.');
        ends && (begins || before.ends_with("self."))
    })
}

/// The functions of a file that take the content of a file, and those that they call.
fn readers<'a, 'b>(all: &'b [Function<'a>]) -> Vec<&'b Function<'a>> {
    let mut reader_indices: BTreeSet<usize> = (0..all.len()).filter(|i| takes_content(&all[*i])).collect();
    loop {
        let called = |i: &usize| reader_indices.iter().any(|k| calls(all[*k].body, all[*i].name));
        let callees: Vec<usize> = (0..all.len()).filter(|i| !reader_indices.contains(i)).filter(called).collect();
        if callees.is_empty() {
            return reader_indices.into_iter().map(|i| &all[i]).collect();
        }
        reader_indices.extend(callees);
    }
}

/// `path:line` of every cut in a reader that has neither a comparison before it nor a reason above it.
fn unguarded(source: &Source) -> Vec<String> {
    if source.test {
        return Vec::new();
    }
    let code = source.outside_tests(&source.code());
    let lines: Vec<&str> = source.text.lines().collect();
    let file_functions = functions(&code);
    let mut unguarded_cuts = BTreeSet::new();
    for reader in readers(&file_functions) {
        for (at, cut) in CUTS.iter().flat_map(|cut| reader.body.match_indices(cut)) {
            let line = code[..reader.start + at].matches('\n').count();
            let compared = COMPARISONS.iter().any(|comparison| reader.body[..at].contains(comparison));
            let reasoned = lines[line.saturating_sub(ABOVE)..=line].iter().any(|line| line.contains(REASON));
            if !compared && !reasoned {
                let name = cut.trim_matches(['.', '(', ':', '<']);
                unguarded_cuts.insert(format!(
                    "{}:{}: `{name}` in the reader `{}`",
                    source.path,
                    line + 1,
                    reader.name
                ));
            }
        }
    }
    unguarded_cuts.into_iter().collect()
}

#[test]
fn readers_compare_lengths_before_they_cut() {
    assert_none(sources(&["pipeline"]).iter().flat_map(unguarded).collect());
}

#[test]
fn the_readers_of_the_project_are_found() {
    let files = sources(&["pipeline"]);
    let reader_names = |path: &str| {
        let source = files.iter().find(|source| source.path == path).expect("the file is there");
        let code = source.outside_tests(&source.code());
        readers(&functions(&code)).iter().map(|reader| reader.name.to_owned()).collect::<Vec<_>>()
    };
    for (path, names) in [
        ("pipeline/twin/src/unpack.rs", &["unpack_file", "array_values", "assemble_data", "unpack_region"][..]),
        ("pipeline/optimize/src/network/file.rs", &["from_safetensors", "tensor_values", "layer_from_file"]),
        ("pipeline/records/src/reduced.rs", &["from_files"]),
        ("pipeline/records/src/runs.rs", &["read_runs"]),
        ("pipeline/track/src/lens/opencv/mod.rs", &["read", "camera_matrix", "fit_lens"]),
    ] {
        let file_readers = reader_names(path);
        assert!(names.iter().all(|name| file_readers.iter().any(|own| own == name)), "{path}: {file_readers:?}");
    }
}

#[test]
fn a_cut_in_a_reader_is_found_through_the_functions_that_it_calls() {
    let count_cuts = |text: &str| unguarded(&Source::new("a.rs", text)).len();
    let cut = "fn read(bytes: &[u8]) -> Result<T, E> { rows(bytes.chunks_exact(8).map(f)) }\n";
    assert_eq!(count_cuts(cut), 1);
    assert_eq!(
        count_cuts(
            "fn read(bytes: &[u8]) -> Option<T> { Some(rows(bytes)) }\nfn rows(b: B) -> T { b.a.iter().zip(b.c) }"
        ),
        1
    );
    assert_eq!(count_cuts("fn parse(text: &str) -> Result<T, E> { text.chars().take_while(f).count() }"), 1);
    assert_eq!(count_cuts("fn sum(a: &[f64], b: &[f64]) -> f64 { a.iter().zip(b).sum() }"), 0);
}

#[test]
fn a_comparison_before_a_cut_or_a_reason_above_it_is_seen() {
    let count_cuts = |text: &str| unguarded(&Source::new("a.rs", text)).len();
    let body = "if a.len() != b.len() { return Err(e) }\n Ok(a.iter().zip(b))";
    assert_eq!(count_cuts(&format!("fn read(t: &Columns) -> Result<T, E> {{ {body} }}")), 0);
    let late = "let c = a.iter().zip(b);\n if a.len() != b.len() { return Err(e) }";
    assert_eq!(count_cuts(&format!("fn read(t: &Columns) -> Result<T, E> {{ {late} }}")), 1);
    let reason = "// length: columns of one table are equally long\n a.iter().zip(b)";
    assert_eq!(count_cuts(&format!("fn read(t: &Columns) -> Result<T, E> {{ {reason} }}")), 0);
}
