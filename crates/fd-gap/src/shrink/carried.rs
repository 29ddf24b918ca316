//! What an effect remembers outlives a window.

use std::{collections::HashMap, sync::Arc};

use fd_model::{Channel, SampleTime};
use fd_sim::{
    model::Parameter,
    simulate::{Initial, Port, Simulator},
};

use crate::fit::{Log, Segment};

/// A simulator of which the effect begins a window with what it remembers of those before: the level of a hidden store, the
/// side on which a play rests. Started afresh, it would be blamed for the first part of each window. The plant is where it
/// was estimated to be at the start of every window, so that its errors do not add up.
#[derive(Clone, Debug)]
pub(super) struct Carried {
    inner: Box<dyn Simulator>,
    /// The simulator as it is at the first samples of windows.
    memories: Arc<HashMap<u64, Box<dyn Simulator>>>,
    /// Whether each state belongs to the effect.
    of_effect: Vec<bool>,
}

impl Carried {
    /// A simulator that has states beyond those of the `plant`, by name, with what it remembers at the starts of the segments
    /// of a log, of which the states of the plant there are known. `None` where there is nothing to remember, the
    /// simulation diverges or cannot go on from another state.
    pub(super) fn new(
        simulator: &dyn Simulator,
        plant: &[Initial],
        theta: &[f64],
        log: &Log,
        starts: &[(Segment, Vec<f64>)],
    ) -> Option<Self> {
        let is_of_plant = |state: &Initial| plant.iter().any(|p| p.channel == state.channel);
        let initial = simulator.initial().iter();
        let of_effect: Vec<bool> = initial.map(|state| !is_of_plant(state)).collect();
        let [(first, x0), others @ ..] = starts else { return None };
        if !of_effect.contains(&true) || others.is_empty() {
            return None;
        }
        let mut all = Self { inner: simulator.boxed(), memories: Arc::default(), of_effect };
        let mut memories: HashMap<u64, Box<dyn Simulator>> = HashMap::new();
        let mut running = simulator.boxed();
        let mut y = vec![0.0; simulator.outputs().len()];
        running.start(theta, x0, (log.first + first.from) as u64);
        let mut k = first.from;
        for (segment, x0) in others {
            for k in k..segment.from {
                running.step(log.input(k), log.input(k + 1), &[], &mut y);
                if y.iter().any(|value| !value.is_finite()) {
                    return None;
                }
            }
            k = segment.from;
            let x = all.joined(x0, running.state());
            if !running.go_on_from(&x) {
                return None;
            }
            memories.insert((log.first + k) as u64, running.boxed());
        }
        all.memories = Arc::new(memories);
        Some(all)
    }

    /// States of the plant from `x0`, those of the effect from its memory.
    fn joined(&self, x0: &[f64], memory: &[f64]) -> Vec<f64> {
        let each = x0.iter().zip(memory).zip(&self.of_effect);
        each.map(|((x, known), is_of_effect)| if *is_of_effect { *known } else { *x }).collect()
    }
}

impl Simulator for Carried {
    fn ts(&self) -> SampleTime {
        self.inner.ts()
    }

    fn inputs(&self) -> &[Channel] {
        self.inner.inputs()
    }

    fn outputs(&self) -> &[Channel] {
        self.inner.outputs()
    }

    fn parameters(&self) -> &[Parameter] {
        self.inner.parameters()
    }

    fn initial(&self) -> &[Initial] {
        self.inner.initial()
    }

    fn ports(&self) -> &[Port] {
        self.inner.ports()
    }

    /// In the middle of the log, parameters are those that it remembers with.
    fn start(&mut self, theta: &[f64], x0: &[f64], first: u64) {
        let Some(memory) = self.memories.get(&first) else {
            self.inner.start(theta, x0, first);
            return;
        };
        let x = self.joined(x0, memory.state());
        self.inner = memory.boxed();
        self.inner.go_on_from(&x);
    }

    fn step(&mut self, u: &[f64], u_next: &[f64], f: &[f64], y: &mut [f64]) {
        self.inner.step(u, u_next, f, y);
    }

    fn state(&self) -> &[f64] {
        self.inner.state()
    }

    fn boxed(&self) -> Box<dyn Simulator> {
        Box::new(self.clone())
    }
}
