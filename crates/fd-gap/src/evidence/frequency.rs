//! How often a class forecasts best when the blocks of a log are drawn again.
//!
//! Real logs do not reach the noise, and their likelihoods are absurdly sure. What one may trust is
//! how often a class wins under a moving-block bootstrap of its forecast errors (Künsch 1989, here
//! on the blocks closed to a circle).
//!
//! A replica draws as many blocks as there are. The error of a class is the mean, over sets of logs, horizons
//! and outputs, of the logarithm of its root mean square error; the least error wins.
//!
//! *When not to use:* on blocks that are shorter than the memory of the errors (they are then as
//! sure as likelihoods), and on fewer than about eight blocks (the bootstrap then knows too
//! little).

use fd_compensate::calibrate::CircularBlocks;

/// Errors of which the logarithms differ by less than this are equal: no one should be blamed for a
/// per mille.
const EQUAL: f64 = 1e-3;

/// Errors at one horizon: per class, per block, the sum of squares and how many there are.
pub type BlockErrors = [Vec<[f64; 2]>];

/// Shares of replicas that the classes win at one horizon; classes of equal errors share a win.
/// They add up to 1.
///
/// Blocks must be the same for all classes. A class with an error that is not finite does not win.
///
/// ```
/// use fd_gap::evidence::win_frequencies;
///
/// let (good, bad) = (vec![[1.0, 10.0], [2.0, 10.0]], vec![[4.0, 10.0], [1.0, 10.0]]);
/// let wins = win_frequencies(&[good, bad], 400, 1);
/// // The second one wins where the second block is drawn twice, in one of four replicas.
/// assert!((wins[1] - 0.25).abs() < 0.1);
/// assert!((wins[0] + wins[1] - 1.0).abs() < 1e-12);
/// ```
#[must_use]
pub fn win_frequencies(blocks: &BlockErrors, replicas: usize, seed: u64) -> Vec<f64> {
    win_frequencies_over(&[&[blocks]], 1, replicas, seed)
}

/// The same over several sets of logs, of which each has blocks of its own and weighs as much as any other, and over several
/// horizons (or outputs) in each, with blocks that are drawn `run` in a row, so that blocks can begin anywhere. Blocks
/// must be the same stretches of the logs of a set at all horizons.
///
/// A horizon at which some replica has no error at all does not count in that replica, nor a set without blocks.
///
/// ```
/// use fd_gap::evidence::win_frequencies_over;
///
/// // By a hundredth worse in the logs of the fit, and by a factor of two better in those held out.
/// let fitted = [vec![[1.0, 1.0]], vec![[1.02, 1.0]]];
/// let held_out = [vec![[4.0, 1.0]; 2], vec![[1.0, 1.0]; 2]];
/// assert_eq!(win_frequencies_over(&[&[&fitted], &[&held_out]], 1, 100, 1), [0.0, 1.0]);
/// ```
#[must_use]
pub fn win_frequencies_over(
    sets: &[&[&BlockErrors]],
    run: usize,
    replicas: usize,
    seed: u64,
) -> Vec<f64> {
    let classes = sets.iter().copied().flatten().next().map_or(0, |blocks| blocks.len());
    let each = sets.iter().enumerate().map(|(i, horizons)| {
        let blocks = horizons.iter().copied().flatten().map(Vec::len).min().unwrap_or(0);
        (blocks, CircularBlocks::new(blocks, run, seed.wrapping_add(i as u64)))
    });
    let mut drawn: Vec<(usize, CircularBlocks)> = each.collect();
    let mut wins = vec![0.0; classes];
    if classes == 0 || replicas == 0 || drawn.iter().all(|(blocks, _)| *blocks == 0) {
        return wins;
    }
    let mut errors = vec![0.0; classes];
    for _ in 0..replicas {
        errors.fill(0.0);
        for (horizons, (blocks, drawn)) in sets.iter().zip(&mut drawn) {
            let replica: Vec<usize> = drawn.by_ref().take(*blocks).collect();
            for horizon in *horizons {
                add_log_errors(horizon, &replica, &mut errors);
            }
        }
        let least = errors.iter().copied().fold(f64::INFINITY, f64::min);
        let is_best = |error: f64| error <= least + EQUAL;
        let winners = errors.iter().filter(|error| is_best(**error)).count() as f64;
        for (wins, error) in wins.iter_mut().zip(&errors) {
            if is_best(*error) {
                *wins += 1.0 / winners;
            }
        }
    }
    wins.iter().map(|wins| wins / replicas as f64).collect()
}

/// Adds the mean over horizons, up to a common factor that does not matter for the order; the
/// tolerance is for a sum.
fn add_log_errors(horizon: &BlockErrors, replica: &[usize], errors: &mut [f64]) {
    let total = |blocks: &Vec<[f64; 2]>| -> [f64; 2] {
        replica.iter().fold([0.0; 2], |[s, n], &b| [s + blocks[b][0], n + blocks[b][1]])
    };
    let totals: Vec<[f64; 2]> = horizon.iter().map(total).collect();
    if totals.iter().all(|[_, count]| *count == 0.0) {
        return;
    }
    for (error, [squares, count]) in errors.iter_mut().zip(totals) {
        let mean = squares / count;
        // No error at all is as good as it gets, but must not make an infinite difference.
        let log = if mean.is_finite() { mean.max(f64::MIN_POSITIVE).ln() } else { f64::INFINITY };
        *error += 0.5 * log;
    }
}
