//! Likelihood, probabilities, and the share of a gap that is closed, against what is known exactly.

use fd_gap::{
    evidence::{NoisePrior, likelihood, pool, probabilities},
    quality::spectral_peaks,
    shrink::{closed, gap},
};
use fd_model::signal::{ArNoise, WhiteNoise};
use proptest::prelude::*;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn probabilities_add_up_and_keep_the_order(
        evidence in proptest::collection::vec(-1e4..1e4_f64, 1..30),
        no_gap in 0.01..0.99_f64,
        temperature in 0.5..5.0_f64,
    ) {
        let mut answers = vec![(0.0, no_gap)];
        answers.extend(evidence.iter().map(|e| (*e, (1.0 - no_gap) / evidence.len() as f64)));
        let answer = probabilities(&answers, temperature);
        prop_assert!((answer.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        for (a, pa) in evidence.iter().zip(&answer[1..]) {
            for (b, pb) in evidence.iter().zip(&answer[1..]) {
                prop_assert!(a > b || pa <= pb);
            }
        }
    }

    #[test]
    fn a_family_lies_between_its_mean_and_its_best_law(
        laws in proptest::collection::vec(-50.0..50.0_f64, 1..8),
    ) {
        let best = laws.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let pooled = pool(&laws);
        prop_assert!(pooled <= best + 1e-12);
        prop_assert!(best - (laws.len() as f64).ln() - 1e-12 <= pooled);
    }
}

#[test]
fn the_scale_of_the_noise_balances_data_and_prior() {
    let noise = WhiteNoise::new(3.0, 1).values(4000).unwrap();
    let free = likelihood(&[vec![noise.clone()]], &[NoisePrior::white(10.0)]);
    let held = likelihood(&[vec![noise.clone()]], &[NoisePrior::white(1e-3)]);
    let power = noise.iter().map(|v| v * v).sum::<f64>();
    // With a wide prior: the root of the mean square.
    assert!((free.scale[0] / f64::sqrt(power / 4000.0) - 1.0).abs() < 1e-4);
    // Stationary point of n l + E exp(−2l)/2 + l²/(2 t²).
    let l = held.scale[0].ln();
    let slope = 4000.0 - power * (-2.0 * l).exp() + l * 1e6;
    assert!(slope.abs() < 1e-4 && l < 0.1 && 0.0 < l, "{slope} at {l}");
    assert!(held.log < free.log);
}

/// What is expected of the noise need not be sigma: it pulls the size towards itself, by as much as its spread allows.
#[test]
fn the_scale_of_the_noise_is_pulled_towards_what_is_expected() {
    let noise = WhiteNoise::new(1.0, 3).values(50).unwrap();
    let power = noise.iter().map(|v| v * v).sum::<f64>();
    for (centre, spread) in [(0.7, 0.2), (-0.5, 0.2), (2.0, 0.05)] {
        let prior = NoisePrior { centre, ..NoisePrior::white(spread) };
        let found = likelihood(&[vec![noise.clone()]], &[prior]);
        let l = found.scale[0].ln();
        // Stationary point of n l + E exp(−2l)/2 + (l − c)²/(2 t²), and its value.
        let slope = 50.0 - power * (-2.0 * l).exp() + (l - centre) / (spread * spread);
        assert!(slope.abs() < 1e-6, "{slope} at {l}, {centre}");
        let log = -(50.0 * l + 0.5 * power * (-2.0 * l).exp() + prior.cost(l));
        assert!((found.log - log).abs() < 1e-9, "{} {log}", found.log);
        assert!((prior.cost(l) - 0.5 * ((l - centre) / spread).powi(2)).abs() < 1e-12);
    }
}

/// Errors of ±3 about steps of 1 are noise of 3, whatever was expected: rounding adds the variance of a step, 1/12, to
/// what the noise had before (Sheppard), and the scale is that of both.
#[test]
fn noise_behind_steps_has_its_own_size() {
    let errors: Vec<f64> = (0..400).map(|k| if k % 2 == 0 { 3.0 } else { -3.0 }).collect();
    for before in [0.5, 1.0, 8.0] {
        let prior = NoisePrior::white(10.0).rounded(before, 1.0);
        let found = likelihood(&[vec![errors.clone()]], &[prior]);
        // The top is found to a hundredth of a logarithm; the prior pulls by 1/(100 · 800) of one.
        assert!((found.scale[0] / 3.0).ln().abs() < 0.012, "{before}: {}", found.scale[0]);
        // As likely as Gaussian errors of that size, without the constant that all have in common.
        let log = -400.0 * (3.0_f64.ln() + 0.5);
        assert!((found.log - log).abs() < 3.0, "{before}: {} {log}", found.log);
    }
}

/// Noise that is small beside a step counts as 0.15 of it, and what is expected of the rounded values is that with the
/// standard deviation of rounding, a step over √12.
#[test]
fn noise_behind_steps_is_at_least_a_share_of_them() {
    for (before, step, expected) in [(1.0, 10.0, 1.5), (0.0, 2.0, 0.3), (4.0, 10.0, 4.0)] {
        let prior = NoisePrior::white(0.1).rounded(before, step);
        // Rounding of a logarithm and back.
        assert!(
            (prior.before_rounding() - expected).abs() < 1e-12,
            "{before} of {step}: {prior:?}"
        );
        let size = f64::sqrt(expected * expected + step * step / 12.0);
        assert!((prior.centre.exp() - size).abs() < 1e-12 * size, "{before} of {step}: {prior:?}");
        let without = prior.of_its_size().before_rounding();
        assert!((without - size).abs() < 1e-12 * size, "{before} of {step}: {without}");
    }
}

/// Innovations at their best size, what whitening them did, the prior, and `½ ln n` for each coefficient.
#[test]
fn each_coefficient_of_a_colour_costs_half_a_logarithm() {
    let mut signals: Vec<Vec<f64>> =
        (5..7).map(|seed| ArNoise::new(vec![0.5, 0.3], 1.0, seed).values(300).unwrap()).collect();
    signals[0][40..60].fill(f64::NAN);
    let prior = NoisePrior { centre: 0.2, ..NoisePrior::white(0.3).coloured(true) };
    let found = likelihood(std::slice::from_ref(&signals), &[prior]);
    let (colour, l, n) = (&found.colour[0], found.scale[0].ln(), 580.0_f64);
    assert!(2 <= colour.order(), "{colour:?}");
    let power = |signal: &Vec<f64>| {
        let mut innovations = vec![0.0; signal.len()];
        colour.whiten(signal, &mut innovations);
        innovations.iter().map(|e| e * e).sum::<f64>()
    };
    let power: f64 = signals.iter().map(power).sum();
    let spreads: f64 = signals.iter().map(|signal| colour.log_spread(signal)).sum();
    let fit = n * l + 0.5 * power * (-2.0 * l).exp() + prior.cost(l);
    let log = -(fit + spreads + 0.5 * colour.order() as f64 * n.ln());
    assert!((found.log - log).abs() < 1e-9, "{} {log}", found.log);
    let slope = n - power * (-2.0 * l).exp() + (l - prior.centre) / prior.spread.powi(2);
    assert!(slope.abs() < 1e-6, "{slope} at {l}");
}

#[test]
fn coloured_noise_is_no_evidence_once_its_colour_is_known() {
    // A sinusoid fitted to AR(0.8) noise: much better as white noise, no better as what it is.
    let mut gains = [0.0; 2];
    for seed in 0..20 {
        let noise = ArNoise::new(vec![0.8], 1.0, seed).values(1000).unwrap();
        let peak = spectral_peaks(&[&noise], 1)[0];
        let basis = |k: usize| (2.0 * std::f64::consts::PI * peak * k as f64).sin_cos();
        let (a, b) = noise.iter().enumerate().fold((0.0, 0.0), |(a, b), (k, w)| {
            let (s, c) = basis(k);
            (a + 0.002 * w * s, b + 0.002 * w * c)
        });
        let left: Vec<f64> = noise
            .iter()
            .enumerate()
            .map(|(k, w)| {
                let (s, c) = basis(k);
                w - a * s - b * c
            })
            .collect();
        for (gain, coloured) in gains.iter_mut().zip([false, true]) {
            let log = |e: &Vec<f64>| {
                likelihood(&[vec![e.clone()]], &[NoisePrior::white(0.15).coloured(coloured)]).log
            };
            *gain += (log(&left) - log(&noise)) / 20.0;
        }
    }
    // The peak of white noise among 2000 frequencies is worth about ln 1000 = 7 nats.
    assert!(20.0 < gains[0], "white: {}", gains[0]);
    assert!(gains[1] < 12.0, "coloured: {}", gains[1]);
}

/// A simulation that draws the staircase of a log says no more than one that goes through the steps, if noise hides
/// nothing; one that misses them is as wrong as it is far.
#[test]
fn where_in_a_step_a_simulation_is_says_nothing() {
    let step = 10.0;
    let prior = NoisePrior::white(0.1).rounded(1.0, step);
    let log = |errors: Vec<f64>| likelihood(&[vec![errors]], &[prior]).log;
    let through: Vec<f64> = (0..1000).map(|k| 4.0 * (0.01 * f64::from(k)).sin()).collect();
    let (drawn, far) = (log(vec![0.0; 1000]), log(through.iter().map(|e| 2.0 * e).collect()));
    let through = log(through);
    // Noise of 1.5, the least, throws a value 1 from the edge into the next step one time in four: ln(1/.75) = .29 at
    // the most, .11 on average over the sine.
    assert!((drawn - through).abs() < 0.12 * 1000.0, "{drawn} {through}");
    // White noise of the same size says half the mean square of the sine, 8, in that of the noise.
    let white = 1000.0 * 0.5 * 8.0 / (2.0 * prior.centre).exp();
    assert!(3.0 * (drawn - through) < white, "{drawn} {through} {white}");
    assert!(far + 500.0 < through, "{far} {through}");
}

#[test]
fn the_interval_of_the_closed_share_covers_the_truth() {
    // Before: AR(0.9) errors of size 5 on noise of 1; after: of size 2. True share of rms above
    // the floor 1: 1 − (√5 − 1)/(√26 − 1).
    let truth = 1.0 - (5.0_f64.sqrt() - 1.0) / (26.0_f64.sqrt() - 1.0);
    let mut covered = 0;
    for seed in 0..100 {
        let white = WhiteNoise::new(1.0, 1000 + seed).values(4000).unwrap();
        let slow = ArNoise::new(vec![0.9], 1.0, seed).values(4000).unwrap();
        let errors = |size: f64| -> Vec<Vec<Vec<f64>>> {
            vec![vec![white.iter().zip(&slow).map(|(w, s)| w + size * s).collect()]]
        };
        let share = closed(&errors(5.0), &errors(2.0), 1.0, 200, seed).unwrap();
        // Five times (1 + 0.9)/(1 − 0.9) = 19 samples, of which an estimate may be half or double.
        assert!((40..=300).contains(&share.block), "{}", share.block);
        let [low, high] = share.interval;
        covered += usize::from(low <= truth && truth <= high);
    }
    // 95 of 100 with a standard deviation of 2.2; the bootstrap of 40 blocks is a little short.
    assert!((85..=100).contains(&covered), "{covered} of 100 intervals cover");
}

#[test]
fn no_gap_has_no_share() {
    let errors = vec![vec![WhiteNoise::new(1.0, 2).values(500).unwrap()]];
    let floor = gap(&errors);
    assert_eq!(closed(&errors, &errors, floor, 50, 1), None);
    let far: Vec<Vec<Vec<f64>>> = vec![vec![errors[0][0].iter().map(|v| 10.0 * v).collect()]];
    let share = closed(&far, &errors, floor, 50, 1).unwrap();
    assert!((share.fraction - 1.0).abs() < 1e-12);
}
