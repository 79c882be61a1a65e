//! SLEAP's CSV of an analysis: `track,frame_idx,instance.score,NODE.x,NODE.y,NODE.score,…`, one line an instance and frame. A frame without an
//! instance has no line, and a node that was not found empty fields.

use diagnostics::Result;

use super::{Place, import_error, place_at};

/// Columns of a line and the nodes of the titles.
struct Titles<'a> {
    frame: usize,
    /// Columns of x and y of each name.
    places: Vec<[usize; 2]>,
    words: Vec<&'a str>,
}

/// The places of the nodes that `names` are in each of `frames` frames, each with the number of its marker.
pub(super) fn read_places(text: &str, names: &[String], frames: usize) -> Result<Vec<(usize, Place)>> {
    let mut lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
    let titles = Titles::new(lines.next().map_or("", |(_, line)| line), names)?;
    let mut places: Vec<Option<Vec<Place>>> = (0..frames).map(|_| None).collect();
    for (row, line) in lines {
        let fields: Vec<&str> = line.split(',').map(str::trim).collect();
        let wrong = |reason: String| import_error(format!("line {}: {reason}", row + 1));
        let frame = fields.get(titles.frame).and_then(|word| word.parse::<usize>().ok());
        let frame = frame.ok_or_else(|| wrong("it has no number of a frame".into()))?;
        let Some(place) = places.get_mut(frame) else {
            return Err(wrong(format!("it is of frame {frame}, and the film has {frames}")));
        };
        if place.is_some() {
            return Err(wrong(format!("frame {frame} has two instances; export one track alone")));
        }
        *place = Some(titles.line_places(&fields).map_err(wrong)?);
    }
    let lost = || names.iter().map(|_| place_at([f64::NAN; 2])).collect();
    Ok(places.into_iter().flat_map(|place| place.unwrap_or_else(lost).into_iter().enumerate()).collect())
}

impl<'a> Titles<'a> {
    fn new(line: &'a str, names: &[String]) -> Result<Self> {
        let words: Vec<&str> = line.split(',').map(str::trim).collect();
        let column = |title: &str| words.iter().position(|word| *word == title);
        let frame = column("frame_idx").ok_or_else(|| import_error("its titles have no `frame_idx`".into()))?;
        let place = |name: &String| {
            // length: two numbers, not lists
            let columns = column(&format!("{name}.x")).zip(column(&format!("{name}.y")));
            columns.map(|(x, y)| [x, y]).ok_or_else(|| {
                let nodes: Vec<&str> = words.iter().filter_map(|word| word.strip_suffix(".x")).collect();
                import_error(format!("no node is marker `{name}`; the file has {}", nodes.join(", ")))
            })
        };
        let places = names.iter().map(place).collect::<Result<_>>()?;
        Ok(Self { frame, places, words })
    }

    /// The place of each name in a line.
    fn line_places(&self, fields: &[&str]) -> Result<Vec<Place>, String> {
        if fields.len() != self.words.len() {
            return Err(format!("it has {} fields, the titles {}", fields.len(), self.words.len()));
        }
        let number = |column: usize| match fields[column] {
            "" => Ok(f64::NAN),
            word => word.parse().map_err(|_| format!("`{word}` stands in place of a number")),
        };
        self.places.iter().map(|[x, y]| Ok(place_at([number(*x)?, number(*y)?]))).collect()
    }
}

#[cfg(test)]
mod tests {
    const TEXT: &str = "track,frame_idx,instance.score,tip.x,tip.y,tip.score,base.x,base.y,base.score\n\
        a,0,0.9,3,4,0.9,1,2,0.8\na,2,0.9,3.5,4,0.9,,,\n";

    fn tip_and_base(text: &str, frames: usize) -> diagnostics::Result<Vec<super::super::PixelTrack>> {
        super::super::read(text.as_bytes(), &["base", "tip"].map(str::to_owned), frames, 0.5)
    }

    #[test]
    fn nodes_are_read_by_their_names_and_lost_where_a_frame_or_a_number_is_missing() {
        let tracks = tip_and_base(TEXT, 3).unwrap();
        assert_eq!(tracks[0].at, [Some([1.0, 2.0]), None, None]);
        assert_eq!(tracks[1].at, [Some([3.0, 4.0]), None, Some([3.5, 4.0])]);
    }

    #[test]
    fn two_instances_frames_beyond_the_film_and_other_nodes_are_refused() {
        let refusal = |text: &str, frames| tip_and_base(text, frames).unwrap_err().why;
        assert!(refusal(&format!("{TEXT}b,2,0.9,9,9,0.9,8,8,0.9\n"), 3).contains("line 4: frame 2 has two instances"));
        assert!(refusal(TEXT, 2).contains("line 3: it is of frame 2, and the film has 2"));
        assert!(refusal(&TEXT.replace("base", "root"), 3).contains("no node is marker `base`; the file has tip, root"));
        assert!(refusal(&TEXT.replace(",,,\n", ",,\n"), 3).contains("line 3: it has 8 fields, the titles 9"));
    }
}
