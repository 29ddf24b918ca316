//! Several runs of a simulator outside of this program in lock-step: one call for all lanes, and groups of lanes on
//! several instances at once.

use std::sync::Arc;

use super::{
    super::{
        contract::Contract,
        loan::{Shared, Work},
        lock::open,
        memory::Past,
        source::{Instance, Lost, Start},
        tally::Tally,
    },
    OutsideSimulator,
    settle::settle,
};
use crate::{
    simulate::{Around, Driven, Run, Simulator, lane_by_lane},
    workers::on_workers,
};

type Lanes<'a> = [Box<dyn Driven + 'a>];

/// Makes the runs of all lanes.
pub(super) fn lock_step(simulator: &mut OutsideSimulator, first: u64, lanes: &mut Lanes<'_>) {
    let shared = Arc::clone(&simulator.shared);
    let powers = shared.contract.powers;
    let responses = if powers.step { None } else { open(&shared.responses).clone() };
    if let Some(responses) = responses {
        settle(&shared, &responses, first, lanes);
        return;
    }
    if shared.source.takes_equations() && lanes.iter().all(|lane| lane.equations().is_some()) {
        in_equations(&shared, lanes);
        return;
    }
    let width = if powers.step { powers.lanes.max(1) } else { 1 };
    // As many groups as there are instances, each no wider than one takes.
    let workers = shared.pool.workers();
    let width = width.min(lanes.len().div_ceil(workers)).max(1);
    let groups: Vec<&mut Lanes<'_>> = lanes.chunks_mut(width).collect();
    on_workers(workers, groups, |group| {
        let mut copy = OutsideSimulator::of(Arc::clone(&shared));
        if group.len() < 2 || !copy.in_lock_step(first, group) {
            lane_by_lane(&mut copy, first, group);
        }
    });
}

/// Makes the runs of lanes where the simulators are, groups of one length in one call.
fn in_equations(shared: &Arc<Shared>, lanes: &mut Lanes<'_>) {
    let width = shared.source.lanes().min(lanes.len().div_ceil(shared.pool.workers())).max(1);
    let mut groups: Vec<&mut Lanes<'_>> = Vec::new();
    for same in lanes.chunk_by_mut(|a, b| a.steps() == b.steps()) {
        groups.extend(same.chunks_mut(width));
    }
    on_workers(shared.pool.workers(), groups, |group| {
        OutsideSimulator::of(Arc::clone(shared)).whole(group);
    });
}

impl OutsideSimulator {
    /// Makes the runs of lanes of one length in one call.
    fn whole(&mut self, lanes: &mut Lanes<'_>) {
        let all: Vec<Around<'_>> = lanes.iter().filter_map(|lane| lane.equations()).collect();
        let Some(around) = all.first().copied() else { return };
        let size = around.samples * self.outputs().len();
        let mut y = vec![f64::NAN; all.len() * size];
        // What the group is blamed for is the first lane's.
        let origin = Past::default().and(around.theta).and(around.x0);
        let Self { shared, loan, .. } = self;
        let steps = lanes.iter().map(|lane| lane.steps() as u64).sum();
        let work = loan.work(shared, origin, |instance, reached| {
            *reached = None;
            let places = y.chunks_exact_mut(size.max(1));
            let mut runs: Vec<Run<'_>> =
                all.iter().zip(places).map(|(a, y)| Run::new(a.theta, a.x0, y)).collect();
            instance.in_equations(around, &mut runs)
        });
        if work == Work::Done {
            let count = all.len() as u64;
            for (counter, by) in [
                (&shared.tally.asked, count),
                (&shared.tally.made, count),
                (&shared.tally.steps, steps),
            ] {
                Tally::add(counter, by);
            }
        } else {
            y.fill(f64::NAN);
        }
        drop(all);
        for (lane, y) in lanes.iter_mut().zip(y.chunks_exact(size.max(1))) {
            lane.take_all(y);
        }
        self.rest();
    }

    /// Makes the runs of lanes of one length by calls for all of them; says whether they were made. A lane that leaves
    /// its region gives numbers that are not finite, and the others go on; where a whole call is lost, each lane is
    /// tried by itself.
    fn in_lock_step(&mut self, first: u64, lanes: &mut Lanes<'_>) -> bool {
        let steps = lanes.first().map_or(0, |lane| lane.steps());
        if steps == 0 || lanes.iter().any(|lane| lane.steps() != steps) {
            return false;
        }
        begin(lanes);
        // What the group is blamed for is the first lane's.
        self.start(lanes[0].theta(), lanes[0].x0(), first);
        let Self { shared, loan, origin, .. } = self;
        let count = lanes.len();
        let work = loan.work(shared, *origin, |instance, reached| {
            *reached = None;
            begin(lanes);
            let starts: Vec<Start<'_>> =
                lanes.iter().map(|l| Start { theta: l.theta(), x0: l.x0(), first }).collect();
            instance.reset_lanes(&starts)?;
            drop(starts);
            together(instance, &shared.contract, steps, lanes)
        });
        if work == Work::Done {
            let made = (count * steps) as u64;
            for (counter, by) in [
                (&shared.tally.asked, count as u64),
                (&shared.tally.made, count as u64),
                (&shared.tally.steps, made),
            ] {
                Tally::add(counter, by);
            }
        }
        self.rest();
        work == Work::Done
    }
}

fn begin(lanes: &mut Lanes<'_>) {
    for lane in lanes {
        lane.begin();
    }
}

/// All steps of lanes that were reset.
fn together(
    instance: &mut dyn Instance,
    contract: &Contract,
    steps: usize,
    lanes: &mut Lanes<'_>,
) -> Result<(), Lost> {
    let (nu, nf, ny) = (contract.inputs.len(), contract.ports.len(), contract.outputs.len());
    let (width, n) = (nu + nf, lanes.len());
    let (mut rows, mut u) = (vec![0.0; n * width], vec![0.0; n * nu]);
    let (mut seen, mut y) = (vec![0.0; n * ny], vec![0.0; n * ny]);
    let mut x = vec![0.0; if contract.powers.states { n * contract.initial.len() } else { 0 }];
    let mut goes_on = vec![true; n];
    for step in 0..steps {
        if contract.powers.measure {
            for (lane, u) in lanes.iter().zip(u.chunks_exact_mut(nu.max(1))) {
                u.copy_from_slice(lane.input(step));
            }
            instance.measure_lanes(n, &u, &mut seen)?;
        }
        for (i, lane) in lanes.iter_mut().enumerate().filter(|(i, _)| goes_on[*i]) {
            let seen = contract.powers.measure.then_some(&seen[i * ny..(i + 1) * ny]);
            let (u, f) = rows[i * width..(i + 1) * width].split_at_mut(nu);
            lane.drive(step, seen, u, f);
        }
        instance.step_lanes(n, &rows, &mut y, &mut x)?;
        for (i, lane) in lanes.iter_mut().enumerate() {
            goes_on[i] = goes_on[i] && lane.take(step, &y[i * ny..(i + 1) * ny]);
        }
        if !goes_on.contains(&true) {
            break;
        }
    }
    Ok(())
}
