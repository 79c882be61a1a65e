//! What a recording and a study of it wrote, held to `outputs.txt`: a label, a mark, a line or a pixel that changes is seen, and which file it is in.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use crate::digest::Digest;

/// Of a film so many frames, evenly spaced, each as the mean grey of so many rows and columns.
const FRAMES: usize = 3;
const CELLS: (usize, usize) = (6, 8);
/// What each record has of the run that made it; of the first, its summary is held.
const OF_THE_RUN: [&str; 2] = ["record.json", "durations.json"];
/// Begin and end of the page's section with the durations of stages.
const DURATIONS: [&str; 2] = ["<section id=\"stages\">", "</section>"];
/// What a line with encoded arrays has.
const ARRAYS: &str = "<script type=\"application/json\"";

/// The digest of each file below `root` that the same study writes again.
fn digests(root: &Path) -> BTreeMap<String, Digest> {
    let mut files = Vec::new();
    ["data/raw", "data/processed", "figures", "paper/tables"]
        .iter()
        .for_each(|folder| list(&root.join(folder), &mut files));
    let name = |file: &Path| file.strip_prefix(root).unwrap().to_str().unwrap().to_owned();
    files.iter().filter_map(|file| Some((name(file), digest(file)?))).collect()
}

/// What differs from `outputs.txt`, a file each, and where the file that would have it stands.
pub fn changed(root: &Path) -> String {
    let (found, expected) = (digests(root), expected());
    let mut lines: Vec<String> = found
        .iter()
        .filter_map(|(file, digest)| Some(format!("{file} {}", difference(digest, expected.get(file))?)))
        .collect();
    lines
        .extend(expected.keys().filter(|file| !found.contains_key(*file)).map(|file| format!("{file} is not written")));
    if !lines.is_empty() {
        let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join("outputs.txt");
        fs::write(&file, found.iter().map(|(name, digest)| format!("{name} {}\n", digest.line())).collect::<String>())
            .unwrap();
        lines.push(format!("if this is meant, the new file is {}", file.display()));
    }
    lines.join("\n")
}

fn difference(found: &Digest, expected: Option<&Digest>) -> Option<String> {
    expected.map_or_else(|| Some("is new".to_owned()), |expected| found.difference(expected))
}

fn expected() -> BTreeMap<String, Digest> {
    let lines = include_str!("outputs.txt").lines().map(|line| line.split_once(' ').unwrap());
    lines.map(|(file, digest)| (file.to_owned(), Digest::parse(digest).unwrap())).collect()
}

/// Every file of a folder and its folders.
fn list(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() { list(&path, files) } else { files.push(path) }
    }
}

/// Of texts and films; none of records' own pages, and of what is shown elsewhere.
fn digest(file: &Path) -> Option<Digest> {
    let within = |folder: &str| file.components().any(|part| part.as_os_str() == folder);
    let name = file.file_name()?.to_str()?;
    let each = match file.extension()?.to_str()? {
        "mp4" => return Some(of_film(file)),
        "csv" if within("raw") => 256,
        "csv" | "tex" if within("tables") => 1,
        "toml" | "html" => 1,
        "json" if name == OF_THE_RUN[0] => 1,
        "json" if within("record") && !OF_THE_RUN.contains(&name) => 16,
        "svg" if within("figures") => 64,
        _ => return None,
    };
    let text = fs::read_to_string(file).unwrap();
    let held = |line: &str| name != OF_THE_RUN[0] || line.contains("\"summary\":");
    let lines = || text.lines().filter(|line| held(line) && !crate::is_of_time(line)).collect::<Vec<_>>().join("\n");
    Some(match name {
        "index.html" => Digest::of_text(&lasting(&text), None),
        // the durations of searches stand among other numbers
        name if name.starts_with("methods.") => Digest::of_text(&text, None),
        _ => Digest::of_text(&lines(), Some(each)),
    })
}

/// The page without what another run writes otherwise: durations, which break into lines by their lengths, and the bits of arrays.
fn lasting(page: &str) -> String {
    let (before, rest) = page.split_once(DURATIONS[0]).unwrap();
    let (_, after) = rest.split_once(DURATIONS[1]).unwrap();
    let lines = before.lines().chain(after.lines()).filter(|line| !line.contains(ARRAYS) && !crate::is_of_time(line));
    lines.collect::<Vec<_>>().join("\n")
}

/// A film as the mean grey of the cells of some of its frames.
fn of_film(path: &Path) -> Digest {
    let film = track::video::Film::open(path).unwrap();
    let count = film.info().frames;
    let chosen: Vec<usize> = (0..FRAMES).map(|i| i * (count - 1) / (FRAMES - 1)).collect();
    let frames = film.map(|frame| frame.unwrap()).filter(|frame| chosen.contains(&frame.index));
    let numbers: Vec<f64> = frames.flat_map(|frame| cells(&frame.gray)).collect();
    Digest::new(&count.to_string(), &numbers, 1)
}

/// The mean grey of each cell of a picture.
fn cells(picture: &track::Gray) -> Vec<f64> {
    let (width, height) = (picture.width, picture.height);
    let (mut sums, mut counts) = (vec![0.0; CELLS.0 * CELLS.1], vec![0.0; CELLS.0 * CELLS.1]);
    for y in 0..height {
        for x in 0..width {
            let cell = y * CELLS.0 / height * CELLS.1 + x * CELLS.1 / width;
            sums[cell] += picture.pixel_level(x, y);
            counts[cell] += 1.0;
        }
    }
    sums.iter().zip(counts).map(|(sum, n): (&f64, f64)| sum / n).collect()
}
