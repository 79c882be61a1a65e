//! Pressure logs: round trip, and each error with its line and action.
#![allow(clippy::unwrap_used)] // a test may fail where it stands

use std::path::Path;

use lab::pressure::{self, PressureLog};

const GOOD: &str = "# virtual bench
time_s,left_command_mbar,right_command_mbar,left_mbar,right_mbar,led
1.000,0,0,0.5,-0.3,0
1.005,200,0,1.5,-0.2,1
1.010,200,0,90.25,0.1,1
1.015,200,0,180,0.1,1
";

fn channels() -> [String; 2] {
    ["left", "right"].map(str::to_owned)
}

fn parse(text: &str) -> Result<PressureLog, String> {
    pressure::parse(text, Path::new("pressure.csv"), &channels()).map_err(|e| e.to_string())
}

/// The refusal of the good log with `from` changed to `to`.
fn refusal(from: &str, to: &str) -> String {
    assert!(GOOD.contains(from), "`{from}` is in the good log");
    parse(&GOOD.replacen(from, to, 1)).unwrap_err()
}

#[test]
fn millibar_become_pascal_on_the_clock_of_the_log() {
    let log = parse(GOOD).unwrap();
    let left = log.series(&log.channels[0].measured);
    assert!((log.rate() - 200.0).abs() < 1e-9);
    assert!((left.at(1.010) - 9025.0).abs() < 1e-6);
    assert_eq!(log.channels[0].command, [0.0, 20000.0, 20000.0, 20000.0]);
    assert_eq!(log.led, [0.0, 1.0, 1.0, 1.0]);
}

#[test]
fn a_log_that_is_written_is_read_back_the_same() {
    let log = parse(GOOD).unwrap();
    let text = pressure::write(&log, "virtual bench");
    assert_eq!(parse(&text).unwrap(), log);
    assert_eq!(pressure::write(&parse(&text).unwrap(), "virtual bench"), text);
}

#[test]
fn columns_may_stand_in_any_order_beside_others() {
    let text = "led,temperature_c,right_mbar,left_mbar,right_command_mbar,left_command_mbar,time_s\n\
                1,21,4,3,2,1,0.0\n0,21,4,3,2,1,0.005\n";
    let log = parse(text).unwrap();
    assert_eq!((log.channels[0].command[0], log.channels[1].measured[1]), (100.0, 400.0));
}

#[test]
fn a_byte_order_mark_and_crlf_are_tolerated() {
    let text = format!("\u{feff}{}", GOOD.replace('\n', "\r\n"));
    assert_eq!(parse(&text).unwrap(), parse(GOOD).unwrap());
}

#[test]
fn a_nan_is_refused_with_its_line() {
    let message = refusal("90.25", "NaN");
    assert!(message.contains("line 5:") && message.contains("left_mbar is `NaN`"), "{message}");
}

#[test]
fn a_missing_column_is_refused_with_its_name() {
    let message = refusal("right_mbar", "right_bar");
    assert!(message.contains("line 2:") && message.contains("`right_mbar` is missing"), "{message}");
    assert!(message.contains("rename the column `right_bar` to `right_mbar`"), "{message}");
}

#[test]
fn a_missing_column_that_resembles_no_other_is_to_be_added() {
    let message = refusal(",led", ",temperature");
    assert!(message.contains("`led` is missing") && message.contains("add the column `led`"), "{message}");
}

#[test]
fn a_log_that_was_cut_in_the_middle_of_a_number_is_refused_with_its_last_line() {
    let header = GOOD.lines().nth(1).unwrap();
    let rows: String = (0..20).map(|i| format!("\n0.{:03},0.00,0.00,12.25,0.50,1", 5 * i)).collect();
    let text = format!("{header}{rows}");
    assert!(parse(&text).is_ok());
    let message = parse(text.strip_suffix("0,1").unwrap()).unwrap_err();
    assert!(message.contains("the line has 5 fields"), "{message}");
    let message =
        parse(&format!("{header}{}", rows.replace("0.095,0.00,0.00,12.25,0.50,1", "0.095,0.00,0.00,12.25,0.5,1")))
            .unwrap_err();
    assert!(message.contains("line 21: the last line is `0.095,0.00,0.00,12.25,0.5,1`"), "{message}");
}

#[test]
fn time_that_stands_still_is_refused_with_its_line() {
    let message = refusal("1.010", "1.005");
    assert!(message.contains("line 5:") && message.contains("time_s = 1.005 is repeated"), "{message}");
}

#[test]
fn a_gap_in_time_is_refused() {
    let message = refusal("1.015", "1.030");
    assert!(message.contains("line 6:") && message.contains("the next sample comes 0.0200 s later"), "{message}");
}

#[test]
fn pressures_out_of_range_are_refused_with_the_range() {
    let message = refusal("180", "18000");
    assert!(message.contains("line 6:") && message.contains("-200 to 5000 mbar"), "{message}");
}

#[test]
fn a_lamp_that_is_neither_on_nor_off_is_refused() {
    assert!(refusal("-0.3,0", "-0.3,255").contains("led = 255"));
}

#[test]
fn decimal_commas_are_refused_between_commas_and_read_between_semicolons() {
    let bare = refusal("90.25", "90,25");
    assert!(bare.contains("line 5:") && bare.contains("decimal comma"), "{bare}");
    let quoted = refusal("90.25", "\"90,25\"");
    assert!(quoted.contains("decimal points"), "{quoted}");
    assert_eq!(parse(&GOOD.replace(',', ";").replace('.', ",")).unwrap(), parse(GOOD).unwrap());
}

#[test]
fn a_word_in_place_of_a_number_is_refused() {
    assert!(refusal("90.25", "high").contains("left_mbar is `high`"));
}

#[test]
fn an_empty_log_is_refused() {
    assert!(
        parse("time_s,left_command_mbar,right_command_mbar,left_mbar,right_mbar,led\n")
            .unwrap_err()
            .contains("0 samples")
    );
}

#[test]
fn an_absent_log_is_refused_with_its_name() {
    let message = pressure::read(Path::new("/nowhere/pressure.csv"), &channels()).unwrap_err().to_string();
    assert!(message.contains("/nowhere/pressure.csv"), "{message}");
}

#[test]
fn a_log_of_changing_decimals_may_end_without_a_line_end() {
    let header = GOOD.lines().nth(1).unwrap();
    // 12.25, 12.5 and 12 in turn, as a program that drops zeros writes them
    let rows: String =
        (0..20).map(|i| format!("\n0.{:03},0,0,{},0.5,1", 5 * i, ["12.25", "12.5", "12"][i % 3])).collect();
    let log = parse(&format!("{header}{rows}")).unwrap();
    assert_eq!((log.time.len(), log.channels[0].measured[19]), (20, 1250.0));
}
