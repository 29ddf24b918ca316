//! Steps of a simulator that makes whole runs only.
//!
//! Each step is a whole run, one sample longer than the one before: as many samples as a square. But most steps go
//! through inputs that were gone through before, those of a log. So a run is made further than it was asked for, with
//! what came next in such a run, and its outputs are those of the next steps as long as their inputs come as foreseen;
//! outputs do not depend on what comes later.

use super::{super::tapes::Foreseen, OutsideSimulator};

/// Fewest samples that are looked ahead; of longer runs as many as were made.
const AHEAD: usize = 16;

impl OutsideSimulator {
    /// The outputs after the samples so far and one more, with `row`.
    pub(super) fn step_whole(&mut self, row: &[f64], y: &mut [f64]) {
        let (k, ny) = (self.samples, y.len());
        if let Some(known) = self.foreseen.at(k, ny) {
            y.copy_from_slice(known);
            return;
        }
        // States would be those at the end of the longer run.
        let tape = [&self.tape[..], row].concat();
        let next = if self.x.is_empty() {
            let (nu, tapes) = (self.shared.contract.inputs.len(), &self.shared.tapes);
            let rest = tapes.rest(self.first, &tape);
            rest.or_else(|| tapes.after(self.first + k as u64, row, nu, AHEAD.max(k)))
        } else {
            None
        };
        if let Some(next) = next {
            let samples = k + 1 + next.len() / row.len().max(1);
            let mut all = vec![0.0; samples * ny];
            if self.roll_out(&[&tape[..], &next].concat(), samples, &mut all) {
                y.copy_from_slice(&all[k * ny..(k + 1) * ny]);
                let y = all.split_off((k + 1) * ny);
                self.foreseen = Foreseen { begin: k + 1, rows: next, y };
                return;
            }
            // What is lost later need not be lost here.
        }
        let mut all = vec![0.0; (k + 1) * ny];
        self.roll_out(&tape, k + 1, &mut all);
        y.copy_from_slice(&all[k * ny..]);
    }
}

#[cfg(test)]
mod tests {
    use std::sync::{
        Arc,
        atomic::{AtomicUsize, Ordering::Relaxed},
    };

    use fd_model::{Channel, SampleTime};

    use super::*;
    use crate::{
        outside::{Contract, Instance, Lost, OutsideError, Powers, Source, Start},
        simulate::{Port, Simulator},
    };

    /// The sum of all that was put in, made in whole runs of which samples are counted. Above a limit it is lost.
    #[derive(Clone, Debug, Default)]
    struct Sum {
        calls: Arc<AtomicUsize>,
        samples: Arc<AtomicUsize>,
    }

    impl Instance for Sum {
        fn reset(&mut self, _: Start<'_>) -> Result<(), Lost> {
            Ok(())
        }

        fn measure(&mut self, _: &[f64], _: &mut [f64]) -> Result<(), Lost> {
            Err(Lost::Refused)
        }

        fn step(&mut self, _: &[f64], _: &mut [f64], _: &mut [f64]) -> Result<(), Lost> {
            Err(Lost::Refused)
        }

        fn rollout(
            &mut self,
            _: Start<'_>,
            rows: &[f64],
            samples: usize,
            y: &mut [f64],
            _: &mut [f64],
        ) -> Result<(), Lost> {
            self.calls.fetch_add(1, Relaxed);
            self.samples.fetch_add(samples, Relaxed);
            let mut sum = 0.0;
            for (row, y) in rows.chunks_exact(2).zip(y) {
                sum += row.iter().sum::<f64>();
                *y = sum;
            }
            if sum.abs() < 1e6 { Ok(()) } else { Err(Lost::Refused) }
        }
    }

    impl Source for Sum {
        fn open(&self) -> Result<Box<dyn Instance>, OutsideError> {
            Ok(Box::new(self.clone()))
        }
    }

    const N: usize = 800;

    fn simulator(sum: &Sum) -> OutsideSimulator {
        let port = Port { channel: Channel::new("f", "1") };
        let contract = Contract {
            name: "sum".to_owned(),
            ts: SampleTime::new(1.0).unwrap(),
            inputs: vec![Channel::new("u", "1")],
            outputs: vec![Channel::new("y", "1")],
            noise: vec![None],
            parameters: Vec::new(),
            natives: Vec::new(),
            initial: Vec::new(),
            ports: vec![port],
            motion: Vec::new(),
            powers: Powers { step: false, rollout: true, ..Powers::default() },
        };
        OutsideSimulator::new(contract, sum.clone(), 1).unwrap()
    }

    fn input(k: usize) -> f64 {
        (0.7 * k as f64).sin()
    }

    /// Steps from a sample on, with another input at some sample, and forces; the outputs must be those sums.
    fn steps(simulator: &mut OutsideSimulator, first: usize, other: Option<usize>, force: f64) {
        let (mut y, mut sum) = ([0.0], 0.0);
        simulator.start(&[], &[], first as u64);
        for k in first..N {
            let u = if other == Some(k) { 5.0 } else { input(k) };
            simulator.step(&[u], &[u], &[force], &mut y);
            sum += [u, force].iter().sum::<f64>();
            assert_eq!(y[0].to_bits(), sum.to_bits(), "sample {k}");
        }
    }

    #[test]
    fn steps_through_known_inputs_cost_a_few_runs_and_are_the_same() {
        let sum = Sum::default();
        let mut simulator = simulator(&sum);
        let u: Vec<f64> = (0..N).map(input).collect();
        simulator.simulate(&[], &[], &u, &mut vec![0.0; N]);
        let counted = |act: &mut dyn FnMut()| {
            let before = [&sum.calls, &sum.samples].map(|count| count.load(Relaxed));
            act();
            [&sum.calls, &sum.samples]
                .map(|c| c.load(Relaxed))
                .iter()
                .zip(before)
                .map(|(a, b)| a - b)
                .collect::<Vec<_>>()
        };
        // As in a run that is known, to the end.
        let found = counted(&mut || steps(&mut simulator, 0, None, 0.0));
        assert_eq!(found, [0, 0]);
        // Ahead by 16, and then by as much as was made: 17, 34, 68 ... 800.
        let found = counted(&mut || steps(&mut simulator, 0, None, 0.5));
        assert!(found[0] <= 8 && found[1] <= 3 * N, "{found:?}");
        // From the middle of the log, as windows do.
        let found = counted(&mut || steps(&mut simulator, 300, None, -0.5));
        assert!(found[0] <= 8 && found[1] <= 3 * N, "{found:?}");
        // Another input once: what was foreseen is void, and it goes on from there.
        let found = counted(&mut || steps(&mut simulator, 0, Some(400), 0.25));
        assert!(found[0] <= 12 && found[1] <= 6 * N, "{found:?}");
        // A future that is lost is not the present: outputs are there up to where it is.
        let bad: Vec<f64> = (0..N).map(|k| if k < 500 { input(k) } else { 1e7 }).collect();
        simulator.simulate(&[], &[], &bad, &mut vec![0.0; N]);
        steps(&mut simulator, 0, None, 0.75);
    }
}
