//! No generator allocates per sample, seen by a counting allocator.
#![allow(unsafe_code, reason = "a global allocator cannot be written without")]
#![allow(clippy::unwrap_used, reason = "a failure here is a failed test")]

mod common;

use std::{
    alloc::{GlobalAlloc, Layout, System},
    cell::Cell,
};

use common::{sampled, signal};
use faer::{Mat, mat};
use fd_core::Frame;
use fd_model::StateSpace;
use fd_residual::testing::every_generator;

struct Counting;

thread_local! {
    // Per thread, so that the test harness does not count.
    static ALLOCATIONS: Cell<usize> = const { Cell::new(0) };
}

// SAFETY: forwards to the system allocator; the counter does not allocate.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.with(|count| count.set(count.get() + 1));
        // SAFETY: the caller keeps the contract of `alloc`.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the caller keeps the contract of `dealloc`.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

#[test]
fn no_generator_allocates_per_sample() {
    let a = mat![[0.9, 0.1], [-0.1, 0.8]];
    let model =
        StateSpace::new(a, mat![[0.1], [0.2]], Mat::identity(2, 2), Mat::zeros(2, 1), sampled());
    let (u, y) = (signal(1, 1, 200), signal(2, 2, 200));
    for example in every_generator(&model.unwrap()) {
        let mut generator = example.design.unwrap().build().unwrap();
        let mut r = vec![0.0; generator.residual_len()];
        let before = ALLOCATIONS.with(Cell::get);
        for (k, (u, y)) in (0..).zip(u.iter().zip(&y)) {
            let frame = Frame::new(generator.io(), k, u, y).unwrap();
            generator.step(frame, &mut r);
        }
        assert_eq!(ALLOCATIONS.with(Cell::get), before, "{}", example.name);
        assert!(r.iter().any(|r| *r != 0.0), "{} has seen the samples", example.name);
    }
    drop(std::hint::black_box(vec![1.0_f64; 10]));
    assert!(ALLOCATIONS.with(Cell::get) > 0, "the counter counts");
}
