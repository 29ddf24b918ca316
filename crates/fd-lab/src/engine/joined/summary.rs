//! What many engines say together.

use super::trial::{JoinedTrial, Residual};

/// Part of the probability outside of an interval on either side.
const OUTSIDE: f64 = 0.025;

/// A table in Markdown: one row per residual with the smallest fault of each sensor, and how many times smaller it is
/// than that of the opponent, the first residual without a bias model. Medians over the engines with the 95 % intervals
/// that hold for any distribution (order statistics).
///
/// ```
/// assert!(fd_lab::engine::joined::table(&[]).starts_with("| residual |"));
/// ```
#[must_use]
pub fn table(trials: &[JoinedTrial]) -> String {
    let sensors: Vec<String> = trials
        .iter()
        .flat_map(|trial| &trial.residuals)
        .find_map(|residual| residual.as_ref().ok())
        .map(|found| found.sensors.iter().map(|(name, _)| name.clone()).collect())
        .unwrap_or_default();
    let mut text = String::from("| residual |");
    for sensor in &sensors {
        for column in ["smallest [%]", "with bias model [%]", "times smaller", "with bias model"] {
            text = text + " " + sensor + ": " + column + " |";
        }
    }
    text += " engines | µs per sample |\n|---|";
    text += &"---|".repeat(4 * sensors.len() + 2);
    text.push('\n');
    for (row, residual) in Residual::ALL.into_iter().enumerate() {
        text = text + "| " + residual.name() + " |";
        for sensor in 0..sensors.len() {
            let smallest = |trial: &JoinedTrial, row: usize, way: usize| -> Option<f64> {
                let found = trial.residuals.get(row)?.as_ref().ok()?;
                Some(found.sensors.get(sensor)?.1[way])
            };
            let over = |way: usize, f: &dyn Fn(&JoinedTrial, f64) -> Option<f64>| {
                let values = trials.iter().filter_map(|t| f(t, smallest(t, row, way)?));
                median_with_interval(values.filter(|value| !value.is_nan()).collect())
            };
            for way in 0..2 {
                text = text + " " + &over(way, &|_, smallest| Some(100.0 * smallest)) + " |";
            }
            for way in 0..2 {
                let ratio = |trial: &JoinedTrial, own: f64| Some(smallest(trial, 0, 0)? / own);
                text = text + " " + &over(way, &ratio) + " |";
            }
        }
        let found: Vec<f64> = trials
            .iter()
            .filter_map(|trial| trial.residuals.get(row)?.as_ref().ok())
            .map(|found| found.microseconds)
            .collect();
        let count = found.len();
        let cost = middle(found).map_or("–".to_owned(), figure);
        text = text + " " + &count.to_string() + " | " + &cost + " |\n";
    }
    text
}

/// The median with its interval.
fn median_with_interval(mut values: Vec<f64>) -> String {
    values.sort_by(f64::total_cmp);
    let Some(median) = middle(values.clone()) else { return "–".to_owned() };
    let rank = rank(values.len());
    let (low, high) = (values[rank], values[values.len() - 1 - rank]);
    format!("{} ({} .. {})", figure(median), figure(low), figure(high))
}

fn middle(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let n = values.len();
    (0 < n).then(|| 0.5 * (values[(n - 1) / 2] + values[n / 2]))
}

/// Values to leave out on either side, so that the median is outside of the rest with a probability of at most
/// twice [`OUTSIDE`]; none where there are too few.
fn rank(count: usize) -> usize {
    // Probability of fewer than `rank + 1` of so many fair coins.
    let (mut below, mut term) = (0.0, 0.5_f64.powf(count as f64));
    for rank in 0..count / 2 {
        below += term;
        if OUTSIDE < below {
            return rank.saturating_sub(1);
        }
        term *= (count - rank) as f64 / (rank + 1) as f64;
    }
    (count / 2).saturating_sub(1)
}

/// Three digits.
fn figure(value: f64) -> String {
    if !value.is_finite() {
        return "none".to_owned();
    }
    let digits = if value.abs() >= 100.0 {
        0
    } else if value.abs() >= 10.0 {
        1
    } else if value.abs() >= 1.0 {
        2
    } else {
        4
    };
    format!("{value:.digits$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranks_are_those_of_fair_coins() {
        // P(fewer than 1 of 6 heads) = 1/64 is below 2.5 %, P(fewer than 2) = 7/64 is not: the extremes are the ends.
        assert_eq!(rank(6), 0);
        // P(fewer than 2 of 10) = 11/1024 is, P(fewer than 3) = 56/1024 is not: the second values are the ends.
        assert_eq!(rank(10), 1);
        // Of 20, the sixth.
        assert_eq!(rank(20), 5);
        // Too few for any interval: all there is.
        assert_eq!(rank(3), 0);
    }

    #[test]
    fn medians_come_with_their_interval() {
        let values = (1..=10).map(f64::from).collect();
        assert_eq!(median_with_interval(values), "5.50 (2.00 .. 9.00)");
        assert_eq!(median_with_interval(Vec::new()), "–");
    }
}
