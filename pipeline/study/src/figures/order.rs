//! Order of specimens in figures: the paper's tails come first, each with a fixed colour.

use plot::{Colour, palette};

use records::subject::{Specimen, Trial};

/// The tails of the paper, in its order; others follow by name.
const PAPER: [&str; 3] = ["nemo", "bruce", "dory"];

/// Anything that belongs to a specimen.
pub trait Belongs {
    /// The specimen's name.
    fn tail_name(&self) -> &str;
}

impl Belongs for Specimen {
    fn tail_name(&self) -> &str {
        &self.card.name
    }
}

impl Belongs for Trial {
    fn tail_name(&self) -> &str {
        &self.card.name
    }
}

fn paper_rank(name: &str) -> usize {
    PAPER.iter().position(|p| *p == name).unwrap_or(PAPER.len())
}

/// Subjects and what belongs to them, in the paper's order of tails.
pub(crate) fn in_order<S: Belongs, R>(mut subjects: Vec<(S, R)>) -> Vec<(S, R)> {
    subjects.sort_by(|(a, _), (b, _)| {
        paper_rank(a.tail_name()).cmp(&paper_rank(b.tail_name())).then_with(|| a.tail_name().cmp(b.tail_name()))
    });
    subjects
}

/// The colour of a tail; one for all that are not the paper's.
pub(crate) fn tail_colour(name: &str) -> Colour {
    palette::series(paper_rank(name))
}

/// A specimen's name capitalised: Nemo.
pub(crate) fn capitalised(name: &str) -> String {
    let mut letters = name.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// The record that belongs to a tail.
pub(crate) fn record_of<'a, S: Belongs, R>(subjects: &'a [(S, R)], name: &str) -> Option<&'a R> {
    subjects.iter().find(|(subject, _)| subject.tail_name() == name).map(|(_, record)| record)
}

#[cfg(test)]
mod tests {
    use super::*;

    impl Belongs for &str {
        fn tail_name(&self) -> &str {
            self
        }
    }

    #[test]
    fn the_papers_tails_come_first_and_a_missing_one_changes_no_colour() {
        let names = |all: Vec<&'static str>| -> Vec<&str> {
            in_order(all.into_iter().map(|n| (n, ())).collect()).into_iter().map(|(n, ())| n).collect()
        };
        assert_eq!(names(vec!["dory", "arm", "nemo"]), ["nemo", "dory", "arm"]);
        assert_ne!(tail_colour("nemo"), tail_colour("dory"));
        assert_eq!(capitalised("nemo"), "Nemo");
    }
}
