//! Force logs: round trip, and each error with its file, line and column.
#![allow(clippy::unwrap_used)] // a test may fail where it stands

use std::path::Path;

use lab::force::{self, ForceLog};

const GOOD: &str = "# virtual bench
time_s,force_n
0.000000,0.012
0.012500,-0.003
0.025000,0.250
";

fn parse(text: &str) -> Result<ForceLog, String> {
    force::parse(text, Path::new("trials/flap/force.csv")).map_err(|e| e.to_string())
}

/// The refusal of the good log with `from` changed to `to`.
fn refusal(from: &str, to: &str) -> String {
    assert!(GOOD.contains(from), "`{from}` is in the good log");
    parse(&GOOD.replacen(from, to, 1)).unwrap_err()
}

#[test]
fn a_log_that_is_written_is_read_back_the_same() {
    let log = parse(GOOD).unwrap();
    assert_eq!(force::write(&log, "virtual bench"), GOOD);
    assert!((log.rate() - 80.0).abs() < 1e-9);
    assert!((log.series().at(0.025) - 0.25).abs() < 1e-12);
}

#[test]
fn columns_may_stand_in_any_order_beside_others() {
    let log = parse("force_n,counts,time_s\n0.5,92970,0\n0.6,111565,0.0955\n").unwrap();
    assert_eq!((log.time[1], log.force[0]), (0.0955, 0.5));
}

#[test]
fn a_lamp_beside_the_force_is_read_and_written() {
    let text =
        "# virtual bench\ntime_s,force_n,led\n0.000000,0.012,0.000\n0.012500,-0.003,0.250\n0.025000,0.250,1.000\n";
    let log = parse(text).unwrap();
    assert_eq!(log.led, [0.0, 0.25, 1.0]);
    assert_eq!(force::write(&log, "virtual bench"), text);
    assert!(parse(&text.replace("0.250\n0.02", "1.250\n0.02")).unwrap_err().contains("led = 1.25"));
}

#[test]
fn a_force_in_grams_or_millinewtons_is_refused_with_its_line_column_and_range() {
    let said = refusal("0.250", "250");
    assert!(said.contains("trials/flap/force.csv, line 5:") && said.contains("force_n = 250"), "{said}");
    assert!(said.contains("-50 to 50 N"), "{said}");
}

#[test]
fn a_missing_column_is_refused_with_its_name() {
    let said = refusal("force_n", "force");
    assert!(said.contains("line 2:") && said.contains("a force log has the columns time_s, force_n"), "{said}");
    assert!(said.contains("rename the column `force` to `force_n`"), "{said}");
}

#[test]
fn numbers_that_are_none_are_refused_with_their_line_and_column() {
    for bad in ["NaN", "inf", "high"] {
        let said = refusal("-0.003", bad);
        assert!(said.contains("line 4:") && said.contains(&format!("force_n is `{bad}`")), "{said}");
    }
}

#[test]
fn repeated_times_and_gaps_are_refused() {
    assert!(refusal("0.012500", "0.000000").contains("time must rise"));
    assert!(refusal("0.025000", "0.075000").contains("the next sample comes 0.0625 s later"));
    assert!(parse("time_s,force_n\n0,0\n").unwrap_err().contains("1 samples"));
}

#[test]
fn an_absent_log_is_refused_with_its_name() {
    let said = force::read(Path::new("/nowhere/force.csv")).unwrap_err().to_string();
    assert!(said.contains("/nowhere/force.csv") && said.contains("`hammer`"), "{said}");
}
