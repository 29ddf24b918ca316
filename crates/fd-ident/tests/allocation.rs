//! Per-sample methods do not allocate, seen by a counting allocator.
#![allow(unsafe_code, reason = "a global allocator cannot be written without")]
#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]

mod common;

use std::{
    alloc::{GlobalAlloc, Layout, System},
    cell::Cell,
};

use common::{noise, record};
use faer::mat;
use fd_core::stage::{BiasModel, Identifier};
use fd_ident::{
    arx::{ArxModel, ArxOrders, ArxSimulator, RecursiveArx},
    extended::RecursiveArmax,
    hammerstein::{Basis, Expanded, Expansion},
    instrumental::{IvDesign, RecursiveIv},
    random_walk::{Drift, KalmanRls, RandomWalkDesign},
    rls::{Forgetting, RlsDesign, RlsKernel, UdRls, WindowDesign, WindowRls},
    scheduled::{RecursiveScheduled, Regions, ScheduledModel},
    subspace::StateSpaceBias,
};
use fd_model::{Discrete, SampleTime, StateSpace};

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

fn allocations(work: impl FnOnce()) -> usize {
    let before = ALLOCATIONS.with(Cell::get);
    work();
    ALLOCATIONS.with(Cell::get) - before
}

const ORDERS: ArxOrders = ArxOrders { na: 3, nb: 2, delay: 1, offset: true };

fn learn<K: RlsKernel<f64>>(kernel: K) -> usize {
    learn_with(RecursiveArx::new(ORDERS, 2, 2, kernel).unwrap())
}

fn learn_with(mut arx: impl Identifier<f64>) -> usize {
    let (u, mu) = (noise(1, 2000), noise(2, 2000));
    let mut variance = vec![0.0; arx.theta().len()];
    allocations(|| {
        for (u, mu) in u.chunks_exact(2).zip(mu.chunks_exact(2)) {
            arx.update(u, mu);
            arx.variance_into(&mut variance);
        }
    })
}

#[test]
fn the_counter_counts() {
    assert_eq!(allocations(|| drop(std::hint::black_box(vec![1.0_f64; 10]))), 1);
}

#[test]
fn learning_does_not_allocate() {
    let n = ORDERS.parameters(2);
    let lambda = 0.95;
    for forgetting in [
        Forgetting::None,
        Forgetting::Equation18 { alpha: 0.5 },
        Forgetting::Exponential { lambda },
        Forgetting::Directional { lambda },
        Forgetting::Bounded { lambda, variance: 10.0 },
        Forgetting::Resetting { lambda, floor: 0.01 },
    ] {
        let kernel = UdRls::<f64>::new(n, &RlsDesign::forgetting(forgetting)).unwrap();
        assert_eq!(learn(kernel), 0, "{forgetting:?}");
    }
    let window = WindowDesign { samples: 20, prior_variance: 1e3 };
    assert_eq!(learn(WindowRls::<f64>::new(n, &window).unwrap()), 0);
    let drift = Drift::Uniform { variance: 1e-3 };
    let walk = RandomWalkDesign { drift, ..RandomWalkDesign::default() };
    assert_eq!(learn(KalmanRls::<f64>::new(n, &walk).unwrap()), 0);
}

#[test]
fn learning_in_noise_does_not_allocate() {
    let n = ORDERS.parameters(2);
    let kernel = |n| UdRls::<f64>::new(n, &RlsDesign::default()).unwrap();
    let extended = RecursiveArmax::new(ORDERS, 2, 2, 2, kernel(n + 2)).unwrap();
    assert_eq!(learn_with(extended), 0);
    assert_eq!(learn_with(RecursiveIv::<f64>::new(ORDERS, 2, 2, &IvDesign::default()).unwrap()), 0);
    let regions = Regions::new(1, 5.0, vec![-0.1, 0.1]).unwrap();
    let scheduled = RecursiveScheduled::new(&regions, ORDERS, 2, 2, kernel(n)).unwrap();
    assert_eq!(learn_with(scheduled), 0);
    let training = record(2, 1, noise(1, 20), noise(2, 10));
    let curve = Expansion::from_training(Basis::Polynomial { degree: 3 }, &[training]).unwrap();
    let arx = RecursiveArx::new(ORDERS, 6, 2, kernel(ORDERS.parameters(6))).unwrap();
    assert_eq!(learn_with(Expanded::new(&curve, arx).unwrap()), 0);
}

#[test]
fn running_a_bias_model_does_not_allocate() {
    run_without_allocation(ArxSimulator::<f64>::new(ORDERS, 2, 2).unwrap());
    let (a, b) = (mat![[0.5, 0.1], [0.0, 0.4]], mat![[1.0, 0.0], [0.0, 1.0]]);
    let domain = Discrete { ts: SampleTime::new(0.1).unwrap() };
    let system = StateSpace::new(a, b.clone(), b.clone(), b, domain).unwrap();
    let states = StateSpaceBias::new(system, vec![0.0; 2], &[1.0; 2]).unwrap();
    run_without_allocation(states.freeze::<f64>().unwrap());
    let theta = vec![0.1; 2 * ORDERS.parameters(2)];
    let local = ArxModel::new(ORDERS, 2, 2, theta, domain.ts).unwrap();
    let regions = Regions::new(1, 5.0, vec![-0.1, 0.1]).unwrap();
    let scheduled = ScheduledModel::new(regions, vec![local.clone(), local]).unwrap();
    run_without_allocation(scheduled.freeze::<f64>().unwrap());
}

fn run_without_allocation(mut bias: impl BiasModel<f64>) {
    let theta = noise(3, bias.theta_len());
    let u = noise(4, 600);
    let mut mu_hat = [0.0; 2];
    let count = allocations(|| {
        bias.load(&theta);
        for u in u.chunks_exact(2) {
            bias.observe(u, &[0.1, 0.2]);
            bias.predict(u, &[0.1, 0.2], &mut mu_hat);
            bias.simulate(u, &mut mu_hat);
        }
    });
    assert_eq!(count, 0);
}
