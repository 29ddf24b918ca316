//! No generator allocates per sample, seen by a counting allocator.
#![allow(clippy::unwrap_used, reason = "a failure here is a failed test")]

use crate::common::{sampled, signal};
use allocation_counter::measure;
use faer::{Mat, mat};
use fd_core::Frame;
use fd_model::StateSpace;
use fd_residual::testing::every_generator;

#[test]
fn no_generator_allocates_per_sample() {
    let a = mat![[0.9, 0.1], [-0.1, 0.8]];
    let model =
        StateSpace::new(a, mat![[0.1], [0.2]], Mat::identity(2, 2), Mat::zeros(2, 1), sampled());
    let (u, y) = (signal(1, 1, 200), signal(2, 2, 200));
    for example in every_generator(&model.unwrap()) {
        let mut generator = example.design.unwrap().build().unwrap();
        let mut r = vec![0.0; generator.residual_len()];
        let allocated = measure(|| {
            for (k, (u, y)) in (0..).zip(u.iter().zip(&y)) {
                let frame = Frame::new(generator.io(), k, u, y).unwrap();
                generator.step(frame, &mut r);
            }
        });
        assert_eq!(allocated.count_total, 0, "{}", example.name);
        assert!(r.iter().any(|r| *r != 0.0), "{} has seen the samples", example.name);
    }
}

#[test]
fn the_counter_counts() {
    let allocated = measure(|| drop(std::hint::black_box(vec![1.0_f64; 10])));
    assert_eq!(allocated.count_total, 1);
}
