//! Which log belongs to which film: by the time that the lamp is on in both, and where that leaves a choice, by their names.

use std::collections::BTreeSet;

/// A recording with the duration of its lamp, in the units of its own clock.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Timed {
    pub(super) name: String,
    /// Of a film at the rate of its container, of a log by its stamps; s.
    pub(super) lit: f64,
    /// To how much it is known, s.
    pub(super) resolution: f64,
}

/// A film and a log that belong together.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Pair {
    pub(super) film: usize,
    pub(super) log: usize,
    /// Whether no other film and no other log would do.
    pub(super) is_only: bool,
    /// Whether names told it from others of the same duration.
    pub(super) is_named: bool,
}

/// Share by which two clocks may differ.
const DRIFT: f64 = 0.004;

/// The pairs, and the seconds of the logs in a second of the films: 1 where the films' rate is the true one.
pub(super) fn pairs(films: &[Timed], logs: &[Timed]) -> (Vec<Pair>, f64) {
    let ratios = films.iter().flat_map(|film| logs.iter().map(|log| log.lit / film.lit));
    let fits_at = |ratio: f64| films.iter().filter(|film| logs.iter().any(|log| is_same(film, log, ratio))).count();
    // the containers' own rate unless another explains more of the films
    let best = ratios.fold((1.0, fits_at(1.0)), |best, ratio| {
        let count = fits_at(ratio);
        if count > best.1 { (ratio, count) } else { best }
    });
    let ratio = mean_ratio(films, logs, best.0);
    (assign_groups(films, logs, ratio), ratio)
}

fn is_same(film: &Timed, log: &Timed, ratio: f64) -> bool {
    (film.lit * ratio - log.lit).abs() <= 2.0 * (film.resolution * ratio + log.resolution) + DRIFT * log.lit
}

/// The mean over the films that one log alone fits; as it is given where there is none, or where it is as good as 1.
fn mean_ratio(films: &[Timed], logs: &[Timed], ratio: f64) -> f64 {
    if (ratio - 1.0).abs() < 1e-9 {
        return ratio;
    }
    let ratios = films.iter().filter_map(|film| {
        let fits: Vec<&Timed> = logs.iter().filter(|log| is_same(film, log, ratio)).collect();
        (fits.len() == 1).then(|| fits[0].lit / film.lit)
    });
    let ratios: Vec<f64> = ratios.collect();
    if ratios.is_empty() { ratio } else { ratios.iter().sum::<f64>() / ratios.len() as f64 }
}

/// Pairs within each group of films and logs whose lamps are on as long: the only ones, by names where these tell all of a group apart,
/// else in the order of the names.
fn assign_groups(films: &[Timed], logs: &[Timed], ratio: f64) -> Vec<Pair> {
    let mut pairs = Vec::new();
    for group in lamp_groups(films, logs, ratio) {
        let named = |all: &[Timed], members: &[usize]| telling_tokens(members.iter().map(|k| &all[*k].name[..]));
        let (of_films, of_logs) = (named(films, &group.films), named(logs, &group.logs));
        let by_name = by_name(&of_films, &of_logs);
        let is_only = group.films.len() == 1 && group.logs.len() == 1;
        let places = by_name.clone().unwrap_or_else(|| (0..group.films.len().min(group.logs.len())).collect());
        // length: films beyond the logs of their group have none
        let members = group.films.iter().zip(places);
        let pair = |(film, place): (&usize, usize)| Pair {
            film: *film,
            log: group.logs[place],
            is_only,
            is_named: by_name.is_some(),
        };
        pairs.extend(members.map(pair));
    }
    pairs.sort_by_key(|pair| pair.film);
    pairs
}

/// Films and logs whose lamps are on as long, in the natural order of their names.
struct Group {
    films: Vec<usize>,
    logs: Vec<usize>,
}

fn lamp_groups(films: &[Timed], logs: &[Timed], ratio: f64) -> Vec<Group> {
    let mut groups: Vec<Group> = Vec::new();
    for (f, film) in films.iter().enumerate() {
        let fits: Vec<usize> = (0..logs.len()).filter(|l| is_same(film, &logs[*l], ratio)).collect();
        let (joined, mut others): (Vec<Group>, Vec<Group>) =
            groups.into_iter().partition(|group| group.logs.iter().any(|log| fits.contains(log)));
        let mut group = Group { films: vec![f], logs: fits };
        joined.into_iter().for_each(|other| {
            group.films.extend(other.films);
            group.logs.extend(other.logs);
        });
        let in_order = |members: &mut Vec<usize>, all: &[Timed]| {
            members.sort_by_key(|k| natural_key(&all[*k].name));
            members.dedup();
        };
        in_order(&mut group.films, films);
        in_order(&mut group.logs, logs);
        others.extend((!group.logs.is_empty()).then_some(group));
        groups = others;
    }
    groups
}

/// Words and numbers of a name, numbers by their value.
fn natural_key(name: &str) -> Vec<(u64, String)> {
    let mut key: Vec<(u64, String)> = Vec::new();
    for part in parts(name) {
        key.push(part.parse().map_or((u64::MAX, part), |number| (number, String::new())));
    }
    key
}

/// Of each name the words and numbers that not all of the names have.
fn telling_tokens<'a>(names: impl Iterator<Item = &'a str>) -> Vec<BTreeSet<String>> {
    let token_sets: Vec<BTreeSet<String>> = names.map(tokens).collect();
    let common = token_sets
        .iter()
        .skip(1)
        .fold(token_sets.first().cloned().unwrap_or_default(), |common, token_set| &common & token_set);
    token_sets.iter().map(|token_set| token_set - &common).collect()
}

/// The log of each film by what their names share; none where that does not tell all of them apart.
fn by_name(films: &[BTreeSet<String>], logs: &[BTreeSet<String>]) -> Option<Vec<usize>> {
    let best = |film: &BTreeSet<String>| {
        // what they share against what one of them alone has; sharing nothing is no likeness
        let likeness = |log: &BTreeSet<String>| {
            let (shared, alone) = (film.intersection(log).count(), film.symmetric_difference(log).count());
            if shared > 0 { 2 * shared as i64 - alone as i64 } else { i64::MIN }
        };
        let alike: Vec<i64> = logs.iter().map(likeness).collect();
        let best_likeness = alike.iter().copied().max().filter(|best_likeness| *best_likeness > i64::MIN)?;
        let places: Vec<usize> = (0..logs.len()).filter(|place| alike[*place] == best_likeness).collect();
        (places.len() == 1).then(|| places[0])
    };
    let places: Vec<usize> = films.iter().map(best).collect::<Option<_>>()?;
    let distinct: BTreeSet<usize> = places.iter().copied().collect();
    (distinct.len() == places.len()).then_some(places)
}

/// The words and numbers of a path without its ending; 01 and 1 are one number.
fn tokens(name: &str) -> BTreeSet<String> {
    let number = |part: String| part.parse::<u64>().map(|number| number.to_string()).unwrap_or(part);
    parts(name).into_iter().map(number).collect()
}

/// Runs of letters and of digits in a path without its ending, in lower case.
fn parts(name: &str) -> Vec<String> {
    let stem = name.rsplit_once('.').map_or(name, |(stem, _)| stem).to_lowercase();
    let kind = |c: char| if c.is_ascii_digit() { 1 } else { 2 * u8::from(c.is_alphanumeric()) };
    let mut parts = Vec::new();
    let mut word = String::new();
    for c in stem.chars().chain([' ']) {
        if word.chars().last().is_some_and(|last| kind(last) != kind(c)) {
            parts.push(std::mem::take(&mut word));
        }
        if kind(c) > 0 {
            word.push(c);
        }
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    fn timed(name: &str, lit: f64) -> Timed {
        Timed { name: name.to_owned(), lit, resolution: 0.01 }
    }

    #[test]
    fn durations_tell_pairs_and_the_true_rate() {
        let films = [timed("c.mp4", 2.0), timed("a.mp4", 4.0), timed("b.mp4", 7.0)];
        for ratio in [1.0, 0.125] {
            let logs = [4.001, 7.003, 2.0].map(|lit| timed("log.csv", lit * ratio));
            let logs = logs.map(|log| Timed { resolution: 0.001, ..log });
            let (pairs, seen) = pairs(&films, &logs);
            assert_eq!(pairs.iter().map(|pair| (pair.film, pair.log)).collect::<Vec<_>>(), [(0, 2), (1, 0), (2, 1)]);
            assert!(pairs.iter().all(|pair| pair.is_only) && (seen / ratio - 1.0).abs() < 1e-3, "{seen}");
        }
    }

    #[test]
    fn among_equal_durations_names_decide_where_they_can() {
        let films = [timed("films/run_01.mp4", 3.0), timed("films/run_02.mp4", 3.0)];
        let named = pairs(&films, &[timed("daq/Run-2.csv", 3.0), timed("daq/Run-1.csv", 3.0)]).0;
        assert_eq!(named.iter().map(|pair| (pair.film, pair.log)).collect::<Vec<_>>(), [(0, 1), (1, 0)]);
        assert!(named.iter().all(|pair| pair.is_named && !pair.is_only));
        let unnamed = pairs(&films, &[timed("daq/x.csv", 3.0), timed("daq/y.csv", 3.0)]).0;
        assert!(unnamed.iter().all(|pair| !pair.is_named && !pair.is_only));
        let repeats = ["air_01", "air_02", "water_01", "water_02"];
        let films = repeats.map(|name| timed(&format!("200mbar_2hz_{name}/video.mp4"), 3.0));
        let logs = [3, 1, 0, 2].map(|k| timed(&format!("200mbar_2hz_{}/log.csv", repeats[k]), 3.0));
        let repeated = pairs(&films, &logs).0;
        assert_eq!(repeated.iter().map(|pair| pair.log).collect::<Vec<_>>(), [2, 1, 3, 0]);
        assert!(repeated.iter().all(|pair| pair.is_named));
        let films = [timed("films/run_01.mp4", 3.0), timed("films/run_02.mp4", 3.0)];
        // counters of two instruments that began at different numbers: their order, not a number that they share by chance
        let counters = pairs(&films, &[timed("daq/log_2.csv", 3.0), timed("daq/log_10.csv", 3.0)]).0;
        assert_eq!(counters.iter().map(|pair| (pair.film, pair.log)).collect::<Vec<_>>(), [(0, 0), (1, 1)]);
        assert!(counters.iter().all(|pair| !pair.is_named));
        assert!(pairs(&films, &[timed("daq/x.csv", 9.0), timed("daq/y.csv", 5.0)]).0.len() < 2);
    }
}
