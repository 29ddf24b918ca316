//! Stand-ins (linear surrogates) for simulators that are expensive to run.
//!
//! A diagnosis tries some hundred candidates, and each costs some dozen runs. Nearly all of these runs only
//! show that a candidate is hopeless, or how the outputs change with a parameter; for both purposes a linear
//! model is good enough. A [`StandIn`] is that model: the simulator, linearised along replays of the logs. At
//! each sample it is set to the state of the replay, one state, input, force or parameter is moved a little,
//! and one step is made: `1 + states + inputs + ports + parameters` runs in all. Where that foretells little, as where
//! dry friction holds a joint at times, it is done again with larger moves. Effects are spliced around a stand-in as
//! around the simulator, so friction still depends on the motion that it changes; only the plant is linear.
//!
//! A stand-in proposes causes, and lends its slopes to fits of the simulator ([`StandIn::lent`]); the answer
//! comes from the simulator alone.
//!
//! *When not to use:* for equations, where thousands of runs take a second. It is not possible where a
//! simulator cannot be set to a state ([`Simulator::go_on_from`]), and of little use where contacts or chaos
//! make slopes worthless: [`StandIn::explains`] says how well it predicts a run of the simulator.
//!
//! [`Simulator::go_on_from`]: crate::simulate::Simulator::go_on_from

mod affine;
mod check;
mod difference;
mod linearise;
mod nudge;
mod replay;
mod replayed;
mod respond;
mod responses;
mod slopes;

use fd_model::{Channel, ModelError, Record, SampleTime};

pub use self::replay::{Driven, Replay};
pub(crate) use self::replayed::ROW;
use self::{
    affine::Affine,
    check::explained,
    linearise::linearise,
    nudge::{COARSE, part},
    replayed::Replayed,
    respond::respond,
    responses::Responses,
};
use crate::{
    model::Model,
    scales::ReplayScales,
    simulate::{Nominal, Shell, SimulateError, Simulator},
};

/// Share of a disturbance below which slopes are taken once more, from moves that are large.
const LITTLE: f64 = 0.5;

/// A simulator in its shell, linearised along replays of logs.
///
/// Records have to bring the rows of the replay as one more input: [`record`](Self::record).
#[derive(Clone, Debug)]
pub struct StandIn {
    /// The shell of the simulator: effects are spliced into its model.
    shell: Shell,
    /// The same shell around the linear model.
    inside: Shell,
    /// Where each replay begins among the rows of all.
    begins: Vec<usize>,
    explains: f64,
    runs: usize,
}

impl StandIn {
    /// Linearises the simulator of a shell along replays, with the parameters `theta` of the simulator inside (none for
    /// the nominal ones). `forces` are typical forces at its ports. `None` when it cannot be set to a state, or diverges.
    ///
    /// ```
    /// use fd_sim::{
    ///     model::Model,
    ///     simulate::{EquationSimulator, Nominal, Shell},
    ///     stand_in::{Replay, StandIn},
    /// };
    ///
    /// let model: Model = r#"
    /// version = 1
    /// kind = "equations"
    /// name = "pendulum"
    /// sample_time = 0.05
    /// parameters = { l = { unit = "m", value = 0.5, tolerance = 0.05 } }
    /// inputs = { u = { unit = "1/s^2" } }
    /// outputs = { angle = { unit = "rad", value = "q" } }
    /// [states]
    /// q = { unit = "rad", initial = 0.0, derivative = "w" }
    /// w = { unit = "rad/s", initial = 0.0, derivative = "u - 9.81/l*sin(q) - 0.3*w" }
    /// "#.parse()?;
    /// let ts = model.sample_time()?;
    /// // As of a simulator of which nothing is known but that it steps.
    /// let shell = Shell::new("pendulum", Box::new(EquationSimulator::<f64>::at(&model, ts)?))?;
    /// let u: Vec<f64> = (0..200).map(|k| (0.1 * f64::from(k)).sin()).collect();
    /// let replay = Replay { u: &u, samples: 200, first: 0, x0: None, driven: None };
    /// let stand_in = StandIn::of(&shell, ts, &[replay], &[], None)?.ok_or("states can be set")?;
    /// // Itself, two states, an input and a parameter, and one run to see how good that is.
    /// assert_eq!(stand_in.runs(), 6);
    /// assert!(0.95 < stand_in.explains());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Returns an error when the shell cannot be simulated with samples `ts` apart.
    pub fn of(
        shell: &Shell,
        ts: SampleTime,
        replays: &[Replay<'_>],
        forces: &[f64],
        theta: Option<&[f64]>,
    ) -> Result<Option<Self>, SimulateError> {
        let steps = shell.steps(ts)?;
        let simulator = shell.inside();
        // A shell without effects hands its parameters on as they are, and leaves native effects at rest.
        let mut nominal: Vec<f64> = simulator.parameters().iter().map(|p| p.value).collect();
        if let Some(theta) = theta {
            nominal.iter_mut().zip(theta).for_each(|(to, from)| *to = *from);
        }
        let theta = &nominal[..];
        let moved = simulator.initial().len()
            + simulator.inputs().len()
            + simulator.ports().len()
            + simulator.parameters().len();
        let judged = |linear: Box<dyn Simulator>| {
            let explains = explained(simulator, &*linear, replays, steps, forces, theta);
            (linear, explains)
        };
        let by = |part: f64| {
            let slopes = linearise(simulator, replays, steps, forces, theta, part)?;
            Some(judged(Box::new(Replayed::new(simulator, Affine::new(slopes), steps))))
        };
        let (fine, mut runs) = (part(simulator), 2 + moved);
        let known = match by(fine) {
            Some(known) if fine < COARSE && known.1 < LITTLE => {
                runs *= 2;
                by(COARSE).filter(|coarse| known.1 < coarse.1).or(Some(known))
            }
            known => known,
        };
        let responding = || {
            let known = respond(simulator, replays, steps, forces, theta)?;
            Some(judged(Box::new(Replayed::new(simulator, Responses::new(known), steps))))
        };
        let Some((linear, explains)) = known.or_else(responding) else { return Ok(None) };
        let begins = replays.iter().scan(0, |begin, replay| {
            *begin += replay.samples;
            Some(*begin - replay.samples)
        });
        Ok(Some(Self {
            inside: shell.with_row(linear)?,
            shell: shell.clone(),
            begins: begins.collect(),
            explains,
            runs,
        }))
    }

    /// The shell of the simulator itself, to whose fits the stand-in lends its slopes.
    #[must_use]
    pub fn lent(&self) -> Shell {
        self.shell.clone().with_stand_in(self.inside.clone())
    }

    /// What the simulator is given in a run of a `model` of its shell, with the values that the model states, from the
    /// states of replay `number` on, through the replay; as far as the stand-in knows. `None` where the run diverges, or
    /// is given what it is given anyway.
    ///
    /// # Errors
    ///
    /// Returns an error when the model is not that of this shell, or cannot be simulated with samples `ts` apart.
    pub fn driven(
        &self,
        model: &Model,
        ts: SampleTime,
        number: usize,
        replay: &Replay<'_>,
    ) -> Result<Option<Driven>, SimulateError> {
        let nu = replay.u.len() / replay.samples.max(1);
        let begin = self.begins.get(number).copied().unwrap_or_default();
        let rows = (0..replay.samples)
            .flat_map(|k| [&replay.u[k * nu..(k + 1) * nu], &[(begin + k) as f64]].concat());
        let (u, x0): (Vec<f64>, _) = (rows.collect(), replay.start(self.shell.inside()));
        let driven = self.inside.driven(model, ts, [&x0, &u], replay.first)?;
        Ok(driven.filter(|driven| {
            let steps = driven.steps / replay.samples.max(1);
            let is_other = |k: usize| replay.input(k, steps, nu) != &driven.u[k * nu..(k + 1) * nu];
            (0..driven.steps).any(is_other) || driven.f.iter().any(|f| *f != 0.0)
        }))
    }

    /// The record of replay `number`, from 0, with its rows among its inputs.
    ///
    /// # Errors
    ///
    /// Returns an error when it has such an input already.
    pub fn record(&self, number: usize, record: &Record) -> Result<Record, ModelError> {
        let begin = self.begins.get(number).copied().unwrap_or_default();
        let inputs = [record.inputs(), &[Channel::new(ROW, "1")]].concat();
        let rows = (0..record.len())
            .map(|k| ([record.u(k), &[(begin + k) as f64]].concat(), record.y(k).to_vec()));
        let new = Record::from_rows(inputs, record.outputs().to_vec(), rows, record.ts())?;
        Ok(new.at_the_place_of(record))
    }

    /// Share of the change of the outputs by a disturbance of everything that the stand-in foretells, from 0
    /// to 1.
    #[must_use]
    pub fn explains(&self) -> f64 {
        self.explains
    }

    /// Runs of the simulator that were made for it, each through all replays.
    #[must_use]
    pub fn runs(&self) -> usize {
        self.runs
    }
}

impl Nominal for StandIn {
    fn model(&self) -> &Model {
        self.shell.model()
    }

    fn patched(&self, model: &Model, ts: SampleTime) -> Result<Box<dyn Simulator>, SimulateError> {
        self.inside.patched_with_row(model, ts)
    }

    fn keeps_step(&self) -> bool {
        true
    }

    fn scales(
        &self,
        ts: SampleTime,
        u: &[f64],
        samples: usize,
    ) -> Result<ReplayScales, SimulateError> {
        self.inside.scales(ts, u, samples)
    }
}
