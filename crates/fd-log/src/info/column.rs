//! What a column of a log is like.

use fd_model::unit::KNOWN_UNITS;
use serde::Serialize;

use crate::{header::HeaderColumn, hints::is_comma};

/// One column.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ColumnInfo {
    /// Its name, without a unit.
    pub name: String,
    /// Unit that the file states.
    pub unit: Option<String>,
    /// Unit that the name suggests, where the file states none. Nothing is ever converted by a guess.
    pub guess: Option<String>,
    /// Rows with a number.
    pub values: usize,
    /// Rows without a value.
    pub missing: usize,
    /// Rows with something else.
    pub texts: usize,
    /// Least number; NaN without any.
    pub least: f64,
    /// Largest number; NaN without any.
    pub most: f64,
    /// What should be looked at before it is trusted.
    pub doubts: Vec<String>,
}

/// A column while it is read.
#[derive(Clone, Debug, Default)]
pub(super) struct Tally {
    values: usize,
    missing: usize,
    texts: usize,
    /// The first cell that is no number.
    text: Option<String>,
    range: Option<(f64, f64)>,
}

impl Tally {
    pub(super) fn number(&mut self, number: f64) {
        if number.is_nan() {
            self.missing += 1;
            return;
        }
        self.values += 1;
        let (least, most) = self.range.unwrap_or((number, number));
        self.range = Some((least.min(number), most.max(number)));
    }

    pub(super) fn text(&mut self, found: &str) {
        self.texts += 1;
        self.text.get_or_insert_with(|| found.to_owned());
    }

    pub(super) fn of(self, header: &HeaderColumn) -> ColumnInfo {
        let (least, most) = self.range.unwrap_or((f64::NAN, f64::NAN));
        let guess = if header.unit.is_some() { None } else { guess(&header.name) };
        let mut doubts = Vec::new();
        if let Some(text) = &self.text {
            let why = if is_comma(text) { ": `decimal_comma = true`?" } else { "" };
            doubts.push(format!("{} cells are no numbers, the first is `{text}`{why}", self.texts));
        }
        if self.values == 0 {
            doubts.push("no number at all".to_owned());
        } else if self.values > 1 && (least..=least).contains(&most) {
            doubts.push("never changes".to_owned());
        }
        let unit = header.unit.as_deref().or(guess.as_deref());
        // Ten turns; joints do not do that, degrees do.
        if unit == Some("rad") && least.abs().max(most.abs()) > 20.0 * std::f64::consts::PI {
            doubts.push("many turns, if these are radians".to_owned());
        }
        ColumnInfo {
            name: header.name.clone(),
            unit: header.unit.clone(),
            guess,
            values: self.values,
            missing: self.missing,
            texts: self.texts,
            least,
            most,
            doubts,
        }
    }
}

/// The unit that a name suggests: what ROS prescribes for its messages (REP 103), or a unit behind the last `_`.
fn guess(name: &str) -> Option<String> {
    const ROS: [(&str, &str); 8] = [
        (".angular_velocity.", "rad/s"),
        (".linear_acceleration.", "m/s^2"),
        (".force.", "N"),
        (".torque.", "N m"),
        (".linear.", "m/s"),
        (".angular.", "rad/s"),
        (".pose.position.", "m"),
        (".stamp", "s"),
    ];
    if let Some((_, unit)) = ROS.iter().find(|(part, _)| name.contains(part)) {
        return Some((*unit).to_owned());
    }
    let (_, end) = name.rsplit_once('_')?;
    // Names cannot have strokes.
    let plain = match end {
        "mps" => "m/s",
        "radps" => "rad/s",
        "mps2" => "m/s^2",
        other => other,
    };
    let is_known =
        KNOWN_UNITS.iter().any(|(names, ..)| names.contains(&plain) && !plain.is_empty());
    // `q_d` is what is demanded of `q`.
    (is_known && !matches!(plain, "1" | "-" | "d")).then(|| plain.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_guessed_from_names_only() {
        for (name, unit) in [
            ("electric_power_W", Some("W")),
            ("position_rad", Some("rad")),
            ("speed_mps", Some("m/s")),
            ("/imu.angular_velocity.x", Some("rad/s")),
            ("/wrench.wrench.torque.z", Some("N m")),
            ("joint_1", None),
            ("speed", None),
            ("x_", None),
        ] {
            assert_eq!(guess(name).as_deref(), unit, "{name}");
        }
    }

    #[test]
    fn doubts_have_reasons() {
        let mut tally = Tally::default();
        tally.text("1,5");
        tally.number(f64::NAN);
        let column = tally.of(&HeaderColumn::parse("x [V]"));
        assert_eq!((column.texts, column.missing, column.guess), (1, 1, None));
        assert!(
            column.doubts[0].ends_with("`1,5`: `decimal_comma = true`?"),
            "{:?}",
            column.doubts
        );
        let mut degrees = Tally::default();
        degrees.number(-170.0);
        degrees.number(170.0);
        assert_eq!(degrees.of(&HeaderColumn::parse("q_rad")).doubts.len(), 1);
    }
}
