//! Triangles of an STL, binary or ASCII, of one solid or several.
//!
//! Words in either case, ends of lines of any system, and the names of solids in any encoding are read. Normals are not: the order of the
//! corners says the same, and several programs write zeros or NaN.

use std::collections::HashMap;

/// A file that is no STL: what is there, and what belongs there.
#[derive(Debug, thiserror::Error)]
#[error("{place}: `{word}` stands where {wanted} belongs")]
pub struct StlSyntax {
    /// Line of a text, byte of a binary file.
    pub place: String,
    /// What stands there.
    pub word: String,
    /// What belongs there.
    pub wanted: &'static str,
}

/// Corners of each triangle, in the file's unit.
pub(super) type Triangle = [[f32; 3]; 3];

/// Bytes before the first triangle of a binary file: a remark and the number of triangles.
const HEAD: usize = 84;
/// Bytes of a triangle: normal, corners, attributes.
const TRIANGLE: usize = 50;

/// The triangles of all solids of a file.
///
/// # Errors
/// [`StlSyntax`] at the first word that does not belong there.
pub(super) fn read_triangles(bytes: &[u8]) -> Result<Vec<Triangle>, StlSyntax> {
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let count = bytes.get(80..HEAD).and_then(|count| count.first_chunk().copied()).map(u32::from_le_bytes);
    let length = count.and_then(|count| (count as usize).checked_mul(TRIANGLE)?.checked_add(HEAD));
    // Some programs begin the remark of a binary file with `solid`: its length decides before its words do.
    match length {
        // length: whole triangles stand behind the head
        _ if is_uncounted(bytes, count, text) => Ok(bytes[HEAD..].chunks_exact(TRIANGLE).map(read_triangle).collect()),
        Some(length) if hides_triangles(bytes, length) && !is_text(text) => Err(miscounted(bytes.len(), count)),
        Some(length) if length == bytes.len() || length < bytes.len() && !is_text(text) => {
            // length: the head announces whole triangles
            Ok(bytes[HEAD..length].chunks_exact(TRIANGLE).map(read_triangle).collect())
        }
        _ if is_text(text) => Text::new(text).read_facets(),
        _ => Err(binary_length(bytes.len(), length)),
    }
}

/// Whether a binary file has the count that a program writes before it knows the number of triangles, and the length of some.
fn is_uncounted(bytes: &[u8], count: Option<u32>, text: &[u8]) -> bool {
    let is_whole = bytes.len() > HEAD && (bytes.len() - HEAD).is_multiple_of(TRIANGLE);
    matches!(count, Some(0 | u32::MAX)) && is_whole && !(is_text(text) && text.is_ascii())
}

/// Whether whole triangles that are not all zeros stand behind the counted ones.
fn hides_triangles(bytes: &[u8], length: usize) -> bool {
    let behind = bytes.get(length..).unwrap_or_default();
    !behind.is_empty() && behind.len().is_multiple_of(TRIANGLE) && behind.iter().any(|byte| *byte != 0)
}

fn miscounted(bytes: usize, count: Option<u32>) -> StlSyntax {
    let word = format!(
        "a count of {} triangles, in a file with the length of {},",
        count.unwrap_or(0),
        (bytes - HEAD) / TRIANGLE
    );
    StlSyntax { place: "byte 80".into(), word, wanted: "the number of triangles" }
}

fn binary_length(bytes: usize, expected: Option<usize>) -> StlSyntax {
    let word = expected.map_or("end of file".into(), |length| format!("end of file, {length} bytes announced,"));
    StlSyntax { place: format!("byte {bytes}"), word, wanted: "`solid`, or 84 bytes and 50 for each triangle," }
}

fn is_text(text: &[u8]) -> bool {
    let word: Vec<u8> = text.iter().copied().skip_while(u8::is_ascii_whitespace).take(5).collect();
    word.eq_ignore_ascii_case(b"solid")
}

fn read_triangle(bytes: &[u8]) -> Triangle {
    let number = |k: usize| {
        let offset = 12 + 4 * k;
        bytes[offset..].first_chunk().map_or(f32::NAN, |four| f32::from_le_bytes(*four))
    };
    [0, 1, 2].map(|corner| [0, 1, 2].map(|axis| number(3 * corner + axis)))
}

/// A text that is read word by word.
struct Text<'a> {
    rest: &'a [u8],
    line: usize,
}

impl<'a> Text<'a> {
    fn new(rest: &'a [u8]) -> Self {
        Self { rest, line: 1 }
    }

    fn read_facets(&mut self) -> Result<Vec<Triangle>, StlSyntax> {
        let mut facets = Vec::new();
        while let Some(word) = self.next_word() {
            match word.to_ascii_lowercase().as_slice() {
                // the rest of the line is the solid's name
                b"solid" | b"endsolid" => self.skip_line(),
                b"facet" => facets.push(self.read_facet()?),
                _ => return Err(self.syntax_error(Some(word), "`facet`, `solid` or `endsolid`")),
            }
        }
        Ok(facets)
    }

    fn read_facet(&mut self) -> Result<Triangle, StlSyntax> {
        self.expect_keyword(b"normal", "`normal`")?;
        for _ in 0..3 {
            self.next_word();
        }
        self.expect_keyword(b"outer", "`outer`")?;
        self.expect_keyword(b"loop", "`loop`")?;
        let triangle = [self.read_vertex()?, self.read_vertex()?, self.read_vertex()?];
        self.expect_keyword(b"endloop", "`endloop` after three corners")?;
        self.expect_keyword(b"endfacet", "`endfacet`")?;
        Ok(triangle)
    }

    fn read_vertex(&mut self) -> Result<[f32; 3], StlSyntax> {
        self.expect_keyword(b"vertex", "`vertex`")?;
        Ok([self.read_number()?, self.read_number()?, self.read_number()?])
    }

    fn read_number(&mut self) -> Result<f32, StlSyntax> {
        let word = self.next_word();
        // between blanks, a comma is a decimal sign
        let number = word.and_then(|word| std::str::from_utf8(word).ok()?.replacen(',', ".", 1).parse().ok());
        number.ok_or_else(|| self.syntax_error(word, "a number"))
    }

    fn expect_keyword(&mut self, keyword: &[u8], wanted: &'static str) -> Result<(), StlSyntax> {
        let word = self.next_word();
        let is = word.is_some_and(|word| word.eq_ignore_ascii_case(keyword));
        is.then_some(()).ok_or_else(|| self.syntax_error(word, wanted))
    }

    fn syntax_error(&self, word: Option<&[u8]>, wanted: &'static str) -> StlSyntax {
        let word = word.map_or("end of file".into(), |word| String::from_utf8_lossy(word).chars().take(24).collect());
        StlSyntax { place: format!("line {}", self.line), word, wanted }
    }

    fn next_word(&mut self) -> Option<&'a [u8]> {
        while let Some((byte, rest)) = self.rest.split_first().filter(|(byte, _)| byte.is_ascii_whitespace()) {
            self.line += usize::from(ends_line(*byte, rest));
            self.rest = rest;
        }
        let length = self.rest.iter().position(u8::is_ascii_whitespace).unwrap_or(self.rest.len());
        let (word, rest) = self.rest.split_at(length);
        self.rest = rest;
        (!word.is_empty()).then_some(word)
    }

    fn skip_line(&mut self) {
        let length = self.rest.iter().position(|byte| matches!(byte, b'\n' | b'\r')).unwrap_or(self.rest.len());
        self.rest = &self.rest[length..];
    }
}

/// Whether a line ends here, LF, CR LF or CR alone.
fn ends_line(byte: u8, rest: &[u8]) -> bool {
    byte == b'\n' || byte == b'\r' && rest.first() != Some(&b'\n')
}

/// Each place once, in the order of the file, and the triangles by their numbers.
pub(super) fn index_places(triangles: &[Triangle]) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let mut numbers: HashMap<[u32; 3], u32> = HashMap::new();
    let mut places = Vec::new();
    let mut number = |place: [f32; 3]| {
        // By bits, which a hash can have: 0 and −0 become two places, and welding joins them.
        *numbers.entry(place.map(f32::to_bits)).or_insert_with(|| {
            places.push(place);
            places.len() as u32 - 1
        })
    };
    let faces = triangles.iter().map(|corners| corners.map(&mut number)).collect();
    (places, faces)
}

#[cfg(test)]
mod tests {
    use super::*;

    const FACET: &str =
        "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 2.5e0 0\nendloop\nendfacet\n";
    const CORNERS: Triangle = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 2.5, 0.0]];

    fn text(solid: &str) -> Result<Vec<Triangle>, StlSyntax> {
        read_triangles(solid.as_bytes())
    }

    #[test]
    fn every_solid_of_a_text_is_read_whatever_its_lines_letters_and_names() {
        let two = format!("solid a facet\n{FACET}endsolid a facet\nsolid\n{FACET}endsolid\n");
        for form in [
            two.clone(),
            two.to_uppercase(),
            two.replace('\n', "\r"),
            two.replace('\n', "\r\n"),
            format!("\u{feff}{two}"),
        ] {
            assert_eq!(text(&form).unwrap(), [CORNERS; 2], "{form:?}");
        }
        let latin: Vec<u8> = [b"solid k\xf6rper\n", FACET.as_bytes()].concat();
        assert_eq!(read_triangles(&latin).unwrap(), [CORNERS]);
        assert_eq!(text(&format!("solid\n{}", FACET.replace("0 0 1\n", "nan -nan(ind) inf\n"))).unwrap(), [CORNERS]);
    }

    #[test]
    fn a_binary_file_is_known_by_its_length_whatever_its_remark_says() {
        let mut binary = b"solid facet normal\n".to_vec();
        binary.resize(80, b' ');
        binary.extend(1_u32.to_le_bytes());
        binary.extend([f32::NAN; 3].iter().chain(CORNERS.iter().flatten()).flat_map(|x| x.to_le_bytes()));
        binary.extend([0, 0]);
        assert_eq!(read_triangles(&binary).unwrap(), [CORNERS]);
        binary.pop();
        assert!(read_triangles(&binary).is_err());
    }

    #[test]
    fn a_count_that_was_never_written_is_that_of_the_length_and_a_wrong_one_is_refused() {
        let mut binary = vec![b' '; 80];
        binary.extend(0_u32.to_le_bytes());
        for _ in 0..3 {
            binary.extend([0.0_f32; 3].iter().chain(CORNERS.iter().flatten()).flat_map(|x| x.to_le_bytes()));
            binary.extend([0, 0]);
        }
        assert_eq!(read_triangles(&binary).unwrap(), [CORNERS; 3]);
        binary[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
        assert_eq!(read_triangles(&binary).unwrap(), [CORNERS; 3]);
        binary[80] = 2;
        binary[81..84].fill(0);
        let error = read_triangles(&binary).unwrap_err().to_string();
        assert!(error.contains("a count of 2 triangles, in a file with the length of 3"), "{error}");
        let behind = HEAD + 2 * TRIANGLE;
        binary[behind..].fill(0);
        assert_eq!(read_triangles(&binary).unwrap(), [CORNERS; 2], "zeros fill the file");
    }

    #[test]
    fn a_wrong_word_is_named_with_its_line() {
        assert_eq!(text(&format!("solid\n{}", FACET.replace("2.5e0", "2,5"))).unwrap(), [CORNERS]);
        let error = text(&format!("solid\n{}", FACET.replace("2.5e0", "2,5,0"))).unwrap_err().to_string();
        assert_eq!(error, "line 6: `2,5,0` stands where a number belongs");
        let quadrilateral = FACET.replace("endloop", "vertex 1 1 0\nendloop");
        let error = text(&format!("solid\r\n{}", quadrilateral.replace('\n', "\r\n"))).unwrap_err().to_string();
        assert!(error.starts_with("line 7: `vertex` stands where `endloop`"), "{error}");
        assert!(text("solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0").is_err());
    }

    #[test]
    fn a_place_has_one_number() {
        let (places, faces) = index_places(&[CORNERS, [CORNERS[1], [9.0; 3], CORNERS[0]]]);
        assert_eq!((places.len(), faces), (4, vec![[0, 1, 2], [1, 3, 0]]));
    }
}
