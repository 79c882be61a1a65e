//! Times of a log: seconds, fractions of seconds, or dates and times of day, in ISO 8601 or with the day or the year first.

use chrono::{DateTime, NaiveDateTime, NaiveTime, Timelike};
use si::Second;

/// Dates that can be read in one way only; of 01/05/2024 the month is not known.
const DATES: [&str; 3] = ["%Y-%m-%dT%H:%M:%S%.f", "%Y/%m/%dT%H:%M:%S%.f", "%d.%m.%YT%H:%M:%S%.f"];
/// Times of day.
const TIMES: [&str; 2] = ["%H:%M:%S%.f", "%I:%M:%S%.fT%p"];

/// The time in an ISO 8601 field, s: since 1970 of a date, since midnight of a time of day alone. A space may stand in place of the
/// `T`, a comma in place of the point; without an offset from UTC the time is taken as UTC's. Dates as 2024/05/01 and 01.05.2024 and times with
/// AM or PM are read as well.
pub(crate) fn iso8601(field: &str) -> Option<Second> {
    if !field.contains(':') {
        return None;
    }
    let text = field.trim().replace(',', ".").replacen(' ', "T", 1);
    // milliseconds behind a third colon, as some programs write them
    let text = match text.rsplit_once(':') {
        Some((time, fraction)) if text.matches(':').count() == 3 && fraction.len() == 3 => format!("{time}.{fraction}"),
        _ => text,
    };
    if let Ok(zoned) = DateTime::parse_from_rfc3339(&text) {
        return Some(total_seconds(zoned.timestamp(), zoned.timestamp_subsec_nanos()));
    }
    if let Some(local) = DATES.iter().find_map(|form| NaiveDateTime::parse_from_str(&text, form).ok()) {
        let utc = local.and_utc();
        return Some(total_seconds(utc.timestamp(), utc.timestamp_subsec_nanos()));
    }
    let time = TIMES.iter().find_map(|form| NaiveTime::parse_from_str(&text, form).ok())?;
    Some(total_seconds(i64::from(time.num_seconds_from_midnight()), time.nanosecond()))
}

/// Days from 1954 to 2173 as spreadsheets count them, from the end of 1899 on.
const SPREADSHEET_DAYS: std::ops::Range<f64> = 20_000.0..100_000.0;
/// Steps of a logger in days: from a tenth of a millisecond to two seconds. In seconds they would be those of 40 kHz and more.
const LOGGER_STEPS: std::ops::Range<f64> = 1e-9..2.4e-5;

/// Whether times look like days of a spreadsheet rather than seconds.
pub fn are_spreadsheet_days(times: &[f64]) -> bool {
    let mut steps: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step > 0.0).collect();
    steps.sort_by(f64::total_cmp);
    let median_step = steps.get(steps.len() / 2);
    times.first().is_some_and(|first| SPREADSHEET_DAYS.contains(first))
        && median_step.is_some_and(|step| LOGGER_STEPS.contains(step))
}

fn total_seconds(whole: i64, nanoseconds: u32) -> Second {
    whole as f64 + 1e-9 * f64::from(nanoseconds)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn days_of_a_spreadsheet_are_no_seconds() {
        let clock = |begin: f64, step: f64| (0..9).map(|i| begin + step * f64::from(i)).collect::<Vec<f64>>();
        assert!(are_spreadsheet_days(&clock(45_413.520_833, 0.01 / 86_400.0)));
        assert!(!are_spreadsheet_days(&clock(45_413.5, 0.01)) && !are_spreadsheet_days(&clock(0.5, 1e-7)));
        assert!(!are_spreadsheet_days(&[]));
    }

    #[test]
    fn dates_with_and_without_an_offset_and_times_of_day_are_read() {
        assert_eq!(iso8601("1970-01-02T00:00:00.125"), Some(86_400.125));
        assert_eq!(iso8601("1970-01-02 00:00:00,125"), Some(86_400.125));
        assert_eq!(iso8601("1970-01-01T02:00:00.5+02:00"), Some(0.5));
        assert_eq!(iso8601("1970-01-01T00:00:01Z"), Some(1.0));
        assert_eq!([iso8601("01:00:00.25"), iso8601("01:00:00:250")], [Some(3600.25); 2]);
        for day in ["1970/01/02 00:00:00.125", "02.01.1970 00:00:00,125"] {
            assert_eq!(iso8601(day), Some(86_400.125), "{day}");
        }
        assert_eq!([iso8601("01:00:00.5 PM"), iso8601("12:00:01 AM")], [Some(46_800.5), Some(1.0)]);
        assert_eq!([iso8601("yesterday"), iso8601("01/02/1970 00:00:01"), iso8601("12")], [None; 3]);
    }
}
