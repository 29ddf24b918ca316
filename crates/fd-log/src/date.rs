//! Dates and times of day in text logs: ISO 8601, and as people write them.
//!
//! | written | read as |
//! |---------|---------|
//! | `2026-11-23T13:08:01.250Z`, `2026/11/23 13:08` | year, month, day |
//! | `23.11.2026 13:08:01`, `23-Nov-2026 13:08:01` | day, month, year |
//! | `11/23/2026 01:08:01 PM`, `23-11-2026` | by what is possible, or as the column map says |
//! | `13:08:01` | time of day, going on over midnight |

use std::cell::RefCell;

use crate::time_map::DateOrder;

/// Seconds of a minute, an hour and a day.
const MINUTE: i64 = 60;
const HOUR: i64 = 60 * MINUTE;
const DAY: i64 = 24 * HOUR;

/// Dates as numbers: seconds since the midnight (UTC) before the first date of the file, so that a fraction of a second
/// keeps its digits.
#[derive(Clone, Debug, Default)]
pub(crate) struct Dates {
    state: RefCell<State>,
}

#[derive(Clone, Debug, Default)]
struct State {
    /// How dates of both orders are read, once that is known.
    order: Option<DateOrder>,
    first: Option<Date>,
    /// The last time of each column, in seconds since the first midnight.
    last: Vec<(usize, i64)>,
}

/// What a text says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum When {
    /// Neither a date nor a time of day.
    Never,
    /// Seconds since the first midnight.
    At(f64),
    /// A date that may be two, where it matters which.
    Unclear,
}

/// What kind of date a text is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Day,
    Time,
    Both,
}

/// A day as it is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Date {
    /// Days since 1970.
    Day(i64),
    /// Two numbers, day and month in either order, and the year.
    Either(i64, i64, i64),
}

/// A text, taken apart.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Parts {
    date: Option<Date>,
    /// Whole seconds since midnight; nothing for a day alone.
    seconds: Option<i64>,
    fraction: f64,
}

impl Date {
    /// Days since 1970, as one order has it; nothing where that is no date.
    fn days(self, order: DateOrder) -> Option<i64> {
        match (self, order) {
            (Self::Day(days), _) => Some(days),
            (Self::Either(day, month, year), DateOrder::DayFirst)
            | (Self::Either(month, day, year), DateOrder::MonthFirst) => {
                (month <= 12).then(|| days(year, month, day))
            }
        }
    }
}

impl Dates {
    pub(crate) fn new(order: Option<DateOrder>) -> Self {
        Self { state: RefCell::new(State { order, ..State::default() }) }
    }

    /// The number of a date or a time of day in a column.
    ///
    /// Where day and month may be told either way, the first date that is possible in one order only decides; before
    /// that, a log that runs over midnight goes on with the next day. One day needs no order.
    pub(crate) fn seconds(&self, column: usize, text: &str) -> When {
        let Some(Parts { date, seconds, fraction }) = parse(text) else { return When::Never };
        let of_day = seconds.unwrap_or(0);
        let mut state = self.state.borrow_mut();
        let last = state.last.iter().position(|(of, _)| *of == column);
        let before = last.map(|at| state.last[at].1);
        let whole = match date {
            Some(date) => {
                let first = *state.first.get_or_insert(date);
                match state.day(first, date, of_day, before) {
                    Some(day) => day * DAY + of_day,
                    None => return When::Unclear,
                }
            }
            // Back by half a day or more is over midnight; less is a log that is out of order.
            None => before.map_or(of_day, |before| {
                let same = before.div_euclid(DAY) * DAY + of_day;
                if same < before - DAY / 2 { same + DAY } else { same }
            }),
        };
        match last {
            Some(at) => state.last[at].1 = whole,
            None => state.last.push((column, whole)),
        }
        When::At(whole as f64 + fraction)
    }
}

impl State {
    /// Days since the first date.
    fn day(&mut self, first: Date, date: Date, of_day: i64, before: Option<i64>) -> Option<i64> {
        let since = |order| Some(date.days(order)? - first.days(order)?);
        if let Some(order) = self.order {
            return since(order);
        }
        let (by_day, by_month) = (since(DateOrder::DayFirst), since(DateOrder::MonthFirst));
        let order = match (by_day, by_month) {
            (None, None) => return None,
            (Some(_), None) => DateOrder::DayFirst,
            (None, Some(_)) => DateOrder::MonthFirst,
            (Some(one), Some(other)) if one == other => return Some(one),
            (Some(one), Some(other)) => {
                let goes_on = |day: i64| {
                    before.is_some_and(|before| (0..DAY).contains(&(day * DAY + of_day - before)))
                };
                match (goes_on(one), goes_on(other)) {
                    (true, false) => DateOrder::DayFirst,
                    (false, true) => DateOrder::MonthFirst,
                    _ => return None,
                }
            }
        };
        self.order = Some(order);
        since(order)
    }
}

/// What kind of date a text is; nothing for other text.
pub(crate) fn kind(text: &str) -> Option<Kind> {
    let Parts { date, seconds, .. } = parse(text)?;
    Some(match (date, seconds) {
        (Some(_), None) => Kind::Day,
        (Some(_), Some(_)) => Kind::Both,
        (None, _) => Kind::Time,
    })
}

fn parse(text: &str) -> Option<Parts> {
    let text = text.trim();
    if let Some((seconds, fraction, true)) = time(text) {
        return Some(Parts { date: None, seconds: Some(seconds), fraction });
    }
    let (day, rest) = split(text);
    let date = date(day)?;
    if rest.is_empty() {
        return Some(Parts { date: Some(date), seconds: None, fraction: 0.0 });
    }
    let (rest, offset) = zone(rest)?;
    let (seconds, fraction, _) = time(rest)?;
    // More hours than a day has are a length, and no time of it.
    let seconds = (seconds <= DAY).then_some(seconds - offset);
    Some(Parts { date: Some(date), seconds: Some(seconds?), fraction })
}

/// Date and time: at a `T` between digits, else at a blank, with a comma before it or not.
fn split(text: &str) -> (&str, &str) {
    let is_between = |at: usize| {
        let digit = |byte: Option<&u8>| byte.is_some_and(u8::is_ascii_digit);
        let bytes = text.as_bytes();
        at > 0 && digit(bytes.get(at - 1)) && digit(bytes.get(at + 1))
    };
    let at = text.find(['T', 't']).filter(|at| is_between(*at)).or_else(|| text.find(' '));
    let (date, rest) = at.map_or((text, ""), |at| text.split_at(at));
    (date.trim_end_matches(','), rest.trim_start_matches([' ', 'T', 't']))
}

fn date(text: &str) -> Option<Date> {
    let separator = text.chars().find(|c| matches!(c, '-' | '/' | '.'))?;
    let mut parts = text.split(separator);
    let [first, second, third] = [parts.next()?, parts.next()?, parts.next()?];
    if parts.next().is_some() {
        return None;
    }
    let small = |text: &str| number(text, 1..=2).filter(|n| *n > 0);
    let date = if first.len() == 4 {
        let (year, month, day) = (number(first, 4..=4)?, small(second)?, small(third)?);
        (month <= 12 && day <= 31).then(|| Date::Day(days(year, month, day)))?
    } else {
        let year = match third.len() {
            // Two digits are years of this century (POSIX: from 1969 on).
            2 => number(third, 2..=2)
                .map(|year| if year < 69 { 2000 + year } else { 1900 + year })?,
            _ => number(third, 4..=4)?,
        };
        let day = small(first)?;
        if let Some(month) = month(second) {
            (day <= 31).then(|| Date::Day(days(year, month, day)))?
        } else {
            let other = small(second)?;
            let is_possible = |day: i64, month: i64| day <= 31 && month <= 12;
            // Nobody writes months first between dots.
            if separator == '.' {
                is_possible(day, other).then(|| Date::Day(days(year, other, day)))?
            } else {
                let either = is_possible(day, other) || is_possible(other, day);
                either.then_some(Date::Either(day, other, year))?
            }
        }
    };
    Some(date)
}

/// The number of a month by the first letters of its English name.
fn month(text: &str) -> Option<i64> {
    const MONTHS: [&str; 12] =
        ["jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec"];
    let start = text.get(..3)?.to_lowercase();
    let is_letters = text.bytes().all(|byte| byte.is_ascii_alphabetic());
    (1..).zip(MONTHS).find(|(_, month)| is_letters && *month == start).map(|(number, _)| number)
}

/// Whole seconds, the rest, and whether seconds were written.
fn time(text: &str) -> Option<(i64, f64, bool)> {
    let lower = text.to_lowercase();
    let lower = lower.trim();
    let half = |ends: [&str; 2]| ends.iter().find_map(|end| lower.strip_suffix(end));
    let (text, is_pm) = match (half(["am", "a.m."]), half(["pm", "p.m."])) {
        (Some(text), _) => (text.trim(), Some(false)),
        (_, Some(text)) => (text.trim(), Some(true)),
        _ => (lower, None),
    };
    let (whole, fraction) = text.split_once(['.', ',']).unwrap_or((text, "0"));
    let mut parts = whole.split(':');
    let (hour, minute) = (number(parts.next()?, 1..=4)?, number(parts.next()?, 2..=2)?);
    let seconds = parts.next();
    let second = seconds.map_or(Some(0), |second| number(second, 2..=2))?;
    let is_number = fraction.bytes().all(|byte| byte.is_ascii_digit()) && !fraction.is_empty();
    // A leap second is the second after the 59th.
    if parts.next().is_some() || !is_number || minute > 59 || second > 60 {
        return None;
    }
    let hour = match is_pm {
        None => hour,
        Some(_) if !(1..=12).contains(&hour) => return None,
        Some(is_pm) => hour % 12 + if is_pm { 12 } else { 0 },
    };
    let fraction = format!("0.{fraction}").parse().ok()?;
    Some((hour * HOUR + minute * MINUTE + second, fraction, seconds.is_some()))
}

/// A number of so many digits.
fn number(text: &str, digits: std::ops::RangeInclusive<usize>) -> Option<i64> {
    let is_number = digits.contains(&text.len()) && text.bytes().all(|byte| byte.is_ascii_digit());
    is_number.then(|| text.parse().ok())?
}

/// The time without its zone, and how many seconds the zone is ahead of UTC; none is UTC.
fn zone(time: &str) -> Option<(&str, i64)> {
    if let Some(time) = time.strip_suffix(['Z', 'z']) {
        return Some((time, 0));
    }
    let Some(at) = time.rfind(['+', '-']) else { return Some((time, 0)) };
    let (time, zone) = time.split_at_checked(at)?;
    let sign = if zone.starts_with('-') { -1 } else { 1 };
    let zone = zone.get(1..)?.replace(':', "");
    let (hour, minute) = match zone.len() {
        2 => (number(&zone, 2..=2)?, 0),
        _ => (number(zone.get(..2)?, 2..=2)?, number(zone.get(2..)?, 2..=2)?),
    };
    Some((time.trim_end(), sign * (hour * HOUR + minute * MINUTE)))
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

    fn since_1970(text: &str) -> Option<i64> {
        let parts = parse(text)?;
        Some(parts.date?.days(DateOrder::DayFirst)? * DAY + parts.seconds.unwrap_or(0))
    }

    #[test]
    fn dates_are_seconds_since_1970() {
        for (text, seconds) in [
            ("1970-01-01T00:00:00Z", 0),
            ("2000-02-29 12:00", 951_825_600),
            ("2026-11-23T13:08:01+01:00", 1_795_435_681),
            ("2026-11-23T13:08:01-0130", 1_795_444_681),
            ("1969-12-31t23:59:59z", -1),
            ("29.02.2000 12:00", 951_825_600),
            ("29.2.00, 12:00:00", 951_825_600),
            ("29-Feb-2000 12:00:00", 951_825_600),
            ("2000/02/29 12:00:00 PM", 951_825_600),
            ("29/02/2000 12:00:00 am", 951_782_400),
            ("2000-02-29", 951_782_400),
        ] {
            assert_eq!(since_1970(text), Some(seconds), "{text}");
        }
        for text in [
            "",
            "2026-13-01T00:00",
            "2026-11-23T25:00",
            "2026-11-23T1:2:3",
            "32.01.2024 00:00",
            "13/13/2024",
            "1e5",
            "1.5",
            "1.000.000",
            "10.0.0.1",
            "12:30",
            "2026-11-23Té",
            "2026-11-23 13:00 PM",
        ] {
            assert_eq!(parse(text), None, "{text}");
        }
    }

    #[test]
    fn fractions_keep_their_digits_over_midnight() {
        let dates = Dates::default();
        assert_eq!(dates.seconds(0, "2026-11-23T23:59:59.250"), When::At(86_399.25));
        assert_eq!(dates.seconds(0, "2026-11-24T00:00:00,000000001"), When::At(86_400.0 + 1e-9));
    }

    #[test]
    fn the_order_of_day_and_month_is_found_or_asked_for() {
        let read = |order: Option<DateOrder>, texts: &[&str]| {
            let dates = Dates::new(order);
            texts.iter().map(|text| dates.seconds(0, text)).collect::<Vec<_>>()
        };
        let at = |seconds: &[i64]| seconds.iter().map(|s| When::At(*s as f64)).collect::<Vec<_>>();
        // One day needs no order, and over midnight the next day goes on.
        let night = ["02/01/2024 11:59:30 PM", "02/02/2024 12:00:00 AM", "02/03/2024 12:00:00 AM"];
        assert_eq!(read(None, &night), at(&[86_370, 86_400, 172_800]));
        let night = ["01/02/2024 23:59:30", "02/02/2024 00:00:00", "13/02/2024 00:00:00"];
        assert_eq!(read(None, &night), at(&[86_370, 86_400, 12 * 86_400]));
        // A day that is no month decides.
        assert_eq!(read(None, &["01/02/2024", "01/13/2024"]), at(&[0, 11 * 86_400]));
        let days = ["01/02/2024", "02/02/2024"];
        assert_eq!(read(None, &days)[1], When::Unclear);
        assert_eq!(read(Some(DateOrder::DayFirst), &days), at(&[0, 86_400]));
        assert_eq!(read(Some(DateOrder::MonthFirst), &days), at(&[0, 31 * 86_400]));
    }

    #[test]
    fn times_of_day_go_on_over_midnight() {
        let dates = Dates::default();
        for (text, seconds) in
            [("23:59:30", 86_370.0), ("00:00:00.5", 86_400.5), ("00:01:00", 86_460.0)]
        {
            assert_eq!(dates.seconds(0, text), When::At(seconds));
        }
        // Another column has a midnight of its own, and lengths may be longer than a day.
        assert_eq!(dates.seconds(1, "100:00:00"), When::At(360_000.0));
    }
}
