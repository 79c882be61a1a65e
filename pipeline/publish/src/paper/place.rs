//! Resolution of one page: each of its words is replaced.

use super::facts::{Facts, Made};
use super::scan::{self, Call};
use super::{Page, Problem, board, generated};
use crate::claims::{Verdict, short_number};

const WORDS: &[&str] =
    &["num", "val", "verdict", "when", "plate", "wide", "tabular", "broad", "eq", "claims", "failing"];
/// The text for a number that this profile does not measure.
const ABSENT: &str = "#emph[not measured in this profile]";

/// The resolved page; used figures and tables, and problems, are added to the lists.
pub(crate) fn resolved_page(page: &Page, facts: &Facts, shown: &mut Vec<String>, problems: &mut Vec<Problem>) -> Page {
    let text = Resolution { page, facts, shown, problems }.resolved_text(&page.text, 0);
    Page { name: page.name.clone(), text }
}

/// The resolution of one page.
struct Resolution<'a> {
    page: &'a Page,
    facts: &'a Facts,
    /// Names of the figures and tables so far.
    shown: &'a mut Vec<String>,
    problems: &'a mut Vec<Problem>,
}

impl<'a> Resolution<'a> {
    /// `text` begins at byte `offset` of its page.
    fn resolved_text(&mut self, text: &str, offset: usize) -> String {
        let (mut output, mut position) = (String::new(), 0);
        while let Some(call) = scan::next_call(text, WORDS, position) {
            output += &text[position..call.span.0];
            let call_offset = offset + call.span.0;
            position = call.span.1;
            match chosen_block(&call, self.facts) {
                Some(Ok((choice, count))) => {
                    let Some((blocks, end)) = blocks_after(text, position, count) else {
                        self.add_problem(
                            call_offset,
                            format!("`#{}(…)` needs {count} blocks in brackets after it", call.word),
                        );
                        continue;
                    };
                    let (inside, start) = blocks[choice];
                    output += &self.resolved_text(inside, offset + start);
                    position = end;
                }
                Some(Err(problem)) => self.add_problem(call_offset, problem),
                None => match self.replacement(&call) {
                    Ok(words) => output += &words,
                    Err(problem) => self.add_problem(call_offset, problem),
                },
            }
        }
        output + &text[position..]
    }

    /// The replacement of a word without blocks.
    fn replacement(&mut self, call: &Call) -> Result<String, String> {
        let facts = self.facts;
        match call.word {
            "num" | "val" => Ok(match measured_number(call, facts)? {
                Some((number, unit)) => number_in_words(number, call, unit),
                None => ABSENT.to_owned(),
            }),
            "plate" | "wide" => {
                let figure = self.made_text(call, &facts.figures, "figure")?;
                let word = if figure.is_some() { call.word } else { "absent" };
                Ok(format!("#{word}(\"{}\")", call.name))
            }
            "tabular" | "broad" => match self.made_text(call, &facts.tables, "table")? {
                Some(csv) => board::typst_table(call.word, call.name, csv),
                None => Ok(format!("#absent(\"{}\")", call.name)),
            },
            "eq" if facts.tests.as_ref().is_none_or(|tests| tests.contains(call.name)) => {
                Ok(format!("#eq(\"{}\")", call.name))
            }
            "eq" => Err(format!("no test is called `{}`", call.name)),
            "claims" => Ok(generated::claim_table(facts)),
            _ => Ok(generated::failing_claims(facts)),
        }
    }

    /// The text of a figure or table, which counts as shown from now on; nothing where this profile does not make it.
    fn made_text(&mut self, call: &Call, entries: &'a [Made], kind: &str) -> Result<Option<&'a str>, String> {
        let name = call.name;
        let entry = entries.iter().find(|m| m.name == name).ok_or_else(|| format!("there is no {kind} `{name}`"))?;
        if self.shown.iter().any(|s| s == name) {
            return Err(format!("{kind} `{name}` is shown twice"));
        }
        self.shown.push(name.to_owned());
        match &entry.text {
            Some(text) => Ok(Some(text)),
            None if self.facts.strict && !entry.elsewhere => {
                Err(format!("{kind} `{name}` was not made: study run {name}"))
            }
            None => Ok(None),
        }
    }

    /// Records a problem at a byte of the page.
    fn add_problem(&mut self, position: usize, what: String) {
        let line = scan::line_number(&self.page.text, position);
        self.problems.push(Problem { page: self.page.name.clone(), line, what });
    }
}

/// Insides of `count` blocks with where they begin, and the end of the last.
fn blocks_after(text: &str, start: usize, count: usize) -> Option<(Vec<(&str, usize)>, usize)> {
    let (mut insides, mut position) = (Vec::new(), start);
    for _ in 0..count {
        let (inside, end) = scan::block_inside(text, position)?;
        insides.push((inside, position + 1));
        position = end;
    }
    Some((insides, position))
}

/// Index of the chosen block after a call and their number; none for words without blocks.
fn chosen_block(call: &Call, facts: &Facts) -> Option<Result<(usize, usize), String>> {
    match call.word {
        "verdict" => {
            let claim = facts.claims.iter().find(|c| c.name == call.name);
            // the text says what came out, the table of claims who decided it
            let verdict = claim.map(|c| match c.rule_outcome(&facts.metrics) {
                Verdict::Reproduces | Verdict::SetByBench => (0, 3),
                Verdict::Fails => (1, 3),
                Verdict::NotMeasured | Verdict::Undetermined => (2, 3),
            });
            Some(verdict.ok_or_else(|| format!("claim `{}` is not in claims.toml", call.name)))
        }
        "when" => Some(measured_number(call, facts).map(|number| (usize::from(number.is_none()), 2))),
        _ => None,
    }
}

/// The number and its unit; nothing where this profile does not measure it.
fn measured_number<'a>(call: &Call, facts: &'a Facts) -> Result<Option<(f64, &'a str)>, String> {
    let matching = facts.metrics.iter().find(|m| m.metric.id == call.name);
    match matching {
        Some(entry) => Ok(Some((entry.metric.value, entry.metric.unit.as_str()))),
        None if facts.known.contains(call.name) && !facts.strict => Ok(None),
        None if facts.known.contains(call.name) => Err(format!("number `{}` was not computed: study run", call.name)),
        None => Err(format!(
            "number `{}` is not defined: no stage makes it and paper/expected.toml does not list it",
            call.name
        )),
    }
}

/// A string of typst, ended by the semicolon that it would otherwise take from the sentence.
fn number_in_words(value: f64, call: &Call, unit: &str) -> String {
    let digits = call.digits.map_or_else(|| short_number(value), |digits| format!("{value:.digits$}"));
    let unit = if call.word == "val" && !unit.is_empty() { format!("\u{a0}{unit}") } else { String::new() };
    match digits.split_once('e') {
        Some((mantissa, power)) => format!("${mantissa} dot 10^({power})$#\"{unit}\";"),
        None => format!("#\"{}{unit}\";", digits.replace('-', "−")),
    }
}
