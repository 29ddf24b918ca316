//! Plants and exciting inputs for the tests of effects.

use std::path::Path;

use fd_effect::{Candidate, Effect, Kind, NotTestable, Offers, library, offers};
use fd_sim::{
    model::Model,
    scales::ReplayScales,
    simulate::{EquationSimulator, Outcome, Simulator},
};

pub(crate) const PLANTS: [&str; 8] = [
    "mass_spring_damper",
    "dc_drive",
    "dc_drive_closed_loop",
    "pendulum",
    "cart_pole",
    "two_mass_drive",
    "tanks",
    "two_input",
];

/// The effect that offers a candidate.
pub(crate) fn effect(candidate: &Candidate) -> Box<dyn Effect> {
    library().into_iter().find(|effect| effect.label() == candidate.label).unwrap()
}

/// A plant, its input and all that the library offers.
pub(crate) struct Case {
    pub(crate) model: Model,
    pub(crate) u: Vec<f64>,
    pub(crate) samples: usize,
    pub(crate) scales: ReplayScales,
}

impl Case {
    pub(crate) fn new(plant: &str, samples: usize) -> Self {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/models");
        let model = Model::load(&root.join(format!("{plant}.toml"))).unwrap();
        Self::of(model, samples)
    }

    pub(crate) fn of(model: Model, samples: usize) -> Self {
        let u = excitation(&model, samples);
        Self::with_input(model, u, samples)
    }

    pub(crate) fn with_input(model: Model, u: Vec<f64>, samples: usize) -> Self {
        let ts = model.sample_time().unwrap();
        let scales = ReplayScales::of(&model, ts, &u, samples).unwrap();
        Self { model, u, samples, scales }
    }

    pub(crate) fn offers(&self) -> Offers {
        offers(&library(), &self.model, &self.scales)
    }

    /// Candidates that change the simulation.
    pub(crate) fn simulated(&self) -> Vec<Candidate> {
        let testable = self.offers().into_iter().filter_map(Result::ok);
        testable.filter(|candidate| candidate.kind == Kind::Simulation).collect()
    }

    pub(crate) fn refused(&self) -> Vec<NotTestable> {
        self.offers().into_iter().filter_map(Result::err).collect()
    }

    /// Outputs of the nominal model on the grid of the candidates.
    pub(crate) fn nominal(&self) -> Vec<f64> {
        self.run(&self.model, &self.model.nominal()).1
    }

    pub(crate) fn run(&self, model: &Model, theta: &[f64]) -> (Outcome, Vec<f64>) {
        let mut simulator = EquationSimulator::<f64>::new(model).unwrap();
        let mut y = vec![0.0; self.samples * model.outputs.len()];
        let outcome = Simulator::simulate(&mut simulator, theta, &model.initial(), &self.u, &mut y);
        (outcome, y)
    }

    /// Outputs of a candidate with these parameters of the effect.
    pub(crate) fn apply(&self, candidate: &Candidate, phi: &[f64]) -> (Outcome, Vec<f64>) {
        let mut theta = self.model.nominal();
        theta.extend(phi);
        self.run(&candidate.model, &theta)
    }

    /// Largest difference of two simulations, in standard deviations of the outputs.
    pub(crate) fn distance(&self, a: &[f64], b: &[f64]) -> f64 {
        let ny = self.scales.outputs.len();
        let scaled = a.iter().zip(b).enumerate();
        scaled
            .map(|(i, (a, b))| (a - b).abs() / self.scales.outputs[i % ny].std)
            .fold(0.0, f64::max)
    }
}

/// Steps of pseudo-random height and length, inside the limits of each input and in both
/// directions where the plant has two.
fn excitation(model: &Model, samples: usize) -> Vec<f64> {
    let (middle, swing, length) = match model.name.as_str() {
        "tanks" => (5.0, 4.5, 40),
        "two-input" => (8e-5, 7e-5, 40),
        "dc-drive-closed-loop" => (0.0, 150.0, 60),
        "dc-drive" => (0.0, 12.0, 60),
        "cart-pole" => (0.0, 6.0, 60),
        "two-mass-drive" => (0.0, 3.0, 40),
        "pendulum" => (0.0, 1.5, 60),
        _ => (0.0, 8.0, 50),
    };
    let nu = model.external_inputs().len();
    let mut seed = 0x9e37_79b9_7f4a_7c15_u64;
    let mut random = move || {
        // A linear congruence of Knuth; its upper bits are even enough for a test.
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / 2.0_f64.powi(53) * 2.0 - 1.0
    };
    let mut level = vec![0.0; nu];
    let mut rows = Vec::with_capacity(samples * nu);
    for k in 0..samples {
        for (i, level) in level.iter_mut().enumerate() {
            if (k + i * length / 2).is_multiple_of(length) || k == 0 {
                *level = middle + swing * random();
            }
            rows.push(*level);
        }
    }
    rows
}

/// All strengths neutral, shapes as in `point`.
pub(crate) fn without_strength(candidate: &Candidate, point: &[f64]) -> Vec<f64> {
    let parameters = candidate.parameters.iter().zip(point);
    parameters.map(|(p, x)| if p.is_strength { p.neutral } else { *x }).collect()
}

/// Strengths a fraction of the way to `point`.
pub(crate) fn weaker(candidate: &Candidate, point: &[f64], fraction: f64) -> Vec<f64> {
    let parameters = candidate.parameters.iter().zip(point);
    let part = |neutral: f64, x: f64| neutral + fraction * (x - neutral);
    parameters.map(|(p, x)| if p.is_strength { part(p.neutral, *x) } else { *x }).collect()
}

pub(crate) fn name(candidate: &Candidate) -> String {
    let Candidate { label, law, site, partner, .. } = candidate;
    format!("{label} ({law}) at {site:?} {partner:?}")
}
