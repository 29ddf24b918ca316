//! Laws that every generator of this crate obeys, on random stable plants.
#![allow(clippy::unwrap_used, reason = "a failure here is a failed test")]

use crate::common::{
    Draw, distance, draws, joined, peak, plant, plus, residuals, sampled, signal, simulate,
};
use faer::{Mat, MatRef, mat};
use fd_core::{
    Fixed, Frame, Heap, HeapMap, Scalar, Storage,
    stage::{ResidualGenerator, Stage},
    testing::{memory, reset_and_restore},
};
use fd_model::{Discrete, StateSpace};
use fd_residual::{
    GeneratorDesign,
    bank::Bank,
    observer::ObserverDesign,
    parity::{FixedWindow, ParityDesign},
    simulation::SimulationDesign,
    testing::{Example, every_generator},
    weighted::{FilteredDesign, WeightedDesign},
};
use proptest::prelude::*;

/// Every generator that exists for this plant.
fn designs(model: &StateSpace<Discrete>) -> Vec<(&'static str, usize, Box<dyn GeneratorDesign>)> {
    let of = |example: Example| Some((example.name, example.wait, example.design.ok()?));
    every_generator(model).into_iter().filter_map(of).collect()
}

/// Every generator that exists for this plant and does not learn while it runs.
fn constant(model: &StateSpace<Discrete>) -> Vec<(&'static str, usize, Box<dyn GeneratorDesign>)> {
    let adapts: Vec<_> =
        every_generator(model).into_iter().filter(|e| e.adapts).map(|e| e.name).collect();
    designs(model).into_iter().filter(|design| !adapts.contains(&design.0)).collect()
}

/// A list that quietly loses its members proves nothing: a good plant allows them all, and the plants of
/// these tests all those that ask for no more outputs than there are.
#[test]
fn every_generator_exists_for_a_good_plant() {
    let a = mat![[0.9, 0.1, 0.0], [-0.1, 0.8, 0.05], [0.0, 0.1, 0.7]];
    let b = mat![[0.1], [0.2], [0.3]];
    let good = StateSpace::new(a, b, Mat::identity(3, 3), Mat::zeros(3, 1), sampled()).unwrap();
    for example in every_generator(&good) {
        assert!(example.design.is_ok(), "{example:?}");
    }
    let single = plant(Draw { nx: 4, nu: 1, ny: 1, radius: 0.8, seed: 3 });
    let missing: Vec<_> = every_generator(&single)
        .into_iter()
        .filter(|e| e.design.is_err())
        .map(|e| e.name)
        .collect();
    assert_eq!(missing, ["unknown-input", "decoupled", "eigenstructure", "directional"]);
}

/// Size of what goes through the states of a generator, where it may cancel: rounding is relative to that.
fn through(system: &StateSpace<Discrete>) -> f64 {
    let largest = |m: MatRef<'_, f64>| {
        (0..m.ncols())
            .flat_map(|j| (0..m.nrows()).map(move |i| m[(i, j)].abs()))
            .fold(0.0, f64::max)
    };
    largest(system.b()) * largest(system.c()) * system.nx() as f64
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// Eq. (5): `H_u + H_y G_u = 0`.
    #[test]
    fn inputs_do_not_reach_the_residual(draw in draws()) {
        let model = plant(draw);
        for (name, _, design) in designs(&model) {
            // Two resolvents of radius <= 0.95 (cond <= ~1e4 for these sizes) cost 1e4 n eps.
            let defect = design.form().unwrap().consistency(&model).unwrap();
            prop_assert!(defect < 1e-10, "{defect:e} for {name}");
            // The generator of another plant does not pass this check.
            let other = plant(Draw { seed: draw.seed ^ 8, ..draw });
            let defect = design.form().unwrap().consistency(&other).unwrap();
            prop_assert!(1e-3 < defect, "{defect:e} for {name}");
        }
    }

    /// The residual of a healthy plant dies out whatever its initial state was.
    #[test]
    fn a_healthy_plant_shows_no_residual(draw in draws()) {
        // At radius 0.9 every transient is below 0.9^600 = 4e-28 of its start; observers are faster.
        let model = plant(Draw { radius: draw.radius.min(0.9), ..draw });
        let u = signal(draw.seed ^ 1, draw.nu, 700);
        let x0 = signal(draw.seed ^ 2, draw.nx, 1).remove(0);
        let y = simulate(&model, &x0, &u);
        for (name, _, design) in constant(&model) {
            let r = residuals(&mut *design.build().unwrap(), &u, &y);
            // Rounding of sums of some ten terms of the size of y, filtered by a gain of up to 100.
            prop_assert!(peak(&r[600..]) < 1e-11 * (1.0 + peak(&y)), "{name}");
        }
    }

    /// What runs is what was designed.
    #[test]
    fn a_generator_computes_its_form(draw in draws()) {
        let model = plant(draw);
        let (u, y) = (signal(draw.seed ^ 1, draw.nu, 60), signal(draw.seed ^ 2, draw.ny, 60));
        for (name, wait, design) in constant(&model) {
            let system = design.form().unwrap().system().clone();
            let expected = simulate(&system, &vec![0.0; system.nx()], &joined(&u, &y));
            let mut generator = design.build().unwrap();
            prop_assert_eq!(generator.residual_len(), design.residual_len());
            prop_assert_eq!(generator.io(), design.io());
            let r = residuals(&mut *generator, &u, &y);
            let error = distance(&r[wait..], &expected[wait..]);
            // 60 steps of stable recursions in two orders of summation.
            let size = 1.0 + peak(&expected) + through(&system);
            prop_assert!(error < 1e-11 * size, "{error:e} of {size:e} for {name}");
        }
    }

    /// Faults add their own response `H_y f` to the residual of the healthy plant.
    #[test]
    fn faults_superpose(draw in draws()) {
        let model = plant(draw);
        let u = signal(draw.seed ^ 1, draw.nu, 60);
        let y = simulate(&model, &vec![0.3; draw.nx], &u);
        let fault = signal(draw.seed ^ 2, draw.ny, 60);
        for (name, wait, design) in constant(&model) {
            let hy = design.form().unwrap().hy().unwrap();
            let effect = simulate(&hy, &vec![0.0; hy.nx()], &fault);
            let healthy = residuals(&mut *design.build().unwrap(), &u, &y);
            let faulty = residuals(&mut *design.build().unwrap(), &u, &plus(&y, &fault));
            let error = distance(&faulty[wait..], &plus(&healthy, &effect)[wait..]);
            let size = 1.0 + peak(&faulty) + through(&hy);
            prop_assert!(error < 1e-11 * size, "{error:e} of {size:e} for {name}");
        }
    }

    /// A reset generator repeats itself, and a restored one continues to the bit.
    #[test]
    fn every_generator_obeys_the_law_of_memory(draw in draws(), samples in 2..60_usize) {
        let model = plant(draw);
        let (u, y) = (signal(draw.seed ^ 1, draw.nu, 60), signal(draw.seed ^ 2, draw.ny, 60));
        for (name, _, design) in designs(&model) {
            let mut r = vec![0.0; design.residual_len()];
            let (mut one, mut two) = (design.build().unwrap(), design.build().unwrap());
            memory(&mut one, &mut two, samples, |generator, k| {
                let frame = Frame::new(generator.io(), k as u64, &u[k], &y[k]).unwrap();
                generator.step(frame, &mut r);
                (name, r.iter().map(|v| v.to_bits()).collect::<Vec<_>>())
            });
        }
    }

    /// A simulation that starts where the plant starts has no residual at all.
    #[test]
    fn a_simulation_from_the_right_state_is_exact(draw in draws()) {
        let model = plant(draw);
        let u = signal(draw.seed ^ 1, draw.nu, 100);
        let x0 = signal(draw.seed ^ 2, draw.nx, 1).remove(0);
        let y = simulate(&model, &x0, &u);
        let mut generator = SimulationDesign::new(&model)
            .unwrap()
            .freeze::<f64, Heap>()
            .unwrap()
            .starting_at(&x0)
            .unwrap();
        let r = residuals(&mut generator, &u, &y);
        prop_assert!(peak(&r) < 1e-12 * (1.0 + peak(&y)));
        generator.reset();
        prop_assert_eq!(residuals(&mut generator, &u, &y), r);
    }

    /// Other units of a sensor and another order of sensors give the same residual in these.
    #[test]
    fn units_and_order_of_sensors_do_not_matter(draw in draws()) {
        let model = plant(draw);
        let ny = draw.ny;
        // y' = S y with S a scaled rotation of the channels.
        let scale = |i: usize| 10.0_f64.powi(i32::try_from(i).unwrap() - 1);
        let change = |i: usize, j: usize| if (i + 1) % ny == j { scale(i) } else { 0.0 };
        let s = Mat::from_fn(ny, ny, change);
        let (a, b) = (model.a().to_owned(), model.b().to_owned());
        let changed = StateSpace::new(a, b, &s * model.c(), &s * model.d(), model.domain()).unwrap();
        let r = Mat::<f64>::identity(ny, ny);
        let q = Mat::<f64>::identity(draw.nx, draw.nx);
        let one = ObserverDesign::kalman_with(&model, q.as_ref(), r.as_ref()).unwrap();
        let noise = &s * r * s.transpose();
        let other = ObserverDesign::kalman_with(&changed, q.as_ref(), noise.as_ref()).unwrap();
        // L' S = L; the scales span 1000, whose square enters the innovation covariance.
        prop_assert!((other.gain() * &s - one.gain()).norm_max() < 1e-8);
    }
}

/// Sizes for static storage.
const DRAW: Draw = Draw { nx: 4, nu: 2, ny: 3, radius: 0.9, seed: 7 };
type Size = Fixed<4, 2, 3>;
/// A row of three, as `W = [1 1 1]`.
type Row = <Fixed<3, 1, 1> as Storage<f64>>::Yx;

fn frames(len: usize) -> Vec<(Vec<f64>, Vec<f64>)> {
    signal(1, DRAW.nu, len).into_iter().zip(signal(2, DRAW.ny, len)).collect()
}

/// Asserts equal residuals to the bit, and the law of reset and restore for both.
fn same_to_the_bit<A, B>(mut a: A, mut b: B)
where
    A: ResidualGenerator + Clone,
    B: ResidualGenerator + Clone,
{
    let frames = frames(50);
    let (u, y): (Vec<_>, Vec<_>) = frames.iter().cloned().unzip();
    let r = residuals(&mut a, &u, &y);
    assert!(0.1 < peak(&r), "a test on zeros shows nothing");
    assert_eq!(r, residuals(&mut b, &u, &y));
    reset_and_restore(&mut a, &frames);
    reset_and_restore(&mut b, &frames);
}

#[test]
fn static_and_heap_storage_agree() {
    let model = plant(DRAW);
    let simulation = SimulationDesign::new(&model).unwrap();
    same_to_the_bit(
        simulation.freeze::<f64, Size>().unwrap(),
        simulation.freeze::<f64, Heap>().unwrap(),
    );
    let kalman = ObserverDesign::kalman(&model, 1.0, 1.0).unwrap();
    let (fixed, heap) =
        (kalman.freeze::<f64, Size>().unwrap(), kalman.freeze::<f64, Heap>().unwrap());
    same_to_the_bit(fixed.clone(), heap.clone());
    let form = kalman.form().unwrap();
    same_to_the_bit(
        form.freeze::<f64, Fixed<4, 2, 3>, Fixed<4, 3, 3>>().unwrap(),
        form.freeze::<f64, Heap, Heap>().unwrap(),
    );

    // Order 2: 9 rows of rank 4 leave 5 vectors.
    let parity = ParityDesign::all(&model, 2).unwrap();
    same_to_the_bit(
        parity.freeze::<f64, FixedWindow<5, 9, 6>>().unwrap(),
        parity.freeze::<f64, Heap>().unwrap(),
    );
    same_to_the_bit(
        Bank::<_, [_; 2]>::new([fixed.clone(), fixed.clone()]).unwrap(),
        Bank::<_>::new(vec![heap.clone(), heap.clone()]).unwrap(),
    );

    let w = Mat::from_fn(1, 3, |_, _| 1.0);
    let weighted = WeightedDesign::new(kalman.clone(), w.as_ref()).unwrap();
    same_to_the_bit(
        weighted.behind::<f64, _, Row, [f64; 3]>(fixed.clone()).unwrap(),
        weighted.behind::<f64, _, HeapMap<f64>, Vec<f64>>(heap.clone()).unwrap(),
    );

    let scalar = |v: f64| Mat::from_fn(1, 1, |_, _| v);
    let none = Mat::zeros(1, 3);
    let lag = StateSpace::new(scalar(0.5), w, scalar(1.0), none, model.domain()).unwrap();
    let filtered = FilteredDesign::new(kalman, &lag).unwrap();
    same_to_the_bit(
        filtered.behind::<f64, _, Fixed<1, 3, 1>, [f64; 3]>(fixed).unwrap(),
        filtered.behind::<f64, _, Heap, Vec<f64>>(heap).unwrap(),
    );
}

/// Single precision runs the same designs; also its snapshots are exact.
#[test]
fn single_precision_follows_double() {
    let model = plant(DRAW);
    let kalman = ObserverDesign::kalman(&model, 1.0, 1.0).unwrap();
    let narrow: Vec<_> = frames(50)
        .iter()
        .map(|(u, y)| {
            let f = |v: &[f64]| v.iter().map(|&v| f32::from_design(v)).collect::<Vec<f32>>();
            (f(u), f(y))
        })
        .collect();
    let (u, y): (Vec<_>, Vec<_>) = frames(50).into_iter().unzip();
    let (un, yn): (Vec<_>, Vec<_>) = narrow.iter().cloned().unzip();
    let mut single = kalman.freeze::<f32, Size>().unwrap();
    let r = residuals(&mut kalman.freeze::<f64, Size>().unwrap(), &u, &y);
    let s: Vec<Vec<f64>> = residuals(&mut single, &un, &yn)
        .iter()
        .map(|r| r.iter().map(|&v| f64::from(v)).collect())
        .collect();
    // Some ten roundings of 6e-8 per step, accumulated over the observer's memory of ~10 steps.
    assert!(distance(&r, &s) < 1e-5 * peak(&r), "{}", distance(&r, &s));
    reset_and_restore(&mut single, &narrow);
}

#[test]
fn a_nonlinear_plant_can_stand_beside_its_twin() {
    use fd_core::{IoDims, stage::Plant};
    use fd_residual::{observer::Observer, simulation::Simulation};

    #[derive(Clone, Debug)]
    struct Pendulum;

    impl Plant for Pendulum {
        fn nx(&self) -> usize {
            2
        }
        fn io(&self) -> IoDims {
            IoDims { nu: 1, ny: 1 }
        }
        fn advance(&self, x: &[f64], u: &[f64], x_next: &mut [f64]) {
            x_next[0] = x[0] + 0.05 * x[1];
            x_next[1] = x[1] + 0.05 * (u[0] - x[0].sin() - 0.5 * x[1]);
        }
        fn output(&self, x: &[f64], _u: &[f64], y: &mut [f64]) {
            y[0] = x[0];
        }
    }

    let u = signal(3, 1, 400);
    let mut x = vec![0.8, -0.1];
    let mut y = Vec::new();
    for u in &u {
        let (mut out, mut next) = (vec![0.0], vec![0.0; 2]);
        Pendulum.output(&x, u, &mut out);
        Pendulum.advance(&x, u, &mut next);
        y.push(out);
        x = next;
    }
    let twin = Simulation::<f64, Fixed<2, 1, 1>, _>::new(Pendulum).unwrap();
    let r = residuals(&mut twin.clone().starting_at(&[0.8, -0.1]).unwrap(), &u, &y);
    assert!(peak(&r) < f64::MIN_POSITIVE, "the same arithmetic leaves nothing");

    // From the wrong state the observer forgets at the rate of its gain, the twin at its own.
    let gain = static_gain([0.5, 0.8]);
    let mut observer = Observer::<f64, Fixed<2, 1, 1>, _>::new(Pendulum, gain).unwrap();
    let r = residuals(&mut observer, &u, &y);
    assert!(0.5 < peak(&r[..5]) && peak(&r[300..]) < 1e-12, "{}", peak(&r[300..]));
    let frames: Vec<_> = u.into_iter().zip(y).collect();
    reset_and_restore(&mut observer, &frames);
}

/// A 2 × 1 gain in static storage.
fn static_gain(column: [f64; 2]) -> <Fixed<2, 1, 1> as fd_core::Storage<f64>>::Xy {
    fd_core::LinMap::from_fn("observer gain L", fd_core::Shape::new(2, 1), |i, _| column[i])
        .unwrap()
}

/// A nonlinear generator has no answer where its model diverges, and begins anew: so does the filter behind it.
#[test]
fn a_filter_begins_anew_with_its_generator() {
    use fd_core::{IoDims, StateVisitor};
    use fd_residual::weighted::Filtered;

    #[derive(Clone, Debug)]
    struct LostAboveTen;

    impl Stage for LostAboveTen {
        fn reset(&mut self) {}

        fn visit_state(&mut self, _visitor: &mut dyn StateVisitor<f64>) {}
    }

    impl ResidualGenerator for LostAboveTen {
        fn io(&self) -> IoDims {
            IoDims { nu: 1, ny: 1 }
        }

        fn residual_len(&self) -> usize {
            1
        }

        fn step(&mut self, frame: Frame<'_, f64>, r: &mut [f64]) {
            r[0] = if frame.y()[0] < 10.0 { frame.y()[0] } else { f64::NAN };
        }
    }

    let scalar = |v: f64| Mat::from_fn(1, 1, |_, _| v);
    let domain = plant(DRAW).domain();
    let lag = StateSpace::new(scalar(0.8), scalar(0.2), scalar(1.0), scalar(0.0), domain).unwrap();
    let fresh =
        Filtered::<f64, _, Fixed<1, 1, 1>, [f64; 1]>::new(LostAboveTen, lag.freeze().unwrap());
    let fresh = fresh.unwrap();
    let mut used = fresh.clone();
    let sample = |filter: &mut Filtered<_, _, Fixed<1, 1, 1>, _>, y: f64| {
        let mut r = [0.0];
        filter.step(Frame::new(filter.io(), 0, &[0.0], &[y]).unwrap(), &mut r);
        r[0]
    };
    (0..5).for_each(|_| assert!(sample(&mut used, 1.0).is_finite()));
    assert!(sample(&mut used, 11.0).is_nan());
    let mut fresh = fresh;
    for _ in 0..5 {
        assert_eq!(sample(&mut used, 1.0).to_bits(), sample(&mut fresh, 1.0).to_bits());
    }
}
