//! Films as cameras write them, from the file to the marker's position: rotated, unevenly timed, as pictures, truncated.

#![allow(clippy::unwrap_used)] // a test may unwrap

use std::path::{Path, PathBuf};

use si::{Point2, Second};
use track::Gray;
use track::klt::{Settings, Tracker};
use track::video::{Film, Quality, VideoError, Writer};

const SIZE: (usize, usize) = (320, 192);
const FRAMES: usize = 24;

/// A place of its own for each test, gone when the test ends.
struct Scratch(PathBuf);

impl Scratch {
    fn new(name: &str) -> Self {
        let scratch = Self(std::env::temp_dir().join(format!("films-{}-{name}", std::process::id())));
        let _ = std::fs::remove_dir_all(&scratch.0);
        std::fs::create_dir_all(&scratch.0).unwrap();
        scratch
    }

    /// A coded film, its bytes changed by `change`.
    fn film(&self, change: impl Fn(Vec<u8>) -> Vec<u8>) -> PathBuf {
        let path = self.0.join("film.mp4");
        let mut writer = Writer::create(&path, SIZE, 60.0, Quality::Quantiser(18)).unwrap();
        (0..FRAMES).for_each(|k| writer.push(&picture(k)).unwrap());
        writer.finish().unwrap();
        let bytes = std::fs::read(&path).unwrap();
        std::fs::write(&path, change(bytes)).unwrap();
        path
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// Where the marker is in frame `k` as it is coded, px.
fn place(k: usize) -> Point2 {
    [50.3 + 2.7 * k as f64, 88.4 + 0.6 * k as f64]
}

/// A dark disc on light ground that slopes.
fn picture(k: usize) -> Gray {
    let [u, v] = place(k);
    Gray::from_fn(SIZE.0, SIZE.1, |x, y| {
        let dark = (10.5 - (x as f64 - u).hypot(y as f64 - v)).clamp(0.0, 1.0);
        (185.0 + 0.05 * x as f64) * (1.0 - 0.75 * dark)
    })
}

#[test]
fn pictures_are_found_by_their_numbers_in_any_order_unless_the_film_ends_before() {
    let scratch = Scratch::new("numbers");
    let film = scratch.film(|bytes| bytes);
    let found = Film::open(&film).unwrap().pictures(&[17, 3, 17], |_| ()).unwrap().unwrap();
    let all: Vec<Gray> = Film::open(&film).unwrap().map(|frame| frame.unwrap().gray).collect();
    assert!(found[0] == all[17] && found[1] == all[3] && found[2] == all[17] && all[3] != all[17]);
    assert_eq!(Film::open(&film).unwrap().pictures(&[3, FRAMES], |_| ()).unwrap(), None);
}

/// A film's size as it is shown, its times and the marker's places.
type Followed = ((usize, usize), Vec<Second>, Vec<Point2>);

/// Follows the marker from `start` through a film.
fn followed(path: &Path, start: Point2) -> Result<Followed, VideoError> {
    let film = Film::open(path)?;
    let size = (film.info().width, film.info().height);
    let (mut tracker, mut times, mut places) = (None::<Tracker>, Vec::new(), Vec::new());
    for frame in film {
        let frame = frame?;
        match &mut tracker {
            Some(tracker) => drop(tracker.step(&frame.gray).unwrap()),
            None => tracker = Some(Tracker::new(&frame.gray, &[start], Settings::default()).unwrap()),
        }
        places.extend(tracker.iter().map(|t| t.observations()[0].at));
        times.push(frame.time);
    }
    Ok((size, times, places))
}

/// The largest distance of positions from `truth` in each frame, px.
fn worst(places: &[Point2], truth: impl Fn(usize) -> Point2) -> f64 {
    assert_eq!(places.len(), FRAMES);
    let away = |(k, p): (usize, &Point2)| (p[0] - truth(k)[0]).hypot(p[1] - truth(k)[1]);
    places.iter().enumerate().map(away).fold(0.0, f64::max)
}

/// Where the content of the first box of a name begins.
fn content(film: &[u8], name: &[u8; 4]) -> usize {
    let index = film.windows(4).rposition(|w| w == b"moov").unwrap();
    index + film[index..].windows(4).position(|w| w == name).unwrap() + 4
}

/// The film of a camera that was held on its side: its track has a quarter turn clockwise.
fn on_its_side(mut film: Vec<u8>) -> Vec<u8> {
    let header = content(&film, b"tkhd");
    let matrix = header + if film[header] == 1 { 52 } else { 40 };
    let turn = [0, 1 << 16, 0, -(1 << 16), 0, 0, (SIZE.1 as i32) << 16, 0, 1 << 30];
    for (k, number) in turn.into_iter().enumerate() {
        film[matrix + 4 * k..][..4].copy_from_slice(&i32::to_be_bytes(number));
    }
    film
}

/// The film of a camera that slowed down: its frames from the tenth on last twice as long.
fn slowing(mut film: Vec<u8>) -> Vec<u8> {
    let table = content(&film, b"stts");
    let number = |at: usize| u32::from_be_bytes(film[at..at + 4].try_into().unwrap());
    assert_eq!((number(table + 4), number(table + 8)), (1, FRAMES as u32), "one run of all frames");
    let ticks = number(table + 12);
    let runs = [2, 10, ticks, FRAMES as u32 - 10, 2 * ticks];
    for name in [b"moov", b"trak", b"mdia", b"minf", b"stbl", b"stts"] {
        let size = content(&film, name) - 8;
        let grown = u32::from_be_bytes(film[size..size + 4].try_into().unwrap()) + 8;
        film[size..size + 4].copy_from_slice(&grown.to_be_bytes());
    }
    film.splice(table + 4..table + 16, runs.iter().flat_map(|n| n.to_be_bytes()));
    film
}

#[test]
fn a_marker_is_followed_through_a_film_on_its_side_as_it_is_shown() {
    let scratch = Scratch::new("side");
    let shown = |k: usize| [SIZE.1 as f64 - 1.0 - place(k)[1], place(k)[0]];
    let (size, _, places) = followed(&scratch.film(on_its_side), shown(0)).unwrap();
    assert_eq!(size, (SIZE.1, SIZE.0));
    // what the codec leaves of a still disc's edge
    assert!(worst(&places, shown) < 0.1, "{}", worst(&places, shown));
}

#[test]
fn frames_of_uneven_length_keep_their_own_times() {
    let scratch = Scratch::new("uneven");
    let (_, times, places) = followed(&scratch.film(slowing), place(0)).unwrap();
    for (k, time) in times.iter().enumerate() {
        let truth = (k.min(10) + 2 * k.saturating_sub(10)) as f64 / 60.0;
        assert!((time - truth).abs() < 1e-9, "frame {k}: {time} s");
    }
    assert!(worst(&places, place) < 0.1);
}

#[test]
fn a_marker_is_followed_through_a_folder_of_pictures_to_three_hundredths() {
    let scratch = Scratch::new("folder");
    for k in 0..FRAMES {
        std::fs::write(scratch.0.join(format!("{k:04}.png")), picture(k).to_png().unwrap()).unwrap();
    }
    let times: String = (0..FRAMES).map(|k| format!("{}\n", k as f64 / 60.0)).collect();
    std::fs::write(scratch.0.join("times.csv"), format!("time_s\n{times}")).unwrap();
    let (size, _, places) = followed(&scratch.0, place(0)).unwrap();
    assert_eq!(size, SIZE);
    assert!(worst(&places, place) < 0.03, "{}", worst(&places, place));
}

#[test]
fn a_film_cut_short_gives_no_track_at_all() {
    let scratch = Scratch::new("cut");
    let path = scratch.film(|film| film[..film.len() / 2].to_vec());
    let error = followed(&path, place(0)).unwrap_err();
    assert!(matches!(error, VideoError::NoIndex { .. }) && error.to_string().contains("do:"), "{error}");
}
