//! What does a sample cost from `(u, y)` to the decision, while training and while compensating?
//!
//! The paper's pipeline: observer of 5 states and 5 outputs, `W`, a bias model of second order,
//! magnitude, debouncing. Its sizes are known to the compiler (`fixed`) or at construction
//! (`heap`), its methods to the compiler or at run time (`boxed`). A `fleet` is 1024 units that learn
//! and compensate side by side.
#![allow(clippy::unwrap_used, reason = "a benchmark")]
#![allow(missing_docs, reason = "criterion's macros make public functions")]

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use fdiag::{
    compensate::{
        SampleRows,
        decide::{Debounce, Debouncing},
        detect::Magnitude,
        residual_compensation::{CompensationPlan, PreFitted, ResidualCompensator},
    },
    core::{
        Buffer, DynStages, Fixed, Heap, LinMap, Pipeline, Scalar, Stages, Storage,
        stage::{Compensator, DecisionRule, Detector, Phase, ResidualGenerator, Stage},
    },
    fleet::{Fleet, FleetBlock, FleetDesign, FleetScalar},
    ident::{
        arx::{ArxFit, ArxModel, ArxOrders, ArxSimulator, RecursiveArx},
        rls::{RlsDesign, RlsStorage, Static, UdRls},
    },
    residual::{GeneratorDesign, observer::Observer, weighted::Weighted},
};
use fdiag_benches::{MEASUREMENT, PaperCase, SAMPLES, WARM_UP};
use rayon::ThreadPoolBuilder;

const ORDERS: ArxOrders = ArxOrders::paper(2);

/// Where the numbers of all stages live.
trait Layout<T: Scalar> {
    type Observer: Storage<T>;
    type Weight: LinMap<T>;
    type Inner: Buffer<T>;
    type Covariance: RlsStorage<T>;
}

struct OnStack;
struct OnHeap;

impl<T: Scalar> Layout<T> for OnStack {
    type Observer = Fixed<5, 1, 5>;
    type Weight = <Fixed<5, 1, 1> as Storage<T>>::Yx;
    type Inner = [T; 5];
    type Covariance = Static<5>;
}

impl<T: Scalar> Layout<T> for OnHeap {
    type Observer = Heap;
    type Weight = <Heap as Storage<T>>::Yx;
    type Inner = Vec<T>;
    type Covariance = Heap;
}

type Generator<T, L> = Weighted<
    T,
    Observer<T, <L as Layout<T>>::Observer>,
    <L as Layout<T>>::Weight,
    <L as Layout<T>>::Inner,
>;
type Bias<T, L> = ResidualCompensator<
    T,
    RecursiveArx<T, UdRls<T, <L as Layout<T>>::Covariance>>,
    ArxSimulator<T>,
>;

/// Everything that is decided before the first sample.
struct Design {
    case: PaperCase,
    bias: ArxModel,
    fit: PreFitted,
}

impl Design {
    fn new() -> Self {
        let case = PaperCase::new().unwrap();
        let bias = ArxFit::new(ORDERS).fit(&[&case.residual]).unwrap().model;
        let rows = |record: &fdiag::model::Record| -> (Vec<f64>, Vec<f64>) {
            (record.input(0).collect(), record.output(0).collect())
        };
        let (u, r) = rows(&case.residual);
        let (u, r) = (SampleRows::new(1, &u).unwrap(), SampleRows::new(1, &r).unwrap());
        let fit = PreFitted::from_training(bias.theta().to_vec(), u, r);
        Self { case, bias, fit }
    }

    fn stages<T: Scalar, L: Layout<T>>(
        &self,
        phase: &str,
    ) -> Stages<Generator<T, L>, Bias<T, L>, Magnitude<T>, Debounce> {
        let kernel = UdRls::new(ORDERS.parameters(1), &RlsDesign::default()).unwrap();
        let identifier = RecursiveArx::new(ORDERS, 1, 1, kernel).unwrap();
        let simulator = self.bias.freeze().unwrap();
        let mut plan = CompensationPlan::default();
        let compensator = if phase == "training" {
            plan.convergence.least_samples = u64::MAX;
            ResidualCompensator::new(identifier, simulator, &plan)
        } else {
            ResidualCompensator::pre_fitted(identifier, simulator, self.fit.clone(), &plan)
        };
        let observer = self.case.observer.freeze().unwrap();
        Stages {
            generator: self.case.generator.behind(observer).unwrap(),
            compensator: compensator.unwrap(),
            detector: Magnitude::new(&[1.0], 0.01).unwrap(),
            rule: Debounce::new(1, Debouncing::consecutive(3)).unwrap(),
        }
    }

    fn samples<T: Scalar>(&self) -> Vec<(Vec<T>, Vec<T>)> {
        let convert = |row: &[f64]| row.iter().map(|&v| T::from_design(v)).collect();
        self.case.record.samples().map(|(u, y)| (convert(u), convert(y))).collect()
    }
}

fn run<T, G, C, D, J>(
    c: &mut Criterion,
    (phase, name): (&str, String),
    samples: &[(Vec<T>, Vec<T>)],
    stages: Stages<G, C, D, J>,
) where
    T: Scalar,
    G: ResidualGenerator<T>,
    C: Compensator<T>,
    D: Detector<T>,
    J: DecisionRule<T>,
{
    let mut pipeline = Pipeline::new(stages).unwrap();
    let mut group = c.benchmark_group(format!("sample, {phase}"));
    group.throughput(Throughput::Elements(samples.len() as u64));
    let mut compensated = 0;
    group.bench_function(name, |b| {
        b.iter(|| {
            pipeline.reset();
            compensated = 0;
            let mut peak = T::zero();
            for (u, y) in samples {
                let step = pipeline.step(u, y).unwrap();
                compensated += usize::from(step.phase == Phase::Compensating);
                peak = peak.max(step.verdict.statistic);
            }
            peak
        });
    });
    group.finish();
    // All samples were of the phase that the figure is about.
    assert_eq!(compensated, if phase == "training" { 0 } else { samples.len() });
}

fn scalar<T: Scalar>(c: &mut Criterion, design: &Design, scalar: &str) {
    let samples = design.samples::<T>();
    for phase in ["training", "compensating"] {
        let name = |layout: &str| (phase, format!("{layout} {scalar}"));
        run(c, name("fixed"), &samples, design.stages::<T, OnStack>(phase));
        run(c, name("heap"), &samples, design.stages::<T, OnHeap>(phase));
        let stages = design.stages::<T, OnHeap>(phase);
        let boxed: DynStages<T> = Stages {
            generator: Box::new(stages.generator),
            compensator: Box::new(stages.compensator),
            detector: Box::new(stages.detector),
            rule: Box::new(stages.rule),
        };
        run(c, name("boxed"), &samples, boxed);
    }
}

/// The same pipeline for many units at once, on one core and on two.
fn fleet<T: FleetScalar>(c: &mut Criterion, design: &Design, scalar: &str) {
    const UNITS: usize = 1024;
    let samples = design.samples::<T>();
    let io = design.case.generator.io();
    let mut block = FleetBlock::new(io, UNITS, samples.len());
    for unit in 0..UNITS {
        for (step, (u, y)) in samples.iter().enumerate() {
            block.set(unit, step, u, y);
        }
    }
    let mut bench = |phase, training, threads| {
        let design = FleetDesign {
            generator: design.case.generator.form().unwrap(),
            orders: ORDERS,
            // A prior that f32 can hold too.
            learning: RlsDesign { prior_variance: 1e2, ..RlsDesign::default() },
            settling: 0,
            training,
            detector: Magnitude::<T>::new(&[1.0], 0.01).unwrap(),
            rule: Debounce::new(1, Debouncing::consecutive(3)).unwrap(),
        };
        let mut fleet = Fleet::<T, _, _>::new(&design, UNITS).unwrap();
        let pool = ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let mut group = c.benchmark_group(format!("sample, {phase}"));
        group.throughput(Throughput::Elements((UNITS * samples.len()) as u64)).sample_size(10);
        let before = fleet.unit(0).samples;
        group.bench_function(format!("fleet {scalar}, threads: {threads}"), |b| {
            b.iter(|| pool.install(|| fleet.update_on_all_cores(&block).unwrap()));
        });
        group.finish();
        // All samples but the first few were of the phase that the figure is about.
        let compensates = fleet.unit(0).phase == Phase::Compensating;
        assert_eq!(compensates, phase == "compensating");
        assert!(fleet.unit(0).samples > before + 1000);
    };
    for threads in [1, 2] {
        bench("training", u64::MAX, threads);
        bench("compensating", 100, threads);
    }
}

fn pipelines(c: &mut Criterion) {
    let design = Design::new();
    fleet::<f64>(c, &design, "f64");
    fleet::<f32>(c, &design, "f32");
    scalar::<f64>(c, &design, "f64");
    scalar::<f32>(c, &design, "f32");
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(SAMPLES)
        .warm_up_time(WARM_UP)
        .measurement_time(MEASUREMENT);
    targets = pipelines
}
criterion_main!(benches);
