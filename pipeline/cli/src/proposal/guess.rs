//! A guess about a recording, with its evidence and how sure it is.

use std::fmt;

/// How sure a guess is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Confidence {
    /// The files say so themselves.
    Certain,
    /// The files agree with it and with little else.
    Likely,
    /// One of several that the files agree with.
    Unsure,
}

/// A guess.
#[derive(Debug, Clone, PartialEq)]
pub struct Guess {
    /// What it is about: a key of the card, or a file.
    pub about: String,
    /// The guess; of a question, none.
    pub value: Option<String>,
    /// How sure it is; of a question, unsure.
    pub confidence: Confidence,
    /// What it was concluded from; of a question, what is to be done.
    pub evidence: String,
}

impl Guess {
    pub(super) fn new(
        confidence: Confidence,
        about: impl Into<String>,
        value: impl fmt::Display,
        evidence: impl Into<String>,
    ) -> Self {
        Self { about: about.into(), value: Some(value.to_string()), confidence, evidence: evidence.into() }
    }

    /// What the files do not say.
    pub(super) fn question(about: impl Into<String>, evidence: impl Into<String>) -> Self {
        Self { about: about.into(), value: None, confidence: Confidence::Unsure, evidence: evidence.into() }
    }

    /// Its remark on the card.
    pub(super) fn remark(&self) -> String {
        match self.value {
            Some(_) => format!("{}: {}", self.confidence, self.evidence),
            None => format!("FILL IN; {}", self.evidence),
        }
    }
}

impl fmt::Display for Confidence {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Certain => "certain",
            Self::Likely => "likely",
            Self::Unsure => "unsure",
        })
    }
}

impl fmt::Display for Guess {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.value {
            Some(value) => write!(f, "{:<8} {} = {value}; {}", self.confidence, self.about, self.evidence),
            None => write!(f, "{:<8} {}; {}", "question", self.about, self.evidence),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_guess_and_a_question_are_a_line_and_a_remark() {
        let guess = Guess::new(Confidence::Likely, "camera.board.columns", 9, "12 of 20 frames");
        assert_eq!(guess.to_string(), "likely   camera.board.columns = 9; 12 of 20 frames");
        assert_eq!(guess.remark(), "likely: 12 of 20 frames");
        let question = Guess::question("length", "measure it");
        assert_eq!(question.to_string(), "question length; measure it");
        assert_eq!(question.remark(), "FILL IN; measure it");
    }
}
