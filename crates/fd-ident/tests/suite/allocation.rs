//! Per-sample methods do not allocate, seen by a counting allocator.
#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]

use crate::common::noise;
use allocation_counter::measure;
use fd_ident::{
    arx::ArxOrders,
    testing::{every_bias_model, every_identifier},
};

fn allocations(work: impl FnOnce()) -> u64 {
    measure(work).count_total
}

const ORDERS: ArxOrders = ArxOrders { na: 3, nb: 2, delay: 1, offset: true };

#[test]
fn the_counter_counts() {
    assert_eq!(allocations(|| drop(std::hint::black_box(vec![1.0_f64; 10]))), 1);
}

#[test]
fn learning_does_not_allocate() {
    let (u, mu) = (noise(1, 2000), noise(2, 2000));
    for (name, mut identifier) in every_identifier::<f64>(ORDERS, 2, 2).unwrap() {
        let mut variance = vec![0.0; identifier.theta().len()];
        let count = allocations(|| {
            for (u, mu) in u.chunks_exact(2).zip(mu.chunks_exact(2)) {
                identifier.update(u, mu);
                identifier.variance_into(&mut variance);
            }
        });
        assert_eq!(count, 0, "{name}");
        assert!(identifier.theta().iter().any(|v| *v != 0.0), "{name} has learned something");
    }
}

#[test]
fn running_a_bias_model_does_not_allocate() {
    let u = noise(4, 600);
    for (name, mut bias) in every_bias_model::<f64>(ORDERS, 2, 2).unwrap() {
        let theta = noise(3, bias.theta_len());
        let mut mu_hat = [0.0; 2];
        let count = allocations(|| {
            bias.load(&theta);
            for u in u.chunks_exact(2) {
                bias.observe(u, &[0.1, 0.2]);
                bias.predict(u, &[0.1, 0.2], &mut mu_hat);
                bias.simulate(u, &mut mu_hat);
            }
        });
        assert_eq!(count, 0, "{name}");
    }
}
