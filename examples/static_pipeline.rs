//! A pipeline put together at compile time, in `f32`, with a detector of your own.
#![allow(clippy::print_stdout, reason = "an example")]

use std::error::Error;

use faer::mat;
use fdiag::{
    compensate::{
        decide::{Debounce, Debouncing},
        residual_compensation::{CompensationPlan, ResidualCompensator},
    },
    core::{
        Fixed, Pipeline, Scalar, Stages, StateVisitor,
        stage::{Detector, Stage, Verdict},
    },
    ident::{
        arx::{ArxOrders, ArxSimulator, RecursiveArx},
        rls::{RlsDesign, Static, UdRls},
    },
    model::{Discrete, SampleTime, StateSpace, signal::Prbs},
    residual::observer::ObserverDesign,
};

/// Your own method: the magnitude of the mean residual, old samples forgotten.
#[derive(Debug)]
struct MovingMean(f32);

impl Stage<f32> for MovingMean {
    fn reset(&mut self) {
        self.0 = 0.0;
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor<f32>) {
        visitor.reals("mean", std::slice::from_mut(&mut self.0));
    }
}

impl Detector<f32> for MovingMean {
    fn residual_len(&self) -> usize {
        1
    }

    fn update(&mut self, _u: &[f32], r: &[f32]) -> Verdict<f32> {
        self.0 += 0.1 * (r[0] - self.0);
        Verdict { statistic: self.0.abs(), threshold: 0.02 }
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let ts = SampleTime::new(0.1)?;
    let (a, b, c, d) = (mat![[0.9]], mat![[0.1]], mat![[1.0]], mat![[0.0]]);
    let model = StateSpace::new(a, b, c, d, Discrete { ts })?;
    let orders = ArxOrders::paper(1);
    let kernel = UdRls::<f32, Static<3>>::new(orders.parameters(1), &RlsDesign::default())?;
    let stages = Stages {
        generator: ObserverDesign::faster(&model, 3.0)?.freeze::<f32, Fixed<1, 1, 1>>()?,
        compensator: ResidualCompensator::new(
            RecursiveArx::new(orders, 1, 1, kernel)?,
            ArxSimulator::new(orders, 1, 1)?,
            &CompensationPlan::default(),
        )?,
        detector: MovingMean(0.0),
        rule: Debounce::new(1, Debouncing::consecutive(3))?,
    };
    let mut pipeline = Pipeline::new(stages)?;

    // The plant has 20 % more gain than its model, and from sample 2000 on a sensor that drifts.
    let mut x = 0.0;
    for (k, u) in Prbs::new(9, 0.5, 1.0).values(4000, ts)?.into_iter().enumerate() {
        let drift = 1e-4 * k.saturating_sub(2000) as f64;
        let step = pipeline.step(&[f32::from_design(u)], &[f32::from_design(x + drift)])?;
        for event in step.events.iter() {
            println!(
                "sample {k}: {event}; r = {:.4}, r* = {:.4}",
                step.residual[0], step.compensated[0]
            );
        }
        x = 0.9 * x + 0.12 * u;
    }
    Ok(())
}
