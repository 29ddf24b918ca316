//! Several runs side by side are to the bit what they are alone.

use std::sync::Arc;

use fd_effect::{Candidate, Kind, library, offers};
use fd_gap::fit::{Horizon, LeastSquares, Plan, Problem, Search, Variable, Weights, minimise_all};
use fd_model::{Channel, SampleTime};
use fd_sim::{
    model::Parameter,
    scales::ReplayScales,
    simulate::{EquationSimulator, Initial, Outcome, Port, Run, Simulator},
};
use proptest::prelude::*;

use crate::diagnosis::bench_cases::{Reality, example, record};

const PLANTS: [&str; 8] = [
    "mass_spring_damper",
    "dc_drive",
    "dc_drive_closed_loop",
    "pendulum",
    "cart_pole",
    "two_mass_drive",
    "tanks",
    "two_input",
];

/// Without the power to run side by side.
#[derive(Clone, Debug)]
struct OneByOne(Box<dyn Simulator>);

impl Simulator for OneByOne {
    fn ts(&self) -> SampleTime {
        self.0.ts()
    }

    fn inputs(&self) -> &[Channel] {
        self.0.inputs()
    }

    fn outputs(&self) -> &[Channel] {
        self.0.outputs()
    }

    fn parameters(&self) -> &[Parameter] {
        self.0.parameters()
    }

    fn initial(&self) -> &[Initial] {
        self.0.initial()
    }

    fn ports(&self) -> &[Port] {
        self.0.ports()
    }

    fn start(&mut self, theta: &[f64], x0: &[f64], first: u64) {
        self.0.start(theta, x0, first);
    }

    fn step(&mut self, u: &[f64], u_next: &[f64], f: &[f64], y: &mut [f64]) {
        self.0.step(u, u_next, f, y);
    }

    fn state(&self) -> &[f64] {
        self.0.state()
    }

    fn boxed(&self) -> Box<dyn Simulator> {
        Box::new(self.clone())
    }
}

fn bits(values: &[f64]) -> Vec<u64> {
    // One NaN is as good as another.
    values.iter().map(|v| if v.is_nan() { f64::NAN } else { *v }.to_bits()).collect()
}

/// All effects of the library at all places of a model.
fn candidates(name: &str, u: &[f64], samples: usize) -> Vec<Candidate> {
    let model = example(name);
    let ts = model.sample_time().unwrap();
    let scales = ReplayScales::of(&model, ts, u, samples).unwrap();
    let all = offers(&library(), &model, &scales).into_iter().filter_map(Result::ok);
    all.filter(|candidate| candidate.kind == Kind::Simulation).collect()
}

fn excitation(inputs: usize, samples: usize) -> Vec<f64> {
    (0..samples * inputs)
        .map(|k| if k / 37 % 2 == 0 { 2.0 } else { -1.0 } * (0.1 * k as f64).cos())
        .collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]

    #[test]
    fn runs_side_by_side_are_what_they_are_alone(
        plant in 0..PLANTS.len(),
        which in any::<prop::sample::Index>(),
        runs in 1..20_usize,
        first in 0..50_u64,
        spread in 0.0..0.1_f64,
        wild in any::<prop::sample::Index>(),
        has_more in any::<bool>(),
    ) {
        let inputs = example(PLANTS[plant]).external_inputs().len();
        let samples = 80;
        let u = excitation(inputs, samples + usize::from(has_more));
        let all = candidates(PLANTS[plant], &u, samples);
        let candidate = which.get(&all);
        let ts = candidate.model.sample_time().unwrap();
        let mut simulator = EquationSimulator::<f64>::at(&candidate.model, ts).unwrap();
        let nominal = candidate.model.parameters.len() - candidate.parameters.len();
        let thetas: Vec<Vec<f64>> = (0..runs)
            .map(|i| {
                let mut theta = candidate.model.nominal();
                theta[nominal..].copy_from_slice(&candidate.starts[i % candidate.starts.len()]);
                for p in &mut theta {
                    *p *= 1.0 + spread * i as f64 / 20.0;
                }
                theta
            })
            .collect();
        let mut x0s = vec![candidate.model.initial(); runs];
        // One run diverges at once, whatever the others do.
        if let Some(x) = x0s[wild.index(runs)].first_mut() {
            *x = f64::INFINITY;
        }
        let ny = simulator.outputs().len();
        let mut together = vec![vec![0.0; samples * ny]; runs];
        let mut runs: Vec<Run<'_>> = thetas
            .iter()
            .zip(&x0s)
            .zip(&mut together)
            .map(|((theta, x0), y)| Run::new(theta, x0, y))
            .collect();
        simulator.simulate_many(first, &u, &mut runs);
        let outcomes: Vec<Outcome> = runs.iter().map(|run| run.outcome).collect();
        let mut alone = OneByOne(Box::new(simulator));
        for (i, expected) in together.iter().enumerate() {
            let mut y = vec![0.0; samples * ny];
            let mut run = [Run::new(&thetas[i], &x0s[i], &mut y)];
            alone.simulate_many(first, &u, &mut run);
            prop_assert_eq!(run[0].outcome, outcomes[i]);
            prop_assert_eq!(bits(&y), bits(expected), "{} {}", candidate.label, candidate.law);
        }
    }
}

fn problem(candidate: &Candidate, horizon: Horizon, side_by_side: bool) -> Problem {
    let nominal = EquationSimulator::<f64>::new(&example("dc_drive")).unwrap();
    let reality =
        Reality { samples: 200, amplitude: 20.0, parameter_error: 0.03, colour: 0.0, seed: 4 };
    let log = record(&example("dc_drive"), reality, 1);
    let plan = Arc::new(Plan::new(&nominal, &[log], horizon).unwrap());
    let simulator: Box<dyn Simulator> =
        Box::new(EquationSimulator::<f64>::new(&candidate.model).unwrap());
    let simulator = if side_by_side { simulator } else { Box::new(OneByOne(simulator)) };
    let effects = candidate.parameters.iter().map(Variable::effect);
    let weights = Weights::white(vec![0.02, 0.2]);
    Problem::new(plan, simulator, effects.collect(), weights).unwrap()
}

#[test]
fn slopes_and_fits_side_by_side_are_what_they_are_one_by_one() {
    let all = candidates("dc_drive", &excitation(1, 200), 200);
    for (i, candidate) in all.iter().enumerate().step_by(3) {
        let horizon = if i % 2 == 0 { Horizon::FreeRun } else { Horizon::Windows { samples: 60 } };
        let [mut together, mut alone] =
            [true, false].map(|side_by_side| problem(candidate, horizon, side_by_side));
        let origin = vec![0.0; together.layout().unknowns() - candidate.parameters.len()];
        let places: Vec<Vec<f64>> =
            candidate.starts.iter().map(|start| together.place(&origin, start)).collect();
        let columns = 0..together.layout().shared + together.layout().own;
        let [found, expected] =
            [&mut together, &mut alone].map(|p| p.linearize(&places, columns.clone()));
        assert_eq!(found, expected, "{} {}", candidate.label, candidate.law);
        // And the slopes at a place are those of single residuals.
        let there = expected[0].as_ref().unwrap();
        let mut slopes = vec![vec![0.0; there.r.len()]; columns.end];
        alone.slopes(&places[0], &there.r, columns, &mut slopes);
        assert_eq!(slopes, there.slopes);
        // A fit from several starts is as many fits.
        let search = Search { iterations: 2, ..Search::default() };
        let many = minimise_all(&mut together, &places, None, search);
        for (place, minimum) in places.iter().zip(&many) {
            let single = minimise_all(&mut alone, std::slice::from_ref(place), None, search);
            let [single, minimum] = [&single[0], minimum].map(|m| m.as_ref().unwrap());
            assert_eq!((&single.z, &single.slopes), (&minimum.z, &minimum.slopes));
        }
    }
}
