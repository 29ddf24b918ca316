//! Laws of effects have slopes, by dual numbers.

use fd_sim::simulate::EquationSimulator;
use num_dual::Dual64;

use crate::{
    cases::{Case, PLANTS, effect, name},
    laws::is_held,
};

#[test]
fn dual_numbers_go_through_every_effect() {
    const SAMPLES: usize = 120;
    for plant in PLANTS {
        let case = Case::new(plant, SAMPLES);
        for candidate in case.simulated() {
            let mut simulator = EquationSimulator::<Dual64>::new(&candidate.model).unwrap();
            let x0: Vec<Dual64> =
                candidate.model.initial().into_iter().map(Dual64::from_re).collect();
            let neutral: Vec<f64> = candidate.parameters.iter().map(|p| p.neutral).collect();
            for phi in std::iter::once(&neutral).chain(&candidate.starts) {
                for i in 0..phi.len() {
                    let nominal = case.model.nominal();
                    let mut theta: Vec<Dual64> =
                        nominal.iter().chain(phi).copied().map(Dual64::from_re).collect();
                    theta[nominal.len() + i].eps = candidate.parameters[i].scale;
                    let mut y = vec![Dual64::from_re(0.0); SAMPLES * case.model.outputs.len()];
                    simulator.run(&theta, &x0, &case.u, &mut y);
                    // What flows out of a tank that has run empty has no slope.
                    let is_empty = plant == "tanks" && y.iter().any(|y| y.re <= 0.0);
                    let is_finite =
                        y.iter().all(|y| y.re.is_finite() && (is_empty || y.eps.is_finite()));
                    assert!(is_finite, "{plant}: {} {phi:?}, slope {i}", name(&candidate));
                    // A fit can leave its first start. Rounding to a grid has no slope, nor has a hat
                    // of a map over values that do not occur, nor a held signal between its steps.
                    let leaves = y.iter().any(|y| y.eps != 0.0)
                        || !candidate.parameters[i].is_strength
                        || !effect(&candidate).has_slope()
                        || (candidate.label == "sensor-delay" && is_held(&candidate));
                    let is_first = *phi == candidate.starts[0];
                    assert!(leaves || !is_first, "{plant}: {} has no slope {i}", name(&candidate));
                }
            }
        }
    }
}
