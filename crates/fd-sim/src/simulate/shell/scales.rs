//! Sizes of the signals of a shell, and what forces at its ports do.

use super::Shell;
use crate::{
    equation::Expr,
    model::{Model, Site},
    scales::{AT_REST, ForceScale, ReplayScales, SignalScale},
    simulate::{Run, Simulator, Tape},
};

/// Moments of the replay at which a force is tried.
const PROBES: usize = 12;
/// What kicks move is at least so many times what equal runs differ by.
const ROUGH: f64 = 30.0;
/// Samples between two kicks, at least.
const FEWEST_APART: usize = 4;
/// Change of a velocity or output by a trial force, as a part of what it is usually.
const TRIAL: f64 = 0.01;
/// Samples after which a plant that does not rest has moved.
const AWHILE: usize = 4;

/// Simulates the shell without effects and measures its signals.
pub(super) fn measure(
    shell: &Shell,
    simulator: Box<dyn Simulator>,
    u: &[f64],
    samples: usize,
) -> ReplayScales {
    let ts = simulator.ts();
    let mut replay = Replay { simulator, u, samples, model: &shell.model };
    let y = replay.outputs(&vec![0.0; samples * replay.simulator.ports().len()]);
    let (nu, ny) = (replay.simulator.inputs().len(), shell.names.raw.len());
    let column = |values: &[f64], width: usize, i: usize| -> Vec<f64> {
        values.iter().skip(i).step_by(width).copied().take_while(|x| x.is_finite()).collect()
    };
    let scale = |name: &str, unit: &str, values: &[f64]| {
        SignalScale::of(name, unit, values.iter().copied())
    };
    let model = &shell.model;
    let outputs: Vec<SignalScale> = (model.outputs.iter().enumerate())
        .map(|(i, output)| scale(&output.name, &output.unit, &column(&y, ny, i)))
        .collect();
    let inputs = model.inputs[..nu].iter().enumerate();
    let inputs: Vec<SignalScale> =
        inputs.map(|(i, input)| scale(&input.name, &input.unit, &column(u, nu, i))).collect();
    let sites = model.sites.iter().enumerate().map(|(port, site)| {
        let of = |expr: &Option<Expr>| {
            let name = expr.clone()?;
            let raw = shell.names.raw.iter().position(|raw| Expr::name(raw) == name)?;
            Some((raw, column(&y, ny, raw)))
        };
        let (position, velocity) = (of(&site.position), of(&site.velocity));
        replay.site(port, site, position.as_ref(), velocity.as_ref(), &outputs, &y)
    });
    let sites = sites.collect();
    let rests = replay.rests(&outputs);
    ReplayScales {
        rests,
        signals: Vec::new(),
        ts: ts.seconds(),
        duration: samples as f64 * ts.seconds(),
        step: shell.inside.ts().seconds(),
        inputs,
        // None that an effect could couple to: those of the shell are bookkeeping.
        states: Vec::new(),
        outputs,
        sites,
    }
}

/// The simulator without effects, with its inputs.
struct Replay<'a> {
    simulator: Box<dyn Simulator>,
    u: &'a [f64],
    samples: usize,
    model: &'a Model,
}

impl Replay<'_> {
    /// Outputs of the whole replay with forces, row by row.
    fn outputs(&mut self, f: &[f64]) -> Vec<f64> {
        self.run(self.u, f, self.samples)
    }

    /// Outputs from the start on with inputs and forces, row by row.
    fn run(&mut self, u: &[f64], f: &[f64], samples: usize) -> Vec<f64> {
        let ny = self.simulator.outputs().len();
        let x0: Vec<f64> = self.simulator.initial().iter().map(|state| state.value).collect();
        let mut y = vec![f64::NAN; samples * ny];
        let theta = self.model.nominal();
        self.simulator.replay(0, &mut [Tape { run: Run::new(&theta, &x0, &mut y), u, f }]);
        y
    }

    /// Whether outputs stay where they start while all inputs are zero.
    fn rests(&mut self, outputs: &[SignalScale]) -> bool {
        let (nu, nf) = (self.simulator.inputs().len(), self.simulator.ports().len());
        let y = self.run(&vec![0.0; AWHILE * nu], &vec![0.0; AWHILE * nf], AWHILE);
        let ny = self.simulator.outputs().len();
        let (first, later) = y.split_at(ny);
        let stays = |(y, (first, scale)): (&f64, (&f64, &SignalScale))| {
            (y - first).abs() <= AT_REST * scale.std
        };
        later.chunks(ny).all(|row| row.iter().zip(first.iter().zip(outputs)).all(stays))
    }

    /// Forces at a port, by the sample.
    fn forces(&self, port: usize, force: impl Fn(usize) -> f64) -> Vec<f64> {
        let nf = self.simulator.ports().len();
        let mut f = vec![0.0; self.samples * nf];
        f.iter_mut().skip(port).step_by(nf).enumerate().for_each(|(k, f)| *f = force(k));
        f
    }

    /// What the force at a port moves; `position` and `velocity` are places among the outputs, with
    /// their values.
    fn site(
        &mut self,
        port: usize,
        site: &Site,
        position: Option<&(usize, Vec<f64>)>,
        velocity: Option<&(usize, Vec<f64>)>,
        outputs: &[SignalScale],
        y: &[f64],
    ) -> ForceScale {
        let ts = self.simulator.ts().seconds();
        let rates =
            |values: &[f64]| values.windows(2).map(|x| (x[1] - x[0]) / ts).collect::<Vec<_>>();
        let signal = |values: &[f64]| SignalScale::of("acceleration", "", values.iter().copied());
        let (motion, mobility) = match (velocity, position) {
            (Some((place, values)), _) => {
                let kick = self.kick(port, *place, outputs[*place].std, y);
                (signal(&rates(values)), kick.map(|kick| kick / ts))
            }
            (None, Some((place, values))) => {
                // From rest, a force of 1 moves a unit mass by ts²/2.
                let kick = self.kick(port, *place, outputs[*place].std, y);
                (signal(&rates(&rates(values))), kick.map(|kick| 2.0 * kick / (ts * ts)))
            }
            (None, None) => (signal(&[]), [0.0; 2]),
        };
        let [mean, peak] = mobility;
        let force = match (velocity, position) {
            (None, None) => self.force_that_shows(port, outputs, y),
            _ if motion.moves() && mean != 0.0 => motion.std / mean.abs(),
            _ => 0.0,
        };
        let step = ts / self.steps_per_sample();
        let of = |expr: &Option<Expr>, signal: Option<&(usize, Vec<f64>)>| {
            let (expr, (place, _)) = (expr.clone()?, signal?);
            Some((expr, outputs[*place].clone()))
        };
        ForceScale {
            name: site.name.clone(),
            unit: site.unit.clone(),
            force,
            mobility: mean,
            kick: peak * step,
            is_discrete: true,
            motion,
            acceleration: Expr::Number(0.0),
            compliance: Expr::Number(mean),
            helpers: Vec::new(),
            velocity: of(&site.velocity, velocity),
            position: of(&site.position, position),
        }
    }

    fn steps_per_sample(&self) -> f64 {
        self.simulator.ts().seconds() / self.model.sample_time
    }

    /// Mean and largest magnitude of what a force of 1 during one sample changes in an output of
    /// the next sample, at moments of the replay.
    fn kick(&mut self, port: usize, output: usize, usual: f64, y: &[f64]) -> [f64; 2] {
        let mut force = 1.0;
        let mut kicks = self.kicks(port, output, force, y);
        let size = |kicks: &[f64]| kicks.iter().fold(0.0_f64, |m, k| m.max(k.abs()));
        if 0.0 < size(&kicks) && 0.0 < usual {
            // Small enough to be linear, large enough not to drown in rounding.
            let trial = TRIAL.max((ROUGH * self.simulator.precision()).min(1.0));
            force = trial * usual / size(&kicks);
            kicks = self.kicks(port, output, force, y);
        }
        let mean = kicks.iter().sum::<f64>() / kicks.len().max(1) as f64;
        [mean, size(&kicks)]
    }

    /// One run with all kicks, against that without, of which the outputs are `y`: what the ones before still do goes on
    /// as it did during the last two samples.
    fn kicks(&mut self, port: usize, output: usize, force: f64, y: &[f64]) -> Vec<f64> {
        let ny = self.simulator.outputs().len();
        let every = (self.samples / PROBES).max(FEWEST_APART);
        let is_kicked = |k: usize| every <= k + 1 && (k + 1).is_multiple_of(every);
        let f = self.forces(port, |k| if is_kicked(k) { force } else { 0.0 });
        let pushed = self.outputs(&f);
        let change = |k: usize| pushed[k * ny + output] - y[k * ny + output];
        let kicked = (1..self.samples.saturating_sub(1)).filter(|k| is_kicked(*k));
        let kicks = kicked.map(|k| (change(k + 1) - (2.0 * change(k) - change(k - 1))) / force);
        kicks.filter(|kick| kick.is_finite()).collect()
    }

    /// The constant force that changes some output by as much as it moves in the replay.
    fn force_that_shows(&mut self, port: usize, outputs: &[SignalScale], y: &[f64]) -> f64 {
        let mut force = 1.0;
        // Twice, for the effect of a force that is far too large is not linear.
        for fraction in [TRIAL, 1.0] {
            let pushed = self.outputs(&self.forces(port, |_| force));
            let change = |(i, output): (usize, &SignalScale)| {
                let pairs = pushed.iter().zip(y).skip(i).step_by(outputs.len());
                let squares = pairs.map(|(p, y)| (p - y) * (p - y)).filter(|x| x.is_finite());
                let (sum, n) = squares.fold((0.0, 0.0), |(sum, n), x| (sum + x, n + 1.0));
                if output.std > 0.0 && n > 0.0 { (sum / n).sqrt() / output.std } else { 0.0 }
            };
            let largest = outputs.iter().enumerate().map(change).fold(0.0, f64::max);
            if largest == 0.0 || !largest.is_finite() {
                return 0.0;
            }
            force *= fraction / largest;
        }
        force
    }
}
