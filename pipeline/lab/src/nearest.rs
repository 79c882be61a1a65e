//! The known word nearest to a misspelt one, for messages that say what was probably meant.
//!
//! Stands on: nothing. Never knows: where the words come from.

/// Levenshtein's distance between two words: the fewest letters put in, left out or changed.
fn distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, from) in a.chars().enumerate() {
        let mut corner = row[0];
        row[0] = i + 1;
        for (j, to) in b.iter().enumerate() {
            let change = corner + usize::from(from != *to);
            corner = row[j + 1];
            row[j + 1] = change.min(row[j] + 1).min(corner + 1);
        }
    }
    row[b.len()]
}

/// The word of `known` that is nearest to `word`, if it is near enough to be a slip (a third of its letters or two).
pub(crate) fn nearest<'a>(word: &str, known: &[&'a str]) -> Option<&'a str> {
    let (steps, best) = known.iter().map(|k| (distance(word, k), *k)).min()?;
    (steps <= 2.max(word.chars().count() / 3)).then_some(best)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slip_of_two_letters_finds_its_word_and_a_strange_word_finds_none() {
        let known = ["youngs_modulus", "poissons_ratio", "density"];
        assert_eq!(nearest("young_modulus", &known), Some("youngs_modulus"));
        assert_eq!(nearest("colour", &known), None);
    }
}
