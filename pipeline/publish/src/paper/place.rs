//! Resolution of one page: each of its words is replaced. What is not at hand is marked for [`super::omit`].

use super::facts::{Facts, Made};
use super::omit::ABSENT;
use super::scan::{self, Call};
use super::{Page, Problem, board, generated};
use crate::claims::{Verdict, short_number};

const WORDS: &[&str] =
    &["num", "val", "verdict", "when", "plate", "wide", "tabular", "broad", "eq", "claims", "failing", "scope"];

/// What the pages that were resolved so far have shown and lack.
#[derive(Default)]
pub(super) struct Found {
    /// Names of the figures and tables.
    pub shown: Vec<String>,
    /// Labels of those that were not made.
    pub missing: Vec<String>,
    /// What prevents building the paper.
    pub problems: Vec<Problem>,
}

/// The resolved page; used figures and tables, and problems, are added to what was found.
pub(super) fn resolved_page(page: &Page, facts: &Facts, found: &mut Found) -> Page {
    let text = Resolution { page, facts, found }.resolved_text(&page.text, 0);
    Page { name: page.name.clone(), text }
}

/// The resolution of one page.
struct Resolution<'a> {
    page: &'a Page,
    facts: &'a Facts,
    found: &'a mut Found,
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
                    output += &self.chosen_text(&blocks, choice, offset);
                    position = end;
                }
                Some(Err(problem)) => self.add_problem(call_offset, problem),
                None => match self.replacement(&call) {
                    Ok(words) => {
                        output += &words;
                        position = self.caption_end(&call, text, position);
                    }
                    Err(problem) => self.add_problem(call_offset, problem),
                },
            }
        }
        output + &text[position..]
    }

    /// The text of the chosen block. Without a choice the sentence around it is left out; nothing is where the blocks are sentences.
    fn chosen_text(&mut self, blocks: &[(&str, usize)], choice: Option<usize>, offset: usize) -> String {
        match choice {
            Some(choice) => {
                let (inside, start) = blocks[choice];
                self.resolved_text(inside, offset + start)
            }
            None if blocks[0].0.trim_end().ends_with('.') => String::new(),
            None => ABSENT.to_string(),
        }
    }

    /// Where the text goes on: behind the caption of a figure or table that was not made.
    fn caption_end(&self, call: &Call, text: &str, position: usize) -> usize {
        let missing = label_of(call).is_some_and(|label| self.found.missing.contains(&label));
        let caption = || scan::block_inside(text, position).map(|(_, end)| end);
        if missing { caption().unwrap_or(position) } else { position }
    }

    /// The replacement of a word without blocks.
    fn replacement(&mut self, call: &Call) -> Result<String, String> {
        let facts = self.facts;
        match call.word {
            "num" | "val" => Ok(match number_at_hand(call.name, facts)? {
                Some((number, unit)) => number_in_words(number, call, unit),
                None => ABSENT.to_string(),
            }),
            "plate" | "wide" => {
                let figure = self.made_text(call, &facts.figures, "figure")?;
                Ok(figure.map_or_else(String::new, |_| format!("#{}(\"{}\")", call.word, call.name)))
            }
            "tabular" | "broad" => {
                let table = self.made_text(call, &facts.tables, "table")?;
                table.map_or_else(|| Ok(String::new()), |csv| board::typst_table(call.word, call.name, csv))
            }
            "eq" if facts.tests.as_ref().is_none_or(|tests| tests.contains(call.name)) => {
                Ok(format!("#eq(\"{}\")", call.name))
            }
            "eq" => Err(format!("no test is called `{}`", call.name)),
            "scope" => Ok(generated::SCOPE.to_string()),
            "claims" => Ok(generated::claim_table(facts).unwrap_or_else(|| {
                self.found.missing.push("tab:claims".to_owned());
                String::new()
            })),
            _ => Ok(generated::failing_claims(facts)),
        }
    }

    /// The text of a figure or table, which counts as shown from now on; nothing where this profile does not make it.
    fn made_text(&mut self, call: &Call, entries: &'a [Made], kind: &str) -> Result<Option<&'a str>, String> {
        let name = call.name;
        let entry = entries.iter().find(|m| m.name == name).ok_or_else(|| format!("there is no {kind} `{name}`"))?;
        if self.found.shown.iter().any(|s| s == name) {
            return Err(format!("{kind} `{name}` is shown twice"));
        }
        self.found.shown.push(name.to_owned());
        match &entry.text {
            Some(text) => Ok(Some(text)),
            None if self.facts.strict && !entry.elsewhere => {
                Err(format!("{kind} `{name}` was not made: study run {name}"))
            }
            None => {
                self.found.missing.extend(label_of(call));
                Ok(None)
            }
        }
    }

    /// Records a problem at a byte of the page.
    fn add_problem(&mut self, position: usize, what: String) {
        let line = scan::line_number(&self.page.text, position);
        self.found.problems.push(Problem { page: self.page.name.clone(), line, what });
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

/// The label of a figure or table; none for other words.
fn label_of(call: &Call) -> Option<String> {
    let prefix = match call.word {
        "plate" | "wide" => "fig",
        "tabular" | "broad" => "tab",
        _ => return None,
    };
    Some(format!("{prefix}:{}", call.name))
}

/// Index of the chosen block after a call, where one is chosen, and the number of blocks; none for words without blocks.
fn chosen_block(call: &Call, facts: &Facts) -> Option<Result<(Option<usize>, usize), String>> {
    match call.word {
        "verdict" => {
            let claim = facts.claims.iter().find(|c| c.name == call.name);
            // the text says what came out, the table of claims who decided it
            let verdict = claim.map(|c| match c.rule_outcome(&facts.metrics) {
                Verdict::Reproduces | Verdict::SetByBench => (Some(0), 3),
                Verdict::Fails | Verdict::FailsByBench => (Some(1), 3),
                Verdict::Undetermined => (Some(2), 3),
                Verdict::NotMeasured => (None, 3),
            });
            Some(verdict.ok_or_else(|| format!("claim `{}` is not in claims.toml", call.name)))
        }
        "when" => Some(all_at_hand(call, facts).map(|all| (Some(usize::from(!all)), 2))),
        _ => None,
    }
}

/// Whether every number that a `#when` names is at hand; a figure or table is named by its label.
fn all_at_hand(call: &Call, facts: &Facts) -> Result<bool, String> {
    let at_hand = |name: &&str| match name.split_once(':') {
        Some(("fig", figure)) => Ok(facts.figures.iter().any(|made| made.name == figure && made.text.is_some())),
        Some(("tab", table)) => Ok(facts.tables.iter().any(|made| made.name == table && made.text.is_some())),
        _ => number_at_hand(name, facts).map(|number| number.is_some()),
    };
    call.names.iter().map(at_hand).try_fold(true, |all, one| Ok(all & one?))
}

/// The number and its unit; nothing where it is known and not at hand.
fn number_at_hand<'a>(name: &str, facts: &'a Facts) -> Result<Option<(f64, &'a str)>, String> {
    let matching = facts.metrics.iter().find(|m| m.metric.id == name);
    match matching {
        Some(entry) => Ok(Some((entry.metric.value, entry.metric.unit.as_str()))),
        None if facts.known.contains(name) && !facts.strict => Ok(None),
        None if facts.known.contains(name) => Err(format!("number `{name}` was not computed: study run")),
        None => {
            Err(format!("number `{name}` is not defined: no stage makes it and paper/expected.toml does not list it"))
        }
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
