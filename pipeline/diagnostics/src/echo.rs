//! Text from files as a message shows it: tokens cut, control characters escaped.
//!
//! A message repeats names, words and values that stood in a file. A token of 70,000 characters would push its reason off the screen, and a
//! line end in a name would look like the next part of the message.

use std::fmt::Write;

/// Longest token, characters: a quoted word of a file is recognised by less.
const TOKEN: usize = 80;
/// Longest path and longest line, characters: a path that is cut cannot be copied, and a list of known keys takes half of this.
const LINE: usize = 2000;

/// A text of a message: what stands between backquotes and every word cut at [`TOKEN`] characters, a line at [`LINE`], and control
/// characters escaped; a line end is escaped within backquotes alone, since messages have lines of their own.
pub(crate) fn escaped_message(message: &str) -> String {
    // An opening quote without its end quotes nothing.
    let paired = message.matches('`').count() / 2 * 2;
    let part = |(i, part): (usize, &str)| match i % 2 == 1 && i < paired {
        true => escaped_token(part),
        false => part.split('\n').map(cut_words).collect::<Vec<_>>().join("\n"),
    };
    let parts: Vec<String> = message.split('`').enumerate().map(part).collect();
    parts.join("`").split('\n').map(|line| cut_token(line, LINE)).collect::<Vec<_>>().join("\n")
}

/// One token, such as a name or a path.
pub(crate) fn escaped_token(token: &str) -> String {
    cut_token(&escape_controls(token), token_limit(token))
}

/// A line with each of its words cut.
fn cut_words(line: &str) -> String {
    line.split(' ').map(self::escaped_token).collect::<Vec<_>>().join(" ")
}

fn token_limit(token: &str) -> usize {
    if token.contains(['/', '\\']) { LINE } else { TOKEN }
}

fn cut_token(token: &str, longest: usize) -> String {
    match token.char_indices().nth(longest) {
        Some((end, _)) => format!("{}…", &token[..end]),
        None => token.to_owned(),
    }
}

fn escape_controls(token: &str) -> String {
    let mut shown = String::with_capacity(token.len());
    for c in token.chars() {
        match c {
            '\t' => shown.push(c),
            '\n' => shown.push_str("\\n"),
            c if c.is_control() => write!(shown, "{}", c.escape_unicode()).expect("a string takes any text"),
            c => shown.push(c),
        }
    }
    shown
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_token_is_cut_at_80_characters_quoted_or_not() {
        let long = "ä".repeat(70_000);
        let shown = format!("{}…", "ä".repeat(80));
        assert_eq!(escaped_message(&format!("`{long}` is no key")), format!("`{shown}` is no key"));
        assert_eq!(escaped_message(&format!("found {long}, not 3")), format!("found {shown} not 3"));
        assert_eq!(escaped_message(&format!("`{}`", "a b ".repeat(9000))).chars().count(), 83);
        assert_eq!(escaped_message(&"ab ".repeat(70_000)).chars().count(), LINE + 1);
    }

    #[test]
    fn a_path_of_a_project_is_whole() {
        let path = format!("/home/{}/study.toml", "a".repeat(200));
        assert_eq!(escaped_message(&format!("{path} cannot be read")), format!("{path} cannot be read"));
    }

    #[test]
    fn a_line_end_in_a_name_is_escaped_and_one_of_the_message_is_not() {
        assert_eq!(escaped_message("no record `a\nb\u{1b}[2J`:\nfirst"), "no record `a\\nb\\u{1b}[2J`:\nfirst");
        assert_eq!(escaped_message("an odd ` quote\nof two lines"), "an odd ` quote\nof two lines");
        assert_eq!(escaped_token("a\nb"), "a\\nb");
    }
}
