//! What each stage of a pipeline is given, when its verdicts count, and what is told of it: laws over any samples.
#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panicking")]

use fd_core::{
    EventKind, Events, Frame, IoDims, MissingSamples, Pipeline, Snapshot, Stages, StateVisitor,
    stage::{
        Compensation, Compensator, Decision, DecisionRule, Detector, Evidence, Fault, Phase,
        ResidualGenerator, Stage, Verdict,
    },
    testing::{memory, nonsense},
};
use proptest::prelude::*;

use EventKind::{AlarmCleared, AlarmRaised, ThresholdValid, ThresholdVoid, TrainingStarted};

/// Sample of the scripted pipeline: the input says what the stages do.
#[derive(Clone, Copy, Debug)]
struct Sample {
    trains: bool,
    void: bool,
    lost: bool,
    bias: f64,
    y: f64,
}

impl Sample {
    fn u(self) -> [f64; 4] {
        let [trains, void, lost] = [self.trains, self.void, self.lost].map(u8::from).map(f64::from);
        [trains, void, self.bias, lost]
    }
}

/// `r = y + u₂`: the bias that the compensator takes away again. No answer where `u₃` says so.
#[derive(Clone, Debug)]
struct Biased;

/// `r* = r − u₂`, in training while `u₀` says so; counts the samples of the training.
#[derive(Clone, Debug, Default)]
struct TakesAway {
    trained: u64,
    asked: bool,
}

/// The sum of `r*` since it began; void where `u₁` says so, in training too.
#[derive(Clone, Debug, Default)]
struct Sum {
    sum: f64,
    void: bool,
}

/// Reports what it was shown: the last channel of `r*` as the size, the statistic as the confidence.
#[derive(Clone, Debug)]
struct Shown;

impl Stage for Biased {
    fn reset(&mut self) {}
    fn visit_state(&mut self, _: &mut dyn StateVisitor<f64>) {}
}

impl ResidualGenerator for Biased {
    fn io(&self) -> IoDims {
        IoDims { nu: 4, ny: 1 }
    }
    fn residual_len(&self) -> usize {
        1
    }
    fn step(&mut self, frame: Frame<'_, f64>, r: &mut [f64]) {
        let u = frame.u();
        r[0] = if u[3] > 0.5 { f64::NAN } else { frame.y()[0] + u[2] };
    }
}

impl Stage for TakesAway {
    fn reset(&mut self) {
        *self = Self::default();
    }
    fn visit_state(&mut self, visitor: &mut dyn StateVisitor<f64>) {
        let mut counts = [self.trained, u64::from(self.asked)];
        visitor.counts("trained, asked", &mut counts);
        (self.trained, self.asked) = (counts[0], counts[1] != 0);
    }
}

impl Compensator for TakesAway {
    fn nu(&self) -> Option<usize> {
        Some(4)
    }
    fn residual_len(&self) -> usize {
        1
    }
    fn step(&mut self, frame: Frame<'_, f64>, r: &[f64], r_star: &mut [f64]) -> Compensation {
        r_star[0] = r[0] - frame.u()[2];
        let mut events = Events::none();
        if frame.u()[0] < 0.5 && !std::mem::take(&mut self.asked) {
            self.trained = 0;
            return Compensation { phase: Phase::Compensating, events };
        }
        if self.trained == 0 {
            events.push(TrainingStarted);
        }
        self.trained = self.trained.saturating_add(1);
        Compensation { phase: Phase::Training { samples: self.trained }, events }
    }
    fn retrain(&mut self) -> bool {
        self.asked = true;
        true
    }
}

impl Stage for Sum {
    fn reset(&mut self) {
        *self = Self::default();
    }
    fn visit_state(&mut self, visitor: &mut dyn StateVisitor<f64>) {
        visitor.reals("sum", std::slice::from_mut(&mut self.sum));
        let mut counts = [u64::from(self.void)];
        visitor.counts("void", &mut counts);
        self.void = counts[0] != 0;
    }
}

impl Detector for Sum {
    fn residual_len(&self) -> usize {
        1
    }
    fn update(&mut self, u: &[f64], r: &[f64]) -> Verdict<f64> {
        self.sum += r[0];
        self.void = u[1] > 0.5;
        Verdict { statistic: self.sum, threshold: u[2] }
    }
    fn is_void(&self) -> bool {
        self.void
    }
}

impl Stage for Shown {
    fn reset(&mut self) {}
    fn visit_state(&mut self, _: &mut dyn StateVisitor<f64>) {}
}

impl DecisionRule for Shown {
    fn residual_len(&self) -> usize {
        1
    }
    fn decide(&mut self, evidence: Evidence<'_, f64>) -> Decision<f64> {
        let Evidence { k, phase, verdict, r_star } = evidence;
        if phase != Phase::Compensating || !verdict.alarm() {
            return Decision::Nominal;
        }
        let (size, confidence) = (Some(r_star[0]), Some(verdict.statistic));
        Decision::Fault(Fault { size, confidence, ..Fault::since(k) })
    }
}

type Scripted = Pipeline<f64, Stages<Biased, TakesAway, Box<dyn Detector>, Shown>>;

fn scripted() -> Scripted {
    Pipeline::new(Stages {
        generator: Biased,
        compensator: TakesAway::default(),
        detector: Box::new(Sum::default()) as Box<dyn Detector>,
        rule: Shown,
    })
    .unwrap()
}

/// All that can be seen of a step, and whether the threshold is void after it.
#[derive(Clone, Debug, PartialEq)]
struct Seen {
    k: u64,
    r: f64,
    r_star: f64,
    phase: Phase,
    verdict: Verdict<f64>,
    decision: Decision<f64>,
    events: Vec<EventKind>,
    void: bool,
}

fn push(pipeline: &mut Scripted, u: &[f64], y: &[f64]) -> Seen {
    let step = pipeline.step(u, y).unwrap();
    let (k, r, r_star) = (step.k, step.residual[0], step.compensated[0]);
    let (phase, verdict, decision) = (step.phase, step.verdict, step.decision);
    let events = step.events.iter().collect();
    Seen { k, r, r_star, phase, verdict, decision, events, void: pipeline.is_void() }
}

fn run(samples: &[Sample]) -> Vec<Seen> {
    let mut pipeline = scripted();
    samples.iter().map(|sample| push(&mut pipeline, &sample.u(), &[sample.y])).collect()
}

/// Whole eighths, so that sums are exact in binary.
fn eighths() -> impl Strategy<Value = f64> {
    (-800..800_i32).prop_map(|n| f64::from(n) / 8.0)
}

fn samples() -> impl Strategy<Value = Vec<Sample>> {
    let flags = (prop::bool::weighted(0.3), any::<bool>(), prop::bool::weighted(0.1));
    let sample = (flags, eighths(), eighths()).prop_map(|((trains, void, lost), bias, y)| Sample {
        trains,
        void,
        lost,
        bias,
        y,
    });
    prop::collection::vec(sample, 1..40)
}

proptest! {
    /// Every stage is given what the one before it made of this sample, and nothing else; the sum begins anew where
    /// judging begins, and after a sample without a residual.
    #[test]
    fn data_flow_forward_only(samples in samples()) {
        let (mut sum, mut trained) = (0.0, 0);
        for (k, (sample, seen)) in (0..).zip(samples.iter().zip(run(&samples))) {
            let Sample { trains, lost, bias, y, .. } = *sample;
            trained = if trains { trained + 1 } else { 0 };
            let phase = match trained {
                0 => Phase::Compensating,
                samples => Phase::Training { samples },
            };
            prop_assert_eq!((seen.k, seen.phase), (k as u64, phase));
            let begins = k == 0 || samples[k - 1].lost || !trains && samples[k - 1].trains;
            sum = if begins { y } else { sum + y };
            if lost {
                prop_assert!(seen.r.is_nan() && seen.r_star.is_nan() && !seen.decision.is_fault());
                continue;
            }
            prop_assert_eq!((seen.r, seen.r_star), (y + bias, y));
            prop_assert_eq!(seen.verdict, Verdict { statistic: sum, threshold: bias });
            let decision = if !trains && bias < sum {
                let (size, confidence) = (Some(y), Some(sum));
                Decision::Fault(Fault { size, confidence, ..Fault::since(k as u64) })
            } else {
                Decision::Nominal
            };
            prop_assert_eq!(seen.decision, decision);
        }
    }

    /// What happened in the compensator is told first; then whether the threshold is void, which it is only while
    /// compensating; then the alarm. The last two once when they begin and once when they end.
    #[test]
    fn events_are_the_changes(samples in samples()) {
        let (mut was_void, mut was_fault, mut was_training) = (false, false, false);
        for (sample, seen) in samples.iter().zip(run(&samples)) {
            let (void, fault) = (sample.void && !sample.trains, seen.decision.is_fault());
            let mut expected = Vec::new();
            if sample.trains && !was_training {
                expected.push(TrainingStarted);
            }
            if void != was_void {
                expected.push(if void { ThresholdVoid } else { ThresholdValid });
            }
            if fault != was_fault {
                expected.push(if fault { AlarmRaised } else { AlarmCleared });
            }
            prop_assert_eq!((seen.events, seen.void), (expected, void));
            (was_void, was_fault, was_training) = (void, fault, sample.trains);
        }
    }

    /// A held sample is the sample with its missing channels as they were when last good, for every stage.
    #[test]
    fn a_held_sample_is_one_with_the_last_good_values(
        samples in samples(),
        holes in prop::collection::vec(prop::array::uniform5(prop::bool::weighted(0.3)), 40),
    ) {
        let mut holding = scripted().with_missing_samples(MissingSamples::Hold { at_most: 40 });
        let mut plain = scripted();
        let mut last = [0.0; 5];
        for (k, (sample, holes)) in samples.iter().zip(&holes).enumerate() {
            let [trains, void, bias, lost] = sample.u();
            let mut now = [trains, void, bias, lost, sample.y];
            let held = k > 0 && holes.contains(&true);
            let mut given = now;
            if held {
                for i in (0..5).filter(|&i| holes[i]) {
                    now[i] = last[i];
                    given[i] = f64::NAN;
                }
            }
            last = now;
            let mut found = push(&mut holding, &given[..4], &given[4..]);
            let expected = push(&mut plain, &now[..4], &now[4..]);
            if held {
                prop_assert_eq!(found.events.remove(0), EventKind::SampleHeld);
            }
            prop_assert_eq!(format!("{found:?}"), format!("{expected:?}"));
        }
    }

    /// The law of memory, of the pipeline as a whole, saved as text wherever it is.
    #[test]
    fn a_pipeline_obeys_the_law_of_memory(samples in samples()) {
        let step = |pipeline: &mut Scripted, k: usize| {
            // As text, in which one NaN is like another.
            format!("{:?}", push(pipeline, &samples[k].u(), &[samples[k].y]))
        };
        memory(&mut scripted(), &mut scripted(), samples.len(), step);
        nonsense(&mut scripted(), samples.len(), step);
        let mut used = scripted();
        (0..samples.len()).for_each(|k| drop(step(&mut used, k)));
        let text = serde_json::to_string(&Snapshot::of(&mut used)).unwrap();
        prop_assert_eq!(serde_json::from_str::<Snapshot>(&text).unwrap(), Snapshot::of(&mut used));
        used.reset();
        prop_assert_eq!(Snapshot::of(&mut used), Snapshot::of(&mut scripted()));
    }
}

/// Training again is asked of the compensator, and takes effect with the next sample.
#[test]
fn the_compensator_is_asked_to_train_again() {
    let mut pipeline = scripted();
    let mut phase = |asks: bool| {
        assert!(!asks || pipeline.retrain());
        push(&mut pipeline, &[0.0; 4], &[1.0]).phase
    };
    assert_eq!(
        [phase(false), phase(true), phase(false)],
        [Phase::Compensating, Phase::Training { samples: 1 }, Phase::Compensating]
    );
}
