//! No method allocates per sample, seen by a counting allocator.
#![allow(unsafe_code, reason = "a global allocator cannot be written without")]
#![allow(clippy::unwrap_used, reason = "a failure here is a failed test")]

mod common;

use std::{
    alloc::{GlobalAlloc, Layout, System},
    cell::Cell,
};

use common::Plant;
use fd_core::{Frame, stage::ResidualGenerator};
use fd_data::{
    cva::CvaDesign,
    monitor::Statistic,
    parity::DataParityDesign,
    pca::{Components, PcaDesign},
};

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
fn no_method_allocates_per_sample() {
    let log = [Plant::random(2, 1, 2, 1).log(300, 0.2, 2)];
    let components = Components::Count(3);
    let pca = PcaDesign { lags: 2, components, ..PcaDesign::default() }.learn(&log).unwrap();
    let cva = CvaDesign::default().learn(&log).unwrap();
    let parity = DataParityDesign { order: 3, states: Some(2) }.learn(&log).unwrap();
    let mut monitor = cva.monitor().freeze::<f64>().unwrap();
    let mut generators: [Box<dyn ResidualGenerator>; 3] = [
        Box::new(pca.monitor().freeze::<f64>().unwrap()),
        Box::new(cva.monitor().residual().unwrap().freeze::<f64>().unwrap()),
        Box::new(parity.map().freeze::<f64>().unwrap()),
    ];
    let mut r: Vec<Vec<f64>> = generators.iter().map(|g| vec![0.0; g.residual_len()]).collect();
    let (mut parts, mut seen) = ([0.0; 3], 0.0);
    let before = ALLOCATIONS.with(Cell::get);
    for k in 0..log[0].len() {
        let frame = Frame::new(monitor.io(), k as u64, log[0].u(k), log[0].y(k)).unwrap();
        for (generator, r) in generators.iter_mut().zip(&mut r) {
            generator.step(frame, r);
            seen += r[0].abs();
        }
        if monitor.observe(frame).is_some() {
            monitor.contributions(Statistic::Rest, &mut parts);
            seen += parts[0];
        }
    }
    assert_eq!(ALLOCATIONS.with(Cell::get), before);
    assert!(seen > 0.0, "the samples were seen");
    drop(std::hint::black_box(vec![1.0_f64; 10]));
    assert!(ALLOCATIONS.with(Cell::get) > 0, "the counter counts");
}
