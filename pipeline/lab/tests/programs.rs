//! Logs as other programs write them: encodings, heads, units, separators, doubled titles, dates, counters that overflow.
#![allow(clippy::unwrap_used)] // a test may fail where it stands

use std::path::Path;

use lab::card::{Log, LogKind};
use lab::log::decoded;
use lab::{ForceLog, force};

fn forces(bytes: &[u8], columns: &str) -> Result<ForceLog, String> {
    let path = Path::new("force.csv");
    let text = decoded(bytes.to_vec(), path).map_err(|e| e.to_string())?;
    let card: Log = toml::from_str(columns).unwrap();
    force::parse_as(&text, path, (LogKind::Force, &card)).map(|logged| logged.log).map_err(|e| e.to_string())
}

/// Entries of a card for the time and the force, by title or position, with their units.
fn columns([time, time_unit]: [&str; 2], [force, force_unit]: [&str; 2]) -> String {
    let entry = |quantity: &str, column: &str, unit: &str| {
        let column = column.parse::<usize>().map_or_else(|_| format!("{column:?}"), |place| place.to_string());
        format!("[[columns]]\nquantity = \"{quantity}\"\ncolumn = {column}\nunit = \"{unit}\"\n")
    };
    entry("time_s", time, time_unit) + &entry("force_n", force, force_unit)
}

const FORCE: [f64; 3] = [0.5, -0.25, 0.125];

/// What is read of a log of the forces 0.5, −0.25 and 0.125 N at 0, 0.1 and 0.2 s, from its first time on.
fn same(text: impl AsRef<[u8]>, columns: &str) {
    let log = forces(text.as_ref(), columns).unwrap();
    let off = |(i, t): (usize, &f64)| (t - log.time[0] - 0.1 * i as f64).abs();
    assert!(log.time.iter().enumerate().map(off).fold(0.0, f64::max) < 1e-6, "{:?}", log.time);
    assert!(log.force.iter().zip(FORCE).all(|(a, b)| (a - b).abs() < 1e-12) && log.force.len() == 3, "{:?}", log.force);
}

#[test]
fn a_log_in_any_encoding_is_the_same() {
    let text = "time_s;Temp_°C;force_n\r\n0;21;0,5\r\n0,1;21;-0,25\r\n0,2;21;0,125\r\n";
    let latin: Vec<u8> = text.chars().map(|c| c as u8).collect();
    let wide: Vec<u8> = [0xfeff].into_iter().chain(text.encode_utf16()).flat_map(u16::to_le_bytes).collect();
    for bytes in [text.as_bytes().to_vec(), format!("\u{feff}{text}").into(), latin, wide[2..].to_vec(), wide] {
        same(bytes, "");
    }
    let said = forces(b"PK\x03\x04\x14\0\x06\0", "").unwrap_err();
    assert!(said.contains("the file is no text") && said.contains("UTF-16"), "{said}");
}

#[test]
fn titles_of_several_lines_and_days_of_a_spreadsheet_are_read() {
    let titled = columns(["Time (s)", "s"], ["Load (mN)", "mN"]);
    same("\"Time\n(s)\",\"Load\n(mN)\"\r\n0.0,500\r\n0.1,-250\r\n0.2,125\r\n", &titled);
    let days = "t;force_n\n45413,52083333333;0,5\n45413,52083449074;-0,25\n45413,52083564815;0,125\n";
    same(days, &columns(["t", "day"], ["force_n", "N"]));
    let refusal = forces(days.replacen("t;", "time_s;", 1).as_bytes(), "").unwrap_err();
    assert!(refusal.contains("force.csv, line 2") && refusal.contains("unit = \"day\""), "{refusal}");
}

#[test]
fn heads_units_and_separators_of_other_programs_are_read_past() {
    same("sep=;\ntime_s;force_n\n0;0,5\n0,1;-0,25\n0,2;0,125\n", "");
    same("time_s,force_n\n(s),(N)\n0,0.5\n0.1,-0.25\n0.2,0.125\n", "");
    same("# time_s force_n\n  0.0   0.5\n  0.1  -0.25\n  0.2   0.125\n", "");
    same("time_s,force_n,\n0,0.5,\n0.1,-0.25,\n0.2,0.125,\n", "");
    let titled = columns(["Time (s)", "s"], ["Load (mN)", "mN"]);
    same("Operator: AB\nTime (s)  Load (mN)\n0.0  500\n0.1  -250\n0.2  125\n", &titled);
    let labview = "LabVIEW Measurement\t\r\nReader_Version\t2\r\nSeparator\tTab\r\nDate\t2024/05/01\r\n***End_of_Header***\t\r\n\
                   Channels\t1\t\r\nSamples\t3\t\r\nY_Unit_Label\tN\t\r\nX0\t0.0E+0\t\r\n***End_of_Header***\t\t\r\n\
                   X_Value\tUntitled\tComment\r\n0.0\t0.5\r\n0.1\t-0.25\r\n0.2\t0.125\r\n";
    same(labview, &columns(["X_Value", "s"], ["Untitled", "N"]));
}

#[test]
fn the_first_of_numbers_in_quotes_is_a_sample() {
    let places = columns(["1", "s"], ["2", "N"]);
    same("\"0,0\";\"0,5\"\n\"0,1\";\"-0,25\"\n\"0,2\";\"0,125\"\n", &places);
    same("\"0,0\",\"0,5\"\n\"0,1\",\"-0,25\"\n\"0,2\",\"0,125\"\n", &places);
    same("0.0,0.5,rest\n0.1,-0.25,rest\n0.2,0.125,moving\n", &places);
}

#[test]
fn a_title_that_stands_twice_is_refused_with_both_positions() {
    let text = "time_s,force_n,force_n\n0,0.5,9\n0.1,-0.25,9\n0.2,0.125,9\n";
    let said = forces(text.as_bytes(), "").unwrap_err();
    assert!(said.contains("line 1") && said.contains("2 columns have the title `force_n`"), "{said}");
    assert!(said.contains("positions 2 and 3") && said.contains("column = 2"), "{said}");
    same(text, &columns(["time_s", "s"], ["2", "N"]));
    let other = "time_s,force_n,x,x\n0,0.5,9,8\n0.1,-0.25,9,8\n0.2,0.125,9,8\n";
    same(other, "");
    let said = forces(other.as_bytes(), &columns(["time_s", "s"], ["x", "N"])).unwrap_err();
    assert!(said.contains("2 columns have the title `x`"), "{said}");
}

#[test]
fn dates_and_times_of_day_are_read_and_midnight_passed() {
    let stamped = |stamps: [&str; 3]| {
        let lines = stamps.iter().zip(["0,5", "-0,25", "0,125"]).map(|(stamp, force)| format!("{stamp};{force}\n"));
        "Zeit;Kraft\n".to_owned() + &lines.collect::<String>()
    };
    let named = columns(["Zeit", "iso8601"], ["Kraft", "N"]);
    same(stamped(["01.05.2024 12:00:00,0", "01.05.2024 12:00:00,1", "01.05.2024 12:00:00,2"]), &named);
    same(stamped(["2024/05/01 12:00:00.0", "2024/05/01 12:00:00.1", "2024/05/01 12:00:00.2"]), &named);
    same(stamped(["23:59:59.85", "23:59:59.95", "00:00:00.05"]), &named);
    same(stamped(["11:59:59.85 AM", "11:59:59.95 AM", "12:00:00.05 PM"]), &named);
}

#[test]
fn a_counter_of_microseconds_that_overflows_goes_on() {
    let text = "us,force_n\n4294867296,0.5\n4294967295,-0.25\n99999,0.125\n";
    same(text, &columns(["us", "us"], ["force_n", "N"]));
}

#[test]
fn lines_that_end_in_crlf_have_their_numbers() {
    let text = "# by us\r\n\r\ntime_s,force_n\r\n0,0.5\r\n\r\n# pause\r\n0.1,high\r\n";
    for text in [text.to_owned(), text.replace("\r\n", "\n"), text.replace("\r\n", "\r")] {
        let said = forces(text.as_bytes(), "").unwrap_err();
        assert!(said.contains("line 7:") && said.contains("force_n is `high`"), "{said}");
    }
}
