//! Spikes of an amplifier: means of logs with and without them, and what is said of each.
#![allow(clippy::unwrap_used)] // a test may fail where it stands

use std::path::Path;

use diagnostics::Diagnostic;
use lab::card::{Log, LogKind};
use lab::{ForceLog, Logged, force};

/// Counts of a force amplifier of 24 bits at 80 Hz.
const SCALE: f64 = 5.378e-6;

fn read(counts: &[i64]) -> Logged<ForceLog> {
    parse(counts).unwrap()
}

fn parse(counts: &[i64]) -> Result<Logged<ForceLog>, Diagnostic> {
    let line = |(i, count): (usize, &i64)| format!("{:.5},{count}\n", 0.0125 * i as f64);
    let text = "time_s,counts\n".to_owned() + &counts.iter().enumerate().map(line).collect::<String>();
    let card: Log =
        toml::from_str(&format!("[[columns]]\nquantity = \"force_n\"\ncolumn = \"counts\"\nscale = {SCALE}\n"))
            .unwrap();
    force::parse_as(&text, Path::new("force.csv"), (LogKind::Force, &card))
}

/// Repeatable random numbers (splitmix64).
struct Random(u64);

impl Random {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let a = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let b = (a ^ a >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        b ^ b >> 31
    }

    fn below(&mut self, count: usize) -> usize {
        (self.bits() % count as u64) as usize
    }

    /// Standard normal, the sum of twelve uniform numbers.
    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.bits() as f64 / u64::MAX as f64).sum::<f64>() - 6.0
    }
}

const CODES: [i64; 3] = [8_388_607, -8_388_608, -1];

/// 1,000 logs of a beat over a zero, with up to five spikes of one to three codes.
#[test]
fn spikes_move_no_mean_by_half_of_its_standard_error() {
    let mut random = Random(65);
    let mean = |force: &[f64]| force.iter().sum::<f64>() / force.len() as f64;
    for log in 0..1000 {
        let (zero, beat) = (90_000.0 + 100.0 * f64::from(log), 4000.0);
        let reading = |i: usize, noise: f64| (zero + beat * (0.157 * i as f64).sin() + 150.0 * noise).round() as i64;
        let clean: Vec<i64> = (0..600).map(|i| reading(i, random.normal())).collect();
        let mut spiked = clean.clone();
        for _ in 0..random.below(6) {
            spiked[1 + random.below(598)] = CODES[random.below(3)];
        }
        let truth = read(&clean);
        assert_eq!(truth.sampling.spikes, [], "log {log}");
        // of the noise alone: the beat is no error of a mean over whole cycles
        let standard_error = 150.0 * SCALE / 600_f64.sqrt();
        let moved = mean(&read(&spiked).log.force) - mean(&truth.log.force);
        assert!(moved.abs() < 0.5 * standard_error, "log {log}: {moved}");
    }
}

#[test]
fn each_spike_is_said_with_its_line_and_number() {
    let mut counts: Vec<i64> = (0..200).map(|i| 9000 + i * 37 % 101).collect();
    (counts[40], counts[120]) = (8_388_607, -1);
    let found = read(&counts);
    let said: Vec<String> = found.sampling.spikes.iter().map(ToString::to_string).collect();
    assert_eq!(said[0], "line 42: 8388607 is the full scale of 24 bits, and is left out");
    assert!(said[1].starts_with("line 122: -1 is a jump of a sample alone"), "{said:?}");
    assert!((found.log.force[40] - 0.5 * (found.log.force[39] + found.log.force[41])).abs() < 1e-12);
    assert_eq!(found.log.time.len(), 200);
}

#[test]
fn full_scale_beyond_the_range_of_forces_is_left_out_and_a_clipped_force_refused() {
    let clipped = |from: usize, to: usize| {
        let line = |i: usize| {
            format!("{:.4},{}\n", 0.0125 * i as f64, if (from..to).contains(&i) { 8_388_607 } else { 70 + i % 5 })
        };
        let text = "time_s,force_n\n".to_owned() + &(0..300).map(line).collect::<String>();
        let grams: Log = toml::from_str("[[columns]]\nquantity = \"force_n\"\ncolumn = 2\nunit = \"gf\"\n").unwrap();
        force::parse_as(&text, Path::new("force.csv"), (LogKind::Force, &grams)).map_err(|e| e.to_string())
    };
    assert_eq!(clipped(90, 91).unwrap().sampling.spikes[0].line, 92);
    let said = clipped(90, 120).unwrap_err();
    assert!(said.contains("line 92:") && said.contains("out of range"), "{said}");
}

/// Codes within the range of a beat of 40 samples: those of 16 bits, and that of an open line.
#[test]
fn a_code_beside_a_beat_is_left_out_by_its_course() {
    let reading =
        |i: usize| (9300.0 + 5700.0 * (0.157 * i as f64).sin() + 100.0 * (1.9 * i as f64).sin()).round() as i64;
    let clean: Vec<i64> = (0..600).map(reading).collect();
    for code in [32_767, -32_768, 65_535, -1] {
        for place in [100, 307, 411] {
            let mut counts = clean.clone();
            counts[place] = code;
            let spiked = read(&counts);
            let lines: Vec<usize> = spiked.sampling.spikes.iter().map(|spike| spike.line).collect();
            assert_eq!(lines, [place + 2], "{code} at {place}");
        }
    }
    assert_eq!(read(&clean).sampling.spikes, []);
}

#[test]
fn a_force_that_stays_at_full_scale_or_at_a_number_for_nothing_is_refused_with_its_line() {
    for (code, word) in [(32_767, "full scale"), (-99_999, "is missing")] {
        let counts: Vec<i64> = (0..300).map(|i| if (90..120).contains(&i) { code } else { 70 + i % 5 }).collect();
        let said = parse(&counts).unwrap_err().to_string();
        assert!(
            said.contains(&format!("line 92: the force stays at {code} for 30 samples")) && said.contains(word),
            "{said}"
        );
    }
}
