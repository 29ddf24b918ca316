//! Fewer points with the same look: the smallest and the largest of every stretch.

/// At most about `most` of the `points`, always with the first, the last and every local extreme
/// that would be visible.
#[must_use]
pub fn decimate(points: &[(f64, f64)], most: usize) -> Vec<(f64, f64)> {
    let most = most.max(4);
    if points.len() <= most {
        return points.to_vec();
    }
    // Two points per stretch, and the two ends.
    let stretch = points.len().div_ceil((most - 2) / 2);
    let mut kept = vec![points[0]];
    for part in points.chunks(stretch) {
        let by_height = |a: &usize, b: &usize| part[*a].1.total_cmp(&part[*b].1);
        let low = (0..part.len()).min_by(by_height).unwrap_or(0);
        let high = (0..part.len()).max_by(by_height).unwrap_or(0);
        kept.push(part[low.min(high)]);
        if low != high {
            kept.push(part[low.max(high)]);
        }
    }
    kept.push(points[points.len() - 1]);
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_single_spike_survives() {
        let mut points: Vec<(f64, f64)> = (0..10_000).map(|k| (f64::from(k), 0.0)).collect();
        points[7_777].1 = 5.0;
        let kept = decimate(&points, 100);
        assert!(kept.len() <= 100, "{}", kept.len());
        assert!(kept.contains(&(7_777.0, 5.0)));
        assert_eq!((kept[0], kept[kept.len() - 1]), (points[0], points[9_999]));
        assert!(kept.is_sorted_by(|a, b| a.0 <= b.0));
    }

    #[test]
    fn few_points_stay_as_they_are() {
        let points = [(0.0, 1.0), (1.0, f64::NAN)];
        assert_eq!(decimate(&points, 100).len(), 2);
    }
}
