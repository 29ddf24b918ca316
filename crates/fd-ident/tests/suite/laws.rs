//! Laws that every identifier and every bias model obeys.
#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]

use crate::common::{bits, noise};
use fd_core::{
    stage::{BiasModel, Identifier},
    testing::memory,
};
use fd_ident::{
    arx::ArxOrders,
    testing::{every_bias_model, every_identifier},
};

const ORDERS: ArxOrders = ArxOrders { na: 2, nb: 2, delay: 0, offset: true };

/// Cut before the regressors are full, and after every estimator has learned something.
#[test]
fn every_identifier_obeys_the_law_of_memory() {
    let (u, mu) = (noise(1, 400), noise(2, 400));
    for samples in [3, 60, 200] {
        let twins = every_identifier::<f64>(ORDERS, 2, 2).unwrap();
        let all = every_identifier::<f64>(ORDERS, 2, 2).unwrap();
        for ((name, mut one), (_, mut two)) in all.into_iter().zip(twins) {
            memory(&mut one, &mut two, samples, |identifier, k| {
                identifier.update(&u[2 * k..2 * k + 2], &mu[2 * k..2 * k + 2]);
                let mut variance = vec![0.0; identifier.theta().len()];
                identifier.variance_into(&mut variance);
                (name, bits(identifier.theta()), bits(&variance), identifier.guard())
            });
        }
    }
}

#[test]
fn every_bias_model_obeys_the_law_of_memory() {
    let (u, r) = (noise(3, 400), noise(4, 400));
    for samples in [3, 60, 200] {
        let twins = every_bias_model::<f64>(ORDERS, 2, 2).unwrap();
        let all = every_bias_model::<f64>(ORDERS, 2, 2).unwrap();
        for ((name, mut one), (_, mut two)) in all.into_iter().zip(twins) {
            memory(&mut one, &mut two, samples, |bias, k| {
                let (u, r, mut mu_hat) = (&u[2 * k..2 * k + 2], &r[2 * k..2 * k + 2], [0.0; 2]);
                match k % 5 {
                    0 => bias.observe(u, r),
                    1 => bias.predict(u, r, &mut mu_hat),
                    _ => bias.simulate(u, &mut mu_hat),
                }
                (name, bits(&mu_hat))
            });
        }
    }
}

/// To predict from what was simulated is to simulate; to predict from anything else is not.
#[test]
fn every_bias_model_predicts_from_what_was_measured() {
    let (u, r) = (noise(5, 200), noise(6, 200));
    let simulators = every_bias_model::<f64>(ORDERS, 2, 2).unwrap();
    let predictors = every_bias_model::<f64>(ORDERS, 2, 2).unwrap();
    for ((name, mut simulator), (_, mut predictor)) in simulators.into_iter().zip(predictors) {
        let theta = vec![0.1; simulator.theta_len()];
        for bias in [&mut simulator, &mut predictor] {
            bias.load(&theta);
            (0..20).for_each(|k| bias.observe(&u[2 * k..2 * k + 2], &r[2 * k..2 * k + 2]));
        }
        let [mut simulated, mut predicted] = [[0.0; 2]; 2];
        for (k, u) in u.chunks_exact(2).enumerate().skip(20) {
            simulator.simulate(u, &mut simulated);
            let fault = if k == 98 { 1.0 } else { 0.0 };
            predictor.predict(u, &simulated.map(|mu| mu + fault), &mut predicted);
            // The fault of sample 98 is in the past of sample 99.
            assert_eq!(bits(&predicted) == bits(&simulated), k < 99, "{name}, sample {k}");
        }
    }
}
