//! Several runs side by side.

use std::sync::Arc;

use super::{engine::Engine, system::System};
use crate::{
    equation::{Lanes, Value},
    simulate::run::{Run, rows},
};

/// Most runs side by side: two of the widest registers, so that neither waits for the other.
pub(super) const WIDEST: usize = 16;
/// Runs side by side when there are no more than that …
const WIDE: usize = 8;
/// … and no more than that.
const NARROW: usize = 4;

/// Engines for several runs, each made when it is needed first.
#[derive(Clone, Debug, Default)]
pub(super) struct Many {
    widest: Option<Box<Engine<Lanes<WIDEST>>>>,
    wide: Option<Box<Engine<Lanes<WIDE>>>>,
    narrow: Option<Box<Engine<Lanes<NARROW>>>>,
}

impl Many {
    /// Makes at most [`WIDEST`] runs.
    pub(super) fn run(
        &mut self,
        system: &Arc<System>,
        first: u64,
        u: &[f64],
        runs: &mut [Run<'_>],
    ) {
        match runs.len() {
            1..=NARROW => run(engine(&mut self.narrow, system), first, u, runs),
            ..=WIDE => run(engine(&mut self.wide, system), first, u, runs),
            _ => run(engine(&mut self.widest, system), first, u, runs),
        }
    }
}

fn engine<'a, V: Value>(
    place: &'a mut Option<Box<Engine<V>>>,
    system: &Arc<System>,
) -> &'a mut Engine<V> {
    place.get_or_insert_with(|| Box::new(Engine::new(Arc::clone(system))))
}

/// Runs as many at once as there are lanes, or fewer.
fn run<const N: usize>(engine: &mut Engine<Lanes<N>>, first: u64, u: &[f64], runs: &mut [Run<'_>]) {
    let Some(one) = runs.first() else { return };
    let (nu, ny) = (engine.system.inputs.len(), engine.system.channels.len());
    let (samples, inputs) = (one.y.len() / ny, rows(u, nu));
    // A lane that nobody needs does what the first one does.
    let gather = |values: fn(&Run<'_>, usize) -> f64, i: usize| {
        let mut all = Lanes::splat(values(one, i));
        for (lane, run) in runs.iter().enumerate() {
            all.set_lane(lane, values(run, i));
        }
        all
    };
    let theta: Vec<_> = (0..one.theta.len()).map(|i| gather(|run, i| run.theta[i], i)).collect();
    let x0: Vec<_> = (0..one.x0.len()).map(|i| gather(|run, i| run.x0[i], i)).collect();
    engine.restart(&theta, &x0, first);
    let mut row = vec![Lanes::splat(0.0); ny];
    for k in 0..samples {
        let [now, next] = inputs(k);
        engine.advance(now, next, &[], &mut row);
        for (lane, run) in runs.iter_mut().enumerate() {
            let values = &mut run.y[k * ny..(k + 1) * ny];
            values.iter_mut().zip(&row).for_each(|(y, row)| *y = row.0[lane]);
        }
        if !row.iter().all(Value::all_finite) {
            let mut is_over = true;
            for run in &mut *runs {
                is_over &= !run.check(k, ny);
            }
            if is_over {
                break;
            }
        }
    }
    for run in runs {
        run.finish(ny);
    }
}
