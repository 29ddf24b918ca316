//! A shell does not allocate per step, and nothing is left of the run before.

use allocation_counter::measure;
use fd_effect::{Kind, library, offers};
use fd_model::SampleTime;
use fd_sim::simulate::{Nominal, Simulator};

use super::pendulum::{THETA, TS, excitation, shell};

#[test]
fn no_step_allocates_and_every_run_is_the_same() {
    const SAMPLES: usize = 100;
    let ts = SampleTime::new(TS).unwrap();
    let u = excitation(SAMPLES, 1.0, 9);
    let shell = shell(TS / 2.0);
    let scales = shell.scales(ts, &u, SAMPLES).unwrap();
    let run = |simulator: &mut dyn Simulator, theta: &[f64]| {
        simulator.start(theta, &[0.01, 0.0], 0);
        let mut y = vec![0.0; 2 * SAMPLES];
        let allocated = measure(|| {
            for (k, row) in y.chunks_exact_mut(2).enumerate() {
                simulator.step(&u[k..=k], &u[k..=k], &[], row);
            }
        });
        (y.iter().map(|y| y.to_bits()).collect::<Vec<_>>(), allocated.count_total)
    };
    for candidate in offers(&library(), shell.model(), &scales).into_iter().flatten() {
        if candidate.kind != Kind::Simulation {
            continue;
        }
        let mut simulator = shell.patched(&candidate.model, ts).unwrap();
        let theta: Vec<f64> = THETA.into_iter().chain(candidate.starts[0].clone()).collect();
        let (first, allocations) = run(&mut *simulator, &theta);
        assert_eq!(allocations, 0, "{} at {:?}", candidate.label, candidate.site);
        let (second, _) = run(&mut *simulator.boxed(), &theta);
        assert_eq!(first, second, "{} at {:?}", candidate.label, candidate.site);
    }
}

#[test]
fn the_counter_counts() {
    let allocated = measure(|| drop(std::hint::black_box(vec![1.0_f64; 10])));
    assert_eq!(allocated.count_total, 1);
}
