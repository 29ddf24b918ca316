//! A linear model of a simulator, valid along replays.

use std::sync::Arc;

use fd_model::{Channel, SampleTime};

use super::{ROW, slopes::Slopes};
use crate::{
    model::Parameter,
    simulate::{Initial, Port, Simulator},
};

/// What it has in common with the simulator that it stands for.
#[derive(Debug)]
struct Contract {
    ts: SampleTime,
    inputs: Vec<Channel>,
    outputs: Vec<Channel>,
    parameters: Vec<Parameter>,
    initial: Vec<Initial>,
    ports: Vec<Port>,
    slopes: Slopes,
    /// Steps per sample.
    steps: usize,
}

/// The simulator, linear around each step of the replays. Its last input is the row that a step is at, counted
/// in samples; where there is no such row it diverges.
#[derive(Clone, Debug)]
pub(super) struct Affine {
    contract: Arc<Contract>,
    x: Vec<f64>,
    /// By how much the parameters are moved.
    theta: Vec<f64>,
    /// The row of the step before, and how many steps were made at it.
    last: Option<(f64, usize)>,
    /// Changes of states, inputs, forces and parameters.
    moved: Vec<f64>,
    result: Vec<f64>,
}

impl Affine {
    pub(super) fn new(simulator: &dyn Simulator, slopes: Slopes, steps: usize) -> Self {
        let row = Channel::new(ROW, "1");
        let (moved, result) = (vec![0.0; slopes.widths.iter().sum()], vec![0.0; slopes.results()]);
        let initial = simulator.initial().to_vec();
        let (x, theta) = (vec![0.0; initial.len()], vec![0.0; slopes.theta.len()]);
        let contract = Contract {
            ts: simulator.ts(),
            inputs: [simulator.inputs(), &[row]].concat(),
            outputs: simulator.outputs().to_vec(),
            parameters: simulator.parameters().to_vec(),
            initial,
            ports: simulator.ports().to_vec(),
            slopes,
            steps,
        };
        Self { contract: Arc::new(contract), x, theta, last: None, moved, result }
    }

    /// The step that comes next at a row of samples.
    fn next(&self, row: f64) -> Option<(usize, usize)> {
        let Contract { steps, slopes, .. } = &*self.contract;
        let step = match self.last {
            Some((last, step)) if last == row => (step + 1) % steps,
            _ => 0,
        };
        if !(0.0..(slopes.rows() / steps) as f64).contains(&row) {
            return None;
        }
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a row")]
        let row = row as usize;
        Some((row * steps + step, step))
    }

    /// Outputs and next states of a step at `row`.
    fn results(&mut self, row: usize, u: &[f64], f: &[f64]) {
        let slopes = &self.contract.slopes;
        let [nx, nu, nf, _] = slopes.widths;
        let (x, rest) = self.moved.split_at_mut(nx);
        let (du, rest) = rest.split_at_mut(nu);
        let (df, theta) = rest.split_at_mut(nf);
        let known = &slopes.x[row * nx..(row + 1) * nx];
        x.iter_mut().zip(self.x.iter().zip(known)).for_each(|(dx, (x, known))| *dx = x - known);
        let known = &slopes.u[row * nu..(row + 1) * nu];
        du.iter_mut().zip(u.iter().zip(known)).for_each(|(du, (u, known))| *du = u - known);
        df.fill(0.0);
        df.iter_mut().zip(f).for_each(|(df, f)| *df = *f);
        theta.copy_from_slice(&self.theta);
        let results = slopes.results();
        self.result.copy_from_slice(&slopes.result[row * results..(row + 1) * results]);
        for (moved, slope) in self.moved.iter().zip(slopes.of_row(row).chunks_exact(results)) {
            if *moved != 0.0 {
                self.result.iter_mut().zip(slope).for_each(|(to, slope)| *to += moved * slope);
            }
        }
    }
}

impl Simulator for Affine {
    fn ts(&self) -> SampleTime {
        self.contract.ts
    }

    fn inputs(&self) -> &[Channel] {
        &self.contract.inputs
    }

    fn outputs(&self) -> &[Channel] {
        &self.contract.outputs
    }

    fn parameters(&self) -> &[Parameter] {
        &self.contract.parameters
    }

    fn initial(&self) -> &[Initial] {
        &self.contract.initial
    }

    fn ports(&self) -> &[Port] {
        &self.contract.ports
    }

    fn start(&mut self, theta: &[f64], x0: &[f64], _first: u64) {
        let nominal = &self.contract.slopes.theta;
        self.theta.iter_mut().zip(theta.iter().zip(nominal)).for_each(|(d, (p, p0))| *d = p - p0);
        self.x.copy_from_slice(x0);
        self.last = None;
    }

    fn step(&mut self, u: &[f64], _u_next: &[f64], f: &[f64], y: &mut [f64]) {
        let nu = self.contract.slopes.widths[1];
        let Some((row, step)) = self.next(u[nu]) else {
            y.fill(f64::NAN);
            return;
        };
        self.results(row, &u[..nu], f);
        let (outputs, states) = self.result.split_at(y.len());
        y.copy_from_slice(outputs);
        self.x.copy_from_slice(states);
        self.last = Some((u[nu], step));
    }

    fn measure(&mut self, u: &[f64], y: &mut [f64]) -> bool {
        let nu = self.contract.slopes.widths[1];
        match self.next(u[nu]) {
            Some((row, _)) => {
                self.results(row, &u[..nu], &[]);
                y.copy_from_slice(&self.result[..y.len()]);
            }
            None => y.fill(f64::NAN),
        }
        true
    }

    fn state(&self) -> &[f64] {
        &self.x
    }

    fn go_on_from(&mut self, x: &[f64]) -> bool {
        self.x.copy_from_slice(x);
        true
    }

    fn boxed(&self) -> Box<dyn Simulator> {
        Box::new(self.clone())
    }
}
