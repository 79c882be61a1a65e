//! The next move as it can be pasted: a command in a `do:` line repeats the options by which the program found the project.
//!
//! Crates that name a command know neither the project's folder nor the profile, which the program alone has read. It sets them once.

use std::borrow::Cow;
use std::sync::OnceLock;

/// Begins a next move, in a diagnostic and in a last line.
const NEXT_MOVE: &str = "do:";
/// Commands that depend on where the project is and on its profile, of both programs.
const COMMANDS: [&str; 14] = [
    "rig record",
    "study run",
    "study make",
    "study plan",
    "study why",
    "study doctor",
    "study init",
    "study publish",
    "study page",
    "study fig",
    "study table",
    "study check",
    "study paper",
    "study export",
];

static OPTIONS: OnceLock<String> = OnceLock::new();

/// Sets what commands repeat, once for the process.
pub fn repeat_options(options: &[(&str, &str)]) {
    let text = options.iter().map(|(name, value)| format!(" {name} {}", quote_word(value))).collect();
    // the first call decides: a program reads its command line once
    let _ = OPTIONS.set(text);
}

/// A text whose commands repeat the options that were set.
pub(crate) fn with_options(text: &str) -> Cow<'_, str> {
    match OPTIONS.get().filter(|options| !options.is_empty()) {
        Some(options) if text.contains(NEXT_MOVE) => {
            Cow::Owned(text.split_inclusive('\n').map(|line| append_options(line, options)).collect())
        }
        _ => Cow::Borrowed(text),
    }
}

/// A line with the options behind each command of its next move.
fn append_options(line: &str, options: &str) -> String {
    let Some((before, mut rest)) = line.split_once(NEXT_MOVE) else { return line.to_owned() };
    let mut completed = format!("{before}{NEXT_MOVE}");
    while let Some(end) = COMMANDS.iter().filter_map(|command| Some(rest.find(command)? + command.len())).min() {
        let (command, after) = rest.split_at(end);
        completed += command;
        // a longer word is another one
        if !after.starts_with(|c: char| c.is_alphanumeric() || c == '_') {
            completed += options;
        }
        rest = after;
    }
    completed + rest
}

/// A word as a POSIX shell reads it back.
fn quote_word(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "_-./".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', r"'\''"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_command_of_a_next_move_repeats_the_options_and_nothing_else_does() {
        let options = " --root /p --profile quick";
        let line = |text: &str| append_options(text, options);
        assert_eq!(
            line("  do:  study run mesh, or study plan\n"),
            format!("  do:  study run{options} mesh, or study plan{options}\n")
        );
        assert_eq!(line("  why: study run made it"), "  why: study run made it");
        assert_eq!(line("2 stale; do: study runs, study.toml"), "2 stale; do: study runs, study.toml");
    }

    #[test]
    fn a_folder_with_spaces_or_quotes_is_one_word() {
        assert_eq!(quote_word("/p/quick-1"), "/p/quick-1");
        assert_eq!(quote_word("a b'c$(d)"), r"'a b'\''c$(d)'");
    }
}
