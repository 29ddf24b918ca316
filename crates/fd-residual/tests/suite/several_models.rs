//! One residual for many models, and one that follows an operating variable.
#![allow(clippy::unwrap_used, reason = "a failure here is a failed test")]

use crate::common::{
    Draw, draws, peak, plant, random_matrix, residuals, rng, sampled, signal, simulate,
};
use faer::{Mat, Scale, mat};
use fd_core::{
    Frame,
    stage::{ResidualGenerator, Stage},
    testing::memory,
};
use fd_model::{Discrete, StateSpace};
use fd_residual::{
    DesignError, GeneratorDesign,
    analysis::UnknownInputs,
    model_detection::PlantModel,
    observer::ObserverDesign,
    robust::{FaultShape, RobustDesign, RobustWindow},
    scheduled::{ScheduledDesign, ScheduledObserver, ScheduledPoint, SchedulingVariable},
};
use proptest::prelude::*;

/// Plants near a drawn one, with noise on the outputs, and the faults of all sensors.
fn family(draw: Draw, count: u64, spread: f64) -> (Vec<PlantModel>, Vec<UnknownInputs>) {
    let nominal = plant(Draw { radius: draw.radius.min(0.85), ..draw });
    let one = |k: u64| {
        let mut rng = rng(draw.seed ^ (k + 1));
        let near = |m: faer::MatRef<'_, f64>, rng: &mut _| {
            m + Scale(spread * m.norm_l2() / (m.nrows().max(1) as f64))
                * random_matrix(rng, m.nrows(), m.ncols())
        };
        let (a, b) = (near(nominal.a(), &mut rng), near(nominal.b(), &mut rng));
        let (c, d) = (nominal.c().to_owned(), nominal.d().to_owned());
        let model = StateSpace::new(a, b, c, d, nominal.domain()).unwrap();
        let none = UnknownInputs::none(&model);
        let sensors = (0..model.ny()).fold(none, |all, i| all.sensor(&model, i).unwrap());
        let noise = Scale(0.01) * Mat::<f64>::identity(model.ny(), model.ny());
        let noise = UnknownInputs::new("v", Mat::zeros(model.nx(), model.ny()), noise).unwrap();
        (PlantModel::new("", model).with_noise(noise), sensors)
    };
    (0..count).map(one).unzip()
}

const WINDOW: RobustWindow = RobustWindow { order: 3, shape: FaultShape::Lasting };

/// With the mean of one model, everything in closed form: a static plant `y = g u + v` and a fault of the sensor. The window
/// `[y; u]` has the covariance `[g² + σ², g; g, 1]` and the fault `[1, 0; 0, 0]`, so the best row is `y − g u` over `σ`, with
/// the quotient `1/σ²`.
#[test]
fn the_best_row_of_one_model_is_known() {
    let (g, sigma) = (3.0, 0.1);
    let plant = StateSpace::gain(mat![[g]], sampled()).unwrap();
    let faults = UnknownInputs::none(&plant).sensor(&plant, 0).unwrap();
    let noise = UnknownInputs::new("v", Mat::zeros(0, 1), mat![[sigma]]).unwrap();
    let models = [PlantModel::new("", plant).with_noise(noise)];
    let window = RobustWindow { order: 0, shape: FaultShape::White };
    for design in [
        RobustDesign::average(&models, std::slice::from_ref(&faults), window, 1).unwrap(),
        RobustDesign::worst(&models, std::slice::from_ref(&faults), window).unwrap(),
    ] {
        let form = design.form().unwrap();
        let d = form.system().d();
        // The condition of the covariance is g²/σ² = 1e3.
        assert!((d[(0, 0)] / d[(0, 1)] + g).abs() < 1e-9);
        assert!((design.worst_over_models() * sigma * sigma - 1.0).abs() < 1e-9);
        assert!((design.fault_rms()[0] * sigma - 1.0).abs() < 1e-9);
    }
}

/// Two gains, 1 and 3, and no noise to speak of: for `w = [1, −h]` the healthy variances are `(1 − h)²` and `(3 − h)²` of `u`,
/// so the worst case is least at `h = 2` with 1, and the average at `h = 2` too; with a third model at 3 the average moves
/// to `h = 7/3`, the worst case stays.
#[test]
fn the_worst_case_is_not_the_average() {
    let sigma = 1e-3;
    let family = |gains: &[f64]| -> (Vec<_>, Vec<_>) {
        let one = |&g: &f64| {
            let plant = StateSpace::gain(mat![[g]], sampled()).unwrap();
            let faults = UnknownInputs::none(&plant).sensor(&plant, 0).unwrap();
            let noise = UnknownInputs::new("v", Mat::zeros(0, 1), mat![[sigma]]).unwrap();
            (PlantModel::new("", plant).with_noise(noise), faults)
        };
        gains.iter().map(one).unzip()
    };
    let window = RobustWindow { order: 0, shape: FaultShape::White };
    let (models, faults) = family(&[1.0, 3.0, 3.0]);
    let slope = |design: &RobustDesign| {
        let form = design.form().unwrap();
        -form.system().d()[(0, 0)] / form.system().d()[(0, 1)]
    };
    let average = RobustDesign::average(&models, &faults, window, 1).unwrap();
    assert!((slope(&average) - 7.0 / 3.0).abs() < 1e-6, "{}", slope(&average));
    let worst = RobustDesign::worst(&models, &faults, window).unwrap();
    let case = worst.worst_case().unwrap();
    // 1/(1 + σ²); the search comes as near as its steps are small.
    assert!((slope(&worst) - 2.0).abs() < 0.02, "{}", slope(&worst));
    assert!(0.98 < case.achieved && case.achieved <= 1.0 && case.bound < 1.02, "{case:?}");
    assert!((average.worst_over_models() - 9.0 / 16.0).abs() < 1e-4);
    // The loudest healthy model, with a gain of 1, is 4/3 from 7/3; a fault of the sensor is the same for all.
    assert_eq!(average.fault_rms().len(), 3);
    assert!(average.fault_rms().iter().all(|rms| (rms - 0.75).abs() < 1e-4), "{average:?}");
}

#[test]
fn nonsense_is_refused() {
    let draw = Draw { nx: 2, nu: 1, ny: 1, radius: 0.8, seed: 1 };
    let (models, faults) = family(draw, 2, 0.05);
    let refused = RobustDesign::average(&[], &[], WINDOW, 1).unwrap_err();
    assert!(matches!(refused, DesignError::Empty { what: "model" }));
    let refused = RobustDesign::average(&models, &faults[..1], WINDOW, 1).unwrap_err();
    assert!(matches!(refused, DesignError::Count { .. }));
    assert!(RobustDesign::average(&models, &faults, WINDOW, 9).is_err());
    let unstable =
        StateSpace::new(mat![[1.1]], mat![[1.0]], mat![[1.0]], mat![[0.0]], sampled()).unwrap();
    let fault = UnknownInputs::none(&unstable).sensor(&unstable, 0).unwrap();
    let refused = RobustDesign::worst(&[PlantModel::new("", unstable)], &[fault], WINDOW);
    assert!(matches!(refused, Err(DesignError::Model(_))));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    /// The worst case lies between what the average design has and what no row exceeds; what a design says of itself is what
    /// its residual does on each of the models.
    #[test]
    fn designs_for_a_family_keep_their_word(draw in draws()) {
        let (models, faults) = family(draw, 4, 0.05);
        let average = RobustDesign::average(&models, &faults, WINDOW, 1).unwrap();
        let worst = RobustDesign::worst(&models, &faults, WINDOW).unwrap();
        let case = worst.worst_case().unwrap();
        // The search begins with the average.
        // Where the bound is reached, both are one number by two roads, through a covariance whose condition is up to 1e6.
        prop_assert!(average.worst_over_models() <= case.achieved * (1.0 + 1e-7));
        prop_assert!(case.achieved <= case.bound * (1.0 + 1e-7), "{case:?}");
        // Measured on white inputs and noise: 4000 samples that are correlated over a handful.
        for (m, model) in models.iter().enumerate() {
            let uniform = 3.0_f64.sqrt();
            let scaled = |seed, width| -> Vec<Vec<f64>> {
                let all = signal(seed, width, 4000).into_iter();
                all.map(|v| v.into_iter().map(|v| v * uniform).collect()).collect()
            };
            let (u, v) = (scaled(draw.seed ^ 0x11, draw.nu), scaled(draw.seed ^ 0x12, draw.ny));
            let mut y = simulate(model.plant(), &vec![0.0; draw.nx], &u);
            for (y, v) in y.iter_mut().zip(&v) {
                y.iter_mut().zip(v).for_each(|(y, v)| *y += 0.01 * v);
            }
            let r = residuals(&mut *worst.build().unwrap(), &u, &y);
            let rms = (r[200..].iter().map(|r| r[0] * r[0]).sum::<f64>() / 3800.0).sqrt();
            let expected = worst.healthy_rms()[m];
            prop_assert!((rms / expected - 1.0).abs() < 0.35, "{rms} {expected}");
        }
    }
}

/// Models along a line between two random ones, in coordinates that they share.
fn line(draw: Draw, count: usize) -> Vec<ScheduledPoint> {
    let [p, q] = [0, 1].map(|k| plant(Draw { seed: draw.seed ^ k, ..draw }));
    // Not far from each other, so that a convex combination is as stable as its ends.
    let mix = |a: faer::MatRef<'_, f64>, b: faer::MatRef<'_, f64>, t: f64| a + Scale(0.1 * t) * b;
    let point = |k: usize| {
        let t = k as f64 / (count - 1) as f64;
        let model = StateSpace::new(
            Scale(0.8) * mix(p.a(), q.a(), t),
            mix(p.b(), q.b(), t),
            mix(p.c(), q.c(), t),
            mix(p.d(), q.d(), t),
            p.domain(),
        );
        let mut rng = rng(draw.seed ^ 0x77);
        let steady = |n: usize, rng: &mut _| -> Vec<f64> {
            let all = random_matrix(rng, n, 1);
            (0..n).map(|i| t * all[(i, 0)]).collect()
        };
        let x0 = steady(draw.nx, &mut rng);
        let u0 = steady(draw.nu, &mut rng);
        let y0 = steady(draw.ny, &mut rng);
        ScheduledPoint { at: t, model: model.unwrap(), x0, u0, y0 }
    };
    (0..count).map(point).collect()
}

const FIRST_INPUT: SchedulingVariable = SchedulingVariable::Input { index: 0, smoothing: 0.0 };

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// On a single point about zero it is the observer, to rounding; between points it is that of the interpolated model.
    #[test]
    fn a_scheduled_observer_is_the_local_one(draw in draws(), share in 0.0..1.0_f64) {
        let model = plant(draw);
        let one = ScheduledPoint::about_zero(0.0, model.clone());
        let design = ScheduledDesign::kalman(vec![one], FIRST_INPUT, 1.0, 1.0).unwrap();
        let (u, y) = (signal(draw.seed ^ 1, draw.nu, 60), signal(draw.seed ^ 2, draw.ny, 60));
        prop_assert_eq!((design.residual_len(), design.freeze().residual_len()), (draw.ny, draw.ny));
        let r = residuals(&mut design.freeze(), &u, &y);
        let plain = ObserverDesign::kalman(&model, 1.0, 1.0).unwrap();
        let expected = residuals(&mut *plain.build().unwrap(), &u, &y);
        prop_assert!(crate::common::distance(&r, &expected) < 1e-11 * (1.0 + peak(&expected)));

        // With the variable held, the form at that value computes the deviations from its steady state.
        let points: Vec<_> = line(draw, 3).into_iter().map(|p| ScheduledPoint::about_zero(p.at, p.model)).collect();
        let design = ScheduledDesign::kalman(points, FIRST_INPUT, 1.0, 1.0).unwrap();
        let held: Vec<Vec<f64>> = u.iter().map(|u| [&[share], &u[1..]].concat()).collect();
        let r = residuals(&mut design.freeze(), &held, &y);
        let form = design.form_at(share).unwrap();
        let expected = simulate(form.system(), &vec![0.0; draw.nx], &crate::common::joined(&held, &y));
        prop_assert!(crate::common::distance(&r, &expected) < 1e-11 * (1.0 + peak(&expected)));
    }

    /// Bumpless: when the variable passes a grid point, the residual moves as little as the variable does.
    #[test]
    fn passing_a_grid_point_makes_no_bump(draw in draws()) {
        let design = ScheduledDesign::kalman(line(draw, 3), FIRST_INPUT, 1.0, 1.0).unwrap();
        let (u, y) = (signal(draw.seed ^ 1, draw.nu, 40), signal(draw.seed ^ 2, draw.ny, 40));
        let at = |value: f64| {
            let held: Vec<Vec<f64>> = u.iter().map(|u| [&[value], &u[1..]].concat()).collect();
            residuals(&mut design.freeze(), &held, &y).pop().unwrap()
        };
        let step = 1e-7;
        let (below, above) = (at(0.5 - step), at(0.5 + step));
        let jump = below.iter().zip(&above).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        // Slopes of the interpolation are moderate, sums are over 40 samples.
        prop_assert!(jump < 1e4 * step, "{jump:e}");
    }

    /// In a steady state of the grid, or between two, there is no residual: at once in the one that it begins in, and
    /// again after a reset, later in all others.
    #[test]
    fn a_steady_state_leaves_no_residual(draw in draws(), share in 0.0..1.0_f64) {
        let mut points = line(draw, 3);
        for point in &mut points {
            let steady = [&mut point.x0, &mut point.u0, &mut point.y0];
            steady.into_iter().flatten().for_each(|v| *v += 1.0);
            point.u0[0] = point.at;
        }
        let between = |of: fn(&ScheduledPoint) -> &Vec<f64>, share: f64| -> Vec<f64> {
            let (low, rest) = if share < 0.5 { (0, 2.0 * share) } else { (1, 2.0 * share - 1.0) };
            let pairs = of(&points[low]).iter().zip(of(&points[low + 1]));
            pairs.map(|(low, high)| low + rest * (high - low)).collect()
        };
        let mut observer = ScheduledDesign::kalman(points.clone(), FIRST_INPUT, 1.0, 1.0).unwrap().freeze();
        let after = |observer: &mut ScheduledObserver, share: f64, samples: usize| {
            let (u, y) = (between(|p| &p.u0, share), between(|p| &p.y0, share));
            peak(&residuals(observer, &vec![u; samples], &vec![y; samples])[samples - 1..])
        };
        prop_assert!(after(&mut observer, 0.0, 1) < 1e-13);
        prop_assert!(after(&mut observer, share, 500) < 1e-9);
        observer.reset();
        prop_assert!(after(&mut observer, 0.0, 1) < 1e-13);
    }

    /// The scheduling variable is the first value, and from then on a low-pass of the stated time constant.
    #[test]
    fn the_scheduling_variable_is_a_low_pass(smoothing in 0.0..20.0_f64, samples in 1..60_i32) {
        let model = plant(Draw { nx: 1, nu: 1, ny: 1, radius: 0.5, seed: 1 });
        let variable = SchedulingVariable::Input { index: 0, smoothing };
        let point = ScheduledPoint::about_zero(0.0, model);
        let mut observer = ScheduledDesign::kalman(vec![point], variable, 1.0, 1.0).unwrap().freeze();
        let mut step = |k: u64, u: f64| {
            let io = observer.io();
            observer.step(Frame::new(io, k, &[u], &[0.0]).unwrap(), &mut [0.0]);
            observer.value()
        };
        prop_assert_eq!(step(0, 3.0).to_bits(), 3.0_f64.to_bits());
        let last = (0..samples).map(|_| step(1, 1.0)).last().unwrap();
        let expected = 1.0 + 2.0 * (smoothing / (1.0 + smoothing)).powi(samples);
        prop_assert!((last - expected).abs() < 1e-12, "{last} {expected}");
    }

    /// The law of memory.
    #[test]
    fn a_scheduled_observer_keeps_its_memory(draw in draws()) {
        let smooth = SchedulingVariable::Output { index: 0, smoothing: 3.0 };
        let design = ScheduledDesign::kalman(line(draw, 4), smooth, 1.0, 1.0).unwrap();
        let (u, y) = (signal(draw.seed ^ 1, draw.nu, 60), signal(draw.seed ^ 2, draw.ny, 60));
        let mut r = vec![0.0; draw.ny];
        memory(&mut design.freeze(), &mut design.freeze(), 25, |observer, k| {
            let frame = Frame::new(observer.io(), k as u64, &u[k], &y[k]).unwrap();
            observer.step(frame, &mut r);
            r.iter().map(|v| v.to_bits()).collect::<Vec<_>>()
        });
    }
}

#[test]
fn grids_are_checked() {
    let model = |a: f64| -> StateSpace<Discrete> {
        StateSpace::new(mat![[a]], mat![[1.0]], mat![[1.0]], mat![[0.0]], sampled()).unwrap()
    };
    let point = |at: f64, a: f64| ScheduledPoint::about_zero(at, model(a));
    let design = |points| ScheduledDesign::kalman(points, FIRST_INPUT, 1.0, 1.0);
    assert!(matches!(design(vec![]), Err(DesignError::Empty { .. })));
    assert!(design(vec![point(1.0, 0.5), point(0.0, 0.6)]).is_err());
    assert!(design(vec![point(0.0, 0.5), point(1.0, 0.6)]).unwrap().any_speed());
    let elsewhere = SchedulingVariable::Output { index: 1, smoothing: 0.0 };
    assert!(ScheduledDesign::kalman(vec![point(0.0, 0.5)], elsewhere, 1.0, 1.0).is_err());
    // Stable at both ends and not between: [[0.5, 2], [2, 0.5]] has the eigenvalue 2.5.
    let coupled = |at: f64, up: f64, down: f64| {
        let a = mat![[0.5, up], [down, 0.5]];
        let (b, c) = (mat![[0.0], [0.0]], mat![[0.0, 0.0]]);
        let model = StateSpace::new(a, b, c, mat![[0.0]], sampled()).unwrap();
        ScheduledPoint::about_zero(at, model)
    };
    let points = vec![coupled(0.0, 4.0, 0.0), coupled(1.0, 0.0, 4.0)];
    let gains = vec![Mat::zeros(2, 1); 2];
    let refused = ScheduledDesign::with_gains(points, gains, FIRST_INPUT).unwrap_err();
    assert!(
        matches!(refused, DesignError::Model(fd_model::ModelError::Unstable { .. })),
        "{refused}"
    );
}
