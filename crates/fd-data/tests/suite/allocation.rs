//! No method allocates per sample, seen by a counting allocator.
#![allow(clippy::unwrap_used, reason = "a failure here is a failed test")]

use crate::common::Plant;
use allocation_counter::measure;
use fd_core::{Frame, stage::ResidualGenerator};
use fd_data::{
    cva::CvaDesign,
    monitor::Statistic,
    parity::DataParityDesign,
    pca::{Components, PcaDesign},
};

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
    let allocated = measure(|| {
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
    });
    assert_eq!(allocated.count_total, 0);
    assert!(seen > 0.0, "the samples were seen");
}

#[test]
fn the_counter_counts() {
    let allocated = measure(|| drop(std::hint::black_box(vec![1.0_f64; 10])));
    assert_eq!(allocated.count_total, 1);
}
