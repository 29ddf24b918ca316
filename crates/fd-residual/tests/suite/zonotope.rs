//! Sets of states: the truth never leaves them, and reductions only make them larger.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a failure here is a failed test")]

use crate::common::{Draw, draws, plant, random_matrix, rng, sampled};
use faer::{Mat, MatRef, mat};
use fd_core::{Frame, Scalar, stage::ResidualGenerator};
use fd_model::{Discrete, StateSpace};
use fd_residual::{
    DesignError,
    observer::ObserverDesign,
    zonotope::{Bounds, ModelBounds, Zonotope, ZonotopeDesign},
};
use proptest::prelude::*;
use rand::RngExt;
use rand_xoshiro::Xoshiro256PlusPlus;

/// What rounding may do to sums of some hundred terms.
const ROUNDING: f64 = 1e-9;

fn magnitudes(m: MatRef<'_, f64>, share: f64) -> Mat<f64> {
    Mat::from_fn(m.nrows(), m.ncols(), |i, j| share * m[(i, j)].abs())
}

/// Bounds of every kind; the model is off by a share of each entry.
fn bounds(model: &StateSpace<Discrete>, share: f64, seed: u64) -> Bounds {
    let model_bounds = ModelBounds {
        a: magnitudes(model.a(), share),
        b: magnitudes(model.b(), share),
        c: magnitudes(model.c(), share),
        d: magnitudes(model.d(), share),
    };
    Bounds {
        disturbance: random_matrix(&mut rng(seed), model.nx(), 2),
        noise: vec![0.3; model.ny()],
        initial: Some(vec![1.0; model.nx()]),
        model: model_bounds,
    }
}

/// A number between -1 and 1, as often as not at one of the ends, where bounds are tried hardest.
fn extreme(random: &mut Xoshiro256PlusPlus) -> f64 {
    let drawn: f64 = random.random_range(-1.0..1.0);
    if random.random_bool(0.5) { drawn.signum() } else { drawn }
}

fn times(m: MatRef<'_, f64>, v: &[f64]) -> Vec<f64> {
    (0..m.nrows()).map(|i| (0..m.ncols()).map(|j| m[(i, j)] * v[j]).sum()).collect()
}

/// One plant within the bounds that is another one at each sample.
struct Truth<'a> {
    model: &'a StateSpace<Discrete>,
    bounds: &'a Bounds,
    x: Vec<f64>,
    random: Xoshiro256PlusPlus,
}

impl Truth<'_> {
    /// Input and outputs of a sample; the state is that of the next one. Errors of the size of `size` bounds.
    fn step(&mut self, size: f64) -> (Vec<f64>, Vec<f64>) {
        let (m, b) = (self.model, &self.bounds.model);
        let random = &mut self.random;
        let mut off = |nominal: MatRef<'_, f64>, bound: &Mat<f64>| {
            Mat::from_fn(bound.nrows(), bound.ncols(), |i, j| {
                nominal[(i, j)] + size * bound[(i, j)] * extreme(random)
            })
        };
        let (a, c) = (off(m.a(), &b.a), off(m.c(), &b.c));
        let (b, d) = (off(m.b(), &b.b), off(m.d(), &b.d));
        let u: Vec<f64> = (0..m.nu()).map(|_| extreme(random)).collect();
        let w: Vec<f64> =
            (0..self.bounds.disturbance.ncols()).map(|_| size * extreme(random)).collect();
        let v = self.bounds.noise.iter().map(|bound| size * bound * extreme(random));
        let sum = |parts: &[Vec<f64>], i: usize| parts.iter().map(|part| part[i]).sum::<f64>();
        let seen = [times(c.as_ref(), &self.x), times(d.as_ref(), &u), v.collect()];
        let y = (0..m.ny()).map(|i| sum(&seen, i)).collect();
        let driven = [
            times(a.as_ref(), &self.x),
            times(b.as_ref(), &u),
            times(self.bounds.disturbance.as_ref(), &w),
        ];
        self.x = (0..m.nx()).map(|i| sum(&driven, i)).collect();
        (u, y)
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, max_global_rejects: 48, ..ProptestConfig::default() })]

    /// A plant that stays within the bounds stays within the set, and its residuals within ±1.
    #[test]
    fn the_truth_never_leaves_the_set(
        draw in draws(), share in 0.0..0.02_f64, order in 2..12_usize, exact in any::<bool>(),
    ) {
        let model = plant(Draw { radius: draw.radius.min(0.8), ..draw });
        let bounds = bounds(&model, if exact { 0.0 } else { share }, draw.seed ^ 1);
        let observer = ObserverDesign::kalman(&model, 1.0, 0.1).unwrap();
        let design = match ZonotopeDesign::new(observer, bounds.clone(), order * draw.nx) {
            // Plants that hardly show a state under much uncertainty; too many of them fail the test.
            Err(DesignError::Unbounded { .. }) => return Err(TestCaseError::reject("no bound")),
            design => design.unwrap(),
        };
        let mut running = design.freeze::<f64>().unwrap();
        let mut random = rng(draw.seed ^ 2);
        let x = (0..draw.nx).map(|_| extreme(&mut random)).collect();
        let mut truth = Truth { model: &model, bounds: &bounds, x, random };
        let mut r = vec![0.0; draw.ny];
        for k in 0..150 {
            let (u, y) = truth.step(1.0);
            running.step(Frame::new(running.io(), k, &u, &y).unwrap(), &mut r);
            for r in &r {
                prop_assert!(r.abs() <= 1.0 + ROUNDING, "{r} at sample {k}");
            }
            let set = running.states();
            prop_assert!(set.len() <= order * draw.nx);
            for direction in random_matrix(&mut truth.random, 8, draw.nx).row_iter() {
                let direction: Vec<f64> = direction.iter().copied().collect();
                let far: f64 = (0..draw.nx)
                    .map(|i| direction[i] * (truth.x[i] - set.centre()[i]))
                    .sum();
                let most = set.half_width(&direction);
                prop_assert!(far.abs() <= most * (1.0 + ROUNDING), "{far} of {most} at {k}");
            }
        }
    }

    /// A reduction contains what it reduces, in every direction, and keeps to its limit.
    #[test]
    fn a_reduced_set_contains_the_set(
        n in 1..6_usize, count in 1..40_usize, room in 0..20_usize, seed in any::<u64>(),
    ) {
        let mut random = rng(seed);
        let mut set = Zonotope::<f64>::of_box(&vec![0.5; n], &vec![0.0; n], n + 40).unwrap();
        for _ in 0..count {
            let column: Vec<f64> = (0..n).map(|_| random.random_range(-1.0..1.0)).collect();
            set.add(&column);
        }
        let before = set.clone();
        set.reduce(n + room);
        prop_assert!(set.len() <= n + room && set.centre() == before.centre());
        if count <= n + room {
            prop_assert_eq!(&set, &before);
        }
        for direction in random_matrix(&mut random, 40, n).row_iter() {
            let direction: Vec<f64> = direction.iter().copied().collect();
            let (inner, outer) = (before.half_width(&direction), set.half_width(&direction));
            prop_assert!(inner <= outer * (1.0 + ROUNDING), "{inner} {outer}");
        }
        // Along the coordinates a reduction loses nothing.
        for i in 0..n {
            prop_assert!((set.radius(i) - before.radius(i)).abs() <= ROUNDING * before.radius(i));
        }
    }

    /// With room for every column the half widths are sums over impulse responses,
    /// `Σ_j |C_i (A − L C)^j [E, L σ]| + |C_i (A − L C)^k| x₀ + σ_i`; with less room they are not smaller.
    #[test]
    fn without_reduction_the_bounds_are_exact(draw in draws()) {
        let model = plant(Draw { radius: draw.radius.min(0.8), ..draw });
        let bounds = bounds(&model, 0.0, draw.seed ^ 1);
        let observer = ObserverDesign::kalman(&model, 1.0, 0.1).unwrap();
        let gain = observer.gain().to_owned();
        let exact = ZonotopeDesign::new(observer.clone(), bounds.clone(), 400).unwrap();
        // Boxes that are turned and boxed again may grow without end where the set itself does not.
        let coarse = ZonotopeDesign::new(observer, bounds.clone(), 4 * draw.nx).ok();
        let mut exact = exact.freeze::<f64>().unwrap();
        let mut coarse = coarse.map(|design| design.freeze::<f64>().unwrap());
        let closed = model.a() - &gain * model.c();
        let enters = Mat::from_fn(draw.nx, 2 + draw.ny, |i, j| {
            if j < 2 { bounds.disturbance[(i, j)] } else { gain[(i, j - 2)] * bounds.noise[j - 2] }
        });
        let (u, y, mut r) = (vec![0.7; draw.nu], vec![0.3; draw.ny], vec![0.0; draw.ny]);
        let mut power = Mat::<f64>::identity(draw.nx, draw.nx);
        let mut sums = bounds.noise.clone();
        for k in 0..30 {
            for running in std::iter::once(&mut exact).chain(&mut coarse) {
                running.step(Frame::new(running.io(), k, &u, &y).unwrap(), &mut r);
            }
            let from_start = model.c() * &power;
            for i in 0..draw.ny {
                let start: f64 = (0..draw.nx).map(|j| from_start[(i, j)].abs()).sum();
                let (expected, found) = (sums[i] + start, exact.half_widths()[i]);
                prop_assert!((found - expected).abs() < ROUNDING * expected, "{found} {expected}");
                if let Some(coarse) = &coarse {
                    prop_assert!(expected <= coarse.half_widths()[i] * (1.0 + ROUNDING));
                }
            }
            let response = &from_start * &enters;
            for (i, sum) in sums.iter_mut().enumerate() {
                *sum += (0..response.ncols()).map(|j| response[(i, j)].abs()).sum::<f64>();
            }
            power = power * &closed;
        }
    }
}

/// The example of Alamo, Bravo and Camacho (2005): one uncertain entry, one disturbance, one noisy output.
fn alamo() -> (StateSpace<Discrete>, Bounds) {
    let (a, c) = (mat![[0.0, -0.5], [1.0, 1.0]], mat![[-2.0, 1.0]]);
    let model = StateSpace::new(a, Mat::zeros(2, 1), c, Mat::zeros(1, 1), sampled()).unwrap();
    let mut off = ModelBounds::exact(&model);
    off.a[(1, 1)] = 0.3;
    let bounds = Bounds {
        disturbance: mat![[-0.12], [0.02]],
        noise: vec![0.2],
        initial: Some(vec![3.0; 2]),
        model: off,
    };
    (model, bounds)
}

fn alamo_design(columns: usize) -> Result<ZonotopeDesign, DesignError> {
    let (model, bounds) = alamo();
    ZonotopeDesign::new(ObserverDesign::kalman(&model, 1.0, 1.0).unwrap(), bounds, columns)
}

#[test]
fn the_published_example_is_followed() {
    let (model, bounds) = alamo();
    let design = alamo_design(20).unwrap();
    let mut running = design.freeze::<f64>().unwrap();
    for seed in 0..40 {
        let mut random = rng(seed);
        let x = (0..2).map(|_| 3.0 * extreme(&mut random)).collect();
        let mut truth = Truth { model: &model, bounds: &bounds, x, random };
        let mut r = [0.0];
        fd_core::stage::Stage::reset(&mut running);
        for k in 0..100 {
            let (u, y) = truth.step(1.0);
            running.step(Frame::new(running.io(), k, &u, &y).unwrap(), &mut r);
            assert!(r[0].abs() <= 1.0 + ROUNDING, "{r:?} at {k} of {seed}");
        }
        // The start is forgotten: what is left is far smaller than the box of 3 that it began with.
        let set = running.states();
        assert!(set.radius(0).max(set.radius(1)) < 1.5, "{} {}", set.radius(0), set.radius(1));
    }
}

/// What no plant within the bounds does is above one, and in single precision too.
#[test]
fn what_the_bounds_do_not_explain_is_seen() {
    let (model, bounds) = alamo();
    let design = alamo_design(20).unwrap();
    let mut running = design.freeze::<f32>().unwrap();
    let mut truth = Truth { model: &model, bounds: &bounds, x: vec![0.0; 2], random: rng(1) };
    let mut r = [0.0_f32];
    let mut first = None;
    for k in 0..100 {
        let (u, y) = truth.step(1.0);
        // More than twice what the set explains at rest, whatever the disturbances are at that sample.
        let fault = if k < 60 { 0.0 } else { 2.5 * design.settled()[0] };
        let (u, y) = ([f32::from_design(u[0])], [f32::from_design(y[0] + fault)]);
        running.step(Frame::new(running.io(), k, &u, &y).unwrap(), &mut r);
        if 1.0 < r[0].abs() && first.is_none() {
            first = Some(k);
        }
    }
    assert_eq!(first, Some(60));
}

#[test]
fn what_has_no_bound_is_refused() {
    // A lag whose pole may be anywhere between 0.7 and 1.1.
    let lag = StateSpace::new(mat![[0.9]], mat![[1.0]], mat![[1.0]], mat![[0.0]], sampled());
    let lag = lag.unwrap();
    let mut off = ModelBounds::exact(&lag);
    off.a[(0, 0)] = 0.2;
    let of = |gain: f64, noise: f64, off: &ModelBounds, columns: usize| {
        let observer = ObserverDesign::with_gain(&lag, mat![[gain]].as_ref()).unwrap();
        let bounds = Bounds {
            disturbance: mat![[0.1]],
            noise: vec![noise],
            initial: None,
            model: off.clone(),
        };
        ZonotopeDesign::new(observer, bounds, columns)
    };
    let error = of(0.0, 0.1, &off, 8).unwrap_err();
    assert!(matches!(error, DesignError::Unbounded { .. }), "{error}");
    // An observer that looks at the output bounds it: 0.4 + 0.2 < 1.
    assert!(of(0.5, 0.1, &off, 8).is_ok());
    assert!(of(0.5, 0.0, &off, 8).unwrap_err().to_string().contains("bound of noise"));
    assert!(of(0.5, 0.1, &off, usize::MAX).is_err());
    assert!(matches!(of(0.5, 0.1, &off, 0), Err(DesignError::Count { expected: 1, .. })));
    off.a[(0, 0)] = -0.2;
    assert!(of(0.5, 0.1, &off, 8).unwrap_err().to_string().contains("bound of A"));
}

/// The error of `e⁺ = 0.998 e + w`, `|w| ≤ 0.1`, that no gain corrects is within `0.1/(1 − 0.998)`, after some 7000 samples.
#[test]
fn a_slow_set_is_followed_to_its_end() {
    let lag = StateSpace::new(mat![[0.998]], mat![[1.0]], mat![[1.0]], mat![[0.0]], sampled());
    let lag = lag.unwrap();
    let model = ModelBounds::exact(&lag);
    let bounds = Bounds { disturbance: mat![[0.1]], noise: vec![0.3], initial: None, model };
    let observer = ObserverDesign::with_gain(&lag, mat![[0.0]].as_ref()).unwrap();
    let design = ZonotopeDesign::new(observer, bounds, 8).unwrap();
    // A growth below 1e-6 in a tenth of the time leaves little more than that.
    assert!((design.settled()[0] / 50.3 - 1.0).abs() < 3e-6, "{:?}", design.settled());
}
