//! A residual generator of your own, in one file, next to those of the library.
//!
//! The method here is the oldest one: two sensors that ought to agree are compared, the second
//! after a gain. It needs no model, so its form has no `H_u`.
#![allow(clippy::print_stdout, reason = "an example")]

use std::error::Error;

use faer::{Mat, mat};
use fdiag::{
    core::{
        Frame, IoDims, Scalar, StateVisitor,
        stage::{ResidualGenerator, Stage},
    },
    model::{Discrete, SampleTime, StateSpace},
    residual::{
        DesignError, GeneratorDesign, ResidualForm,
        analysis::{UnknownInputs, fault_effects},
        bank::BankDesign,
    },
    spec::GeneratorSpec,
};

/// Design time: `r = y₁ − gain · y₂`, smoothed by `x⁺ = x + speed (r − x)`.
#[derive(Clone, Debug)]
struct Comparison {
    io: IoDims,
    domain: Discrete,
    gain: f64,
    speed: f64,
}

/// Run time, in any scalar.
#[derive(Clone, Debug)]
struct RunningComparison<T> {
    io: IoDims,
    gain: T,
    speed: T,
    smooth: T,
}

impl GeneratorDesign for Comparison {
    fn io(&self) -> IoDims {
        self.io
    }

    fn residual_len(&self) -> usize {
        1
    }

    /// What the analysis needs to know: the transfer functions from `[u; y]` to `r`.
    fn form(&self) -> Result<ResidualForm, DesignError> {
        let IoDims { nu, ny } = self.io;
        let weight = |j: usize| match j.checked_sub(nu) {
            Some(0) => 1.0,
            Some(1) => -self.gain,
            _ => 0.0,
        };
        let row = Mat::from_fn(1, nu + ny, |_, j| self.speed * weight(j));
        let keep = 1.0 - self.speed;
        let c = mat![[keep]];
        let system = StateSpace::new(mat![[keep]], row.clone(), c, row, self.domain)?;
        ResidualForm::new(self.io, system)
    }

    fn build(&self) -> Result<Box<dyn ResidualGenerator>, DesignError> {
        let (gain, speed) = (self.gain, self.speed);
        Ok(Box::new(RunningComparison { io: self.io, gain, speed, smooth: 0.0 }))
    }
}

impl<T: Scalar> Stage<T> for RunningComparison<T> {
    fn reset(&mut self) {
        self.smooth = T::zero();
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor<T>) {
        visitor.reals("smoothed difference", std::slice::from_mut(&mut self.smooth));
    }
}

impl<T: Scalar> ResidualGenerator<T> for RunningComparison<T> {
    fn io(&self) -> IoDims {
        self.io
    }

    fn residual_len(&self) -> usize {
        1
    }

    fn step(&mut self, frame: Frame<'_, T>, r: &mut [T]) {
        let y = frame.y();
        self.smooth += self.speed * (y[0] - self.gain * y[1] - self.smooth);
        r[0] = self.smooth;
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    // One tank with two level sensors in different units.
    let domain = Discrete { ts: SampleTime::new(0.1)? };
    let (b, c) = (mat![[0.1]], mat![[1.0], [0.25]]);
    let model = StateSpace::new(mat![[0.95]], b, c, Mat::zeros(2, 1), domain)?;
    let own = Comparison { io: IoDims { nu: 1, ny: 2 }, domain, gain: 4.0, speed: 0.2 };

    // The analysis works on it as on every other generator, and so does a bank.
    println!("consistency with the model: {:.1e}", own.form()?.consistency(&model)?);
    let faults = UnknownInputs::none(&model).sensor(&model, 0)?.actuator(&model, 0)?;
    for (name, effect) in
        faults.names().iter().zip(fault_effects(&own.form()?, &faults.system(&model)?)?)
    {
        println!("{name}: detectable {}, lasting {}", effect.detectable, effect.lasting);
    }
    let library = GeneratorSpec::Observer { rate: 2.0 }.design(&model, None, &[])?;
    let mut bank = BankDesign::new(vec![Box::new(own), library])?.build()?;

    // The first sensor is 0.3 too high from sample 100 on.
    let (mut x, mut r) = (0.0, [0.0; 3]);
    for k in 0..200_u32 {
        let u = [if k % 80 < 40 { 1.0 } else { 0.0 }];
        let fault = if k < 100 { 0.0 } else { 0.3 };
        bank.step(Frame::new(bank.io(), k.into(), &u, &[x + fault, 0.25 * x])?, &mut r);
        x = 0.95 * x + 0.1 * u[0];
        if k % 50 == 49 {
            println!("sample {k}: own {:.3}, observer {:.3} {:.3}", r[0], r[1], r[2]);
        }
    }
    Ok(())
}
