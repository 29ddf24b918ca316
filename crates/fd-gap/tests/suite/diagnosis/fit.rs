//! Fits: known optima, boxes, simulators that diverge, holes, windows.

use std::{ops::Range, sync::Arc};

use faer::{Mat, linalg::solvers::SolveLstsq};
use fd_gap::{
    fit::{
        FitError, Horizon, Layout, LeastSquares, Plan, Search, Surroundings, Weights, minimise,
        null_fit,
    },
    quality::Autoregression,
};
use fd_sim::simulate::EquationSimulator;
use proptest::prelude::*;

use crate::diagnosis::bench_cases::{Reality, candidates, example, record, sizes};

/// `r = A z − b`, two shared unknowns, or one more, and one of each of three segments.
struct Linear {
    layout: Layout,
    bounds: Vec<[f64; 2]>,
    prior: Vec<[f64; 2]>,
    a: Mat<f64>,
    b: Vec<f64>,
    /// Residuals are not finite beyond this value of the first unknown.
    cliff: f64,
}

impl Linear {
    fn new(values: &[f64]) -> Self {
        let layout = Layout { shared: 2, own: 1, segments: vec![0..6, 6..11, 11..20] };
        let segment = |row: usize| layout.segments.iter().position(|s| s.contains(&row)).unwrap();
        let a = Mat::from_fn(20, 5, |i, j| match j {
            0 | 1 => values[2 * i + j],
            _ if j - 2 == segment(i) => 1.0 + values[40 + i],
            _ => 0.0,
        });
        Self {
            bounds: vec![[-1e3, 1e3]; 5],
            prior: vec![[0.3, 2.0], [0.0; 2], [0.0; 2], [0.1, 0.5], [0.0; 2]],
            a,
            b: values[60..80].to_vec(),
            layout,
            cliff: f64::INFINITY,
        }
    }

    /// The same with how many times residuals change as one more shared unknown, of which nothing but a range is known.
    fn with_change(&self, change: &[f64], range: [f64; 2]) -> Self {
        let (mut bounds, mut prior) = (self.bounds.clone(), self.prior.clone());
        bounds.insert(2, range);
        prior.insert(2, [0.0; 2]);
        let a = Mat::from_fn(20, 6, |i, j| match j {
            2 => change[i],
            _ => self.a[(i, if j < 2 { j } else { j - 1 })],
        });
        let layout = Layout { shared: 3, ..self.layout.clone() };
        Self { layout, bounds, prior, a, b: self.b.clone(), cliff: self.cliff }
    }

    /// The solution by QR of the system with the prior as further rows.
    fn by_qr(&self) -> Vec<f64> {
        let a = Mat::from_fn(25, 5, |i, j| match i {
            0..20 => self.a[(i, j)],
            _ => f64::from(u8::from(i - 20 == j)) * self.prior[j][1].sqrt(),
        });
        let b = Mat::from_fn(25, 1, |i, _| match i {
            0..20 => self.b[i],
            _ => self.prior[i - 20][0] * self.prior[i - 20][1].sqrt(),
        });
        let x = a.qr().solve_lstsq(b);
        (0..5).map(|i| x[(i, 0)]).collect()
    }
}

impl LeastSquares for Linear {
    fn layout(&self) -> &Layout {
        &self.layout
    }

    fn bounds(&self) -> &[[f64; 2]] {
        &self.bounds
    }

    fn prior(&self) -> &[[f64; 2]] {
        &self.prior
    }

    fn residuals(&mut self, z: &[f64], r: &mut [f64]) -> bool {
        for (i, r) in r.iter_mut().enumerate() {
            *r = (0..z.len()).map(|j| self.a[(i, j)] * z[j]).sum::<f64>() - self.b[i];
        }
        z[0] < self.cliff
    }

    fn slopes(&mut self, _z: &[f64], _r: &[f64], columns: Range<usize>, slopes: &mut [Vec<f64>]) {
        let shared = self.layout.shared;
        for column in columns {
            for (s, rows) in self.layout.segments.iter().enumerate() {
                for row in rows.clone() {
                    let place = if column < shared { column } else { shared + s };
                    slopes[column][row] = self.a[(row, place)];
                }
            }
        }
    }
}

const EXACT: Search = Search { iterations: 60, absolute: 0.0, relative: 1e-15, ..Search::PLAIN };

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn a_linear_problem_ends_at_the_solution_by_qr(
        values in proptest::collection::vec(-1.0..1.0_f64, 80),
    ) {
        let mut problem = Linear::new(&values);
        let expected = problem.by_qr();
        let minimum = minimise(&mut problem, &[0.0; 5], None, EXACT).unwrap();
        for (found, expected) in minimum.z.iter().zip(&expected) {
            // At a relative decrease of 1e-15 the cost (below 30) is flat to 3e-14, and unknowns are
            // within the root of that over the least eigenvalue (above 0.1 for nearly all draws).
            prop_assert!((found - expected).abs() < 1e-5, "{found} {expected}");
        }
    }

    #[test]
    fn a_box_gives_the_best_point_of_the_box(
        values in proptest::collection::vec(-1.0..1.0_f64, 80),
        edge in -0.2..0.2_f64,
    ) {
        let mut problem = Linear::new(&values);
        problem.bounds[0] = [edge - 0.1, edge];
        problem.bounds[3] = [edge, edge + 0.3];
        let minimum = minimise(&mut problem, &[0.0; 5], None, EXACT).unwrap();
        // Karush-Kuhn-Tucker: no feasible direction goes down.
        let mut r = vec![0.0; 20];
        prop_assert!(problem.residuals(&minimum.z, &mut r));
        for (j, z) in minimum.z.iter().enumerate() {
            let [mean, precision] = problem.prior[j];
            let slope = (0..20).map(|i| problem.a[(i, j)] * r[i]).sum::<f64>() + precision * (z - mean);
            let [low, high] = problem.bounds[j];
            prop_assert!(low <= *z && *z <= high);
            let can_fall = slope > 1e-5 && low + 1e-6 < *z || slope < -1e-5 && *z < high - 1e-6;
            prop_assert!(!can_fall, "unknown {j} at {z} in {low}..{high}, slope {slope}");
        }
    }
}

proptest! {
    /// Where residuals are linear, what is promised of a change is what a fit of its amplitude beside the nuisances comes to.
    #[test]
    fn a_promise_is_kept_where_residuals_are_linear(
        values in proptest::collection::vec(-1.0..1.0_f64, 80),
        change in proptest::collection::vec(-1.0..1.0_f64, 20),
        edge in 0.1..3.0_f64,
    ) {
        let mut without = Linear::new(&values);
        without.bounds[..3].copy_from_slice(&[[-0.5, 0.5], [-0.5, 0.5], [-0.3, 0.4]]);
        // From anywhere: the place is no minimum.
        let at = minimise(&mut without, &[0.3, -0.5, 0.2, 0.0, 0.0], None, Search::LOOK).unwrap();
        let around = Surroundings::new(&without, &at).unwrap();
        let range = [-edge, edge];
        let score = around.score(&change, range).unwrap();
        let mut with = without.with_change(&change, range);
        let search = Search { iterations: 200, relative: 1e-14, ..EXACT };
        let found = minimise(&mut with, &[0.0; 6], None, search).unwrap();
        // The fit ends where a step gains less than a part in 1e14, which may be many steps before its end.
        prop_assert!((score.left - found.cost).abs() < 1e-6 * at.cost, "{score:?} {found:?}");
        prop_assert!(score.left <= around.left() + 1e-12 * at.cost);
        let place = [&score.nuisances[..2], &[score.amplitude], &score.nuisances[2..]].concat();
        let there = minimise(&mut with, &place, None, Search::LOOK);
        prop_assert!((there.unwrap().cost - score.left).abs() < 1e-6 * at.cost);
    }
}

#[test]
fn a_step_over_a_cliff_shrinks() {
    let values: Vec<f64> = (0..80).map(|i| f64::from(i * 37 % 41) / 20.0 - 1.0).collect();
    let mut problem = Linear::new(&values);
    let free = problem.by_qr()[0];
    let start = [free - 2.0, 0.0, 0.0, 0.0, 0.0];
    problem.cliff = free - 0.5;
    let minimum = minimise(&mut problem, &start, None, EXACT).unwrap();
    assert!(minimum.z[0] < problem.cliff);
    assert!(free - 1.0 < minimum.z[0], "stopped at {} before {}", minimum.z[0], problem.cliff);
    problem.cliff = -10.0;
    assert!(minimise(&mut problem, &start, None, EXACT).is_none());
}

const REALITY: Reality =
    Reality { samples: 600, amplitude: 10.0, parameter_error: 0.03, colour: 0.0, seed: 9 };

#[test]
fn the_null_fit_reaches_the_noise_in_free_run_in_windows_and_with_holes() {
    let model = example("mass_spring_damper");
    let simulator = EquationSimulator::<f64>::new(&model).unwrap();
    let mut holed = record(&model, REALITY, 1);
    for k in (40..600).step_by(7) {
        holed.y_mut(k)[0] = f64::NAN;
    }
    let logs = [record(&model, REALITY, 2), holed];
    for horizon in [Horizon::FreeRun, Horizon::Windows { samples: 50 }] {
        let plan = Arc::new(Plan::new(&simulator, &logs, horizon).unwrap());
        let null = null_fit(&plan, &simulator, &Weights::white(vec![0.0005])).unwrap();
        let squares = null.minimum.cost - null.minimum.prior_cost;
        let free = plan.measured() as f64 - (2 * plan.segments().len()) as f64 - 3.0;
        // Chi-square with that many degrees of freedom, 4 standard deviations.
        let z = (squares - free) / f64::sqrt(2.0 * free);
        assert!(z.abs() < 4.0, "{horizon:?}: {squares} for {free}, {z} standard deviations");
    }
}

/// Residuals are errors, whitened.
#[test]
fn errors_at_a_minimum_are_those_of_a_simulation() {
    let model = example("dc_drive");
    let simulator = EquationSimulator::<f64>::new(&model).unwrap();
    let mut holed = record(&model, REALITY, 1);
    for k in (0..600).filter(|k| k % 7 == 0 || (100..130).contains(k)) {
        holed.y_mut(k)[k % 2] = f64::NAN;
    }
    let logs = [record(&model, REALITY, 2), holed];
    let white = Weights::white(vec![0.02, 0.2]);
    let slow = [0.9, 0.0].map(Autoregression::first_order);
    let coloured = Weights { colour: slow.to_vec(), ..white.clone() };
    for horizon in [Horizon::FreeRun, Horizon::Windows { samples: 50 }] {
        let plan = Arc::new(Plan::new(&simulator, &logs, horizon).unwrap());
        // An innovation is rounded, and what is rounded lives on for 1/(1 - 0.9) samples.
        for (weights, tolerance) in [(&white, 0.0), (&coloured, 20.0 * f64::EPSILON)] {
            let mut null = null_fit(&plan, &simulator, weights).unwrap();
            let found = null.problem.errors_at(&null.minimum).unwrap();
            let expected = null.problem.errors(&null.minimum.z).unwrap();
            let sizes = expected.iter().flatten().flatten().map(|e| e.abs());
            let largest = sizes.fold(0.0, f64::max);
            for (found, expected) in found.iter().flatten().zip(expected.iter().flatten()) {
                assert_eq!(found.len(), expected.len());
                for (a, b) in found.iter().zip(expected) {
                    let is_same = (a - b).abs() <= tolerance * largest;
                    assert!(is_same || a.is_nan() && b.is_nan(), "{horizon:?}: {a} {b}");
                }
            }
        }
    }
}

#[test]
fn what_does_not_fit_together_is_said() {
    let model = example("mass_spring_damper");
    let simulator = EquationSimulator::<f64>::new(&model).unwrap();
    let log = record(&model, REALITY, 1);
    let plan = |log| Plan::new(&simulator, &[log], Horizon::FreeRun);
    assert!(matches!(plan(log.slice(0, 5)), Err(FitError::TooShort { found: 5, .. })));
    assert_eq!(Plan::new(&simulator, &[], Horizon::FreeRun), Err(FitError::NoLog));
    let other = record(&example("dc_drive"), REALITY, 1);
    assert!(matches!(plan(other), Err(FitError::SampleTime { .. })));
    let thin = log.decimated(2).unwrap();
    assert!(matches!(plan(thin), Err(FitError::SampleTime { log: 1, .. })));
}

#[test]
fn candidates_are_the_nominal_model_at_zero_strength() {
    let model = example("mass_spring_damper");
    let u = crate::diagnosis::bench_cases::excitation(10.0, 200, 4);
    let run = |model: &fd_sim::model::Model| {
        let mut simulator = EquationSimulator::<f64>::new(model).unwrap();
        let mut y = vec![0.0; 200];
        simulator.run(&model.nominal(), &model.initial(), &u, &mut y);
        y
    };
    let nominal = run(&model);
    for candidate in candidates(&model, sizes("mass_spring_damper")) {
        assert_eq!(run(&candidate.model), nominal, "{}", candidate.label);
    }
}
