//! Effects that remember only inputs keep their memory across windows.

use std::{collections::HashMap, sync::Arc};

use fd_model::{Channel, SampleTime};
use fd_sim::{
    model::Parameter,
    simulate::{Initial, Port, Simulator},
};

use super::forecast::Settled;
use crate::fit::Log;

/// Change of the initial states, in their size, that shows whether a memory depends on them.
const NUDGE: f64 = 1e-3;

/// A simulator with an effect whose own states depend on nothing but the inputs, such as a rate
/// limit. A window in the middle of a log starts with the memory that the inputs before it have
/// left; an effect that is started afresh instead would be blamed for the first part of each
/// window. Nothing of it comes from measured outputs.
#[derive(Clone, Debug)]
pub(super) struct Carried {
    inner: Box<dyn Simulator>,
    /// The simulator as it is at samples of a free run.
    memories: Arc<HashMap<u64, Box<dyn Simulator>>>,
    /// Whether each state belongs to the effect.
    of_effect: Vec<bool>,
}

impl Carried {
    /// The simulator with the memories that it has at the samples `starts` of a log, when it has
    /// states beyond the first `plant` ones by name and these depend on the inputs alone.
    pub(super) fn new(
        settled: Settled<'_>,
        plant: &[Initial],
        log: &Log,
        starts: &[usize],
    ) -> Option<Self> {
        let inner = settled.simulator.boxed();
        let is_of_plant = |state: &Initial| plant.iter().any(|p| p.channel == state.channel);
        let of_effect: Vec<bool> = inner.initial().iter().map(|s| !is_of_plant(s)).collect();
        if !of_effect.contains(&true) || !starts.iter().any(|start| 0 < *start) {
            return None;
        }
        let value = |p: &Parameter| {
            let nuisance = settled.nuisances.iter().find(|(name, _)| *name == p.name);
            let effect = settled.effects.iter().find(|(variable, _)| variable.name == p.name);
            nuisance.map(|(_, v)| *v).or(effect.map(|(_, v)| *v)).unwrap_or(p.value)
        };
        let theta: Vec<f64> = inner.parameters().iter().map(value).collect();
        let x0: Vec<f64> = inner.initial().iter().map(|state| state.value).collect();
        let nudged = inner.initial().iter().zip(&of_effect).map(|(state, is_of_effect)| {
            let size = state.value.abs().max(state.tolerance.unwrap_or(0.0)).max(1.0);
            if *is_of_effect { state.value } else { state.value + NUDGE * size }
        });
        let nudged: Vec<f64> = nudged.collect();
        let memories = run(&*inner, &theta, &x0, log, starts)?;
        let others = run(&*inner, &theta, &nudged, log, starts)?;
        let is_same = memories.iter().all(|(start, memory)| {
            let other = others[start].state();
            let effects = memory.state().iter().zip(other).zip(&of_effect);
            effects
                .filter(|(_, is_of_effect)| **is_of_effect)
                .all(|((a, b), _)| a.to_bits() == b.to_bits())
        });
        is_same.then(|| Self { inner, memories: Arc::new(memories), of_effect })
    }
}

/// Copies of a simulator at some samples of a run; `None` when it diverges or cannot go on from
/// another state.
fn run(
    simulator: &dyn Simulator,
    theta: &[f64],
    x0: &[f64],
    log: &Log,
    starts: &[usize],
) -> Option<HashMap<u64, Box<dyn Simulator>>> {
    let mut simulator = simulator.boxed();
    let mut y = vec![0.0; simulator.outputs().len()];
    let mut memories = HashMap::new();
    simulator.start(theta, x0, log.first as u64);
    for k in 0..log.samples {
        if 0 < k && starts.contains(&k) {
            let mut memory = simulator.boxed();
            let x = memory.state().to_vec();
            if !memory.go_on_from(&x) {
                return None;
            }
            memories.insert((log.first + k) as u64, memory);
        }
        simulator.step(log.input(k), log.input(k + 1), &[], &mut y);
        if y.iter().any(|value| !value.is_finite()) {
            return None;
        }
    }
    Some(memories)
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

    /// In the middle of the log, parameters are those of the free run.
    fn start(&mut self, theta: &[f64], x0: &[f64], first: u64) {
        let Some(memory) = self.memories.get(&first) else {
            self.inner.start(theta, x0, first);
            return;
        };
        self.inner = memory.boxed();
        let mut x = x0.to_vec();
        for ((x, known), is_of_effect) in x.iter_mut().zip(memory.state()).zip(&self.of_effect) {
            if *is_of_effect {
                *x = *known;
            }
        }
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
