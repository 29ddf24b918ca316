//! Model detection: distances with published values, Varga's examples, and laws on random models.
#![allow(clippy::unwrap_used, reason = "a failure here is a failed test")]

use crate::common::{draws, plant, residuals, rng, signal, simulate};
use faer::{Mat, MatRef, mat};
use fd_core::{
    Frame, IoDims,
    stage::{ResidualGenerator, Stage},
    testing::memory,
};
use fd_model::{Continuous, SampleTime, StateSpace, TimeDomain, TransferFunction};
use fd_residual::{
    DesignError, GeneratorDesign,
    analysis::UnknownInputs,
    form::ResidualForm,
    model_detection::{
        DetectionRows, Memory, ModelDetection, ModelDetector, ModelDistance, PlantModel, distances,
        nu_gap,
    },
};
use proptest::prelude::*;
use rand::RngExt;

fn ratio(num: &[f64], den: &[f64]) -> StateSpace<Continuous> {
    TransferFunction::new(num, den).unwrap().realise(Continuous).unwrap()
}

/// Zhou and Doyle, "Essentials of Robust Control", 1998, section 17.2.
#[test]
fn published_gaps_are_found() {
    let first = ratio(&[100.0], &[2.0, 1.0]);
    let unstable = ratio(&[100.0], &[2.0, -1.0]);
    let second = ratio(&[100.0], &[1.0, 2.0, 1.0]);
    for (one, other, expected) in
        [(&first, &unstable, 0.02), (&first, &second, 0.8988), (&unstable, &second, 0.8941)]
    {
        for gap in [nu_gap(one, other).unwrap(), nu_gap(other, one).unwrap()] {
            // Printed with four digits at most.
            assert!((gap - expected).abs() < 6e-5, "{gap} instead of {expected}");
        }
    }
}

/// `|P₁ − P₂| / √((1 + |P₁|²)(1 + |P₂|²))`, largest over frequency: what the gap is where no winding is wrong.
fn chordal(one: &StateSpace<Continuous>, other: &StateSpace<Continuous>) -> f64 {
    let at = |omega: f64| {
        let [p, q] = [one, other].map(|g| g.frequency_response(omega).unwrap()[(0, 0)]);
        (p - q).norm() / ((1.0 + p.norm_sqr()) * (1.0 + q.norm_sqr())).sqrt()
    };
    (0..8000).map(|k| at(10.0_f64.powf(-4.0 + f64::from(k) * 1e-3))).fold(0.0, f64::max)
}

/// The four actuators of Varga's test of `emdsyn`: in order, half efficient, disconnected, stalled.
fn actuators() -> Vec<PlantModel<Continuous>> {
    let one = |(name, k): (&str, f64)| PlantModel::new(name, ratio(&[k], &[1.0, k]));
    [("in order", 14.0), ("worn", 7.0), ("disconnected", 140.0), ("stalled", 0.14)]
        .map(one)
        .to_vec()
}

/// The order of a row, smallest first.
fn order(row: impl Iterator<Item = f64>) -> Vec<usize> {
    let values: Vec<f64> = row.collect();
    let mut all: Vec<_> = (0..values.len()).collect();
    all.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
    all
}

fn row(m: MatRef<'_, f64>, i: usize) -> impl Iterator<Item = f64> {
    (0..m.ncols()).map(move |j| m[(i, j)])
}

/// With `Q_i = (s + k_i)/(s + p_i) [1, −G_i]`, `R_ij = (k_j − k_i) s/((s + k_j)(s + p_i))` has the peak
/// `|k_j − k_i|/(k_j + p_i)`, and each row is in units of its least entry; the gaps are those of a fine grid.
#[test]
fn actuators_are_told_apart_as_in_closed_form() {
    let models = actuators();
    let rates: [f64; 4] = [14.0, 7.0, 140.0, 0.14];
    let gaps = distances(&models, &ModelDistance::NuGap).unwrap();
    let bank = ModelDetection::new(&models, &DetectionRows::All, 15.0).unwrap();
    for (i, model) in models.iter().enumerate() {
        let pole = bank.forms()[i].system().poles().unwrap()[0];
        assert!(pole.re <= -15.0 * (1.0 - 1e-9), "{pole}");
        let peak = |j: usize| (rates[j] - rates[i]).abs() / (rates[j] - pole.re);
        let least = (0..4).filter(|&j| j != i).map(peak).fold(f64::INFINITY, f64::min);
        assert_eq!(bank.nearest(model).unwrap().0, i);
        for (j, other) in models.iter().enumerate().filter(|(j, _)| *j != i) {
            let (found, expected) = (bank.norms()[(i, j)], peak(j) / least);
            // Norms are searched to 1e-8.
            assert!((found / expected - 1.0).abs() < 1e-7, "{i} {j}: {found} {expected}");
            // A grid of 1e-3 decades misses a peak by less than 2e-6 of it.
            let expected = chordal(model.plant(), other.plant());
            assert!((gaps[(i, j)] - expected).abs() < 2e-6, "{i} {j}: {} {expected}", gaps[(i, j)]);
        }
    }
    // At steady state all have the gain one and none is told from another.
    let steady = distances(&models, &ModelDistance::At(vec![0.0])).unwrap();
    assert!(steady.norm_max() < 1e-12);
    // ‖14/(s + 14) − 7/(s + 7)‖₂² = 14/2 + 7/2 − 2 · 14 · 7/21
    let h2 = distances(&models, &ModelDistance::H2).unwrap()[(0, 1)];
    assert!((h2.powi(2) - (10.5 - 28.0 / 3.0)).abs() < 1e-12, "{h2}");
}

/// The lateral motion of an aircraft (Varga 2017, example 6.1), with two actuators of full, half or no efficiency.
fn aircraft() -> (StateSpace<Continuous>, Vec<[f64; 2]>) {
    let a = mat![
        [-0.4492, 0.046, 0.0053, -0.9926],
        [0.0, 0.0, 1.0, 0.0067],
        [-50.8436, 0.0, -5.2184, 0.722],
        [16.4148, 0.0, 0.0026, -0.6627],
    ];
    let b = mat![[0.0004, 0.0011], [0.0, 0.0], [-1.4161, 0.2621], [-0.0633, -0.1205]];
    let plant = StateSpace::new(a, b, Mat::identity(4, 4), Mat::zeros(4, 2), Continuous).unwrap();
    let share = [1.0, 0.5, 0.0];
    (plant, share.iter().flat_map(|&p| share.map(|q| [p, q])).collect())
}

fn with_efficiency(plant: &StateSpace<Continuous>, share: &[f64; 2]) -> StateSpace<Continuous> {
    let b = Mat::from_fn(plant.nx(), 2, |i, j| plant.b()[(i, j)] * share[j]);
    let [a, c, d] = [plant.a(), plant.c(), plant.d()].map(|m| m.to_owned());
    StateSpace::new(a, b, c, d, Continuous).unwrap()
}

/// Example 6.1, exact: nine models, filters of order one, and all 81 norms against their closed form. A relation of order
/// one is `r = g (ẏ − A y − B Γ_i u)/(s + 1)`, so `‖R_ij‖∞ = ‖g B (Γ_j − Γ_i)‖`, at steady state.
#[test]
fn nine_aircraft_are_told_apart_by_filters_of_order_one() {
    let (plant, shares) = aircraft();
    let models: Vec<_> = shares
        .iter()
        .map(|share| PlantModel::new(&format!("{share:?}"), with_efficiency(&plant, share)))
        .collect();
    let bank = ModelDetection::new(&models, &DetectionRows::LeastOrder, 1.0).unwrap();
    for (i, form) in bank.forms().iter().enumerate() {
        assert_eq!((form.residual_len(), form.system().nx()), (1, 1));
        // What the last sample of y has: g, times the scale.
        let g = form.system().d().subcols(2, 4) * plant.b();
        let least =
            (0..9).filter(|&j| j != i).map(|j| bank.norms()[(i, j)]).fold(f64::INFINITY, f64::min);
        assert!((least - 1.0).abs() < 1e-12);
        for (j, other) in shares.iter().enumerate() {
            let moved = |k: usize| g[(0, k)] * (other[k] - shares[i][k]);
            let expected = moved(0).hypot(moved(1));
            let found = bank.norms()[(i, j)];
            // Norms are searched to 1e-8.
            assert!(
                (found - expected).abs() < 1e-7 * (1.0 + expected),
                "{i} {j}: {found} {expected}"
            );
        }
    }
    // The published combination of the four residuals of order four works too.
    let h = DetectionRows::Combination(vec![0.7645, 0.8848, 0.5778, 0.9026]);
    let bank = ModelDetection::new(&models, &h, 1.0).unwrap();
    for i in 0..9 {
        assert_eq!(order(row(bank.norms(), i))[0], i);
        assert!(bank.norms()[(i, i)] < 1e-7);
    }
}

/// Varga's test of the on-line decision: sines of 5 Hz on both inputs for one second, sampled at 1 kHz. After it every one of
/// the nine is recognised.
#[test]
fn nine_aircraft_are_recognised_on_line() {
    let (plant, shares) = aircraft();
    let ts = SampleTime::new(1e-3).unwrap();
    let models: Vec<_> = shares
        .iter()
        .map(|share| with_efficiency(&plant, share).sample_zoh(ts).unwrap())
        .map(|model| PlantModel::new("", model))
        .collect();
    let bank = ModelDetection::new(&models, &DetectionRows::LeastOrder, 1.0).unwrap();
    let mut detector = bank.freeze(Memory { samples: 50.0, margin: 2.0 }).unwrap();
    let u: Vec<Vec<f64>> =
        (0..1000).map(|k| vec![(std::f64::consts::PI * 0.01 * f64::from(k)).sin(); 2]).collect();
    for (j, model) in models.iter().enumerate() {
        let y = simulate(model.plant(), &[0.0; 4], &u);
        Stage::<f64>::reset(&mut detector);
        residuals(&mut detector, &u, &y);
        assert_eq!(detector.best(), j);
    }
}

/// Example 6.2, with noise on states and outputs and two outputs in degrees: every residual has noise of unit size, and what
/// the gap is was computed from other functions than the design uses.
#[test]
fn nine_noisy_aircraft_have_gaps() {
    let (plant, shares) = aircraft();
    let c = Mat::from_fn(2, 4, |i, j| if i == j { 180.0 / std::f64::consts::PI } else { 0.0 });
    let models: Vec<_> = shares
        .iter()
        .map(|share| {
            let full = with_efficiency(&plant, share);
            let [a, b] = [full.a(), full.b()].map(|m| m.to_owned());
            let model = StateSpace::new(a, b, c.clone(), Mat::zeros(2, 2), Continuous).unwrap();
            let on =
                |rows, from| Mat::from_fn(rows, 6, |i, j| if i + from == j { 1.0 } else { 0.0 });
            let noise = UnknownInputs::new("w", on(4, 0), on(2, 4)).unwrap();
            PlantModel::new("", model).with_noise(noise)
        })
        .collect();
    let bank = ModelDetection::new(&models, &DetectionRows::All, 1.0).unwrap();
    let differences = distances(&models, &ModelDistance::Peak).unwrap();
    for (i, (form, gap)) in bank.forms().iter().zip(bank.gaps()).enumerate() {
        let noise =
            form.residual_of(&models[i].noise().system(models[i].plant()).unwrap()).unwrap();
        let size = noise.hinf_norm(1e-8).unwrap().norm;
        assert!((size - 1.0).abs() < 1e-6, "{size}");
        // White noise of unit intensity on each output leaves no residual larger than the difference of the outputs.
        let nearest =
            (0..9).filter(|&j| j != i).map(|j| differences[(i, j)]).fold(f64::INFINITY, f64::min);
        assert!(0.0 < *gap && *gap <= nearest * (1.0 + 1e-6), "{gap} {nearest}");
    }
    // All models have the same noise, so the gaps are those of the smallest steps: half of an actuator.
    let gaps = bank.gaps();
    let spread = gaps.iter().map(|gap| (gap / gaps[0] - 1.0).abs()).fold(0.0, f64::max);
    assert!(spread < 1e-6, "{gaps:?}");
}

#[test]
fn models_that_agree_are_refused() {
    let lag = |k: f64| PlantModel::new(&format!("{k}"), ratio(&[k], &[1.0, k]));
    let refused = |models: &[_]| ModelDetection::new(models, &DetectionRows::All, 3.0).unwrap_err();
    assert!(matches!(refused(&[lag(2.0), lag(3.0), lag(2.0)]), DesignError::SameModel { .. }));
    assert!(matches!(refused(&[lag(2.0)]), DesignError::Count { .. }));
    let wide = StateSpace::gain(mat![[1.0, 2.0]], Continuous).unwrap();
    assert!(matches!(refused(&[lag(2.0), PlantModel::new("", wide)]), DesignError::Shape(_)));
}

/// Another plant of the same sizes, in other coordinates and units.
fn in_other_units<D: TimeDomain>(model: &StateSpace<D>, seed: u64) -> StateSpace<D> {
    let mut rng = rng(seed);
    let unit: Vec<f64> =
        (0..model.nx()).map(|_| 10.0_f64.powf(rng.random_range(-3.0..3.0))).collect();
    let (a, b, c) = (model.a(), model.b(), model.c());
    StateSpace::new(
        Mat::from_fn(a.nrows(), a.ncols(), |i, j| a[(i, j)] * unit[j] / unit[i]),
        Mat::from_fn(b.nrows(), b.ncols(), |i, j| b[(i, j)] / unit[i]),
        Mat::from_fn(c.nrows(), c.ncols(), |i, j| c[(i, j)] * unit[j]),
        model.d().to_owned(),
        model.domain(),
    )
    .unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// A metric: zero for itself in any units of the states, symmetric, at most one, and the triangle holds.
    #[test]
    fn the_gap_is_a_metric(draw in draws(), seed in any::<u64>()) {
        let [p, q, s] = [0, 1, 2].map(|k| plant(crate::common::Draw { seed: draw.seed ^ k, ..draw }));
        let gap = |a: &_, b: &_| nu_gap(a, b).unwrap();
        // The square root of rounding, by which a winding that is nearly wrong may be seen.
        prop_assert!(gap(&p, &in_other_units(&p, seed)) < 1e-6);
        let (pq, qs, ps) = (gap(&p, &q), gap(&q, &s), gap(&p, &s));
        prop_assert!((pq - gap(&q, &p)).abs() < 1e-6);
        prop_assert!(pq <= 1.0 && ps <= pq + qs + 1e-6, "{ps} {pq} {qs}");
    }

    /// Each residual is blind to its own model, sees the others, runs as designed, and is found again from a snapshot.
    #[test]
    fn banks_obey_their_laws(draw in draws(), seed in any::<u64>()) {
        let models: Vec<_> = (0..3)
            .map(|k| plant(crate::common::Draw { seed: draw.seed ^ k, ..draw }))
            .map(|model| PlantModel::new("", in_other_units(&model, seed)))
            .collect();
        let bank = ModelDetection::new(&models, &DetectionRows::All, 2.0).unwrap();
        for (i, form) in bank.forms().iter().enumerate() {
            prop_assert!(form.consistency(models[i].plant()).unwrap() < 1e-9);
            prop_assert!(bank.norms()[(i, i)] < 1e-6);
        }
        let u = signal(seed, draw.nu, 300);
        for (j, model) in models.iter().enumerate() {
            let y = simulate(model.plant(), &vec![0.0; draw.nx], &u);
            let mut detector = bank.freeze(Memory::default()).unwrap();
            residuals(&mut detector, &u, &y);
            prop_assert_eq!(detector.best(), j);
        }
        let (u, y) = (signal(seed ^ 5, draw.nu, 60), signal(seed ^ 6, draw.ny, 60));
        let mut r = vec![0.0; bank.residual_len()];
        let frozen = || bank.freeze(Memory::default()).unwrap();
        memory(&mut frozen(), &mut frozen(), 30, |detector, k| {
            let frame = Frame::new(ResidualGenerator::io(detector), k as u64, &u[k], &y[k]).unwrap();
            detector.step(frame, &mut r);
            (detector.best(), r.iter().map(|v| v.to_bits()).collect::<Vec<_>>())
        });
    }

    /// Of two static models, one with two residuals, the levels are the lengths of what they leave, from rest within the
    /// memory; the first is left for the second only where that is smaller by more than the margin.
    #[test]
    fn a_model_is_left_for_one_that_is_better_by_the_margin(
        left in prop::array::uniform3(0.1..10.0_f64),
        samples in 1.0..30.0_f64,
        margin in 1.0..3.0_f64,
        count in 1..40_i32,
    ) {
        let member = |gains: &[f64]| {
            let d = Mat::from_fn(gains.len(), 2, |i, j| if j == 0 { gains[i] } else { 1.0 });
            let system = StateSpace::gain(d, crate::common::sampled()).unwrap();
            ResidualForm::new(IoDims { nu: 1, ny: 1 }, system).unwrap().freeze().unwrap()
        };
        let members = vec![member(&left[..2]), member(&left[2..])];
        let mut detector = ModelDetector::new(members, Memory { samples, margin }).unwrap();
        let (one, other) = (left[0].hypot(left[1]), left[2]);
        prop_assume!((margin * other / one - 1.0).abs() > 1e-9);
        for _ in 0..2 {
            let (u, y) = ([vec![1.0]], [vec![0.0]]);
            (0..count).for_each(|_| drop(residuals(&mut detector, &u, &y)));
            let share = (1.0 - (1.0 - samples.recip()).powi(count)).sqrt();
            for (level, whole) in detector.levels().zip([one, other]) {
                prop_assert!((level - share * whole).abs() < 1e-9 * whole, "{level} {share} {whole}");
            }
            prop_assert_eq!(detector.best(), usize::from(margin * other < one));
            Stage::<f64>::reset(&mut detector);
            prop_assert_eq!((detector.best(), detector.levels().sum::<f64>().to_bits()), (0, 0));
        }
    }
}
