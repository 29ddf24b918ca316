//! Stages in boxes, and what an identifier does that knows no retraining.
#![allow(clippy::unwrap_used, reason = "a failure here is a failed test")]
#![allow(clippy::float_cmp, reason = "small whole numbers are exact")]

use fd_core::{
    Events, Frame, IoDims, Snapshot, StateVisitor,
    stage::{
        BiasModel, Compensation, Compensator, Decision, DecisionRule, Detector, Evidence, Fault,
        GuardReport, Identifier, Phase, Plant, ResidualGenerator, Stage, Verdict,
    },
};

/// A stage of every kind that gives away which of its methods was called: each writes or returns
/// a number that no other does.
#[derive(Clone, Debug)]
struct Telltale {
    calls: u64,
    theta: [f64; 2],
}

const IO: IoDims = IoDims { nu: 3, ny: 4 };

impl Stage for Telltale {
    fn reset(&mut self) {
        self.calls = 0;
    }
    fn visit_state(&mut self, visitor: &mut dyn StateVisitor<f64>) {
        visitor.counts("calls", std::slice::from_mut(&mut self.calls));
    }
}

impl Plant for Telltale {
    fn nx(&self) -> usize {
        5
    }
    fn io(&self) -> IoDims {
        IO
    }
    fn advance(&self, x: &[f64], u: &[f64], x_next: &mut [f64]) {
        x_next[0] = x[0] + 10.0 * u[0];
    }
    fn output(&self, x: &[f64], u: &[f64], y: &mut [f64]) {
        y[0] = x[0] - 10.0 * u[0];
    }
}

impl ResidualGenerator for Telltale {
    fn io(&self) -> IoDims {
        IO
    }
    fn residual_len(&self) -> usize {
        6
    }
    fn step(&mut self, frame: Frame<'_, f64>, r: &mut [f64]) {
        self.calls += 1;
        r[0] = frame.y()[0] - frame.u()[0];
    }
}

impl Identifier for Telltale {
    fn nu(&self) -> usize {
        3
    }
    fn residual_len(&self) -> usize {
        7
    }
    fn update(&mut self, u: &[f64], mu: &[f64]) {
        self.theta = [u[0], mu[0]];
    }
    fn theta(&self) -> &[f64] {
        &self.theta
    }
    fn variance_into(&self, variance: &mut [f64]) {
        variance[0] = 0.25;
    }
    fn guard(&self) -> GuardReport {
        GuardReport { skipped: 1, bounded: 2 }
    }
    fn retrain(&mut self, theta: &[f64]) -> bool {
        self.theta = [theta[0], -theta[1]];
        true
    }
}

impl BiasModel for Telltale {
    fn nu(&self) -> usize {
        3
    }
    fn residual_len(&self) -> usize {
        8
    }
    fn theta_len(&self) -> usize {
        2
    }
    fn load(&mut self, theta: &[f64]) {
        self.theta = [theta[1], theta[0]];
    }
    fn observe(&mut self, u: &[f64], mu: &[f64]) {
        self.theta = [u[0] + mu[0], 0.0];
    }
    fn simulate(&mut self, u: &[f64], mu_hat: &mut [f64]) {
        mu_hat[0] = 2.0 * u[0];
    }
    fn predict(&mut self, u: &[f64], r: &[f64], mu_hat: &mut [f64]) {
        mu_hat[0] = u[0] * r[0];
    }
}

impl Compensator for Telltale {
    fn nu(&self) -> Option<usize> {
        Some(3)
    }
    fn residual_len(&self) -> usize {
        9
    }
    fn step(&mut self, frame: Frame<'_, f64>, r: &[f64], r_star: &mut [f64]) -> Compensation {
        r_star[0] = r[0] - frame.u()[0];
        Compensation { phase: Phase::Training { samples: 11 }, events: Events::none() }
    }
}

impl Detector for Telltale {
    fn nu(&self) -> Option<usize> {
        Some(4)
    }
    fn residual_len(&self) -> usize {
        10
    }
    fn update(&mut self, u: &[f64], r: &[f64]) -> Verdict<f64> {
        Verdict { statistic: u[0], threshold: r[0] }
    }
}

impl DecisionRule for Telltale {
    fn residual_len(&self) -> usize {
        11
    }
    fn decide(&mut self, evidence: Evidence<'_, f64>) -> Decision<f64> {
        Decision::Fault(Fault::since(evidence.k))
    }
}

fn telltale() -> Telltale {
    Telltale { calls: 0, theta: [0.0; 2] }
}

/// A box does what its content does, for every method of every kind of stage.
#[test]
fn stages_in_boxes_are_the_stages_themselves() {
    let mut out = [0.0];
    let plant: Box<dyn Plant> = Box::new(telltale());
    assert_eq!((Plant::nx(&plant), Plant::io(&plant)), (5, IO));
    Plant::advance(&plant, &[1.0], &[2.0], &mut out);
    assert_eq!(out, [21.0]);
    Plant::output(&plant, &[1.0], &[2.0], &mut out);
    assert_eq!(out, [-19.0]);

    let (u, y) = ([1.0; 3], [5.0; 4]);
    let frame = Frame::new(IO, 3, &u, &y).unwrap();
    let mut generator: Box<dyn ResidualGenerator> = Box::new(telltale());
    let sizes = (ResidualGenerator::io(&generator), ResidualGenerator::residual_len(&generator));
    assert_eq!(sizes, (IO, 6));
    ResidualGenerator::step(&mut generator, frame, &mut out);
    assert_eq!(out, [4.0]);
    let stepped = Snapshot::of(&mut generator);
    Stage::reset(&mut generator);
    assert_ne!(Snapshot::of(&mut generator), stepped);
    stepped.restore(&mut generator).unwrap();
    assert_eq!(Snapshot::of(&mut generator), stepped);

    let mut identifier: Box<dyn Identifier> = Box::new(telltale());
    assert_eq!((Identifier::nu(&identifier), Identifier::residual_len(&identifier)), (3, 7));
    Identifier::update(&mut identifier, &[1.0], &[2.0]);
    assert_eq!(Identifier::theta(&identifier), [1.0, 2.0]);
    Identifier::variance_into(&identifier, &mut out);
    assert_eq!(out, [0.25]);
    assert_eq!(Identifier::guard(&identifier), GuardReport { skipped: 1, bounded: 2 });
    assert!(Identifier::retrain(&mut identifier, &[3.0, 4.0]));
    assert_eq!(Identifier::theta(&identifier), [3.0, -4.0]);

    let mut bias: Box<dyn BiasModel> = Box::new(telltale());
    let sizes = (BiasModel::nu(&bias), BiasModel::residual_len(&bias), BiasModel::theta_len(&bias));
    assert_eq!(sizes, (3, 8, 2));
    BiasModel::simulate(&mut bias, &[4.0], &mut out);
    assert_eq!(out, [8.0]);
    BiasModel::predict(&mut bias, &[4.0], &[3.0], &mut out);
    assert_eq!(out, [12.0]);

    let mut compensator: Box<dyn Compensator> = Box::new(telltale());
    assert_eq!(
        (Compensator::nu(&compensator), Compensator::residual_len(&compensator)),
        (Some(3), 9)
    );
    let done = Compensator::step(&mut compensator, frame, &[5.0], &mut out);
    assert_eq!((done.phase, out), (Phase::Training { samples: 11 }, [4.0]));

    let mut detector: Box<dyn Detector> = Box::new(telltale());
    assert_eq!((Detector::nu(&detector), Detector::residual_len(&detector)), (Some(4), 10));
    let verdict = Detector::update(&mut detector, &[2.0], &[1.0]);
    assert_eq!(verdict, Verdict { statistic: 2.0, threshold: 1.0 });

    let mut rule: Box<dyn DecisionRule> = Box::new(telltale());
    assert_eq!(DecisionRule::residual_len(&rule), 11);
    let (k, phase, r_star) = (9, Phase::Compensating, &[0.0][..]);
    let decision = DecisionRule::decide(&mut rule, Evidence { k, phase, verdict, r_star });
    assert_eq!(decision, Decision::Fault(Fault::since(9)));
    assert!(decision.is_fault() && !Decision::<f64>::Nominal.is_fault());
}

/// What a box forwards without an answer is seen in what it holds.
#[test]
fn boxes_pass_on_what_is_loaded_and_observed() {
    let mut bias = Box::new(telltale());
    BiasModel::load(&mut bias, &[1.0, 2.0]);
    assert_eq!(bias.theta, [2.0, 1.0]);
    BiasModel::observe(&mut bias, &[1.0], &[4.0]);
    assert_eq!(bias.theta, [5.0, 0.0]);
}

/// An identifier that cannot start from parameters starts from nothing, and says so.
#[test]
fn retraining_is_starting_anew_by_default() {
    #[derive(Debug)]
    struct Plain(Telltale);
    impl Stage for Plain {
        fn reset(&mut self) {
            self.0.reset();
        }
        fn visit_state(&mut self, visitor: &mut dyn StateVisitor<f64>) {
            self.0.visit_state(visitor);
        }
    }
    impl Identifier for Plain {
        fn nu(&self) -> usize {
            3
        }
        fn residual_len(&self) -> usize {
            7
        }
        fn update(&mut self, _u: &[f64], _mu: &[f64]) {
            self.0.calls += 1;
        }
        fn theta(&self) -> &[f64] {
            &self.0.theta
        }
        fn variance_into(&self, _variance: &mut [f64]) {}
        fn guard(&self) -> GuardReport {
            GuardReport::default()
        }
    }
    let mut identifier = Plain(telltale());
    identifier.update(&[], &[]);
    assert!(!identifier.retrain(&[1.0, 2.0]));
    assert_eq!((identifier.0.calls, identifier.0.theta), (0, [0.0; 2]));
}
