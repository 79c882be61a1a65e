//! Tracks of markers in a film's pixels from another program: a CSV of `study track` or of DeepLabCut.

use si::Point2;

use diagnostics::{Diagnostic, Result};

/// One marker of a file.
#[derive(Debug, Clone, PartialEq)]
pub struct PixelTrack {
    /// Its name there and on the card.
    pub name: String,
    /// Where it is, px: frames.
    pub at: Vec<Point2>,
    /// Covariance of each place, uu, uv and vv, px²: frames.
    pub covariance: Vec<[f64; 3]>,
}

/// Least likelihood of an imported position, no unit.
const LIKELIHOOD: f64 = 0.6;

/// The tracks of the markers `names` in a text, px, one position in each of `frames` frames; `sigma` (px) is their standard deviation
/// where the text has none.
///
/// # Errors
/// [`Diagnostic`] that names the marker and frame at which the text fails.
pub fn read(text: &str, names: &[String], frames: usize, sigma: f64) -> Result<Vec<PixelTrack>> {
    let first = text.lines().next().unwrap_or_default();
    let columns = match first.split(',').next().map(str::trim) {
        Some("scorer") => deeplabcut(text)?,
        Some("frame") => ours(text)?,
        _ => return Err(refused("its first line is neither `frame,…` nor DeepLabCut's `scorer,…`".into())),
    };
    let path = |name: &String| {
        let places: Vec<&Place> = columns.iter().filter(|(n, _)| n == name).map(|(_, place)| place).collect();
        if places.len() != frames {
            return Err(refused(format!("marker `{name}` has {} positions, the film {frames} frames", places.len())));
        }
        let unlikely = places.iter().position(|p| p.likelihood < LIKELIHOOD || !p.at.iter().all(|x| x.is_finite()));
        if let Some(frame) = unlikely {
            let likely = places[frame].likelihood;
            return Err(refused(format!(
                "the likelihood of marker `{name}` is {likely:.2} in frame {frame}; the limit is {LIKELIHOOD}"
            )));
        }
        let (at, covariance) =
            places.iter().map(|p| (p.at, p.spread.unwrap_or([sigma * sigma, 0.0, sigma * sigma]))).unzip();
        Ok(PixelTrack { name: name.clone(), at, covariance })
    };
    names.iter().map(path).collect()
}

/// A marker in a frame.
struct Place {
    at: Point2,
    spread: Option<[f64; 3]>,
    likelihood: f64,
}

/// `frame,time_s,marker,u_px,v_px,uu_px2,uv_px2,vv_px2,…`, frames rising.
fn ours(text: &str) -> Result<Vec<(String, Place)>> {
    let place = |(row, line): (usize, &str)| {
        let words: Vec<&str> = line.split(',').map(str::trim).collect();
        let number = |k: usize| words.get(k).and_then(|w| w.parse::<f64>().ok());
        let (Some(name), Some(u), Some(v)) = (words.get(2), number(3), number(4)) else {
            return Err(refused(format!("line {} has no marker with u and v", row + 2)));
        };
        // length: three numbers, not lists; a covariance is whole or absent
        let spread = number(5).zip(number(6)).zip(number(7)).map(|((a, b), c)| [a, b, c]);
        Ok(((*name).to_owned(), Place { at: [u, v], spread, likelihood: 1.0 }))
    };
    text.lines().skip(1).filter(|line| !line.trim().is_empty()).enumerate().map(place).collect()
}

/// Three lines of titles (scorer, bodyparts, coords), then x, y and likelihood of each body part a frame.
fn deeplabcut(text: &str) -> Result<Vec<(String, Place)>> {
    let mut lines = text.lines().skip(1);
    let titles = |line: Option<&str>| -> Vec<String> {
        line.unwrap_or_default().split(',').skip(1).map(|word| word.trim().to_owned()).collect()
    };
    let (parts, coords) = (titles(lines.next()), titles(lines.next()));
    let whole = parts.len() == coords.len() && coords.chunks(3).all(|three| three == ["x", "y", "likelihood"]);
    if !whole {
        return Err(refused("its third line does not repeat x, y, likelihood for each body part".into()));
    }
    let mut all = Vec::new();
    for (frame, line) in lines.filter(|line| !line.trim().is_empty()).enumerate() {
        let values: std::result::Result<Vec<f64>, _> =
            line.split(',').skip(1).map(|w| w.trim().parse::<f64>()).collect();
        let values = values.map_err(|e| refused(format!("frame {frame} has no numbers: {e}")))?;
        for (three, part) in values.chunks(3).zip(parts.chunks(3)) {
            let [u, v, likelihood] = three else {
                return Err(refused(format!("frame {frame} is short of numbers")));
            };
            all.push((part[0].clone(), Place { at: [*u, *v], spread: None, likelihood: *likelihood }));
        }
    }
    Ok(all)
}

fn refused(why: String) -> Diagnostic {
    Diagnostic::new(
        "imported tracks cannot be used",
        why,
        "export a position of every marker on the card in every frame, or let the film be tracked here",
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names() -> Vec<String> {
        ["m1", "m2"].map(str::to_owned).to_vec()
    }

    #[test]
    fn our_own_csv_keeps_its_covariances() {
        let text = "frame,time_s,marker,u_px,v_px,uu_px2,uv_px2,vv_px2,residual,seen\n0,0,m1,1.5,2.5,0.01,0.002,0.04,1,1\n0,0,m2,3,4,0.01,0,0.01,1,1\n1,0.02,m1,1.6,2.5,0.01,0,0.04,1,1\n1,0.02,m2,3.1,4,0.01,0,0.01,1,1\n";
        let paths = read(text, &names(), 2, 9.0).unwrap();
        assert_eq!(paths[0].at, [[1.5, 2.5], [1.6, 2.5]]);
        assert_eq!(paths[0].covariance[0], [0.01, 0.002, 0.04]);
        assert!(read(text, &names(), 3, 9.0).unwrap_err().why.contains("`m1` has 2 positions, the film 3 frames"));
    }

    #[test]
    fn deeplabcut_s_csv_is_read_by_body_part_and_a_low_likelihood_is_refused() {
        let text = "scorer,net,net,net,net,net,net\nbodyparts,m2,m2,m2,m1,m1,m1\ncoords,x,y,likelihood,x,y,likelihood\n0,3,4,0.99,1,2,0.98\n1,3.5,4,0.99,1.5,2,0.97\n";
        let paths = read(text, &names(), 2, 0.5).unwrap();
        assert_eq!((paths[0].at[1], paths[1].at[1]), ([1.5, 2.0], [3.5, 4.0]));
        assert_eq!(paths[0].covariance[0], [0.25, 0.0, 0.25]);
        let unlikely = text.replace("0.97", "0.30");
        assert!(
            read(&unlikely, &names(), 2, 0.5).unwrap_err().why.contains("likelihood of marker `m1` is 0.30 in frame 1")
        );
    }
}
