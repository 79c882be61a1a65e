//! Times of a log: seconds, fractions of seconds, or ISO 8601.

use chrono::{DateTime, NaiveDateTime, NaiveTime, Timelike};
use si::Second;

/// The time in an ISO 8601 field, s: since 1970 of a date, since midnight of a time of day alone. A space may stand in place of the
/// `T`, a comma in place of the point; without an offset from UTC the time is taken as UTC's.
pub(crate) fn iso8601(field: &str) -> Option<Second> {
    let text = field.trim().replace(',', ".").replacen(' ', "T", 1);
    if let Ok(zoned) = DateTime::parse_from_rfc3339(&text) {
        return Some(seconds(zoned.timestamp(), zoned.timestamp_subsec_nanos()));
    }
    if let Ok(local) = NaiveDateTime::parse_from_str(&text, "%Y-%m-%dT%H:%M:%S%.f") {
        let utc = local.and_utc();
        return Some(seconds(utc.timestamp(), utc.timestamp_subsec_nanos()));
    }
    let time = NaiveTime::parse_from_str(&text, "%H:%M:%S%.f").ok()?;
    Some(seconds(i64::from(time.num_seconds_from_midnight()), time.nanosecond()))
}

fn seconds(whole: i64, nanoseconds: u32) -> Second {
    whole as f64 + 1e-9 * f64::from(nanoseconds)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_with_and_without_an_offset_and_times_of_day_are_read() {
        assert_eq!(iso8601("1970-01-02T00:00:00.125"), Some(86_400.125));
        assert_eq!(iso8601("1970-01-02 00:00:00,125"), Some(86_400.125));
        assert_eq!(iso8601("1970-01-01T02:00:00.5+02:00"), Some(0.5));
        assert_eq!(iso8601("1970-01-01T00:00:01Z"), Some(1.0));
        assert_eq!(iso8601("01:00:00.25"), Some(3600.25));
        assert_eq!(iso8601("yesterday"), None);
    }
}
