//! Changes of the boxes of a film that was written by the crate, whose index is at the end.

/// Where the content of the first box of a name in the index begins.
pub fn content(film: &[u8], name: &[u8; 4]) -> usize {
    let index = film.windows(4).rposition(|w| w == b"moov").unwrap();
    index + film[index..].windows(4).position(|w| w == name).unwrap() + 4
}

/// A box of a name and 32-bit numbers.
pub fn boxed(name: &[u8; 4], numbers: &[u32]) -> Vec<u8> {
    let content: Vec<u8> = numbers.iter().flat_map(|number| number.to_be_bytes()).collect();
    [&(content.len() as u32 + 8).to_be_bytes(), &name[..], &content].concat()
}

/// Puts bytes at the end of the innermost of some boxes, each inside the one before, and makes all of them larger.
pub fn append(mut film: Vec<u8>, inside: &[&[u8; 4]], bytes: &[u8]) -> Vec<u8> {
    let mut end = 0;
    for name in inside {
        let start = content(&film, name) - 8;
        let size = u32::from_be_bytes(film[start..start + 4].try_into().unwrap());
        end = start + size as usize;
        film[start..start + 4].copy_from_slice(&(size + bytes.len() as u32).to_be_bytes());
    }
    film.splice(end..end, bytes.iter().copied());
    film
}
