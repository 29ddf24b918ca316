//! Where a legend hides least.

use plotters::chart::SeriesLabelPosition;

/// Part of the width and height of a picture that a legend may need.
const WIDTH: f64 = 0.25;
const HEIGHT: f64 = 0.2;
/// What a label of a mark or level counts for, in points.
const LABEL: usize = 50;

/// The corner with the fewest points, the upper right one if it makes no difference. Everything is
/// given from 0 to 1: points, the places of marks, labelled at the top to their right, and of
/// levels, labelled at the left.
pub(super) fn emptiest(
    points: impl Iterator<Item = (f64, f64)>,
    marks: impl Iterator<Item = f64>,
    levels: impl Iterator<Item = f64>,
) -> SeriesLabelPosition {
    use SeriesLabelPosition::{LowerLeft, LowerRight, UpperLeft, UpperRight};
    // Right and upper, each with what it hides.
    let mut corners = [
        ((true, true), UpperRight, 0),
        ((false, true), UpperLeft, 0),
        ((true, false), LowerRight, 0),
        ((false, false), LowerLeft, 0),
    ];
    let mut hide = |(x, y): (f64, f64), weight: usize| {
        for ((right, upper), _, hidden) in &mut corners {
            let at_side = if *right { x > 1.0 - WIDTH } else { x < WIDTH };
            let at_end = if *upper { y > 1.0 - HEIGHT } else { y < HEIGHT };
            *hidden += if at_side && at_end { weight } else { 0 };
        }
    };
    points.for_each(|point| hide(point, 1));
    // A label is nearly as wide as a legend.
    marks.for_each(|x| hide((x + 0.5 * WIDTH, 1.0), LABEL));
    levels.for_each(|y| hide((0.0, y), LABEL));
    corners.into_iter().min_by_key(|(.., hidden)| *hidden).map_or(UpperRight, |(_, best, _)| best)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn name(position: &SeriesLabelPosition) -> &'static str {
        match position {
            SeriesLabelPosition::UpperRight => "upper right",
            SeriesLabelPosition::UpperLeft => "upper left",
            SeriesLabelPosition::LowerRight => "lower right",
            _ => "another",
        }
    }

    #[test]
    fn a_legend_keeps_away_from_lines_and_labels() {
        let ramp = || (0..=10).map(|k| (f64::from(k) / 10.0, f64::from(k) / 10.0));
        let none = std::iter::empty::<f64>;
        assert_eq!(name(&emptiest(std::iter::empty(), none(), none())), "upper right");
        assert_eq!(name(&emptiest(ramp(), none(), none())), "upper left");
        let level = std::iter::once(0.95);
        assert_eq!(name(&emptiest(ramp(), none(), level)), "lower right");
        let mark = std::iter::once(0.7);
        assert_eq!(name(&emptiest(std::iter::empty(), mark, none())), "upper left");
    }
}
