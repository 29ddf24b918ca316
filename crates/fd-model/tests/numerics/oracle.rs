//! Numbers of another library on the published engines: SLICOT by way of slycot 0.7.1 and
//! python-control 0.10.2 (`ab13dd`, `ab13bd`, `ab08nd`, `ab09ad`, `ab09nd`, `sb02od`).

use faer::{Mat, Scale, c64};
use fd_model::{Continuous, Discrete, StateSpace, reduce, riccati};

use crate::{
    engines::{engine17, f100},
    models::ts,
};

/// Whether each expected point of the upper half-plane is there, relative to its size, and
/// no others.
fn same_points(found: &[c64], expected: &[(f64, f64)], tolerance: f64) {
    let all = expected.iter().flat_map(|&(re, im)| {
        let pair = if im > 0.0 { 2 } else { 1 };
        [c64::new(re, im), c64::new(re, -im)].into_iter().take(pair)
    });
    let all: Vec<c64> = all.collect();
    assert_eq!(found.len(), all.len(), "{found:?}");
    for point in all {
        let nearest = found.iter().map(|p| (p - point).norm()).fold(f64::MAX, f64::min);
        println!("{:.1e} off {point}", nearest / point.norm());
        assert!(nearest < tolerance * point.norm(), "{nearest:e} from {point} in {found:?}");
    }
}

#[test]
fn norms_agree() {
    let (f100, _) = f100();
    let peak = f100.hinf_norm(1e-9).unwrap();
    assert!((peak.norm / 2_114.418_950_304_795_5 - 1.0).abs() < 1e-9, "{peak:?}");
    assert!((peak.omega / 3.937_060_5 - 1.0).abs() < 1e-4, "{peak:?}");
    let (a, b, c) = (f100.a().to_owned(), f100.b().to_owned(), f100.c().to_owned());
    let proper = StateSpace::new(a, b, c, Mat::zeros(5, 3), Continuous).unwrap();
    let h2 = proper.h2_norm().unwrap();
    assert!((h2 / 4_372.669_064_444_733_5 - 1.0).abs() < 1e-11, "{h2}");
    let (engine, _) = engine17("ref");
    let h2 = engine.h2_norm().unwrap();
    assert!((h2 / 2.586_715_005_876_297_5 - 1.0).abs() < 1e-11, "{h2}");
    let sampled = engine.sample_zoh(ts(0.02)).unwrap();
    for norm in [engine.hinf_norm(1e-9).unwrap().norm, sampled.hinf_norm(1e-9).unwrap().norm] {
        assert!((norm / 0.791_670_361_421_418_4 - 1.0).abs() < 1e-9, "{norm}");
    }
}

#[test]
fn zeros_agree() {
    let (f100, _) = f100();
    assert!(f100.zeros().unwrap().is_empty());
    let (a, b) = (f100.a().to_owned(), f100.b().to_owned());
    let (c, d) = (f100.c().subrows(0, 3).to_owned(), f100.d().subrows(0, 3).to_owned());
    let square = StateSpace::new(a, b, c, d, Continuous).unwrap();
    // Refined by inverse iteration with 50 digits (mpmath).
    let expected = [
        (-605.454_480_503_885_2, 0.0),
        (-50.574_832_395_692_67, 0.415_938_142_460_359_75),
        (-49.593_694_967_708_28, 0.0),
        (-34.402_699_006_438_41, 81.308_166_898_913_82),
        (-20.630_806_440_705_565, 1.646_710_846_708_013_8),
        (-18.890_194_987_367_57, 0.0),
        (-17.714_525_473_605_664, 5.072_122_704_660_54),
        (-3.177_139_555_488_694, 1.206_112_631_710_891),
        (-1.999_258_978_886_105_3, 0.0),
        (-0.661_095_850_168_359_5, 0.0),
    ];
    same_points(&square.zeros().unwrap(), &expected, 1e-10);
    let (engine, _) = engine17("ref");
    let (a, b) = (engine.a().to_owned(), engine.b().to_owned());
    let c = engine.c().subrows(2, 1).to_owned();
    let t7 = StateSpace::new(a, b, c, Mat::zeros(1, 1), Continuous).unwrap();
    let expected = [
        (-759.080_920_170_318_6, 0.0),
        (-328.168_967_372_961_16, 0.0),
        (-269.346_636_273_336_9, 0.0),
        (-142.621_173_304_878_94, 0.0),
        (-125.048_240_022_072_6, 111.615_746_296_704_37),
        (-57.073_269_049_611_284, 196.517_237_940_017_8),
        (-56.957_067_430_363_77, 120.180_394_807_306_36),
        (-40.628_073_715_731_354, 0.0),
        (-15.184_844_924_417_012, 0.0),
        (-5.286_323_147_310_274_5, 0.0),
        (-1.458_377_379_819_517, 0.0),
        (210.109_913_316_917_33, 636.286_378_820_412_4),
    ];
    same_points(&t7.zeros().unwrap(), &expected, 1e-11);
}

#[test]
fn filters_agree() {
    let (engine, _) = engine17("ref");
    let sampled = engine.sample_zoh(ts(0.02)).unwrap();
    let identity = |n| Scale(1e-4) * Mat::<f64>::identity(n, n);
    let (q, r) = (identity(17) + sampled.b() * sampled.b().transpose(), identity(5));
    let filter =
        riccati::discrete_filter(sampled.a(), sampled.c(), q.as_ref(), r.as_ref()).unwrap();
    let trace: f64 = filter.p.diagonal().column_vector().sum();
    assert!((trace / 0.718_605_434_750_37 - 1.0).abs() < 1e-12, "{trace}");
    assert!((filter.p[(0, 0)] / 0.000_360_510_179_939_330_3 - 1.0).abs() < 1e-10);
    assert!((filter.p[(16, 16)] / 0.019_684_925_453_928_345 - 1.0).abs() < 1e-10);
}

#[test]
fn reduced_models_agree() {
    let (engine, _) = engine17("ref");
    let truncated = reduce::balanced_truncation(&engine, 5).unwrap().model;
    let expected = [
        (-57.469_519_508_770_83, 262.776_549_953_228_54),
        (-48.294_502_022_024_33, 37.527_294_346_804_64),
        (-3.168_339_809_413_301_7, 0.0),
    ];
    same_points(&truncated.poles().unwrap(), &expected, 1e-10);
    let residualised = reduce::balanced_residualisation(&engine, 5).unwrap().model;
    let expected = [
        (-191.051_619_199_784_28, 205.452_416_884_142_82),
        (-38.301_122_324_866_71, 23.373_364_764_559_437),
        (-2.329_897_086_026_582, 0.0),
    ];
    same_points(&residualised.poles().unwrap(), &expected, 1e-10);
}

/// A plant of 100 states that any language makes exactly: entries from residues modulo 211. Its
/// spectral radius is 0.923.
fn plant_of_residues() -> StateSpace<Discrete> {
    let entry = |i: usize, j: usize| {
        ((37 * i + 101 * j + 13 * i * i * j + 7 * i * j * j) % 211) as f64 / 211.0 - 0.5
    };
    let n = 100;
    let a = Mat::from_fn(n, n, |i, j| 0.32 * entry(i, j));
    let b = Mat::from_fn(n, 2, |i, j| entry(i, n + j));
    let c = Mat::from_fn(3, n, |i, j| entry(n + i, j));
    StateSpace::new(a, b, c, Mat::zeros(3, 2), Discrete { ts: ts(1.0) }).unwrap()
}

/// Both compute singular values of a product of factors, with errors of some `n ε` of the largest
/// value, which promises 1e-10 of a value itself from `n ε / 1e-10 = 2e-4` of the largest on, and
/// nothing below `n ε` of it. Factors that were never squared do better: 1e-10 of the value down
/// to 1e-9 of the largest.
#[test]
fn hankel_values_of_a_hundred_states_agree() {
    let expected: Vec<f64> =
        include_str!("hankel_100.txt").lines().map(|line| line.parse().unwrap()).collect();
    let model = plant_of_residues();
    let found = model.hankel_singular_values().unwrap();
    let truncated = reduce::balanced_truncation(&model, 5).unwrap();
    let largest = expected[0];
    let n = expected.len();
    assert_eq!(n, 100);
    for values in [&found, &truncated.hankel] {
        assert_eq!(values.len(), n);
        for (value, expected) in values.iter().zip(&expected) {
            let error = (value - expected).abs();
            println!("{expected:.3e} {:.1e} {:.1e}", error / largest, error / expected);
            assert!(error <= n as f64 * f64::EPSILON * largest, "{value} is not {expected}");
            if 1e-9 * largest <= *expected {
                assert!(error <= 1e-10 * expected, "{value} is not {expected}");
            }
        }
    }
}
