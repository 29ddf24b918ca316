//! Dates of ISO 8601 in text logs.

use std::cell::OnceCell;

/// Seconds of a minute, an hour and a day.
const MINUTE: i64 = 60;
const HOUR: i64 = 60 * MINUTE;
const DAY: i64 = 24 * HOUR;

/// Dates as numbers: seconds since the midnight (UTC) before the first date of the file, so that a fraction of a second
/// keeps its digits.
#[derive(Clone, Debug, Default)]
pub(crate) struct Dates {
    first_day: OnceCell<i64>,
}

impl Dates {
    /// The number of a date such as `2026-11-23T13:08:01.250Z`, with a blank for the `T` too; nothing for other text.
    pub(crate) fn seconds(&self, text: &str) -> Option<f64> {
        let (seconds, fraction) = parse(text)?;
        let midnight = self.first_day.get_or_init(|| seconds.div_euclid(DAY) * DAY);
        Some((seconds - midnight) as f64 + fraction)
    }
}

/// Whole seconds since 1970 and the rest.
fn parse(text: &str) -> Option<(i64, f64)> {
    let (date, rest) = text.split_at_checked(10)?;
    let time = rest.strip_prefix(['T', ' ', 't'])?;
    let [year, month, day] = numbers(date, '-', [4, 2, 2])?;
    let (time, offset) = zone(time)?;
    let (whole, fraction) = time.split_once(['.', ',']).unwrap_or((time, "0"));
    let [hour, minute, second] = numbers(whole, ':', [2, 2, 2])
        .or_else(|| numbers(whole, ':', [2, 2]).map(|[hour, minute]| [hour, minute, 0]))?;
    let is_number = fraction.bytes().all(|byte| byte.is_ascii_digit()) && !fraction.is_empty();
    let in_range = (1..=12).contains(&month) && (1..=31).contains(&day);
    // A leap second is the second after the 59th.
    if !is_number || !in_range || hour > 23 || minute > 59 || second > 60 {
        return None;
    }
    let seconds = days(year, month, day) * DAY + hour * HOUR + minute * MINUTE + second - offset;
    Some((seconds, format!("0.{fraction}").parse().ok()?))
}

/// Numbers of so many digits between separators.
fn numbers<const N: usize>(text: &str, separator: char, digits: [usize; N]) -> Option<[i64; N]> {
    let mut parts = text.split(separator);
    let mut numbers = [0; N];
    for (number, digits) in numbers.iter_mut().zip(digits) {
        let part = parts.next().filter(|part| part.len() == digits)?;
        let is_number = part.bytes().all(|byte| byte.is_ascii_digit());
        *number = is_number.then(|| part.parse().ok()).flatten()?;
    }
    parts.next().is_none().then_some(numbers)
}

/// The time without its zone, and how many seconds the zone is ahead of UTC; none is UTC.
fn zone(time: &str) -> Option<(&str, i64)> {
    if let Some(time) = time.strip_suffix(['Z', 'z']) {
        return Some((time, 0));
    }
    let Some(at) = time.rfind(['+', '-']) else { return Some((time, 0)) };
    let (time, zone) = time.split_at_checked(at)?;
    let sign = if zone.starts_with('-') { -1 } else { 1 };
    let zone = zone.get(1..)?;
    let [hour, minute] = numbers(zone, ':', [2, 2])
        .or_else(|| numbers(zone, ':', [2]).map(|[hour]| [hour, 0]))
        .or_else(|| {
            let (hour, minute) = zone.split_at_checked(2)?;
            numbers(&format!("{hour}:{minute}"), ':', [2, 2])
        })?;
    Some((time, sign * (hour * HOUR + minute * MINUTE)))
}

/// Days since 1970-01-01 (Hinnant 2013, `days_from_civil`).
fn days(year: i64, month: i64, day: i64) -> i64 {
    let year = if month <= 2 { year - 1 } else { year };
    let era = year.div_euclid(400);
    let of_era = year.rem_euclid(400);
    let of_year = (153 * ((month + 9) % 12) + 2) / 5 + day - 1;
    era * 146_097 + of_era * 365 + of_era / 4 - of_era / 100 + of_year - 719_468
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_are_seconds_since_1970() {
        for (text, seconds) in [
            ("1970-01-01T00:00:00Z", 0),
            ("2000-02-29 12:00", 951_825_600),
            ("2026-11-23T13:08:01+01:00", 1_795_435_681),
            ("2026-11-23T13:08:01-0130", 1_795_444_681),
            ("1969-12-31t23:59:59z", -1),
        ] {
            assert_eq!(parse(text).map(|parts| parts.0), Some(seconds), "{text}");
        }
        for text in [
            "",
            "2026-11-23",
            "2026-13-01T00:00",
            "2026-11-23T25:00",
            "2026-11-23T1:2:3",
            "1e5",
            "2026-11-23Té",
        ] {
            assert_eq!(parse(text), None, "{text}");
        }
    }

    #[test]
    fn fractions_keep_their_digits_over_midnight() {
        let dates = Dates::default();
        assert_eq!(dates.seconds("2026-11-23T23:59:59.250"), Some(86_399.25));
        assert_eq!(dates.seconds("2026-11-24T00:00:00,000000001"), Some(86_400.0 + 1e-9));
    }
}
