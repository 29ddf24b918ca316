//! Laws of the frequencies with which classes win.

use fd_gap::evidence::{win_frequencies, win_frequencies_over};
use proptest::prelude::*;

type Class = Vec<[f64; 2]>;

/// Classes over the same blocks, some of which have no samples.
fn any_classes() -> impl Strategy<Value = Vec<Class>> {
    (1_usize..7, 2_usize..20).prop_flat_map(|(classes, blocks)| {
        let counts =
            proptest::collection::vec(prop_oneof![1 => Just(0.0), 9 => 1.0..50.0_f64], blocks);
        let levels = proptest::collection::vec(0.01..10.0_f64, classes * blocks);
        (counts, levels).prop_map(move |(counts, levels)| {
            let class = |c: usize| {
                let levels = &levels[c * blocks..(c + 1) * blocks];
                levels.iter().zip(&counts).map(|(level, n)| [level * n, *n]).collect()
            };
            (0..classes).map(class).collect()
        })
    })
}

/// Sums of as many as 400 shares of equal size round to 400 eps.
const ROUNDING: f64 = 1e-12;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn the_order_of_classes_does_not_matter(classes in any_classes(), turn in 0_usize..7, seed: u64) {
        let wins = win_frequencies(&classes, 100, seed);
        let (mut turned, n) = (classes.clone(), classes.len());
        turned.rotate_left(turn % n);
        let other = win_frequencies(&turned, 100, seed);
        for c in 0..n {
            prop_assert!((wins[(c + turn) % n] - other[c]).abs() < ROUNDING);
        }
    }

    #[test]
    fn wins_add_up_to_one(classes in any_classes(), seed: u64) {
        prop_assert!((win_frequencies(&classes, 100, seed).iter().sum::<f64>() - 1.0).abs() < ROUNDING);
    }

    #[test]
    fn identical_classes_share_their_wins(classes in any_classes(), twin in 0_usize..7, seed: u64) {
        let twin = twin % classes.len();
        let alone = win_frequencies(&classes, 100, seed);
        let mut twins = classes.clone();
        twins.push(classes[twin].clone());
        let together = win_frequencies(&twins, 100, seed);
        prop_assert_eq!(together[twin].to_bits(), together[classes.len()].to_bits());
        // What is equal within the tolerance may be more than the two.
        prop_assert!(together[twin] <= alone[twin] + ROUNDING);
        prop_assert!(alone[twin] <= 2.0 * together[twin] + ROUNDING);
    }

    /// Powers of two, so that rounding is the same.
    #[test]
    fn units_do_not_matter(classes in any_classes(), power in -20_i32..20, seed: u64) {
        let scaled: Vec<Class> = classes
            .iter()
            .map(|class| class.iter().map(|[s, n]| [s * 2.0_f64.powi(power), *n]).collect())
            .collect();
        let (wins, other) = (win_frequencies(&classes, 100, seed), win_frequencies(&scaled, 100, seed));
        for (a, b) in wins.iter().zip(&other) {
            // The logarithm of the unit is added to all errors, and rounds: one replica in 100 may
            // be on the edge of a tie.
            prop_assert!((a - b).abs() < 0.011, "{} {}", a, b);
        }
    }

    /// A class that is better in each block at one horizon and equal at the others wins always.
    #[test]
    fn what_is_better_everywhere_wins_everywhere(classes in any_classes(), run in 1_usize..5, seed: u64) {
        let better: Class = (0..classes[0].len())
            .map(|b| {
                let least = classes.iter().map(|class| class[b][0]).fold(f64::INFINITY, f64::min);
                [0.9 * least, classes[0][b][1]]
            })
            .collect();
        let same = vec![vec![[1.0, 2.0]; better.len()]; classes.len() + 1];
        let mut classes = classes;
        classes.push(better);
        let wins = win_frequencies_over(&[&[&classes, &same]], run, 100, seed);
        let last = wins.len() - 1;
        // Replicas without any sample at the first horizon are shared by all.
        let counts: Vec<f64> = classes[last].iter().map(|[_, n]| *n).collect();
        if counts.iter().all(|n| 0.0 < *n) {
            prop_assert!((wins[last] - 1.0).abs() < ROUNDING);
        }
        prop_assert!(wins[..last].iter().all(|w| *w <= wins[last] + ROUNDING));
    }
}

#[test]
fn nothing_that_diverges_wins() {
    let classes = [vec![[f64::INFINITY, 1.0]; 4], vec![[1e9, 1.0]; 4], vec![[f64::NAN, 1.0]; 4]];
    assert_eq!(win_frequencies(&classes, 10, 1), [0.0, 1.0, 0.0]);
    assert!(win_frequencies(&[], 10, 1).is_empty());
    assert_eq!(win_frequencies(&[vec![]], 10, 1), [0.0]);
}

/// Errors are means: what has more samples in a block is not worse, and a class with a third of the error wins however
/// large errors are beside their number.
#[test]
fn errors_are_means_over_samples() {
    let class =
        |square: f64| -> Class { (1..9).map(|n| [square * f64::from(n), f64::from(n)]).collect() };
    for size in [0.01, 1.0, 100.0] {
        let wins = win_frequencies(&[class(9.0 * size), class(size), class(4.0 * size)], 50, 1);
        assert_eq!(wins, [0.0, 1.0, 0.0], "{size}");
    }
    // A class that forecasts a fourth of the samples has a fourth of the sum of squares, and is no better for it.
    let often = |mean: f64, times: f64| -> Class {
        (1..9).map(|n| [mean * times * f64::from(n), times * f64::from(n)]).collect()
    };
    assert_eq!(win_frequencies(&[often(1.0, 4.0), often(1.5, 1.0)], 50, 1), [1.0, 0.0]);
    assert_eq!(win_frequencies(&[often(1.5, 4.0), often(1.0, 1.0)], 50, 1), [0.0, 1.0]);
    assert_eq!(win_frequencies(&[often(2.0, 4.0), often(2.0, 1.0)], 50, 1), [0.5, 0.5]);
    // Over two horizons logarithms are added: 2·2 beats 1·8 and 3·3.
    let [first, second] = [[4.0, 1.0, 9.0], [4.0, 64.0, 9.0]].map(|squares| squares.map(class));
    let wins = win_frequencies_over(&[&[&first[..], &second[..]]], 1, 50, 1);
    assert_eq!(wins, [1.0, 0.0, 0.0]);
    // And over two sets of logs, however many blocks they have.
    let wins = win_frequencies_over(
        &[
            &[&first[..]],
            &[&second.map(|mut c| {
                c.truncate(3);
                c
            })[..]],
        ],
        1,
        50,
        1,
    );
    assert_eq!(wins, [1.0, 0.0, 0.0]);
}
