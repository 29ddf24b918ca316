//! Angles that begin anew after a turn.

/// Where the values of a signal live: on a line, or on a circle, on which values a turn apart are the same.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Circle(Option<f64>);

impl Circle {
    /// No circle: a line.
    pub const LINE: Self = Self(None);

    /// A circle of which a turn is so much, in the unit of the signal.
    ///
    /// ```
    /// use fd_model::Circle;
    ///
    /// let degrees = Circle::new(360.0);
    /// assert_eq!(degrees.difference(-179.0, 179.0), 2.0);
    /// assert_eq!(Circle::LINE.difference(-179.0, 179.0), -358.0);
    /// ```
    #[must_use]
    pub fn new(turn: f64) -> Self {
        Self((0.0 < turn && turn.is_finite()).then_some(turn))
    }

    /// Whether it is a line.
    #[must_use]
    pub fn is_line(self) -> bool {
        self.0.is_none()
    }

    /// A turn, in the unit of the signal; `None` on a line.
    #[must_use]
    pub fn turn(self) -> Option<f64> {
        self.0
    }

    /// How far `a` is from `b`, by the shorter way: at most half a turn.
    #[must_use]
    pub fn difference(self, a: f64, b: f64) -> f64 {
        self.shortest(a - b)
    }

    /// A difference without whole turns.
    #[must_use]
    pub fn shortest(self, difference: f64) -> f64 {
        match self.0 {
            Some(turn) => difference - turn * (difference / turn).round(),
            None => difference,
        }
    }

    /// A value as it goes on from the `last` one, without a jump; as it is where there is none.
    ///
    /// ```
    /// # use fd_model::Circle;
    /// assert_eq!(Circle::new(360.0).continued(-179.0, 539.0), 541.0);
    /// assert_eq!(Circle::new(360.0).continued(-179.0, f64::NAN), -179.0);
    /// ```
    #[must_use]
    pub fn continued(self, value: f64, last: f64) -> f64 {
        if self.is_line() || !last.is_finite() {
            value
        } else {
            last + self.difference(value, last)
        }
    }

    /// The same one value after the other: `last` becomes the value, unless that is missing.
    ///
    /// ```
    /// # use fd_model::Circle;
    /// let (degrees, mut last) = (Circle::new(360.0), f64::NAN);
    /// let read = [170.0, f64::NAN, -170.0].map(|value| degrees.go_on(value, &mut last));
    /// assert_eq!((read[0], read[2]), (170.0, 190.0));
    /// ```
    pub fn go_on(self, value: f64, last: &mut f64) -> f64 {
        let value = self.continued(value, *last);
        if value.is_finite() {
            *last = value;
        }
        value
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        /// However many turns are added, the difference is the same, and at most half a turn.
        #[test]
        fn whole_turns_do_not_count(a in -50.0..50.0_f64, b in -50.0..50.0_f64, k in -9..9_i32) {
            let circle = Circle::new(std::f64::consts::TAU);
            let turns = std::f64::consts::TAU * f64::from(k);
            let (once, again) = (circle.difference(a, b), circle.difference(a + turns, b));
            prop_assert!(once.abs() <= 0.5 * std::f64::consts::TAU * (1.0 + f64::EPSILON));
            // Sums of a hundred, rounded a few times; at half a turn either sign is right.
            let apart = circle.shortest(once - again).abs();
            prop_assert!(apart < 1e-13, "{once} {again}");
        }

        /// A path in steps below half a turn is recovered from what is left of it on the circle.
        #[test]
        fn a_path_is_continued(start in -3.0..3.0_f64, steps in prop::collection::vec(-3.0..3.0_f64, 1..50)) {
            let circle = Circle::new(std::f64::consts::TAU);
            let (mut place, mut last) = (start, start);
            for step in steps {
                place += step;
                last = circle.continued(circle.shortest(place), last);
                prop_assert!((last - place).abs() < 1e-12, "{last} {place}");
            }
        }
    }
}
