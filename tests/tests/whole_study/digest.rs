//! A file in few numbers: its words as a hash, and its numbers in sums of a few with weights.

/// By how much rounding may change a sum: a share of its terms.
const SHARE: f64 = 1e-5;
const WEIGHTS: [f64; 3] = [1.0, 2.0, 3.0];

/// What a picture's bytes stand after in a drawing; a quotation mark ends them.
const PICTURE: &str = "base64,";

/// A file's words and numbers.
#[derive(Debug)]
pub struct Digest {
    words: u64,
    sums: Vec<f64>,
    /// The sums of the terms' absolute values; none of what is expected.
    terms: Vec<f64>,
}

impl Digest {
    /// Of a text, its numbers `each` to a sum, or its words alone; a picture within a drawing is a word.
    pub fn of_text(text: &str, each: Option<usize>) -> Self {
        let pieces = text
            .split(PICTURE)
            .enumerate()
            .map(|(i, piece)| if i == 0 { ("", piece) } else { piece.split_once('"').unwrap() });
        let (mut words, mut numbers) = (String::new(), Vec::new());
        for (picture, piece) in pieces {
            let (others, more) = split(piece);
            words.extend([picture, &*others]);
            numbers.extend(more);
        }
        each.map_or_else(|| Self::new(&words, &[], 1), |each| Self::new(&words, &numbers, each))
    }

    /// Of `words` and `numbers`, `each` of these to a sum.
    pub fn new(words: &str, numbers: &[f64], each: usize) -> Self {
        let weighted = |run: &[f64]| run.iter().zip(WEIGHTS.iter().cycle()).map(|(x, w)| x * w).sum();
        let sizes: Vec<f64> = numbers.iter().map(|x| x.abs()).collect();
        Self {
            words: hash(words),
            sums: numbers.chunks(each).map(weighted).collect(),
            terms: sizes.chunks(each).map(weighted).collect(),
        }
    }

    /// As [`Self::line`] wrote it.
    pub fn parse(line: &str) -> Option<Self> {
        let (words, sums) = line.split_once(' ').unwrap_or((line, ""));
        let sums = sums.split_whitespace().map(|sum| sum.parse().ok()).collect::<Option<_>>()?;
        Some(Self { words: u64::from_str_radix(words, 16).ok()?, sums, terms: Vec::new() })
    }

    /// One line.
    pub fn line(&self) -> String {
        self.sums.iter().fold(format!("{:016x}", self.words), |line, sum| line + &format!(" {sum:.6e}"))
    }

    /// In what this differs from what is `expected`, if it does.
    pub fn difference(&self, expected: &Self) -> Option<String> {
        if self.words != expected.words {
            return Some("has other words".to_owned());
        }
        let near = |i: usize| (self.sums[i] - expected.sums[i]).abs() <= SHARE * self.terms[i];
        let other = (0..self.sums.len().min(expected.sums.len())).find(|&i| !near(i));
        let lengths = (self.sums.len() != expected.sums.len()).then(|| "has more or fewer numbers".to_owned());
        let sum = |i: usize| {
            format!("has {:e} as sum {} of {}, was {:e}", self.sums[i], i + 1, self.sums.len(), expected.sums[i])
        };
        other.map(sum).or(lengths)
    }
}

/// A text without its numbers, and they. A digit belongs to a number wherever it stands.
fn split(text: &str) -> (String, Vec<f64>) {
    let (mut words, mut numbers, mut rest) = (String::new(), Vec::new(), text);
    while let Some(at) = rest.find(|c: char| c.is_ascii_digit()) {
        let begin = at - usize::from(rest[..at].ends_with('-'));
        let end = begin + length(&rest.as_bytes()[begin..]);
        words.push_str(&rest[..begin]);
        words.push('#');
        numbers.push(rest[begin..end].parse().unwrap());
        rest = &rest[end..];
    }
    words.push_str(rest);
    (words, numbers)
}

/// The length of the number that `bytes` begin with: a sign, digits, a point and digits, an exponent.
fn length(bytes: &[u8]) -> usize {
    let digits = |from: usize| from + bytes[from..].iter().take_while(|b| b.is_ascii_digit()).count();
    let mut end = digits(usize::from(bytes[0] == b'-'));
    if bytes.get(end) == Some(&b'.') {
        end = digits(end + 1);
    }
    let sign = usize::from(matches!(bytes.get(end + 1), Some(b'-' | b'+')));
    let power = matches!(bytes.get(end), Some(b'e')) && bytes.get(end + 1 + sign).is_some_and(u8::is_ascii_digit);
    if power { digits(end + 1 + sign) } else { end }
}

/// FNV-1a, 64 bits.
fn hash(words: &str) -> u64 {
    words.bytes().fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}
