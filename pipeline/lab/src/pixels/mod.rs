//! Tracks of markers in a film's pixels from another program: a CSV of `study track` or of DeepLabCut.

mod deeplabcut;
mod sleap;

use std::borrow::Cow;

use si::Point2;

use diagnostics::{Diagnostic, Result};

/// One marker of a file.
#[derive(Debug, Clone, PartialEq)]
pub struct PixelTrack {
    /// Its name there and on the card.
    pub name: String,
    /// Where it is, px; none while it was lost: frames.
    pub at: Vec<Option<Point2>>,
    /// Covariance of each place, uu, uv and vv, px²: frames.
    pub covariance: Vec<[f64; 3]>,
}

/// How a file of HDF5 begins.
const HDF5: &[u8] = b"\x89HDF";

/// The tracks of the markers `names` in the bytes of a text, px, one position in each of `frames` frames; `sigma` (px) is their standard deviation
/// where the text has none.
///
/// # Errors
/// [`Diagnostic`] that names the marker and frame at which the text fails.
pub fn read(bytes: &[u8], names: &[String], frames: usize, sigma: f64) -> Result<Vec<PixelTrack>> {
    if bytes.starts_with(HDF5) {
        let reason = "it is DeepLabCut's HDF5, which is not read here";
        let action = "python -c \"import pandas, sys; pandas.read_hdf(sys.argv[1]).to_csv(sys.argv[2])\" tracks.h5 tracks.csv, and name the CSV on the card";
        return Err(Diagnostic::new("imported tracks cannot be used", reason, action));
    }
    let text =
        crate::log::encoding::decode_text(bytes.to_vec()).ok_or_else(|| import_error("the file is no text".into()))?;
    let text = with_commas(text.trim_start_matches('\u{feff}'));
    let title_line = text.lines().next().unwrap_or_default();
    let places = match title_line.split(',').next().map(str::trim) {
        Some("scorer") => deeplabcut::read_places(&text, names)?,
        Some("frame") => study_places(&text, names)?,
        Some("track") => sleap::read_places(&text, names, frames)?,
        _ => {
            let reason =
                "its first line is neither `frame,…` nor DeepLabCut's `scorer,…` nor SLEAP's `track,frame_idx,…`";
            return Err(import_error(reason.into()));
        }
    };
    let path = |(marker, name): (usize, &String)| {
        let marker_places: Vec<&Place> =
            places.iter().filter(|(owner, _)| *owner == marker).map(|(_, place)| place).collect();
        if marker_places.len() != frames {
            return Err(import_error(format!(
                "marker `{name}` has {} positions, the film {frames} frames",
                marker_places.len()
            )));
        }
        let place_covariance = |place: &Place| place.spread.unwrap_or([sigma * sigma, 0.0, sigma * sigma]);
        let (at, covariance) = marker_places.iter().map(|place| (place.at, place_covariance(place))).unzip();
        Ok(PixelTrack { name: name.clone(), at, covariance })
    };
    names.iter().enumerate().map(path).collect()
}

/// A text between commas; a program that saves a table between semicolons or tabs writes decimal commas.
fn with_commas(text: &str) -> Cow<'_, str> {
    let title_line = text.lines().next().unwrap_or_default();
    match [';', '\t'].into_iter().find(|sign| title_line.contains(*sign) && !title_line.contains(',')) {
        Some(separator) => Cow::Owned(text.replace(',', ".").replace(separator, ",")),
        None => Cow::Borrowed(text),
    }
}

/// A marker in a frame.
struct Place {
    /// None where it was lost.
    at: Option<Point2>,
    spread: Option<[f64; 3]>,
}

fn place_at(position: Point2) -> Place {
    Place { at: position.iter().all(|x| x.is_finite()).then_some(position), spread: None }
}

/// `frame,time_s,marker,u_px,v_px,uu_px2,uv_px2,vv_px2,…`, frames rising, each place with the number of its marker.
fn study_places(text: &str, names: &[String]) -> Result<Vec<(usize, Place)>> {
    let mut places = Vec::new();
    let mut last: Vec<Option<u64>> = vec![None; names.len()];
    for (row, line) in text.lines().enumerate().skip(1).filter(|(_, line)| !line.trim().is_empty()) {
        let words: Vec<&str> = line.split(',').map(str::trim).collect();
        let number = |k: usize| words.get(k).and_then(|w| w.parse::<f64>().ok());
        let frame = words.first().and_then(|word| word.parse::<u64>().ok());
        let (Some(frame), Some(name), Some(u), Some(v)) = (frame, words.get(2), number(3), number(4)) else {
            return Err(import_error(format!("line {} has no frame and marker with u and v", row + 1)));
        };
        let Some(marker) = names.iter().position(|marker_name| marker_name == name) else { continue };
        if let Some(previous) = last[marker].filter(|previous| frame != *previous + 1) {
            return Err(import_error(format!(
                "line {}: frame {frame} of marker `{name}` stands after frame {previous}",
                row + 1
            )));
        }
        last[marker] = Some(frame);
        // length: three numbers, not lists; a covariance is whole or absent
        let spread = number(5).zip(number(6)).zip(number(7)).map(|((a, b), c)| [a, b, c]);
        places.push((marker, Place { spread, ..place_at([u, v]) }));
    }
    Ok(places)
}

fn import_error(reason: String) -> Diagnostic {
    Diagnostic::new(
        "imported tracks cannot be used",
        reason,
        "export a position of every marker on the card in every frame, or let the film be tracked here",
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "frame,time_s,marker,u_px,v_px,uu_px2,uv_px2,vv_px2,residual,seen\n0,0,m1,1.5,2.5,0.01,0.002,0.04,1,1\n0,0,m2,3,4,0.01,0,0.01,1,1\n1,0.02,m1,1.6,2.5,0.01,0,0.04,1,1\n1,0.02,m2,3.1,4,0.01,0,0.01,1,1\n";

    fn names() -> Vec<String> {
        ["m1", "m2"].map(str::to_owned).to_vec()
    }

    #[test]
    fn our_own_csv_keeps_its_covariances() {
        let paths = read(TEXT.as_bytes(), &names(), 2, 9.0).unwrap();
        assert_eq!(paths[0].at, [Some([1.5, 2.5]), Some([1.6, 2.5])]);
        assert_eq!(paths[0].covariance[0], [0.01, 0.002, 0.04]);
        assert!(
            read(TEXT.as_bytes(), &names(), 3, 9.0)
                .unwrap_err()
                .why
                .contains("`m1` has 2 positions, the film 3 frames")
        );
    }

    #[test]
    fn a_table_between_semicolons_has_decimal_commas() {
        let text = TEXT.replace('.', "#").replace(',', ";").replace('#', ",");
        assert_eq!(read(text.as_bytes(), &names(), 2, 9.0), read(TEXT.as_bytes(), &names(), 2, 9.0));
    }

    #[test]
    fn a_frame_that_is_left_out_is_refused_with_its_line() {
        let said = read(TEXT.replace("\n1,", "\n2,").as_bytes(), &names(), 2, 9.0).unwrap_err().why;
        assert!(said.contains("line 4: frame 2 of marker `m1` stands after frame 0"), "{said}");
    }

    #[test]
    fn a_file_of_hdf5_is_refused_with_the_command_that_converts_it() {
        let refused = read(b"\x89HDF\r\n\x1a\n", &names(), 2, 9.0).unwrap_err();
        assert!(refused.action.contains("read_hdf") && refused.action.contains("to_csv"), "{refused}");
    }

    #[test]
    fn frames_in_another_order_are_refused_with_their_line() {
        let lines: Vec<&str> = TEXT.lines().collect();
        let shuffled = [lines[0], lines[3], lines[2], lines[1], lines[4]].join("\n");
        let said = read(shuffled.as_bytes(), &names(), 2, 9.0).unwrap_err().why;
        assert!(said.contains("line 4: frame 0 of marker `m1` stands after frame 1"), "{said}");
    }
}
