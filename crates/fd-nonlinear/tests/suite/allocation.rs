//! No filter allocates per sample, seen by a counting allocator.
#![allow(clippy::unwrap_used, reason = "a failure here is a failed test")]

use crate::common::{TANKS, noisy, run};
use allocation_counter::measure;
use fd_core::Frame;
use fd_nonlinear::{Noise, testing::every_filter};

#[test]
fn no_filter_allocates_per_sample() {
    let noise = Noise { process: vec![0.01; 2], output: vec![0.02], initial: vec![0.1; 2] };
    let model = noisy(TANKS, noise);
    let u: Vec<Vec<f64>> = (0..200).map(|k| vec![0.1 + 0.0001 * f64::from(k)]).collect();
    let (_, mut y) = run(&model, &u, 2);
    // Also not where the model has no answer and the filter starts anew.
    y[90][0] = -1e3;
    for (name, mut filter) in every_filter(&model).unwrap() {
        let (mut r, mut seen) = ([0.0], 0.0);
        let allocated = measure(|| {
            for (k, (u, y)) in (0..).zip(u.iter().zip(&y)) {
                let frame = Frame::new(filter.io(), k, u, y).unwrap();
                filter.step(frame, &mut r);
                if r[0].is_finite() {
                    seen += r[0].abs();
                }
            }
        });
        assert_eq!(allocated.count_total, 0, "{name}");
        assert!(seen > 0.0, "{name} has seen the samples");
    }
}

#[test]
fn the_counter_counts() {
    let allocated = measure(|| drop(std::hint::black_box(vec![1.0_f64; 10])));
    assert_eq!(allocated.count_total, 1);
}
