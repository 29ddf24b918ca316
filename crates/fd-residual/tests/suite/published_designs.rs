//! Published problems, solved by the design rooms: Varga (2017) and the user's guide of FDITOOLS.
//! All in continuous time but for the decisions.
#![allow(clippy::unwrap_used, reason = "a failure here is a failed test")]

use crate::common::{
    problems,
    transfer::{ONE, Ratio, System, ZERO, assert_close, assert_equal, realise},
};
use faer::{Mat, c64, mat};
use fd_core::Frame;
use fd_model::{Continuous, SampleTime, StateSpace};
use fd_residual::{
    DesignError, GeneratorDesign, ResidualForm,
    analysis::{UnknownInputs, fault_effects, fault_to_noise_gap},
    decouple::LeftNullSpace,
    observer::ErrorPoles,
    optimal::{Exposure, OptimalDesign},
    structured::{RowMethod, Structure, StructuredDesign},
};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

/// A plant with one known input, realised together with its unknown ones.
struct Problem {
    plant: System,
    all: System,
}

impl Problem {
    /// Column 0 is `u`.
    fn new<const N: usize>(rows: &[[Ratio; N]; 2]) -> Self {
        let all = realise(rows);
        let (b, d) = (all.b().subcols(0, 1).to_owned(), all.d().subcols(0, 1).to_owned());
        let plant =
            StateSpace::new(all.a().to_owned(), b, all.c().to_owned(), d, Continuous).unwrap();
        Self { plant, all }
    }

    /// The unknown inputs in columns `from..from + count`.
    fn unknown(&self, name: &str, from: usize, count: usize) -> UnknownInputs {
        let (b, d) = (self.all.b().subcols(from, count), self.all.d().subcols(from, count));
        UnknownInputs::new(name, b.to_owned(), d.to_owned()).unwrap()
    }

    fn system(&self, unknown: &UnknownInputs) -> System {
        unknown.system(&self.plant).unwrap()
    }
}

const U1: Ratio = (&[1.0, 1.0], &[1.0, 2.0]);
const U2: Ratio = (&[1.0, 2.0], &[1.0, 3.0]);
const D1: Ratio = (&[1.0, -1.0], &[1.0, 2.0]);

/// The form with its residual multiplied so that the gain of a fault at a frequency is as given.
fn normalised(
    form: &ResidualForm<Continuous>,
    gf: &System,
    fault: usize,
    wanted: f64,
) -> ResidualForm<Continuous> {
    let found = form.residual_of(gf).unwrap().dc_gain().unwrap()[(0, fault)];
    form.weighted(mat![[wanted / found]].as_ref()).unwrap()
}

#[test]
fn varga_5_4_is_solved_for_an_unstable_plant() {
    let first: Ratio = (&[1.0, 1.0], &[1.0, -2.0]);
    let second: Ratio = (&[1.0, 2.0], &[1.0, -3.0]);
    let problem = Problem::new(&[[first, D1, first, ZERO], [second, ZERO, second, ONE]]);
    let (d, f) = (problem.unknown("d", 1, 1), problem.unknown("f", 2, 2));
    let space = LeftNullSpace::of(&problem.plant, &d).unwrap();
    assert_eq!((space.residual_len(), space.order()), (1, 1));
    assert_eq!(space.detects(&f).unwrap().to_string(), "11");
    let form = space.placed(&ErrorPoles::Given(vec![c64::new(-3.0, 0.0)])).unwrap();
    let gf = problem.system(&f);
    let form = normalised(&form, &gf, 0, 2.0 / 3.0);
    // Q = [0, (s−3)/(s+3), −(s+2)/(s+3)], R_f = [(s+2)/(s+3), (s−3)/(s+3)].
    let to_y: Ratio = (&[1.0, -3.0], &[1.0, 3.0]);
    let q = realise(&[[(&[-1.0, -2.0], &[1.0, 3.0]), ZERO, to_y]]);
    assert_equal(form.system(), &q);
    let hy = form.hy().unwrap();
    assert_equal(&hy, &realise(&[[ZERO, to_y]]));
    let effects = fault_effects(&form, &gf).unwrap();
    for (effect, steady) in effects.iter().zip([2.0 / 3.0, 1.0]) {
        assert_close(effect.steady.unwrap(), steady);
        assert_close(effect.peak.norm, 1.0);
    }
    // Only the signature 11 exists: with either fault among the disturbances, nothing is left.
    for one in 0..2 {
        let unknown = d.and(&f.select(&[one]).unwrap()).unwrap();
        assert!(matches!(
            LeftNullSpace::of(&problem.plant, &unknown),
            Err(DesignError::NothingLeft { .. })
        ));
    }
}

#[test]
fn varga_5_3_is_solved_without_dynamics_of_its_own() {
    let problem = Problem::new(&[[U1, D1, U1, ZERO], [U2, ZERO, U2, ONE]]);
    let (d, f) = (problem.unknown("d", 1, 1), problem.unknown("f", 2, 2));
    let space = LeftNullSpace::of(&problem.plant, &d).unwrap();
    let form = space.placed(&ErrorPoles::Given(vec![c64::new(-3.0, 0.0)])).unwrap();
    let form = normalised(&form, &problem.system(&f), 0, 2.0 / 3.0);
    // Q = [0, 1, −(s+2)/(s+3)]: the pole −3 is that of the plant.
    assert_equal(form.system(), &realise(&[[(&[-1.0, -2.0], &[1.0, 3.0]), ZERO, ONE]]));
}

#[test]
fn varga_5_2_has_no_solution() {
    let noise: Ratio = (&[1.0], &[1.0, 2.0]);
    let problem = Problem::new(&[[U1, noise, U1, ZERO], [U2, ZERO, ZERO, ONE]]);
    let (d, f) = (problem.unknown("d", 1, 1), problem.unknown("f", 2, 2));
    let none = UnknownInputs::none(&problem.plant);
    let exposure = Exposure { faults: &f, disturbances: &d, noise: &none };
    let refusal = OptimalDesign::new(&problem.plant, &exposure, 3.0).unwrap_err();
    assert_eq!(refusal, DesignError::Undetectable { fault: "f 1".to_owned(), residuals: 1 });
    assert!(refusal.to_string().starts_with("no solution"), "{refusal}");
}

#[test]
fn varga_5_6_has_the_gap_three() {
    let noise: Ratio = (&[1.0], &[1.0, 2.0]);
    let problem = Problem::new(&[[U1, U1, ZERO, noise], [U2, ZERO, ONE, ZERO]]);
    let (f, w) = (problem.unknown("f", 1, 2), problem.unknown("w", 3, 1));
    let none = UnknownInputs::none(&problem.plant);
    let exposure = Exposure { faults: &f, disturbances: &none, noise: &w };
    let design = OptimalDesign::new(&problem.plant, &exposure, 3.0).unwrap();
    assert_eq!(design.noisy(), 1);
    let form = design.form();
    assert!(form.consistency(&problem.plant).unwrap() < 1e-12);
    let (gf, gw) = (problem.system(&f), problem.system(&w));
    assert_close(fault_to_noise_gap(form, &gf, &gw).unwrap().ratio, 3.0);
    // R_w = 3/(s+3) in the first channel, up to sign, and nothing in the second.
    let sign = form.residual_of(&gw).unwrap().dc_gain().unwrap()[(0, 0)].signum();
    let both = form.weighted(mat![[sign, 0.0], [0.0, 1.0]].as_ref()).unwrap();
    let rw = realise(&[[(&[3.0], &[1.0, 3.0])], [ZERO]]);
    assert_equal(&both.residual_of(&gw).unwrap(), &rw);

    // One residual with the combinations [1 1] and [0.1 1]: the gap stays.
    let quiet = both.residual_of(&gf).unwrap().dc_gain().unwrap()[(1, 1)].signum();
    for weight in [1.0, 0.1] {
        let one = both.weighted(mat![[1.0, weight * quiet]].as_ref()).unwrap();
        let ratio = fault_to_noise_gap(&one, &gf, &gw).unwrap().ratio;
        assert_close(ratio, 3.0 * weight.min(1.0));
        let other = both.weighted(mat![[weight, quiet]].as_ref()).unwrap();
        assert_close(fault_to_noise_gap(&other, &gf, &gw).unwrap().ratio, 3.0);
        assert_close(fault_to_noise_gap(&other, &gf, &gw).unwrap().noise.norm, weight);
    }
    let one = both.weighted(mat![[1.0, quiet]].as_ref()).unwrap();
    let rf = one.residual_of(&gf).unwrap();
    assert_equal(
        &StateSpace::new(
            rf.a().to_owned(),
            rf.b().subcols(0, 1).to_owned(),
            rf.c().to_owned(),
            rf.d().subcols(0, 1).to_owned(),
            Continuous,
        )
        .unwrap(),
        &realise(&[[(&[3.0, 3.0], &[1.0, 3.0])]]),
    );
}

#[test]
fn fditools_example_8_has_the_gap_two() {
    let problem = Problem::new(&[[U1, U1, ONE, ZERO, D1], [U2, U2, ZERO, ONE, ZERO]]);
    let (f, w) = (problem.unknown("f", 1, 3), problem.unknown("w", 4, 1));
    let none = UnknownInputs::none(&problem.plant);
    let exposure = Exposure { faults: &f, disturbances: &none, noise: &w };
    let design = OptimalDesign::new(&problem.plant, &exposure, 1.0).unwrap();
    let (gf, gw) = (problem.system(&f), problem.system(&w));
    let gap = fault_to_noise_gap(design.form(), &gf, &gw).unwrap();
    assert_close(gap.noise.norm, 1.0);
    assert_close(gap.ratio, 2.0);
    // The noisy channel is (s+2)/(s+1) of the first output, R_w = (s−1)/(s+1), up to sign.
    let noisy = design.form().weighted(mat![[1.0, 0.0]].as_ref()).unwrap();
    let noisy = normalised(&noisy, &gf, 1, 2.0);
    assert_equal(&noisy.hy().unwrap(), &realise(&[[(&[1.0, 2.0], &[1.0, 1.0]), ZERO]]));
    assert_equal(&noisy.residual_of(&gw).unwrap(), &realise(&[[(&[1.0, -1.0], &[1.0, 1.0])]]));
}

/// The published scalar filter is the sum of the noisy and the quiet residual. Noise fixes the first; the
/// pole of the second is free, published at −1, and so is its gain: from two thirds of the published one on
/// the gap stays 2.
#[test]
fn fditools_example_8_has_the_published_filter() {
    let problem = Problem::new(&[[U1, U1, ONE, ZERO, D1], [U2, U2, ZERO, ONE, ZERO]]);
    let (f, w) = (problem.unknown("f", 1, 3), problem.unknown("w", 4, 1));
    let none = UnknownInputs::none(&problem.plant);
    let exposure = Exposure { faults: &f, disturbances: &none, noise: &w };
    let pole = ErrorPoles::Given(vec![c64::new(-1.0, 0.0)]);
    let design = OptimalDesign::placed(&problem.plant, &exposure, 1.0, &pole).unwrap();
    assert_eq!((design.noisy(), design.form().residual_len()), (1, 2));
    let (gf, gw) = (problem.system(&f), problem.system(&w));
    // Gains of the sensor faults at rest as published: 2 of the first, 3 of the second.
    let rest = design.form().residual_of(&gf).unwrap().dc_gain().unwrap();
    let combined = |quiet: f64| {
        let row = mat![[2.0 / rest[(0, 1)], quiet / rest[(1, 2)]]];
        design.form().weighted(row.as_ref()).unwrap()
    };
    let form = combined(3.0);
    let to_y: [Ratio; 2] = [(&[1.0, 2.0], &[1.0, 1.0]), (&[1.0, 3.0], &[1.0, 1.0])];
    let to_u: Ratio = (&[-2.0, -3.0], &[1.0, 1.0]);
    assert_equal(form.system(), &realise(&[[to_u, to_y[0], to_y[1]]]));
    let actuator: Ratio = (&[2.0, 3.0], &[1.0, 1.0]);
    let rf = form.residual_of(&gf).unwrap();
    assert_equal(&rf, &realise(&[[actuator, to_y[0], to_y[1]]]));
    let rw = form.residual_of(&gw).unwrap();
    assert_equal(&rw, &realise(&[[(&[1.0, -1.0], &[1.0, 1.0])]]));
    for (effect, peak) in fault_effects(&form, &gf).unwrap().iter().zip([3.0, 2.0, 3.0]) {
        assert_close(effect.peak.norm, peak);
    }
    // The gap is that of the first sensor, whatever the quiet residual adds, if it is not too little.
    for (quiet, gap) in [(3.0, 2.0), (2.0, 2.0), (30.0, 2.0), (1.5, 1.5)] {
        assert_close(fault_to_noise_gap(&combined(quiet), &gf, &gw).unwrap().ratio, gap);
    }
}

/// One residual per fault, decoupled from the other and from the disturbance.
#[test]
fn niemann_faults_are_isolated() {
    let problems::Problem { plant, faults, disturbances: disturbance, .. } = problems::niemann();
    for (ignored, signature) in [(vec![], "11"), (vec![0], "01"), (vec![1], "10")] {
        let unknown = disturbance.and(&faults.select(&ignored).unwrap()).unwrap();
        let space = LeftNullSpace::of(&plant, &unknown).unwrap();
        // Published dimensions of the null space and orders of its full basis: 4 and 4, 3 and 3.
        let expected = if ignored.is_empty() { 4 } else { 3 };
        assert_eq!((space.residual_len(), space.order()), (expected, expected));
        assert_eq!(space.detects(&faults).unwrap().to_string(), signature);
    }
}

/// The same plant sampled at 10 ms, watched by a bank of structure I: which fault, decided sample by
/// sample. Unit gains at rest, Narendra's evaluation `θ ← γ θ + β |r|` with `β = 1.1`, `γ = 0.7` and
/// threshold 1, as the published test of the toolbox has it.
#[test]
fn niemann_faults_are_named_over_time() {
    let niemann = problems::niemann();
    let (a, bu) = (niemann.plant.a().to_owned(), niemann.plant.b());
    let from_disturbance = niemann.disturbances.system(&niemann.plant).unwrap();
    let bd = from_disturbance.b();
    let ts = SampleTime::new(0.01).unwrap();
    let b = Mat::from_fn(5, 3, |i, j| if j < 2 { bu[(i, j)] } else { bd[(i, 0)] });
    let (c, d) = (Mat::<f64>::identity(5, 5), Mat::zeros(5, 3));
    let whole = StateSpace::new(a, b, c.clone(), d, Continuous).unwrap().sample_zoh(ts).unwrap();
    let columns = |from, count| whole.b().subcols(from, count).to_owned();
    let (a, domain) = (whole.a().to_owned(), whole.domain());
    let plant = StateSpace::new(a, columns(0, 2), c, Mat::zeros(5, 2), domain).unwrap();
    let faults = UnknownInputs::new("f", columns(0, 2), Mat::zeros(5, 2)).unwrap();
    let disturbance = UnknownInputs::new("d", columns(2, 1), Mat::zeros(5, 1)).unwrap();
    let structure = Structure::Dedicated;
    let method = RowMethod::Parity { longest: 8 };
    let bank = StructuredDesign::new(&plant, &faults, &disturbance, &structure, method).unwrap();
    assert_eq!(bank.orders(), [1, 1]);
    let gf = faults.system(&plant).unwrap();
    let gains = bank.form().unwrap().residual_of(&gf).unwrap().dc_gain().unwrap();

    let decisions = |sizes: [f64; 2]| {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(51);
        let mut generator = bank.build().unwrap();
        let (mut x, mut evaluated, mut named) = (Mat::<f64>::zeros(5, 1), [0.0; 2], [false; 2]);
        for k in 0..=100 {
            let u = [(std::f64::consts::TAU * 0.01 * f64::from(k)).sin(); 2];
            let y: Vec<f64> = (0..5).map(|i| x[(i, 0)]).collect();
            let mut r = [0.0; 2];
            generator.step(Frame::new(generator.io(), 0, &u, &y).unwrap(), &mut r);
            for i in 0..2 {
                evaluated[i] = 0.7 * evaluated[i] + 1.1 * (r[i] / gains[(i, i)]).abs();
                named[i] |= evaluated[i] > 1.0;
            }
            // Standard deviation 0.1, as published.
            let noise = 0.1 * 3.0_f64.sqrt() * rng.random_range(-1.0..1.0);
            let fault = |i: usize| if k >= 5 { sizes[i] } else { 0.0 };
            let v = mat![[u[0] + fault(0)], [u[1] + fault(1)], [noise]];
            x = whole.a() * x + whole.b() * v;
        }
        named
    };
    assert_eq!(decisions([0.0, 0.0]), [false, false]);
    assert_eq!(decisions([0.5, 0.0]), [true, false]);
    assert_eq!(decisions([0.0, 0.5]), [false, true]);
    assert_eq!(decisions([0.5, 0.5]), [true, true]);
}
