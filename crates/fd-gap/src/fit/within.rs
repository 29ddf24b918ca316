//! The lowest place of a quadratic function in a box.

use super::cholesky::Cholesky;

/// Where `½ xᵀAx + gᵀx` is lowest within a box, by active sets from the place nearest to zero (Nocedal & Wright 2006, section
/// 16.5); the lower triangle of `A`, row by row, is read. `None` where it is not positive definite.
///
/// Each round goes down, so that what rounding breaks off is a place that is nearly as low.
pub(crate) fn lowest_within(a: &[f64], g: &[f64], bounds: &[[f64; 2]]) -> Option<Vec<f64>> {
    let n = g.len();
    let entry = |i: usize, j: usize| a[i.max(j) * n + i.min(j)];
    let slope = |x: &[f64], i: usize| g[i] + (0..n).map(|j| entry(i, j) * x[j]).sum::<f64>();
    let mut x: Vec<f64> = bounds.iter().map(|[low, high]| 0.0_f64.clamp(*low, *high)).collect();
    // By how much an unknown at its edge would like to go back inside.
    let pull = |x: &[f64], i: usize| {
        let [low, high] = bounds[i];
        let inwards = if x[i] <= low { -slope(x, i) } else { slope(x, i) };
        if low < high { inwards } else { f64::NEG_INFINITY }
    };
    let is_at_edge = |x: &[f64], i: usize| x[i] <= bounds[i][0] || bounds[i][1] <= x[i];
    let mut held: Vec<bool> = (0..n).map(|i| is_at_edge(&x, i) && pull(&x, i) <= 0.0).collect();
    // At worst each unknown goes to its edge and comes back.
    for _ in 0..=4 * n {
        let free: Vec<usize> = (0..n).filter(|i| !held[*i]).collect();
        let rows = free.iter().flat_map(|i| free.iter().map(|j| entry(*i, *j)));
        let factor = Cholesky::new(&rows.collect::<Vec<f64>>(), free.len())?;
        let mut step: Vec<f64> = free.iter().map(|i| -slope(&x, *i)).collect();
        factor.forward(&mut step);
        factor.backward(&mut step);
        let part = |(i, step): (&usize, &f64)| {
            let edge = bounds[*i][usize::from(0.0 < *step)];
            let part = if *step == 0.0 { f64::INFINITY } else { (edge - x[*i]) / step };
            (part.max(0.0), *i, edge)
        };
        let first = free.iter().zip(&step).map(part).min_by(|a, b| a.0.total_cmp(&b.0));
        let blocked = first.filter(|(part, ..)| *part < 1.0);
        let part = blocked.map_or(1.0, |(part, ..)| part);
        free.iter().zip(&step).for_each(|(i, step)| x[*i] += part * step);
        if let Some((_, i, edge)) = blocked {
            (x[i], held[i]) = (edge, true);
            continue;
        }
        let pulls = (0..n).filter(|i| held[*i]).map(|i| (pull(&x, i), i));
        match pulls.max_by(|a, b| a.0.total_cmp(&b.0)) {
            Some((pull, i)) if 0.0 < pull => held[i] = false,
            _ => break,
        }
    }
    Some(x)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::lowest_within;

    /// `JᵀJ + I`, which is well conditioned.
    fn matrix(n: usize, entries: &[f64]) -> Vec<f64> {
        let product = |i: usize, j: usize| -> f64 {
            let product: f64 = (0..n).map(|k| entries[k * n + i] * entries[k * n + j]).sum();
            product + if i == j { 1.0 } else { 0.0 }
        };
        (0..n * n).map(|k| product(k / n, k % n)).collect()
    }

    proptest! {
        /// Where no slope points downwards but out of the box, a convex function is lowest (Karush, Kuhn, Tucker).
        #[test]
        fn nothing_in_the_box_is_lower(
            n in 1_usize..6,
            entries in prop::collection::vec(-2.0..2.0_f64, 25),
            g in prop::collection::vec(-5.0..5.0_f64, 5),
            edges in prop::collection::vec(0.0..1.0_f64, 5),
            shift in -0.5..0.5_f64,
        ) {
            let a = matrix(n, &entries);
            let bounds: Vec<[f64; 2]> = edges[..n].iter().map(|e| [shift - e, shift + e]).collect();
            let x = lowest_within(&a, &g[..n], &bounds).unwrap();
            for i in 0..n {
                let slope = g[i] + (0..n).map(|j| a[i * n + j] * x[j]).sum::<f64>();
                let [low, high] = bounds[i];
                prop_assert!((low..=high).contains(&x[i]));
                // Sums of at most six products below a hundred, through a factor of a condition below 1e3.
                let rounding = 1e-10;
                prop_assert!(x[i] <= low || slope <= rounding, "{i}: {slope} at {x:?}");
                prop_assert!(high <= x[i] || -rounding <= slope, "{i}: {slope} at {x:?}");
            }
        }
    }

    #[test]
    fn what_does_not_curve_upwards_has_no_lowest_place() {
        assert_eq!(lowest_within(&[0.0], &[1.0], &[[-1.0, 1.0]]), None);
    }
}
