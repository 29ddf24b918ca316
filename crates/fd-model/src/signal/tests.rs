//! Laws of the signals: periods, spectra, moments.

use std::{collections::BTreeMap, f64::consts::TAU};

use proptest::prelude::*;

use super::{
    prbs::{MOST_BITS, Register},
    *,
};

fn ts(seconds: f64) -> SampleTime {
    SampleTime::new(seconds).unwrap()
}

fn mean_square(values: &[f64]) -> f64 {
    values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64
}

#[test]
fn every_register_has_maximum_length() {
    for bits in 2..=MOST_BITS {
        let mut register = Register::new(bits, 0).unwrap();
        let start = register.state;
        let mut period = 0_u64;
        while period == 0 || register.state != start {
            register.next();
            period += 1;
        }
        assert_eq!(period, (1 << bits) - 1, "{bits} bits");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn prbs_is_balanced_and_white_over_a_period(bits in 2_u32..=10, seed in any::<u64>()) {
        let prbs = Prbs::new(bits, 0.3, 1.0).seeded(seed);
        let period = usize::try_from(prbs.period()).unwrap();
        let u = prbs.values(period, ts(0.3)).unwrap();
        // Sums of ±1 are exact.
        prop_assert_eq!(u.iter().sum::<f64>().to_bits(), 1.0_f64.to_bits());
        for lag in 1..period {
            let sum: f64 = (0..period).map(|k| u[k] * u[(k + lag) % period]).sum();
            prop_assert_eq!(sum.to_bits(), (-1.0_f64).to_bits(), "lag {}", lag);
        }
    }

    #[test]
    fn prbs_holds_each_bit_for_a_clock_period(bits in 2_u32..=8, hold in 1_u32..=5) {
        let slow = Prbs::new(bits, 0.1 * f64::from(hold), 2.0).values(200, ts(0.1)).unwrap();
        let fast = Prbs::new(bits, 0.1, 2.0).values(200, ts(0.1)).unwrap();
        for (k, u) in slow.iter().enumerate() {
            prop_assert_eq!(u.to_bits(), fast[k / hold as usize].to_bits());
        }
    }

    #[test]
    fn multi_sine_lands_on_its_lines(
        seed in any::<u64>(),
        lines in proptest::collection::btree_set(1_u32..60, 1..6),
    ) {
        // 128 samples of 0.1 s: the lines of the spectrum are multiples of 1 / 12.8 Hz.
        let n = 128;
        let multiples: Vec<u32> = lines.iter().copied().collect();
        let sines = MultiSine::harmonics(1.0 / 12.8, &multiples, 0.5, Phases::Random { seed });
        let u = sines.values(n, ts(0.1)).unwrap();
        for line in 0..=64_u32 {
            let (re, im) = u.iter().enumerate().fold((0.0, 0.0), |(re, im), (k, u)| {
                let angle = TAU * f64::from(line) * k as f64 / n as f64;
                (re + u * angle.cos(), im + u * angle.sin())
            });
            let amplitude = f64::hypot(re, im) * 2.0 / n as f64;
            let expected = if lines.contains(&line) { 0.5 } else { 0.0 };
            // Angles reach 2π·64 with relative error eps, so sums are good to about 400 eps.
            prop_assert!((amplitude - expected).abs() < 1e-12, "line {line}: {amplitude}");
        }
    }

    #[test]
    fn specs_survive_toml(seed in 0_u64..1000, sigma in 0.0..2.0_f64) {
        let spec = SignalSpec::Sum { terms: vec![
            WhiteNoise::new(sigma, seed).into(),
            MultiSine::new(vec![1.0], vec![sigma], Phases::Random { seed }).into(),
            StepSines::new(Step::new(sigma, 1.0), MultiSine::harmonics(0.1, &[1, 2], 0.1, Phases::Zero))
                .into(),
        ]};
        let text = toml::to_string(&spec).unwrap();
        prop_assert_eq!(toml::from_str::<SignalSpec>(&text).unwrap(), spec);
    }

    #[test]
    fn staircase_holds_as_long_as_it_says(seed in any::<u64>()) {
        let u = Staircase::new([-1.0, 1.0], [0.3, 0.8], seed).values(500, ts(0.1)).unwrap();
        let mut holds = vec![1];
        for pair in u.windows(2) {
            if pair[0].to_bits() == pair[1].to_bits() {
                *holds.last_mut().unwrap() += 1;
            } else {
                holds.push(1);
            }
        }
        holds.pop(); // cut off by the end of the record
        prop_assert!(holds.iter().all(|hold| (3..=8).contains(hold)), "{holds:?}");
    }
}

/// Five standard deviations of the sample variance of a Gaussian process with the given
/// autocorrelation: `Var(s²) = 2 σ⁴ / n · Σ ρ²` over all lags (Bartlett).
fn five_sigma(n: usize, sum_of_squared_correlations: f64) -> f64 {
    5.0 * (2.0 / n as f64 * sum_of_squared_correlations).sqrt()
}

#[test]
fn noise_has_its_marginal_variance() {
    let n = 200_000;
    let white = WhiteNoise::new(3.0, 1).values(n).unwrap();
    assert!((mean_square(&white) / 9.0 - 1.0).abs() < five_sigma(n, 1.0));

    // ρ = 0.9^|lag|: Σ ρ² = (1 + 0.81) / (1 − 0.81).
    let ar = ArNoise::new(vec![0.9], 3.0, 2).values(n).unwrap();
    assert!((mean_square(&ar) / 9.0 - 1.0).abs() < five_sigma(n, 1.81 / 0.19));
}

#[test]
fn second_order_noise_obeys_yule_walker() {
    // ρ1 = a1 / (1 − a2), ρ2 = a1 ρ1 + a2. Poles have modulus √0.7, so Σ ρ² is below
    // (1 + 0.7) / (1 − 0.7) times the square of the modal amplitude, taken as 4.
    let (n, a1, a2) = (200_000, 1.2, -0.7);
    let w = ArNoise::new(vec![a1, a2], 1.0, 3).values(n).unwrap();
    let correlation =
        |lag: usize| (0..n - lag).map(|k| w[k] * w[k + lag]).sum::<f64>() / (n - lag) as f64;
    let bound = five_sigma(n, 4.0 * 1.7 / 0.3);
    let rho1 = a1 / (1.0 - a2);
    assert!((correlation(0) - 1.0).abs() < bound);
    assert!((correlation(1) - rho1).abs() < bound);
    assert!((correlation(2) - (a1 * rho1 + a2)).abs() < bound);
}

#[test]
fn autoregressive_noise_starts_in_steady_state() {
    let seeds = 4000;
    let draws: Vec<Vec<f64>> = (0..seeds)
        .map(|seed| ArNoise::new(vec![1.2, -0.7], 2.0, seed).values(4).unwrap())
        .collect();
    for k in 0..4 {
        let at_k: Vec<f64> = draws.iter().map(|w| w[k]).collect();
        let error = mean_square(&at_k) / 4.0 - 1.0;
        assert!(error.abs() < five_sigma(draws.len(), 1.0), "sample {k}: {error}");
    }
    // Also jointly: the correlation of the first two samples.
    let product = draws.iter().map(|w| w[0] * w[1]).sum::<f64>() / draws.len() as f64;
    assert!((product / 4.0 - 1.2 / 1.7).abs() < five_sigma(draws.len(), 1.0));
}

#[test]
fn schroeder_phases_keep_the_peaks_low() {
    let multiples: Vec<u32> = (1..=30).collect();
    let crest = |phases| {
        let u = MultiSine::harmonics(0.1, &multiples, 1.0, phases).values(1000, ts(0.01)).unwrap();
        u.iter().fold(0.0_f64, |peak, u| peak.max(u.abs())) / mean_square(&u).sqrt()
    };
    // Schroeder's rule is known to give about 1.7 for flat spectra; aligned phases give
    // almost √(2 N).
    assert!(crest(Phases::Schroeder) < 1.9, "{}", crest(Phases::Schroeder));
    assert!(5.0 < crest(Phases::Zero), "{}", crest(Phases::Zero));
}

#[test]
fn a_chirp_arrives_at_its_frequency() {
    for sweep in [Sweep::Linear, Sweep::Exponential] {
        let mut chirp = Chirp::new(1.0, 0.5, 4.0, 10.0);
        chirp.sweep = sweep;
        let u = chirp.values(40_000, ts(0.001)).unwrap();
        // Rising zero crossings per second in the first and second half of the steady part.
        let crossings = |from: usize, to: usize| {
            u[from..to].windows(2).filter(|w| w[0] < 0.0 && 0.0 <= w[1]).count()
        };
        assert_eq!(crossings(20_000, 30_000), 40);
        // Turns during the sweep: the mean frequency is arithmetic or logarithmic.
        let mean = match sweep {
            Sweep::Linear => 2.25,
            Sweep::Exponential => 3.5 / 8.0_f64.ln(),
        };
        let counted = crossings(0, 10_000) as f64;
        assert!((counted - 10.0 * mean).abs() <= 1.0, "{sweep:?}: {counted}");
    }
}

#[test]
fn a_ramp_ends_where_it_is_told() {
    let ramp = Ramp { slope_per_s: 2.0, start_s: 1.0, end_s: Some(3.0), initial: 5.0 };
    assert_eq!(ramp.values(6, ts(1.0)).unwrap(), [5.0, 5.0, 7.0, 9.0, 9.0, 9.0]);
}

#[test]
fn the_same_seed_means_the_same_numbers() {
    let mut first: BTreeMap<u64, Vec<u64>> = BTreeMap::new();
    for seed in [1, 2, 1] {
        let bits =
            WhiteNoise::new(1.0, seed).values(5).unwrap().iter().map(|v| v.to_bits()).collect();
        if let Some(before) = first.insert(seed, bits) {
            assert_eq!(before, first[&seed]);
        }
    }
    assert_ne!(first[&1], first[&2]);
}

#[test]
fn parameters_out_of_range_are_named() {
    let message = |spec: SignalSpec| spec.values(10, ts(0.1)).unwrap_err().to_string();
    assert_eq!(
        message(Step::new(f64::NAN, 0.0).into()),
        "step: `amplitude` must be finite, got NaN"
    );
    assert_eq!(
        message(Prbs::new(25, 0.1, 1.0).into()),
        "prbs: `bits` must be from 2 to 24, got 25"
    );
    assert_eq!(
        message(Prbs::new(5, 0.25, 1.0).into()),
        "prbs: the clock period 0.25 s must be a whole multiple of the sample time 0.1 s"
    );
    assert_eq!(
        message(MultiSine::new(vec![5.0], vec![1.0], Phases::Zero).into()),
        "multi-sine: 5 Hz is not below the Nyquist frequency 5 Hz of the sample time"
    );
    assert_eq!(
        message(MultiSine::new(vec![1.0], vec![1.0, 2.0], Phases::Zero).into()),
        "multi-sine: `amplitudes` needs 1 values, one per frequency, got 2"
    );
    assert_eq!(
        message(ArNoise::new(vec![0.0, 1.0], 1.0, 0).into()),
        "ar-noise: the coefficients are not stable, reflection coefficient 2 is 1 and must be \
         inside -1 to 1"
    );
    assert_eq!(
        message(Staircase::new([1.0, 0.0], [1.0, 2.0], 0).into()),
        "staircase: `high` must be at least `low`, got 0"
    );
    assert_eq!(
        message(WhiteNoise::new(-1.0, 0).into()),
        "white-noise: `sigma` must be 0 or above, got -1"
    );
}

#[test]
fn unknown_fields_are_rejected_with_the_known_ones() {
    let text = "kind = 'step'\namplitude = 1.0\ndelay = 2.0";
    let message = toml::from_str::<SignalSpec>(text).unwrap_err().to_string();
    assert!(message.contains("unknown field `delay`"), "{message}");
    assert!(message.contains("`time_s`"), "{message}");
}
