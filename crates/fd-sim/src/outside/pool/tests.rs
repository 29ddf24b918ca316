//! Copies of one simulator on threads of their own, in all orders in which they can meet at the pool: each gets the
//! outputs of its own run, and all come to an end.

use std::sync::{
    Arc,
    atomic::{AtomicUsize, Ordering::Relaxed},
};

use fd_model::{Channel, SampleTime};
use loom::{model::Builder, thread};

use crate::{
    model::Parameter,
    outside::{
        Contract, Instance, Lost, OutsideError, OutsideSimulator, Powers, Source, Start,
        sync::in_model,
    },
    simulate::{Initial, Simulator},
};

/// Sums up its inputs: of two runs that were mixed it shows the wrong sum.
#[derive(Debug, Default)]
struct Sum {
    gain: f64,
    x: f64,
    /// Dies at this step of its life.
    death: Option<u32>,
    steps: u32,
}

impl Instance for Sum {
    fn reset(&mut self, start: Start<'_>) -> Result<(), Lost> {
        (self.gain, self.x) = (start.theta[0], 0.0);
        Ok(())
    }

    fn measure(&mut self, _: &[f64], _: &mut [f64]) -> Result<(), Lost> {
        Err(Lost::Refused)
    }

    fn step(&mut self, row: &[f64], y: &mut [f64], _: &mut [f64]) -> Result<(), Lost> {
        self.steps += 1;
        if self.death == Some(self.steps) {
            let [command, message] = ["sum", "dead"].map(str::to_owned);
            return Err(Lost::Gone(Box::new(OutsideError::Start { command, message })));
        }
        self.x += row[0];
        y[0] = self.gain * self.x;
        Ok(())
    }
}

/// Starts sums, of which the first may die.
#[derive(Debug)]
struct Sums {
    started: AtomicUsize,
    death: Option<u32>,
}

impl Source for Sums {
    fn open(&self) -> Result<Box<dyn Instance>, OutsideError> {
        let is_first = self.started.fetch_add(1, Relaxed) == 0;
        Ok(Box::new(Sum { death: self.death.filter(|_| is_first), ..Sum::default() }))
    }
}

fn simulator(workers: usize, death: Option<u32>) -> OutsideSimulator {
    let [name, unit] = ["gain", "1"].map(str::to_owned);
    let gain = Parameter { name, unit, value: 1.0, tolerance: 0.1, bounds: None };
    let contract = Contract {
        name: "sum".into(),
        ts: SampleTime::new(1.0).unwrap(),
        inputs: vec![Channel::new("u", "1")],
        outputs: vec![Channel::new("y", "1")],
        noise: vec![None],
        parameters: vec![gain],
        natives: Vec::new(),
        initial: Vec::<Initial>::new(),
        ports: Vec::new(),
        motion: Vec::new(),
        powers: Powers::default(),
    };
    let sums = Sums { started: AtomicUsize::new(0), death };
    OutsideSimulator::new(contract, sums, workers).unwrap()
}

/// Goes through all orders with at most so many changes of thread that no wait asks for (without a limit, copies could take one
/// simulator from each other for ever).
fn in_all_orders(changes: usize, is_late: bool, model: impl Fn() + Send + Sync + 'static) {
    let mut builder = Builder::new();
    builder.preemption_bound = Some(changes);
    let orders = Arc::new(AtomicUsize::new(0));
    let counted = Arc::clone(&orders);
    builder.check(move || {
        counted.fetch_add(1, Relaxed);
        in_model(is_late, &model);
    });
    println!("{} orders", orders.load(Relaxed));
}

/// A run of one copy, step by step; its simulator is just left at the end.
fn stepped(mut copy: Box<dyn Simulator>, gain: f64, samples: usize) {
    copy.start(&[gain], &[], 0);
    for k in 1..=samples {
        let mut y = [0.0];
        copy.step(&[1.0], &[1.0], &[], &mut y);
        assert_eq!(y[0].to_bits(), (gain * k as f64).to_bits(), "sample {k} of {gain}");
    }
}

/// A whole run of one copy, which gives its simulator back.
fn whole(mut copy: Box<dyn Simulator>, gain: f64, samples: usize) {
    let mut y = vec![0.0; samples];
    copy.simulate(&[gain], &[], &vec![1.0; samples], &mut y);
    let expected: Vec<f64> = (1..=samples).map(|k| gain * k as f64).collect();
    assert_eq!(y, expected);
}

fn together(
    simulator: &OutsideSimulator,
    copies: usize,
    run: impl Fn(Box<dyn Simulator>, f64) + Copy + Send + 'static,
) {
    let gains = (1..copies).map(|i| i as f64 + 1.0);
    let others: Vec<_> = gains
        .map(|gain| {
            let copy = simulator.boxed();
            thread::spawn(move || run(copy, gain))
        })
        .collect();
    run(simulator.boxed(), 1.0);
    for other in others {
        other.join().unwrap();
    }
}

#[test]
fn one_that_is_given_back_is_waited_for() {
    in_all_orders(5, false, || {
        let simulator = simulator(1, None);
        together(&simulator, 2, |copy, gain| whole(copy, gain, 2));
        assert_eq!(simulator.counts().started, 1);
    });
}

#[test]
fn one_that_was_left_is_taken_and_the_run_repeated() {
    in_all_orders(5, true, || {
        let simulator = simulator(1, None);
        together(&simulator, 2, |copy, gain| stepped(copy, gain, 2));
        assert_eq!(simulator.counts().started, 1);
    });
}

#[test]
fn three_copies_share_two() {
    for is_late in [false, true] {
        in_all_orders(3, is_late, || {
            let simulator = simulator(2, None);
            together(&simulator, 3, |copy, gain| whole(copy, gain, 1));
            assert!(simulator.counts().started <= 2);
        });
    }
}

#[test]
fn another_one_takes_the_place_of_one_that_died() {
    in_all_orders(5, true, || {
        let simulator = simulator(1, Some(2));
        together(&simulator, 2, |copy, gain| stepped(copy, gain, 2));
        assert_eq!(simulator.counts().started, 2);
    });
}
