//! The contract of a simulator.

use std::{fmt::Debug, sync::Arc};

use fd_core::StateVisitor;
use fd_model::{Channel, SampleTime};

use super::difference_equation::DifferenceEquation;
use super::lock_step::Driven;
use super::native::NativeEffect;
use super::one_by_one::{lane_by_lane, one_by_one, step_through};
use super::run::{Outcome, Run, Tape, drive};
use crate::model::Parameter;

/// A deterministic model of a plant that can be run from any initial state, with any parameters.
///
/// A gap diagnosis does not care how a simulator computes. It runs the simulator over the inputs of a log,
/// compares the outputs with the measured ones, changes a parameter, and runs it again, many thousands of
/// times. This trait provides what that takes: channels, settable values, and a step.
///
/// A [`Plant`](fd_core::stage::Plant) is a map whose state belongs to the caller. A simulator owns its state
/// and everything else that it remembers: a delay line, the memory of a controller, the internals of a
/// co-simulation. That is why it is started and stepped, and cannot be asked for `f(x, u)`.
///
/// # The contract
///
/// * *The lists are fixed*: [`inputs`](Self::inputs), [`outputs`](Self::outputs),
///   [`parameters`](Self::parameters), [`initial`](Self::initial) and [`ports`](Self::ports) have the same
///   entries, in the same order, for the life of the simulator. Values are passed as slices in these orders,
///   and callers keep indices into them.
/// * [`start`](Self::start) forgets everything. A run depends on `theta`, `x0`, `first` and the inputs,
///   and on nothing that happened before.
/// * [`step`](Self::step) writes the outputs of *this* sample and then advances to the next one. Inputs are
///   held between samples, unless the simulator interpolates towards `u_next`.
/// * *The same run gives the same bits*, in this simulator, in a [copy](Self::boxed), on any thread, and as one
///   of many in [`simulate_many`](Self::simulate_many). Slopes are finite differences of runs, and noise makes
///   them worse: a simulator that cannot do without says so ([`repeats`](Self::repeats), [`spread`](Self::spread)).
///   Measurement noise belongs to the diagnosis.
/// * *Smooth in its parameters*, as far as the plant is. An integrator with an adaptive step makes small jumps
///   where it changes the step, and a fit stops at the first of them. Use an even grid of steps.
///
/// # Who calls it, and when
///
/// | who | calls | for |
/// |---|---|---|
/// | a fit | `simulate_many` with slightly different `theta`, `x0` | residuals and their slopes |
/// | a forecast | `start` at sample `first`, then `step` | what comes after the samples it has seen |
/// | a forecast that continues another | `go_on_from`, `step` | a memory that outlives a segment |
/// | a [`Shell`](super::Shell) | `measure`, then `step` with forces | effects that depend on the motion |
/// | a [`Shell`](super::Shell) | `replay` | all other effects spliced around a black box |
/// | parallel work | `boxed` | a copy per thread |
///
/// # What an implementor must and must not do
///
/// * *Not fail in a step.* A run that leaves its region of validity writes NaN from then on, until it is
///   started again. [`Outcome::Diverged`] then says since when, and the fit moves away from there.
/// * *Not allocate in `start` and `step`.* They are the inner loop of everything.
/// * *Not use samples beyond those it was given.* A forecast is honest only if the simulator cannot see what it
///   forecasts.
/// * *Give honest tolerances.* [`Parameter::tolerance`] and [`Initial::tolerance`] tell the diagnosis how wrong
///   the model may be although nothing is missing in it. If they are too wide, parameters explain every gap; a
///   tolerance of zero means that the value is exact.
///
/// Errors belong to constructors. [`SimulateError`](super::SimulateError) is what those of this crate
/// return.
///
/// # Optional capabilities
///
/// A pure black box has no parameters, no initial states and no ports: the lists are empty, and it can still be
/// diagnosed for effects before its inputs and after its outputs. Each list that is not empty allows the
/// diagnosis to do more. `measure`, `go_on_from`, `visit_memory` and `simulate_many` have default bodies that
/// return "no" or process runs one by one; override them when there is something better.
///
/// # How it composes
///
/// `Box<dyn Simulator>` is what everything takes, and it is `Clone`. To be diagnosed a simulator is put
/// into a [`Shell`](super::Shell), a model of equations into which effects can be spliced; the two together
/// are a [`Nominal`](super::Nominal). From the command line a simulator comes out of a model file.
///
/// # When not to implement it
///
/// If the equations are known, write a model file: [`EquationSimulator`](super::EquationSimulator) runs it
/// several parameter sets at a time, effects reach every force in it, and it can be printed. If the model can
/// only be stepped and has no parameters to set, wrap its [`Plant`](fd_core::stage::Plant) in a
/// [`BlackBox`](super::BlackBox). Implement the trait for existing code that has settings and cannot be
/// rewritten.
///
/// # Example
///
/// A heated room, `C Ṫ = P + Q − (T − T_out)/R`, exact for held inputs. Its time constant and its initial
/// temperature can be set, and heat can be added to it:
///
/// ```
/// use fd_model::{Channel, SampleTime};
/// use fd_sim::{
///     model::Parameter,
///     simulate::{Initial, Outcome, Port, Simulator},
/// };
///
/// #[derive(Clone, Debug)]
/// struct Room {
///     channels: [Vec<Channel>; 2],
///     parameters: Vec<Parameter>,
///     initial: Vec<Initial>,
///     ports: Vec<Port>,
///     ts: SampleTime,
///     kept: f64,
///     temperature: [f64; 1],
/// }
///
/// impl Room {
///     /// Kelvin above the outside per watt.
///     const R: f64 = 0.01;
///
///     fn new(ts: SampleTime) -> Self {
///         let degrees = |name| Channel::new(name, "K");
///         let time_constant = Parameter {
///             name: "tau".into(),
///             unit: "s".into(),
///             value: 7200.0,
///             tolerance: 0.1,
///             bounds: Some([600.0, 86400.0]),
///         };
///         let start = Initial { channel: degrees("T"), value: 20.0, tolerance: Some(0.5) };
///         Self {
///             channels: [vec![Channel::new("P", "W"), degrees("T_out")], vec![degrees("T")]],
///             parameters: vec![time_constant],
///             initial: vec![start],
///             ports: vec![Port { channel: Channel::new("Q", "W") }],
///             ts,
///             kept: 0.0,
///             temperature: [0.0],
///         }
///     }
/// }
///
/// impl Simulator for Room {
///     fn ts(&self) -> SampleTime { self.ts }
///     fn inputs(&self) -> &[Channel] { &self.channels[0] }
///     fn outputs(&self) -> &[Channel] { &self.channels[1] }
///     fn parameters(&self) -> &[Parameter] { &self.parameters }
///     fn initial(&self) -> &[Initial] { &self.initial }
///     fn ports(&self) -> &[Port] { &self.ports }
///
///     fn start(&mut self, theta: &[f64], x0: &[f64], _first: u64) {
///         self.kept = (-self.ts.seconds() / theta[0]).exp();
///         self.temperature[0] = x0[0];
///     }
///
///     fn step(&mut self, u: &[f64], _u_next: &[f64], f: &[f64], y: &mut [f64]) {
///         y[0] = self.temperature[0];
///         let heat = u[0] + f.iter().sum::<f64>();
///         let aim = u[1] + Self::R * heat;
///         self.temperature[0] = aim + self.kept * (self.temperature[0] - aim);
///     }
///
///     fn state(&self) -> &[f64] { &self.temperature }
///     fn boxed(&self) -> Box<dyn Simulator> { Box::new(self.clone()) }
/// }
///
/// // An hour at 1 kW while it is 5 K outside, with the nominal parameters and with a lighter room.
/// let mut room = Room::new(SampleTime::new(60.0)?).boxed();
/// let u = [1000.0, 5.0].repeat(61);
/// let (mut nominal, mut lighter) = ([0.0; 61], [0.0; 61]);
/// assert_eq!(room.simulate(&[7200.0], &[20.0], &u, &mut nominal), Outcome::Complete);
/// assert_eq!(room.simulate(&[3600.0], &[20.0], &u, &mut lighter), Outcome::Complete);
///
/// // T = 15 + 5 e^(−t/τ), exact at every sample but for 60 roundings.
/// assert!((nominal[60] - 15.0 - 5.0 * (-0.5_f64).exp()).abs() < 1e-12);
/// assert!((lighter[60] - 15.0 - 5.0 * (-1.0_f64).exp()).abs() < 1e-12);
///
/// // A hundred watts through the port are a kelvin in the long run, with nothing else changed.
/// room.start(&[7200.0], &[15.0], 0);
/// let mut y = [0.0];
/// (0..10_000).for_each(|_| room.step(&[1000.0, 5.0], &[1000.0, 5.0], &[100.0], &mut y));
/// assert!((y[0] - 16.0).abs() < 1e-9);
/// # Ok::<(), fd_model::ModelError>(())
/// ```
pub trait Simulator: Debug + Send + Sync {
    /// Time between samples.
    fn ts(&self) -> SampleTime;

    /// Inputs of a sample.
    fn inputs(&self) -> &[Channel];

    /// Outputs of a sample.
    fn outputs(&self) -> &[Channel];

    /// Parameters that can be set, with nominal values and tolerances.
    fn parameters(&self) -> &[Parameter];

    /// States whose initial value can be set.
    fn initial(&self) -> &[Initial];

    /// Places at which a force can be applied.
    fn ports(&self) -> &[Port];

    /// Effects that the simulator contains but that are dormant. Their parameters are the last of
    /// [`parameters`](Self::parameters), in this order.
    fn natives(&self) -> &[NativeEffect] {
        &[]
    }

    /// Starts a run at sample number `first` of the log with these parameters and states, in the
    /// order of [`parameters`](Self::parameters) and [`initial`](Self::initial).
    ///
    /// Nothing is left over from the run before. Anything else that a simulator remembers (such as the contents
    /// of a delay) starts as if the plant had been at rest until then.
    ///
    /// # Panics
    ///
    /// May panic when the numbers of values are wrong.
    fn start(&mut self, theta: &[f64], x0: &[f64], first: u64);

    /// Writes the outputs `y` of this sample and advances to the next, with forces `f` in the order of
    /// [`ports`](Self::ports), held until then. `u_next` are the inputs of the next sample, for simulators that
    /// interpolate; others ignore them.
    ///
    /// # Panics
    ///
    /// May panic when the numbers of values are wrong.
    fn step(&mut self, u: &[f64], u_next: &[f64], f: &[f64], y: &mut [f64]);

    /// Writes the outputs of this sample without advancing, and returns whether the simulator can do that. A
    /// force that depends on the motion needs it; otherwise such a force uses the outputs of the previous
    /// sample.
    ///
    /// # Panics
    ///
    /// May panic when the numbers of values are wrong.
    fn measure(&mut self, _u: &[f64], _y: &mut [f64]) -> bool {
        false
    }

    /// The state now, in the order of [`initial`](Self::initial).
    fn state(&self) -> &[f64];

    /// Replaces the state in the middle of a run, in the order of [`initial`](Self::initial), and keeps
    /// everything else that the simulator remembers. Returns `false`, and does nothing, if that is
    /// not possible.
    fn go_on_from(&mut self, _x: &[f64]) -> bool {
        false
    }

    /// Shows every number that influences the rest of the run to `visitor`, always in the same order, and
    /// returns whether it can. A simulator started with the same values and then given these numbers continues
    /// bit for bit; the values of the start are not among them.
    ///
    /// A simulator whose internals cannot be read returns false and shows nothing. On-line use needs one that
    /// can; see `patched` in `fd-nonlinear`.
    fn visit_memory(&mut self, _visitor: &mut dyn StateVisitor<f64>) -> bool {
        false
    }

    /// An independent copy, for another thread.
    fn boxed(&self) -> Box<dyn Simulator>;

    /// Runs through `u`, one row per sample, without forces, and writes the outputs to `y` in the same layout.
    /// After a divergence the rest of `y` is NaN.
    ///
    /// The number of samples is that of `y`; the last sample is held when `u` is to be
    /// interpolated.
    ///
    /// # Panics
    ///
    /// May panic when the numbers of values are wrong.
    fn simulate(&mut self, theta: &[f64], x0: &[f64], u: &[f64], y: &mut [f64]) -> Outcome {
        let (nu, ny) = (self.inputs().len(), self.outputs().len());
        self.start(theta, x0, 0);
        let outcome = drive(nu, ny, u, y, |now, next, row| self.step(now, next, &[], row));
        self.rest();
        outcome
    }

    /// Runs several times through the same inputs `u`, row by row one sample after another from
    /// sample number `first` on, without forces. Each run has parameters and an initial state of
    /// its own, and its results are to the bit those of a run alone.
    ///
    /// The number of samples is that of the outputs, the same for all runs. When `u` has a row
    /// more, that is the input after the last sample; else the last one is held.
    ///
    /// A simulator that can do better than one run after the other overrides this.
    ///
    /// # Panics
    ///
    /// May panic when the numbers of values are wrong.
    fn simulate_many(&mut self, first: u64, u: &[f64], runs: &mut [Run<'_>]) {
        one_by_one(self, first, u, runs);
    }

    /// Runs through tapes, each with inputs and forces of its own that are held between samples, from
    /// sample number `first` on. Results are to the bit those of steps.
    ///
    /// A [`Shell`](super::Shell) whose effects do not depend on what the plant does asks in this way. A
    /// simulator that can make a whole run in one call overrides this.
    ///
    /// # Panics
    ///
    /// May panic when the numbers of values are wrong.
    fn replay(&mut self, first: u64, tapes: &mut [Tape<'_>]) {
        step_through(self, first, tapes);
    }

    /// Makes several runs from sample number `first` on, each driven by what it shows, step by step. Results are to the
    /// bit those of each lane alone.
    ///
    /// A simulator that steps several lanes in one call overrides this; by default it is one lane after the other.
    ///
    /// # Panics
    ///
    /// May panic when the numbers of values are wrong.
    fn lock_step(&mut self, first: u64, lanes: &mut [Box<dyn Driven + '_>]) {
        lane_by_lane(self, first, lanes);
    }

    /// Whether it can be stepped. One that makes whole runs only takes one for each step that is not foreseen.
    fn makes_steps(&self) -> bool {
        true
    }

    /// Tells it how its outputs change with inputs and forces, roughly: one equation per output, inputs before forces.
    ///
    /// One that makes whole runs only needs few of them then for a run of which the forces depend on its outputs.
    /// Others need not listen, and do not by default.
    fn foretell(&self, _responses: &Arc<[DifferenceEquation]>) {}

    /// Announces that the run is over, so that its resources (a process, a licence) are free for others. The
    /// next call, if any, is [`start`](Self::start). Calling this is optional: it only saves time.
    fn rest(&mut self) {}

    /// Relative rounding error of its outputs. The larger it is, the further apart are the runs of which
    /// differences are taken.
    fn precision(&self) -> f64 {
        f64::EPSILON
    }

    /// Standard deviation of each output among equal runs, in its unit: part of the noise of whatever is compared
    /// with a run. Empty where nothing is known to differ.
    fn spread(&self) -> &[f64] {
        &[]
    }

    /// Whether the same run gives the same numbers. Where it does not, runs at two places of the parameters differ by
    /// the [`spread`](Self::spread), too; a linear model of such a simulator repeats itself and still has its spread.
    fn repeats(&self) -> bool {
        true
    }

    /// How many copies of it can run at the same time; more of them wait for each other.
    fn workers(&self) -> usize {
        1
    }

    /// A cheaper simulator whose slopes may replace those of this one, if this one is expensive to run. It has
    /// one input more, the last: the number of the sample in all logs of a case, one after the other, counted
    /// from
    /// 0. See [`StandIn`](crate::stand_in::StandIn).
    fn stand_in(&self) -> Option<Box<dyn Simulator>> {
        None
    }
}

impl Clone for Box<dyn Simulator> {
    fn clone(&self) -> Self {
        self.boxed()
    }
}

/// A state of which the initial value can be set.
#[derive(Clone, Debug, PartialEq)]
pub struct Initial {
    /// Name and unit.
    pub channel: Channel,
    /// Nominal initial value.
    pub value: f64,
    /// How well it is known, in the unit; `None` when it is exact.
    pub tolerance: Option<f64>,
}

/// A place at which a force can be applied.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Port {
    /// Name of the place and unit of the force.
    pub channel: Channel,
}
