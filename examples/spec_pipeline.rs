//! A pipeline described in TOML and trained on a healthy log, and the same with a method of your own.
#![allow(clippy::print_stdout, reason = "an example")]

use std::error::Error;

use faer::{Mat, mat};
use fdiag::{
    compensate::{
        SampleRows,
        decide::Debounce,
        residual_compensation::{FixedParameters, PreFitted, ResidualCompensator},
    },
    core::{
        DynStages, Heap, Pipeline, StateVisitor,
        stage::{Detector, Stage, Verdict},
    },
    model::{
        Channel, Discrete, Inputs, SampleTime, Simulation, StateSpace,
        fault::{FaultProfile, FaultSpec, Site},
        signal::{Prbs, WhiteNoise},
    },
    spec::PipelineSpec,
    training::{Healthy, Trace, residual_record, train},
};

const SPEC: &str = r#"
generator = { kind = "observer", rate = 2.0 }
weighting = [[1.0, 1.0]]
bias.orders = { kind = "fixed", na = 2, nb = 3 }
detector = { kind = "maximum", margin = 0.05 }
rule = { raise = 3, out_of = 3 }
"#;

/// Your own method: the magnitude of the mean residual, old samples forgotten.
#[derive(Debug)]
struct MovingMean(f64);

impl Stage for MovingMean {
    fn reset(&mut self) {
        self.0 = 0.0;
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor<f64>) {
        visitor.reals("mean", std::slice::from_mut(&mut self.0));
    }
}

impl Detector for MovingMean {
    fn residual_len(&self) -> usize {
        1
    }

    fn update(&mut self, _u: &[f64], r: &[f64]) -> Verdict<f64> {
        self.0 += 0.1 * (r[0] - self.0);
        Verdict { statistic: self.0.abs(), threshold: 0.005 }
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    // The plant has 20 % more gain than its model, and in the later log a sensor that drifts.
    let ts = SampleTime::new(0.1)?;
    let with_gain = |gain| {
        let (a, b) = (mat![[0.9, 0.05], [0.0, 0.8]], mat![[0.0], [gain]]);
        StateSpace::new(a, b, Mat::identity(2, 2), Mat::zeros(2, 1), Discrete { ts })
    };
    let (model, plant) = (with_gain(0.2)?, with_gain(0.24)?.freeze::<f64, Heap>()?);
    let inputs =
        Inputs::from_signals([(Channel::new("u", "1"), Prbs::new(9, 0.5, 1.0))], 2000, ts)?;
    let run = |seed, faults| {
        let output_noise = [seed, seed + 1].map(|s| WhiteNoise::new(2e-3, s).into()).to_vec();
        let simulation = Simulation { output_noise, faults, ..Simulation::default() };
        simulation.run(&plant, &inputs, Channel::numbered("y", 2))
    };
    let healthy = run(1, vec![])?;
    let drift = FaultSpec::add(Site::sensor(0), 100.0, FaultProfile::drift(1e-3));
    let later = run(3, vec![drift])?;

    let spec: PipelineSpec = SPEC.parse()?;
    let trained = train(&spec, &model, &[Healthy::split(&healthy, 0.7)])?;
    let trace = Trace::of(&mut trained.compensated()?, &later)?;
    println!("drift from sample 1000 on; the spec's detector: {:?}", trace.first_alarm(0));

    // Any stage can be exchanged: what the spec designed, with another detector.
    let mut generator = trained.design().build()?;
    let residual = residual_record(&mut generator, &healthy, 0)?;
    let (u, r): (Vec<f64>, Vec<f64>) = (residual.input(0).collect(), residual.output(0).collect());
    let (u, r) = (SampleRows::new(1, &u)?, SampleRows::new(1, &r)?);
    let theta = trained.bias_model().theta();
    let fit = PreFitted::from_training(theta.clone(), u, r);
    let (fixed, simulator) = (FixedParameters::new(1, 1, &theta), trained.bias_model().freeze()?);
    generator.reset();
    let stages = DynStages {
        generator,
        compensator: Box::new(ResidualCompensator::pre_fitted(
            fixed,
            simulator,
            fit,
            &spec.compensation,
        )?),
        detector: Box::new(MovingMean(0.0)),
        rule: Box::new(Debounce::new(1, spec.rule)?),
    };
    let trace = Trace::of(&mut Pipeline::new(stages)?, &later)?;
    println!("a detector of your own: {:?}", trace.first_alarm(0));
    Ok(())
}
