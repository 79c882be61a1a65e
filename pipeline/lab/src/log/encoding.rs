//! The encoding of a text: UTF-8 and UTF-16 with or without a byte-order mark, else Windows-1252.

/// What the bytes from 0x80 to 0x9f stand for in Windows-1252; those from 0xa0 on are the first of Unicode.
const WINDOWS_1252: [char; 32] = [
    '€', '\u{81}', '‚', 'ƒ', '„', '…', '†', '‡', 'ˆ', '‰', 'Š', '‹', 'Œ', '\u{8d}', 'Ž', '\u{8f}', '\u{90}', '‘', '’',
    '“', '”', '•', '–', '—', '˜', '™', 'š', '›', 'œ', '\u{9d}', 'ž', 'Ÿ',
];
/// Characters of a text without a mark that are looked at for the zeros of UTF-16.
const EXAMINED: usize = 512;

/// Line breaks within one quoted field at most: more are a quote that was never closed.
const MAX_FIELD_BREAKS: usize = 8;

/// The text of a log; none where the bytes are no text. UTF-8 keeps its byte-order mark; fields in quotes lose their line breaks.
pub(crate) fn decode_text(bytes: Vec<u8>) -> Option<String> {
    let text = match utf_16(&bytes) {
        Some(text) => text?,
        None => String::from_utf8(bytes)
            .unwrap_or_else(|error| error.as_bytes().iter().map(|b| windows_1252_letter(*b)).collect()),
    };
    // A workbook or a picture has bytes that stand in no text.
    let is_control = |c: char| c < ' ' && !matches!(c, '\t' | '\n' | '\r' | '\u{b}' | '\u{c}' | '\u{1a}');
    (!text.chars().any(is_control)).then(|| join_quoted_lines(text))
}

/// Spreadsheets write titles of several lines in quotes. Each break within quotes becomes a blank and moves behind the record, so that the lines
/// below keep their numbers in messages.
fn join_quoted_lines(text: String) -> String {
    if !text.contains('"') {
        return text;
    }
    let lines: Vec<&str> = text.split('\n').collect();
    let mut joined: Vec<String> = Vec::with_capacity(lines.len());
    while joined.len() < lines.len() {
        let remaining = &lines[joined.len()..];
        let count = quoted_record_length(remaining);
        let parts: Vec<&str> = remaining[..count].iter().map(|line| line.trim_end_matches('\r')).collect();
        joined.push(if count == 1 { remaining[0].to_owned() } else { parts.join(" ") });
        joined.extend(std::iter::repeat_n(String::new(), count - 1));
    }
    joined.join("\n")
}

/// Lines of the first record: more than one where its last quote opens a field that a later line closes.
fn quoted_record_length(lines: &[&str]) -> usize {
    let quotes = |line: &str| line.matches('"').count();
    // a quote behind a word is a sign of its own, such as inches in a title
    let opens_field = lines[0].rsplit_once('"').is_some_and(|(before, _)| {
        before.trim_end_matches(' ').chars().next_back().is_none_or(|c| matches!(c, ',' | ';' | '\t' | '\u{feff}'))
    });
    if !opens_field || quotes(lines[0]) % 2 == 0 {
        return 1;
    }
    let last = lines.iter().take(MAX_FIELD_BREAKS + 1).skip(1).position(|line| quotes(line) % 2 == 1);
    last.map_or(1, |position| position + 2)
}

/// Whether bytes are read as Windows-1252, which no mark confirms.
pub fn is_windows_1252(bytes: &[u8]) -> bool {
    utf_16(bytes).is_none() && std::str::from_utf8(bytes).is_err()
}

fn windows_1252_letter(byte: u8) -> char {
    match byte {
        0x80..=0x9f => WINDOWS_1252[usize::from(byte - 0x80)],
        _ => char::from(byte),
    }
}

/// A text in UTF-16, by its mark or by the zeros beside its Latin letters: none where the bytes are not in UTF-16, within it none where they
/// are cut or broken.
fn utf_16(bytes: &[u8]) -> Option<Option<String>> {
    let zero_count = |odd: usize| bytes.iter().skip(odd).step_by(2).take(EXAMINED).filter(|byte| **byte == 0).count();
    let threshold = bytes.len().div_ceil(2).min(EXAMINED) / 2;
    let order: fn([u8; 2]) -> u16 = match bytes {
        [0xff, 0xfe, ..] => u16::from_le_bytes,
        [0xfe, 0xff, ..] => u16::from_be_bytes,
        _ if threshold > 0 && zero_count(1) > threshold && zero_count(0) == 0 => u16::from_le_bytes,
        _ if threshold > 0 && zero_count(0) > threshold && zero_count(1) == 0 => u16::from_be_bytes,
        _ => return None,
    };
    // length: an odd byte at the end is half a letter of a file that was cut
    let (pairs, odd_byte) = bytes.as_chunks::<2>();
    let units: Vec<u16> = pairs.iter().map(|pair| order(*pair)).collect();
    let text = String::from_utf16(&units).ok().filter(|_| odd_byte.is_empty());
    Some(text.map(|text| text.trim_start_matches('\u{feff}').to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "time_s;Temp °C;€\n0,5;21,5;1\n";

    #[test]
    fn a_text_comes_back_from_every_encoding() {
        let wide = |order: fn(u16) -> [u8; 2]| TEXT.encode_utf16().flat_map(order).collect::<Vec<u8>>();
        let (little, big) = (wide(u16::to_le_bytes), wide(u16::to_be_bytes));
        let marked = |mark: [u8; 2], bytes: &[u8]| [&mark[..], bytes].concat();
        let single: Vec<u8> = TEXT.chars().map(|c| if c == '€' { 0x80 } else { c as u8 }).collect();
        assert!(is_windows_1252(&single) && !is_windows_1252(TEXT.as_bytes()) && !is_windows_1252(&little));
        let all = [marked([0xff, 0xfe], &little), marked([0xfe, 0xff], &big), little, big, single, TEXT.into()];
        for bytes in all {
            assert_eq!(decode_text(bytes.clone()).as_deref(), Some(TEXT), "{bytes:?}");
        }
        assert_eq!(decode_text(format!("\u{feff}{TEXT}").into()), Some(format!("\u{feff}{TEXT}")));
    }

    #[test]
    fn quoted_titles_of_several_lines_become_one_and_lines_below_keep_their_numbers() {
        let joined = |text: &str| decode_text(text.into()).unwrap();
        let text = "\"Time\n(s)\",\"Force\r\n(mN)\"\r\n0,1\r\n";
        assert_eq!(joined(text), "\"Time (s)\",\"Force (mN)\"\r\n\n\n0,1\r\n".replace("\"\r\n", "\"\n"));
        assert_eq!(joined(text).lines().position(|line| line == "0,1"), text.lines().position(|line| line == "0,1"));
        for unchanged in ["t,\"a\"\"b\"\n0,1\n", "t,5\" bore\n0,1\n", "t,\"open\n0,1\n1,2\n", "\"a\",\"b\"\n"] {
            assert_eq!(joined(unchanged), unchanged);
        }
    }

    #[test]
    fn bytes_that_are_no_text_are_none() {
        assert_eq!(decode_text(b"PK\x03\x04\x14\x00\x06\x00\x08\x00\xe9".to_vec()), None);
        assert_eq!(decode_text(b"\xff\xfet\x00i".to_vec()), None, "cut within a letter");
        assert_eq!(decode_text(Vec::new()).as_deref(), Some(""));
    }
}
