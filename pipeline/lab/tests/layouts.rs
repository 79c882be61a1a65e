//! Logs as instruments write them: other separators, titles, units and times; jitter, gaps, jumps and drifts of the clock.
#![allow(clippy::unwrap_used)] // a test may fail where it stands

use std::path::Path;

use lab::card::{Log, LogKind};
use lab::log::{Method, StampFaultKind};
use lab::pressure::Layout;
use lab::{ForceLog, Logged, PressureLog, force, pressure};

fn card(text: &str) -> Log {
    toml::from_str(text).unwrap()
}

fn forces(text: &str, log: &str) -> Result<Logged<ForceLog>, String> {
    force::parse_as(text, Path::new("force.csv"), (LogKind::Force, &card(log))).map_err(|e| e.to_string())
}

fn channels() -> [String; 2] {
    ["left", "right"].map(str::to_owned)
}

fn pressures(text: &str, log: &str) -> Result<Logged<PressureLog>, String> {
    pressure::parse_as(text, Path::new("pressure.csv"), Layout { channels: &channels(), lamp: true, log: &card(log) })
        .map_err(|e| e.to_string())
}

/// A log with the force 0.1 N · sin(4πt) at these times.
fn stamped(times: impl Iterator<Item = f64>) -> String {
    let line = |t: f64| format!("{t:.4},{:.6}\n", 0.1 * (4.0 * std::f64::consts::PI * t).sin());
    "time_s,force_n\n".to_owned() + &times.map(line).collect::<String>()
}

/// Repeatable numbers from −1 to 1.
fn uneven(i: usize) -> f64 {
    2.0 * ((i as f64 * 0.618_034 + 0.31 * (i as f64 * 1.7).sin()).fract().abs()) - 1.0
}

const POINTS: &str = "time_s,force_n,led\n0,0.5,0\n0.1,-0.25,1\n0.2,0.125,1\n";

#[test]
fn semicolons_tabs_and_decimal_commas_are_found_without_a_card() {
    let expected = forces(POINTS, "").unwrap();
    let comma = |text: &str| text.replace(',', ";").replace('.', ",");
    assert_eq!(forces(&comma(POINTS), "").unwrap(), expected);
    assert_eq!(forces(&comma(POINTS).replace(';', "\t"), "").unwrap(), expected);
    assert_eq!(expected.log.led, [0.0, 1.0, 1.0]);
}

#[test]
fn titles_and_units_of_the_card_are_taken_by_name_and_by_position() {
    let german = "Zeit;Kraft;Lampe\n0;500;0\n100;-250;5\n200;125;5\n";
    let by_name = "[[columns]]\nquantity = \"time_s\"\ncolumn = \"Zeit\"\nunit = \"ms\"\n\
                   [[columns]]\nquantity = \"force_n\"\ncolumn = \"Kraft\"\nunit = \"mN\"\nof = \"force\"\n\
                   [[columns]]\nquantity = \"led\"\ncolumn = \"Lampe\"\nscale = 0.2\n";
    let by_title = forces(german, by_name).unwrap();
    assert_eq!(by_title.log, forces(POINTS, "").unwrap().log);
    let bare: String = german.lines().skip(1).map(|line| format!("{line}\n")).collect();
    let by_place = by_name.replace("\"Zeit\"", "1").replace("\"Kraft\"", "2").replace("\"Lampe\"", "3");
    assert_eq!(forces(&bare, &by_place).unwrap().log, by_title.log);
}

/// Thousands look like decimals: 2,380 counts would be read as 2.38.
#[test]
fn a_log_with_separators_of_thousands_is_refused_with_its_line() {
    for (text, line) in [
        ("time_s;force_n\n0.0125;12\n0.0250;2,380\n", "line 3: force_n is `2,380`\n  why: it may be 2380 or 2.380"),
        ("time_s;force_n\n0,0125;12\n0,0250;2.380\n", "line 3: force_n is `2.380`\n  why: it may be 2380 or 2.380"),
        ("time_s;force_n\n0,0125;12\n0,0250;2.380,0\n", "line 3: force_n is `2.380,0`\n  why: it has more signs"),
        ("time_s\tforce_n\n0.0125\t12\n0.0250\t2'380\n", "line 3: force_n is `2'380`\n  why: it has more signs"),
    ] {
        let message = forces(text, "").unwrap_err();
        assert!(message.contains(line) && message.contains("without separators of thousands"), "{message}");
    }
    let three_decimals = forces("time_s;force_n\n0,000;1,250\n0,001;2,375\n", "").unwrap();
    assert_eq!(three_decimals.log.force, [1.25, 2.375]);
}

#[test]
fn a_unit_of_the_file_that_is_not_that_of_the_card_is_refused_with_both() {
    let milliseconds = "[[columns]]\nquantity = \"time_s\"\ncolumn = \"time_s\"\nunit = \"ms\"\n";
    let text = "time_s;force_n\nms;N\n0;0,5\n10;0,25\n20;0,125\n";
    let message = forces(text, "").unwrap_err();
    assert!(message.contains("line 1: time_s is in ms by the file\n  why: the card has it in s\n"), "{message}");
    assert_eq!(forces(text, milliseconds).unwrap().log.time, [0.0, 0.01, 0.02]);
    let titled = "[[columns]]\nquantity = \"force_n\"\ncolumn = \"Kraft [mN]\"\nunit = \"N\"\n";
    let message = forces("time_s;Kraft [mN]\n0,0;0,5\n0,1;0,25\n", titled).unwrap_err();
    assert!(message.contains("force_n is in mN by the file\n  why: the card has it in N\n"), "{message}");
}

#[test]
fn a_unit_holds_for_one_kind_of_log_where_the_card_says_so() {
    let grams = "[[columns]]\nquantity = \"force_n\"\ncolumn = \"force_n\"\nunit = \"gf\"\nof = \"hammer\"\n";
    let first_force =
        |kind| force::parse_as(POINTS, Path::new("force.csv"), (kind, &card(grams))).unwrap().log.force[0];
    assert_eq!(first_force(LogKind::Force), 0.5);
    assert!((first_force(LogKind::Hammer) - 0.5e-3 * 9.80665).abs() < 1e-15);
}

#[test]
fn pressures_in_kilopascals_are_those_in_millibars() {
    let mbar =
        "time_s,left_command_mbar,right_command_mbar,left_mbar,right_mbar,led\n0,100,0,50,5,0\n1,200,0,100,5,1\n";
    let kpa = "t\tl\tr\tL\tR\tled\n0\t10\t0\t5\t0,5\t0\n1\t20\t0\t10\t0,5\t1\n";
    let names = [("time_s", "t", "s"), ("left_command_mbar", "l", "kPa"), ("right_command_mbar", "r", "kPa")];
    let measured = [("left_mbar", "L", "kPa"), ("right_mbar", "R", "kPa")];
    let entry = |(quantity, column, unit): &(&str, &str, &str)| {
        format!("[[columns]]\nquantity = \"{quantity}\"\ncolumn = \"{column}\"\nunit = \"{unit}\"\n")
    };
    let log: String = names.iter().chain(&measured).map(entry).collect();
    assert_eq!(pressures(kpa, &log).unwrap().log, pressures(mbar, "").unwrap().log);
}

#[test]
fn times_in_iso_8601_are_read_where_the_card_says_so() {
    let text =
        "time_s,force_n\n2024-05-01T12:00:00.000,0.5\n2024-05-01T12:00:00.100,-0.25\n2024-05-01T12:00:00.200,0.125\n";
    let log = "[[columns]]\nquantity = \"time_s\"\ncolumn = 1\nunit = \"iso8601\"\n";
    let logged = forces(text, log).unwrap();
    assert!((logged.log.rate() - 10.0).abs() < 1e-5 && logged.sampling.method == Method::AsStamped);
    let message = forces(text, "").unwrap_err();
    assert!(message.contains("line 2") && message.contains("unit = \"iso8601\""), "{message}");
}

#[test]
fn a_log_without_titles_is_refused_with_the_entry_that_it_needs() {
    let message = forces("0,0.5\n0.1,-0.25\n", "").unwrap_err();
    assert!(message.contains("line 1") && message.contains("numbers, not titles"), "{message}");
    assert!(message.contains("[[log.columns]]") && message.contains("quantity = \"time_s\""), "{message}");
    let message = forces(POINTS, "[[columns]]\nquantity = \"force_n\"\ncolumn = \"Kraft\"\n").unwrap_err();
    assert!(message.contains("no column `Kraft`") && message.contains("time_s, force_n, led"), "{message}");
    let message = forces(POINTS, "[[columns]]\nquantity = \"force_n\"\ncolumn = 7\n").unwrap_err();
    assert!(message.contains("no column 7") && message.contains("has 3"), "{message}");
}

#[test]
fn an_even_log_is_read_as_stamped_and_an_uneven_one_on_an_even_clock() {
    let even = forces(&stamped((0..400).map(|i| 0.005 * i as f64)), "").unwrap();
    assert!(even.sampling.method == Method::AsStamped && even.sampling.bounds.is_empty());
    // late by 0 to 8 ms at 200 Hz: stamps may lie 13 ms apart and still rise
    let mut stamp = -1.0;
    let late = (0..400).map(|i| {
        stamp = f64::max(stamp + 2e-4, 0.005 * i as f64 + 4e-3 * (1.0 + uneven(i)));
        stamp
    });
    let logged = forces(&stamped(late), "").unwrap();
    let Logged { log, sampling } = &logged;
    assert_eq!(sampling.method, Method::LinearInterpolation);
    assert!((2e-3..8.5e-3).contains(&sampling.jitter_s), "{sampling:?}");
    let steps: Vec<f64> = log.time.windows(2).map(|t| t[1] - t[0]).collect();
    assert!(steps.iter().all(|step| (step * sampling.rate_hz - 1.0).abs() < 1e-9));
    let bound = &sampling.bounds[0];
    let deviation = |(t, f): (&f64, &f64)| (f - 0.1 * (4.0 * std::f64::consts::PI * t).sin()).abs();
    let largest_deviation = log.time.iter().zip(&log.force).map(deviation).fold(0.0, f64::max);
    // half a rounding step of the last digit of time and force is added to the interpolation's own error
    assert!(largest_deviation < bound.max + 1e-4, "{largest_deviation} {bound:?}");
}

#[test]
fn the_mean_of_a_jittered_log_is_that_of_the_even_one() {
    let value = |t: f64| 0.05 + 0.1 * (4.0 * std::f64::consts::PI * t).sin();
    let log = |late: &dyn Fn(usize) -> f64| {
        let mut last = -1.0;
        let mut line = |i: usize| {
            let time = f64::max(last + 2e-4, 0.005 * i as f64 + late(i));
            last = time;
            format!("{time:.6},{:.8}\n", value(time))
        };
        "time_s,force_n\n".to_owned() + &(0..2001).map(&mut line).collect::<String>()
    };
    let mean = |text: &str| {
        let log = forces(text, "").unwrap().log;
        let series = log.series();
        (0..1600).map(|i| series.at(1.0 + 0.005 * i as f64)).sum::<f64>() / 1600.0
    };
    let (even, jittered) = (mean(&log(&|_| 0.0)), mean(&log(&|i| 4e-3 * (1.0 + uneven(i)))));
    assert!((jittered / even - 1.0).abs() < 1e-3, "{jittered} {even}");
}

#[test]
fn on_an_even_clock_commands_stay_steps_and_held_pressures_stay_what_they_are() {
    let line = |i: usize| {
        let command = if i < 100 { 0.0 } else { 70.1 };
        format!("{:.4},{command},0,{command},0.3,0\n", 0.005 * i as f64 + 2e-3 * uneven(i))
    };
    let titles = "time_s,left_command_mbar,right_command_mbar,left_mbar,right_mbar,led\n";
    let Logged { log, sampling } =
        pressures(&(titles.to_owned() + &(0..300).map(line).collect::<String>()), "").unwrap();
    assert_eq!(sampling.method, Method::LinearInterpolation);
    let first = log.channels[0].command.iter().position(|c| *c > 0.0).unwrap();
    assert!(
        (99..=101).contains(&first)
            && log.channels[0].command[first..].iter().all(|c| *c == log.channels[0].command[first])
    );
    assert!(log.channels[0].measured[first + 1..].iter().all(|p| *p == log.channels[0].command[first]));
    assert!(sampling.bounds.iter().all(|bound| !bound.column.contains("command")));
}

#[test]
fn the_held_pressures_of_a_jittered_log_are_those_of_the_even_one() {
    // a valve that settles to 188 mbar and ripples by 1 mbar; moduli go with the mean of the last two fifths of a hold
    let pressure = |t: f64| 188.0 * (1.0 - (-t / 0.05).exp()) + (61.0 * t).sin();
    let held_mean = |jitter: f64| {
        let mut last = -1.0;
        let mut line = |i: usize| {
            last = f64::max(last + 2e-4, 0.005 * i as f64 + 0.5 * jitter * (1.0 + uneven(i)));
            format!("{last:.6},200,0,{:.3},0.3,0\n", pressure(last))
        };
        let titles = "time_s,left_command_mbar,right_command_mbar,left_mbar,right_mbar,led\n";
        let text = titles.to_owned() + &(0..600).map(&mut line).collect::<String>();
        let log = pressures(&text, "").unwrap().log;
        log.channels[0].measured[360..].iter().sum::<f64>() / log.channels[0].measured[360..].len() as f64
    };
    let (even, jittered) = (held_mean(0.0), held_mean(8e-3));
    assert!((jittered / even - 1.0).abs() < 1e-3, "{jittered} {even}");
}

#[test]
fn a_log_that_was_sampled_evenly_and_stamped_late_gives_the_held_pressures_and_the_edges_of_the_even_one() {
    // a staircase of a valve at 200 Hz, stamped up to 8 ms late
    let pressure =
        |t: f64| 188.0 * if t % 2.0 < 1.0 { 1.0 - (-(t % 1.0) / 0.05).exp() } else { (-(t % 1.0) / 0.05).exp() };
    let log = |late: f64| {
        let mut last = -1.0;
        let mut line = |i: usize| {
            let t = 0.005 * i as f64;
            last = f64::max(last + 2e-4, t + 0.5 * late * (1.0 + uneven(i)));
            let command = if t % 2.0 < 1.0 { 200 } else { 0 };
            format!("{last:.6},{command},0,{:.3},0.3,0\n", pressure(t) + 0.2 * uneven(5 * i + 1))
        };
        let titles = "time_s,left_command_mbar,right_command_mbar,left_mbar,right_mbar,led\n";
        pressures(&(titles.to_owned() + &(0..1600).map(&mut line).collect::<String>()), "").unwrap()
    };
    let (even, late) = (log(0.0), log(8e-3));
    assert_eq!((even.sampling.method, late.sampling.method), (Method::AsStamped, Method::EvenSampling));
    assert!((late.sampling.rate_hz / even.sampling.rate_hz - 1.0).abs() < 1e-4 && late.sampling.bounds.is_empty());
    assert_eq!(late.log.channels, even.log.channels);
    // late by 4 ms in the mean, alike from the first to the last sample
    let later: Vec<f64> = late.log.time.iter().zip(&even.log.time).map(|(a, b)| a - b).collect();
    assert!(later.iter().all(|d| (d - 4e-3).abs() < 3e-4), "{:?}", &later[..3]);
}

#[test]
fn a_gap_is_what_exceeds_the_longest_gap_of_the_card() {
    let times = |i: usize| 0.005 * i as f64 + if i >= 60 { 0.03 } else { 0.0 };
    let text = stamped((0..400).map(times));
    let message = forces(&text, "").unwrap_err();
    assert!(message.contains("line 62:") && message.contains("0.0350 s later"), "{message}");
    assert!(forces(&text, "longest_gap = 0.05").is_ok());
    assert!(forces(&text, "longest_gap = 0.03").is_err());
    // at 10 Hz every step is longer than that
    let slow = stamped((0..40).map(|i| 0.0955 * i as f64));
    assert!(forces(&slow, "longest_gap = 0.05").is_ok());
}

#[test]
fn every_gap_and_every_time_that_does_not_rise_is_found_with_its_line() {
    let mut times: Vec<f64> = (0..200).map(|i| 0.005 * f64::from(i)).collect();
    times[50..].iter_mut().for_each(|t| *t += 0.1);
    times[90] = times[89];
    times[120..].iter_mut().for_each(|t| *t -= 0.2);
    times[170..].iter_mut().for_each(|t| *t += 0.04);
    let text = stamped(times.into_iter());
    let report = force::stamps(&text, Path::new("force.csv"), (LogKind::Force, &Log::default())).unwrap();
    let found_faults: Vec<(usize, StampFaultKind)> = report.faults.iter().map(|f| (f.line, f.kind)).collect();
    let (gap, repeated, backward) = (StampFaultKind::Gap, StampFaultKind::Repeated, StampFaultKind::Backward);
    assert_eq!(found_faults, [(52, gap), (92, repeated), (122, backward), (172, gap)]);
    let message = forces(&text, "").unwrap_err();
    assert!(message.contains("line 52:") && message.contains("so it is on line 172"), "{message}");
}

#[test]
fn a_clock_that_changes_its_rate_is_found_with_its_line_and_jitter_is_not_taken_for_one() {
    let rate = |change: f64, jitter: f64| {
        let time = |i: usize| {
            let (early, late) = (i.min(700) as f64, i.saturating_sub(700) as f64);
            0.005 * (early + (1.0 + change) * late) + jitter * uneven(i)
        };
        let text = stamped((0..2000).map(time));
        force::stamps(&text, Path::new("force.csv"), (LogKind::Force, &Log::default())).unwrap().rate_change
    };
    let rate_change = rate(0.01, 1e-3).unwrap();
    assert!((rate_change.line as f64 - 702.0).abs() < 30.0, "{rate_change:?}");
    assert!(
        (rate_change.rates[0] - 200.0).abs() < 0.1 && (rate_change.rates[1] - 198.02).abs() < 0.1,
        "{rate_change:?}"
    );
    assert_eq!((rate(0.0, 0.0), rate(0.0, 2e-3), rate(2e-4, 0.0)), (None, None, None));
}
