//! True tracks: where every marker truly was in every frame, in pixels and in metres.

use std::fmt::Write;
use std::path::Path;

use serde::Deserialize;
use si::{Point2, Point3, Second};

use diagnostics::{Diagnostic, input};

/// One marker through a trial, every list `frames` long.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TrueTrack {
    /// The marker's name.
    pub marker: String,
    /// Time of the frame on the video's clock, s.
    pub time: Vec<Second>,
    /// Centre in the picture, px, as it was drawn: each row at the time when a rolling shutter read it.
    pub pixel: Vec<Point2>,
    /// Centre in space, m, CAD frame, at the frame's own time, which is its middle row's.
    pub at: Vec<Point3>,
}

#[derive(Deserialize)]
struct Row {
    time_s: f64,
    marker: String,
    u_px: f64,
    v_px: f64,
    x_m: f64,
    y_m: f64,
    z_m: f64,
}

/// The text of a track file: one line a frame and marker.
pub fn write_tracks(tracks: &[TrueTrack], remark: &str) -> String {
    let mut text = format!("# {remark}\nframe,time_s,marker,u_px,v_px,x_m,y_m,z_m\n");
    let frames = tracks.first().map_or(0, |t| t.time.len());
    for frame in 0..frames {
        for track in tracks {
            let ([u, v], [x, y, z]) = (track.pixel[frame], track.at[frame]);
            let (time, marker) = (track.time[frame], &track.marker);
            writeln!(text, "{frame},{time:.6},{marker},{u:.4},{v:.4},{x:.8},{y:.8},{z:.8}")
                .expect("a string takes any text");
        }
    }
    text
}

/// The tracks in the file `path`, markers in the file's order.
///
/// # Errors
/// [`Diagnostic`] when the file cannot be read or a line is broken.
pub fn read_tracks(path: &Path) -> Result<Vec<TrueTrack>, Diagnostic> {
    let text = input::read_text(path, input::MESH).map_err(|e| Diagnostic::io(path, e, ACTION))?;
    parse_tracks(&text, path)
}

const ACTION: &str = "record the specimen on the virtual bench again";

/// The tracks in a text, markers in its order; `path` appears only in diagnostics.
///
/// # Errors
/// [`Diagnostic`] when a line is broken.
pub fn parse_tracks(text: &str, path: &Path) -> Result<Vec<TrueTrack>, Diagnostic> {
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(text.as_bytes());
    let mut tracks: Vec<TrueTrack> = Vec::new();
    for row in reader.deserialize::<Row>() {
        let row = row.map_err(|e| {
            let line = e.position().map(|p| p.line() as usize);
            Diagnostic::file(path, "the line is no true track", e.to_string().to_lowercase(), ACTION).at_line(line)
        })?;
        push_row(&mut tracks, row);
    }
    Ok(tracks)
}

fn push_row(tracks: &mut Vec<TrueTrack>, row: Row) {
    let position = tracks.iter().position(|t| t.marker == row.marker);
    let index = position.unwrap_or_else(|| {
        tracks.push(TrueTrack { marker: row.marker.clone(), ..TrueTrack::default() });
        tracks.len() - 1
    });
    let track = &mut tracks[index];
    track.time.push(row.time_s);
    track.pixel.push([row.u_px, row.v_px]);
    track.at.push([row.x_m, row.y_m, row.z_m]);
}
