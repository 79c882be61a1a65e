//! `study force` on logs whose mean force, cross-talk, lag, waves and drift are known: even, jittered, and written as instruments write them.
#![allow(clippy::unwrap_used)]

use std::f64::consts::TAU;
use std::fs;
use std::path::{Path, PathBuf};

use instruments::force;

/// Mean thrust, N.
const THRUST: f64 = 0.05;
/// Lag of the force behind the pressure, s.
const LAG: f64 = 0.28;

/// Mean cross-talk of a cycle, N: the integral of the curve over the filling of one chamber and the emptying of the other.
const TALK: f64 = 0.04981;

const PAGE: &str = "name = \"cell\"
[tank]
length = 0.45
depth = 0.15
[[recording]]
id = \"taps\"
kind = \"taps\"
force = \"taps.csv\"
hammer = \"hammer.csv\"
[[recording]]
id = \"still\"
kind = \"still_water\"
force = \"still.csv\"
[[recording]]
id = \"static\"
kind = \"staircase\"
force = \"static_force.csv\"
pressure = \"static_pressure.csv\"
levels = [10000.0, 20000.0]
[[recording]]
id = \"2hz\"
kind = \"flapping\"
force = \"flap_force.csv\"
pressure = \"flap_pressure.csv\"
frequency = 2.0
";

/// A folder with a page and its logs.
struct Bench(PathBuf);

impl Bench {
    /// Logs whose stamps are late by up to `jitter` (s), as their samples are.
    fn new(name: &str, jitter: f64) -> Self {
        let bench = Self(std::env::temp_dir().join(format!("force-{name}-{}", std::process::id())));
        fs::create_dir_all(&bench.0).unwrap();
        bench.write("page.toml", PAGE);
        let since = |t: f64| (1..=5).map(move |k| t - 2.0 * f64::from(k));
        let hammer = |t: f64| since(t).filter(|s| (0.0..6e-3).contains(s)).map(|s| 4.0 * (523.6 * s).sin()).sum();
        let ring = |t: f64| since(t).filter(|s| *s > 0.0).map(|s| 1.3 * (-2.6 * s).exp() * (88.0 * s).sin()).sum();
        bench.log("hammer.csv", [1000.0, 12.0, 0.0], &hammer);
        bench.log("taps.csv", [80.0, 12.0, 0.0], &ring);
        bench.log("still.csv", [80.0, 10.0, jitter], &|t| wave(t) + 0.01 + 3e-3 * t);
        let held = |t: f64| if t < LAG { 0.0 } else { crosstalk(steps(t - LAG)) };
        bench.log("static_force.csv", [80.0, 20.0, jitter], &|t| held(t) + 0.02 - 1e-3 * t);
        bench.pressures("static_pressure.csv", [20.0, jitter], &|t| [steps(t), 0.0]);
        bench.log("flap_force.csv", [80.0, 14.0, jitter], &flapping);
        bench.pressures("flap_pressure.csv", [14.0, jitter], &flapped);
        bench
    }

    fn write(&self, name: &str, text: &str) {
        fs::write(self.0.join(name), text).unwrap();
    }

    /// A log at a rate (Hz) for a time (s) with a jitter (s), with noise of 1 mN.
    fn log(&self, name: &str, [rate, length, jitter]: [f64; 3], force: &dyn Fn(f64) -> f64) {
        let line = |(i, t): (usize, &f64)| format!("{t:.6},{:.6}\n", force(*t) + 1e-3 * noise(i));
        self.write(
            name,
            &("time_s,force_n\n".to_owned()
                + &times(rate, length, jitter).iter().enumerate().map(line).collect::<String>()),
        );
    }

    /// Two channels at 200 Hz in Pa.
    fn pressures(&self, name: &str, [length, jitter]: [f64; 2], of: &dyn Fn(f64) -> [f64; 2]) {
        let line = |t: &f64| {
            let [left, right] = of(*t).map(|p| p / 100.0);
            format!("{t:.6},{left:.3},{right:.3}\n")
        };
        let text = times(200.0, length, jitter).iter().map(line).collect::<String>();
        self.write(name, &("time_s,left_mbar,right_mbar\n".to_owned() + &text));
    }

    fn record(&self) -> serde_json::Value {
        force::run(&self.0.join("page.toml"), None).unwrap();
        serde_json::from_str(&fs::read_to_string(self.0.join("page.out/force.json")).unwrap()).unwrap()
    }

    /// The numbers of the run in the table.
    fn row(&self) -> Vec<f64> {
        self.record();
        let table = fs::read_to_string(self.0.join("page.out/force.csv")).unwrap();
        table.lines().nth(1).unwrap().split(',').skip(1).map(|word| word.parse().unwrap()).collect()
    }

    fn refusal(&self) -> String {
        force::run(&self.0.join("page.toml"), None).map(|_| ()).unwrap_err().to_string()
    }
}

impl Drop for Bench {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// Stamps at a rate (Hz), each late by up to a jitter (s).
fn times(rate: f64, length: f64, jitter: f64) -> Vec<f64> {
    let mut last = -1.0;
    let late = |i: usize| 0.5 * jitter * (1.0 + (i as f64 * 2.399_963).sin());
    let mut next = |i: usize| {
        last = f64::max(last + 1e-4, i as f64 / rate + late(i));
        last
    };
    (0..(length * rate) as usize).map(&mut next).collect()
}

/// Uneven numbers of unit size, always the same (splitmix64).
fn noise(i: usize) -> f64 {
    let mut z = (i as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    12.0_f64.sqrt() * (((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64 - 0.5)
}

fn wave(t: f64) -> f64 {
    3e-3 * (-0.0875 * t).exp() * (TAU * 1.16 * t).cos()
}

/// 100 and 200 mbar, 5 s each with 3 s between.
fn steps(t: f64) -> f64 {
    match t {
        t if (1.0..6.0).contains(&t) => 1e4,
        t if (9.0..14.0).contains(&t) => 2e4,
        _ => 0.0,
    }
}

/// Linear between 0, 14 and 56 mN at 0, 100 and 200 mbar.
fn crosstalk(pressure: f64) -> f64 {
    if pressure < 1e4 { 1.4e-6 * pressure } else { 0.014 + 4.2e-6 * (pressure - 1e4) }
}

/// Left and right in turn at 2 Hz from 2 to 11 s; a chamber fills and empties with a time constant of 40 ms.
fn flapped(t: f64) -> [f64; 2] {
    let half = ((t - 2.0) * 4.0).floor();
    let since = t - 2.0 - 0.25 * half;
    let (full, empty) = (1.0 - (-since / 0.04).exp(), (-since / 0.04).exp());
    let (last, even) = (half >= 36.0, half.rem_euclid(2.0) == 0.0);
    match (t < 2.0, last, even) {
        (true, ..) => [0.0; 2],
        (_, true, _) if half > 36.0 => [0.0; 2],
        (_, true, _) => [0.0, 2e4 * empty],
        (_, _, true) if half == 0.0 => [2e4 * full, 0.0],
        (_, _, true) => [2e4 * full, 2e4 * empty],
        (_, _, false) => [2e4 * empty, 2e4 * full],
    }
}

fn flapping(t: f64) -> f64 {
    let thrust = if (2.0..11.0).contains(&t) { THRUST + 0.1 * (TAU * 2.0 * (t - 2.0)).sin() } else { 0.0 };
    let talk: f64 = flapped(t - LAG).iter().map(|p| crosstalk(*p)).sum();
    thrust + talk + wave(t) + 0.015 + 2e-3 * t
}

#[test]
fn fixture_waves_lag_and_mean_force_are_those_that_were_put_in() {
    let bench = Bench::new("even", 0.0);
    let record = bench.record();
    let number = |path: &str| record.pointer(path).and_then(serde_json::Value::as_f64).unwrap();
    assert!((number("/fixture/natural_frequency_hz/0") - 14.0).abs() < 0.1);
    assert!((number("/still_water/waves/0/frequency_hz/0") - 1.16).abs() < 0.01);
    assert_eq!(record["still_water"]["waves"].as_array().unwrap().len(), 1);
    assert!(number("/still_water/evidence/0/p_value") < 1e-3);
    let [low, high] = [0, 1].map(|k| number(&format!("/crosstalk/lag_interval_s/{k}")));
    assert!(low <= LAG && LAG <= high && high - low < 0.05, "{low} {high}");
    assert!((number("/crosstalk/forces_n/2") - 0.056).abs() < 1e-3);
    assert_eq!(record["sampling"]["2hz"]["method"], "as_stamped");
    let row = bench.row();
    let [raw, talk, mean, low, high, drift] = [4, 5, 6, 7, 8, 9].map(|k| row[k]);
    // the width of the interval is four standard deviations
    assert!((mean - THRUST).abs() < 1.5e-3 && (mean - THRUST).abs() < high - low, "{row:?}");
    assert!((raw - mean - talk).abs() < 1e-5 && (talk - TALK).abs() < 1e-3, "{row:?}");
    // from the middle of the first rest to that of the last
    assert!((drift - 2e-3 * 12.0).abs() < 2e-3, "{drift}");
    // the mean of 50 mN with the raw one of 100 mN, and a force of −100 to 200 mN over 14 s
    let figure = fs::read_to_string(bench.0.join("page.out/force.svg")).unwrap();
    assert!(figure.starts_with("<svg") && ticks(&figure).iter().all(|tick| tick.abs() < 300.0), "{:?}", ticks(&figure));
    // from the first pressure on, without the first cycle; the last chamber empties for 0.1 s
    assert!((row[1] - 2.5).abs() < 6e-3 && (row[2] - 11.0).abs() < 6e-3 && row[3] == 17.0, "{row:?}");
    let text = force::run(&bench.0.join("page.toml"), None).unwrap().0.to_string();
    for words in ["fixture: 14.", "standing waves: 1 over the noise of ", "cross-talk: up to 56.", "2 Hz, 17 cycles: "]
    {
        assert!(text.contains(words), "{words} is not in\n{text}");
    }
    assert!(text.contains(&format!("{:.2} mN (95 % ", 1e3 * mean)) && text.lines().count() == 4, "{text}");
}

/// The numbers at the axes of a figure.
fn ticks(figure: &str) -> Vec<f64> {
    let words = figure.split("</text>").filter_map(|text| text.rsplit('>').next());
    words.filter_map(|word| word.trim().replace('−', "-").parse().ok()).collect()
}

#[test]
fn more_harmonics_than_the_sampling_rate_resolves_leave_the_mean_as_it_is() {
    let bench = Bench::new("harmonics", 0.0);
    bench.write("page.toml", &PAGE.replace("[tank]", "[settings]\nharmonics = 39\n[tank]"));
    let mean = bench.row()[6];
    assert!((mean - THRUST).abs() < 1.5e-3, "{mean}");
}

/// Lit twice, 10 s apart on the clock of the force.
fn lit(t: f64) -> u8 {
    u8::from((1.0..1.5).contains(&t) || (11.5..12.0).contains(&t))
}

#[test]
fn the_lamp_in_both_logs_brings_them_onto_one_clock() {
    let bench = Bench::new("lamp", 0.0);
    let force = |(i, t): (usize, &f64)| format!("{t:.6},{:.6},{}\n", flapping(*t) + 1e-3 * noise(i), lit(*t));
    let force: String = times(80.0, 14.0, 0.0).iter().enumerate().map(force).collect();
    bench.write("flap_force.csv", &format!("time_s,force_n,led\n{force}"));
    // the clock of the pressure is 3 s ahead
    let pressure = |t: &f64| {
        let [left, right] = flapped(*t).map(|p| p / 100.0);
        format!("{:.6},{left:.3},{right:.3},{}\n", t + 3.0, lit(*t))
    };
    let pressure: String = times(200.0, 14.0, 0.0).iter().map(pressure).collect();
    bench.write("flap_pressure.csv", &format!("time_s,left_mbar,right_mbar,led\n{pressure}"));
    let row = bench.row();
    assert!((row[1] - 2.5).abs() < 0.02 && (row[6] - THRUST).abs() < 2e-3, "{row:?}");
}

#[test]
fn jitter_of_eight_milliseconds_changes_the_mean_force_by_less_than_a_hundredth() {
    let (even, jittered) = (Bench::new("plain", 0.0), Bench::new("late", 8e-3));
    let (a, b) = (even.row()[6], jittered.row()[6]);
    assert!((b / a - 1.0).abs() < 0.01, "{a} {b}");
    assert_eq!(jittered.record()["sampling"]["2hz"]["method"], "linear_interpolation");
}

#[test]
fn a_lag_on_the_page_is_taken_out_of_the_force() {
    let bench = Bench::new("lag", 0.0);
    bench.write("page.toml", &PAGE.replace("[tank]", "[log]\nforce_lag = 0.28\nforce_lag_sigma = 0.01\n[tank]"));
    let record = bench.record();
    assert_eq!(record["cell_lag"]["lag_s"], 0.28);
    assert!(record["crosstalk"]["lag_s"].as_f64().unwrap() < 0.021);
}

#[test]
fn a_run_without_pressure_is_evaluated_over_its_seconds() {
    let bench = Bench::new("seconds", 0.0);
    let page = PAGE.split("[[recording]]\nid = \"static\"").next().unwrap().to_owned();
    let run = "[[recording]]\nid = \"2hz\"\nkind = \"flapping\"\nforce = \"flap_force.csv\"\nfrequency = 2.0\nseconds = [2.0, 11.0]\n";
    bench.write("page.toml", &(page + run));
    let table = {
        force::run(&bench.0.join("page.toml"), None).unwrap();
        fs::read_to_string(bench.0.join("page.out/force.csv")).unwrap()
    };
    let mean: f64 = table.lines().nth(1).unwrap().split(',').nth(7).unwrap().parse().unwrap();
    // without a staircase the cross-talk stays in
    assert!((mean - THRUST - TALK).abs() < 3e-3, "{table}");
}

#[test]
fn a_page_that_lacks_something_is_refused_with_the_recording_and_the_line() {
    let bench = Bench::new("lacks", 0.0);
    for (from, to, piece) in [
        ("hammer = \"hammer.csv\"\n", "", "recording `taps` has no `hammer`"),
        ("[tank]\nlength = 0.45\ndepth = 0.15\n", "", "recording `still` has no [tank]"),
        ("frequency = 2.0\n", "", "recording `2hz` has no `frequency`"),
        ("pressure = \"flap_pressure.csv\"\n", "", "recording `2hz` has no `pressure` or `seconds`"),
        ("levels = [10000.0, 20000.0]\n", "levels = [100.0e5]\n", "out of range"),
        ("kind = \"taps\"", "kind = \"hits\"", "unknown variant `hits`"),
    ] {
        assert!(PAGE.contains(from));
        bench.write("page.toml", &PAGE.replacen(from, to, 1));
        let said = bench.refusal();
        assert!(said.contains(piece) && said.contains("page.toml, line"), "{said}");
    }
}

/// Every number that a page may have.
const NUMBERS: &str = "[settings]
band = [3.0, 30.0]
modes = 2
level = 0.005
still_limit = 0.02
harmonics = 12
settling_cycles = 1.0
settling_time = 1.0
longest_lag = 0.6
[log]
force_lag = 0.2
force_lag_sigma = 0.01
[tank]";

/// A page with every number.
fn numbered() -> String {
    PAGE.replace("[tank]", NUMBERS).replace("frequency = 2.0", "frequency = 2.0\nseconds = [2.0, 11.0]")
}

#[test]
fn every_number_of_a_page_is_refused_out_of_its_range_with_file_and_key() {
    let (page, path) = (numbered(), Path::new("cell.toml"));
    force::check_page(&page, path).unwrap();
    // zero of what may be left out
    let zero = ["harmonics", "settling_cycles", "settling_time", "levels", "seconds", "force_lag", "force_lag_sigma"];
    for number in diagnostics::table::numbers(&page) {
        let key = number.key.trim_end_matches(|c: char| c == '.' || c.is_ascii_digit());
        for value in ["nan", "inf", "-inf", "-1", "0", "1e308", "1e18", "18446744073709551615"] {
            let slip = format!("{}{value}{}", &page[..number.span.start], &page[number.span.end..]);
            let refused = force::check_page(&slip, path).err().map(|refused| refused.to_string());
            let may_be = (value == "0" && zero.iter().any(|word| key.ends_with(word)))
                || (value == "-1" && ["seconds", "force_lag"].iter().any(|word| key.ends_with(word)));
            match refused {
                Some(text) => {
                    assert!(text.starts_with("cell.toml, line") && text.contains(key), "{key} = {value}: {text}")
                }
                None => assert!(may_be, "{key} = {value} is accepted"),
            }
        }
    }
}

#[test]
fn an_id_and_a_level_stand_once_and_lists_rise() {
    for (from, to, words) in [
        ("id = \"still\"", "id = \"taps\"", "two recordings have the id `taps`"),
        ("id = \"still\"", "id = \" \"", "empty `id`"),
        ("levels = [10000.0, 20000.0]", "levels = [10000.0, 1e4]", "the level 10000 Pa twice"),
        ("band = [3.0, 30.0]", "band = [30.0, 3.0]", "does not rise"),
        ("seconds = [2.0, 11.0]", "seconds = [11.0, 2.0]", "does not rise"),
    ] {
        let page = numbered();
        assert!(page.contains(from), "{from}");
        let refused = force::check_page(&page.replacen(from, to, 1), Path::new("cell.toml")).unwrap_err().to_string();
        assert!(refused.starts_with("cell.toml, line") && refused.contains(words), "{refused}");
    }
}

#[test]
fn seconds_outside_the_recording_are_refused_with_those_of_its_log() {
    let bench = Bench::new("outside", 0.0);
    bench.write("page.toml", &PAGE.replace("pressure = \"flap_pressure.csv\"", "seconds = [50.0, 60.0]"));
    let refused = bench.refusal();
    assert!(refused.contains("page.toml: recording `2hz`") && refused.contains("from 0.000 to 13.98"), "{refused}");
    // a log that was cut would give the mean of fewer cycles than the page names
    bench.write("page.toml", &PAGE.replace("pressure = \"flap_pressure.csv\"", "seconds = [2.0, 15.0]"));
    assert!(bench.refusal().contains("has no force for a part of its run"));
}

#[test]
fn a_run_that_is_named_as_still_water_is_refused() {
    let bench = Bench::new("moving", 0.0);
    bench.write("page.toml", &PAGE.replace("still.csv", "flap_force.csv"));
    let said = bench.refusal();
    assert!(said.contains("flap_force.csv") && said.contains("in still water it is under"), "{said}");
}

#[test]
fn a_frequency_that_the_pressures_contradict_is_refused_with_both() {
    let bench = Bench::new("frequency", 0.0);
    for declared in ["20.0", "1.0", "2.2", "4.0"] {
        bench.write("page.toml", &PAGE.replace("frequency = 2.0", &format!("frequency = {declared}")));
        let said = bench.refusal();
        assert!(said.contains(&format!("frequency = {} Hz", declared.trim_end_matches(".0"))), "{said}");
        assert!(said.contains("its pressures repeat at 2.0") || said.contains("repeat at 1.99"), "{said}");
    }
    bench.write("page.toml", &PAGE.replace("frequency = 2.0", "frequency = 2.01"));
    assert_eq!(bench.row()[0], 2.01);
}

/// Times in milliseconds that are taken for seconds: 80 samples a second are then 0.08.
#[test]
fn a_force_that_is_sampled_too_rarely_for_its_cycles_is_refused() {
    let bench = Bench::new("slow", 0.0);
    let line = |i: usize| format!("{:.1},{:.4}\n", 12.5 * i as f64, flapping(0.0125 * i as f64));
    bench.write("slow.csv", &("time_s,force_n\n".to_owned() + &(0..1000).map(line).collect::<String>()));
    let page = "name = \"cell\"\nchannels = [\"a\"]\n[[recording]]\nid = \"run\"\nkind = \"flapping\"\nforce = \"slow.csv\"\n\
                seconds = [2.0, 11.0]\nfrequency = 2.0\n[log]\nforce_lag = 0.0\n";
    bench.write("page.toml", page);
    let said = bench.refusal();
    assert!(
        said.contains("flaps at 2 Hz, and its force has 0.0800 samples a second") && said.contains("unit of time_s"),
        "{said}"
    );
}

/// An amplifier's full scale among the samples of a run, in counts of 5.378 µN: it is said with its line, and moves no mean.
#[test]
fn a_spike_is_said_with_its_line_and_moves_no_mean() {
    let bench = Bench::new("spike", 0.0);
    let page = "name = \"cell\"\nchannels = [\"a\"]\n[log]\nforce_lag = 0.0\n[[log.columns]]\nquantity = \"force_n\"\n\
                column = \"counts\"\nunit = \"N\"\nscale = 5.378e-6\n[[recording]]\nid = \"run\"\nkind = \"flapping\"\n\
                force = \"counts.csv\"\nseconds = [2.0, 11.0]\nfrequency = 2.0\n";
    bench.write("page.toml", page);
    let mean = |spike: Option<(usize, i64)>| {
        let line = |i: usize| {
            let (time, force) = (0.0125 * i as f64, flapping(0.0125 * i as f64) + 1e-3 * noise(i));
            let count = spike.filter(|(at, _)| *at == i).map_or((force / 5.378e-6).round() as i64, |(_, code)| code);
            format!("{time:.5},{count}\n")
        };
        bench.write("counts.csv", &("time_s,counts\n".to_owned() + &(0..1120).map(line).collect::<String>()));
        let said = force::run(&bench.0.join("page.toml"), None).unwrap().0.to_string();
        let table = fs::read_to_string(bench.0.join("page.out/force.csv")).unwrap();
        (table.lines().nth(1).unwrap().split(',').nth(7).unwrap().parse::<f64>().unwrap(), said)
    };
    let (clean, said) = mean(None);
    assert!(!said.contains("left out"), "{said}");
    for code in [8_388_607, -8_388_608] {
        let (spiked, said) = mean(Some((500, code)));
        assert!(said.contains(&format!("counts.csv, line 502: {code} is the full scale of 24 bits")), "{said}");
        assert!((spiked - clean).abs() < 1e-4, "{spiked} {clean}");
    }
}
