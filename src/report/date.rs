//! Date and time of reports.

use std::time::SystemTime;

/// Seconds of a day.
const DAY: u64 = 24 * 3600;

/// Returns the time now, such as "2026-01-31 12:00 UTC".
pub fn now() -> String {
    let since = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
    written(since.as_secs())
}

/// Returns a time in seconds since 1970 as text.
fn written(seconds: u64) -> String {
    let [year, month, day] = date(seconds / DAY);
    let minutes = seconds % DAY / 60;
    format!("{year}-{month:02}-{day:02} {:02}:{:02} UTC", minutes / 60, minutes % 60)
}

/// Returns year, month and day of a number of days since 1970, in the Gregorian calendar (Hinnant
/// 2013, `civil_from_days`: years begin in March, in eras of 400 years).
fn date(days: u64) -> [u64; 3] {
    // Days between 0000-03-01 and 1970-01-01.
    let days = days + 719_468;
    let (era, day) = (days / 146_097, days % 146_097);
    let year = (day - day / 1460 + day / 36_524 - day / 146_096) / 365;
    let day = day - (365 * year + year / 4 - year / 100);
    let month = (5 * day + 2) / 153;
    let day = day - (153 * month + 2) / 5 + 1;
    let month = if month < 10 { month + 3 } else { month - 9 };
    [era * 400 + year + u64::from(month <= 2), month, day]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_are_those_of_the_calendar() {
        assert_eq!(written(0), "1970-01-01 00:00 UTC");
        assert_eq!(written(951_782_400), "2000-02-29 00:00 UTC");
        assert_eq!(written(1_709_251_199), "2024-02-29 23:59 UTC");
        assert_eq!(written(4_107_542_400), "2100-03-01 00:00 UTC");
    }
}
