//! The same plant in other coordinates and other units.

use faer::{Mat, MatRef, prelude::Solve};
use fd_model::{Continuous, StateSpace};
use fd_numeric::dense::Dense;
use fd_residual::analysis::UnknownInputs;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::problems::Problem;

/// Condition of a change of coordinates.
const CONDITION: f64 = 10.0;

/// `x = S x̃`, `ỹ = M y`, and so on for all signals; faults and noise keep their columns.
#[derive(Clone, Debug)]
pub(crate) struct Change {
    states: Mat<f64>,
    outputs: Mat<f64>,
    inputs: Mat<f64>,
    disturbances: Mat<f64>,
    faults: Mat<f64>,
}

impl Change {
    /// Well-conditioned combinations of states, of outputs, of inputs and of disturbances.
    pub(crate) fn coordinates(problem: &Problem, seed: u64) -> Self {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let mut draw = |n| mixture(&mut rng, n);
        Self {
            states: draw(problem.plant.nx()),
            outputs: draw(problem.plant.ny()),
            inputs: draw(problem.plant.nu()),
            disturbances: draw(problem.disturbances.len()),
            faults: Mat::identity(problem.faults.len(), problem.faults.len()),
        }
    }

    /// Each signal in another unit, between `10^-decades` and `10^decades`.
    pub(crate) fn units(problem: &Problem, decades: f64, faults: bool, seed: u64) -> Self {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let mut draw = |n, changes: bool| {
            let units: Vec<f64> =
                (0..n).map(|_| 10.0_f64.powf(rng.random_range(-decades..decades))).collect();
            Mat::from_fn(n, n, |i, j| match (i == j, changes) {
                (true, true) => units[i],
                (true, false) => 1.0,
                _ => 0.0,
            })
        };
        Self {
            states: draw(problem.plant.nx(), true),
            outputs: draw(problem.plant.ny(), true),
            inputs: draw(problem.plant.nu(), true),
            disturbances: draw(problem.disturbances.len(), true),
            faults: draw(problem.faults.len(), faults),
        }
    }

    /// The problem after the change.
    pub(crate) fn of(&self, problem: &Problem) -> Problem {
        let into = |b: MatRef<'_, f64>| self.states.lu().solve(b);
        let p = &problem.plant;
        let a = into((p.a() * &self.states).as_ref());
        let c = &self.outputs * p.c() * &self.states;
        let entry = |unknown: &UnknownInputs, mix: MatRef<'_, f64>| {
            let entry = unknown.system(p).unwrap();
            let b = into((entry.b() * mix).as_ref());
            UnknownInputs::new("f", b, &self.outputs * entry.d() * mix).unwrap()
        };
        let noise = Mat::<f64>::identity(problem.noise.len(), problem.noise.len());
        let b = into((p.b() * &self.inputs).as_ref());
        let d = &self.outputs * p.d() * &self.inputs;
        Problem {
            plant: StateSpace::new(a, b, c, d, Continuous).unwrap(),
            faults: entry(&problem.faults, self.faults.as_ref()),
            disturbances: entry(&problem.disturbances, self.disturbances.as_ref()),
            noise: entry(&problem.noise, noise.as_ref()),
            published: &problem.published
                * self.outputs.lu().solve(Mat::<f64>::identity(p.ny(), p.ny())),
        }
    }
}

/// `Q₁ diag(σ) Q₂` with `σ` between one and the condition.
fn mixture(rng: &mut Xoshiro256PlusPlus, n: usize) -> Mat<f64> {
    let mut turn = || {
        let full = Mat::from_fn(n, n, |_, _| rng.random_range(-1.0..1.0));
        full.factor_qr().compute_thin_Q()
    };
    let (left, right) = (turn(), turn());
    let stretch = Mat::from_fn(n, n, |i, j| {
        if i == j { CONDITION.powf(i as f64 / (n.max(2) - 1) as f64) } else { 0.0 }
    });
    left * stretch * right
}
