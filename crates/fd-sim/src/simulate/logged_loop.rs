//! A closed loop whose controller acts on what was logged.
//!
//! The controller of a real loop sees measured outputs, noise included, and so the noise of the
//! sensors drives the plant. A simulated loop knows nothing of it: its controller sees simulated
//! outputs, and what the noise has moved looks like an effect. Here the controller is run on the
//! *logged* outputs instead. It then gives the commands that the plant has really had, and the
//! plant is simulated in the open loop with these (the *direct* approach to identification in
//! closed loop; L. Ljung, *System Identification*, 2nd ed. 1999, section 13.4).
//!
//! That is right for every effect: one of the actuator or of the plant acts after the controller,
//! and what a faulty sensor shows is what the controller saw.
//!
//! *When not to use:* where the controller did not see what was logged (other sensors, other
//! filters, a log of a simulation whose noise was added afterwards): then its commands are wrong.
//! On plants that are unstable without their controller: then small errors grow without end. Both
//! show in what the fit of the nominal model leaves.

use fd_model::{Record, SampleTime};

use super::{
    EquationSimulator, Nominal, Outcome, SimulateError, Simulator,
    logged_outputs::{samples_of_action, see_logged, with_logged_outputs},
};
use crate::{
    equation::Expr,
    model::{Law, Model, ModelError, Output},
    scales::ReplayScales,
};

/// A model with a sampled controller, of which the controller acts on logged outputs.
///
/// Each output that the controller uses is one more reference of it, which has to be in the
/// [`record`](Self::record). The model that effects are spliced into is that with the loop closed.
///
/// ```
/// use fd_sim::{model::Model, simulate::{LoggedLoop, Nominal}};
/// use fd_model::{Channel, Record, SampleTime};
///
/// let model: Model = r#"
/// version = 1
/// kind = "equations"
/// name = "tank"
/// sample_time = 0.1
/// inputs = { u = { unit = "m/s" } }
/// outputs = { y = { unit = "m", value = "h" } }
/// states = { h = { unit = "m", initial = 0.0, derivative = "u - h" } }
/// [controller]
/// sample_time = 0.1
/// references = { r = { unit = "m" } }
/// signals = { u = "2*(r - y)" }
/// "#.parse()?;
/// let ts = SampleTime::new(0.1)?;
/// let logged = LoggedLoop::of(&model, ts).ok_or("a sampled controller that uses an output")?;
/// let simulator = logged.simulator(ts)?;
/// let names: Vec<&str> = simulator.inputs().iter().map(|i| i.name.as_str()).collect();
/// assert_eq!(names, ["r", "y_logged"]);
/// let (r, y) = ([Channel::new("r", "m")], [Channel::new("y", "m")]);
/// let record = Record::from_rows(r.to_vec(), y.to_vec(), [([1.0], [0.2]); 3], ts)?;
/// assert_eq!(logged.record(&record)?.u(2), [1.0, 0.2]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct LoggedLoop<'a> {
    nominal: &'a dyn Nominal,
    /// Names of the outputs that the controller uses, and of the references in their place.
    replaced: Vec<(String, String)>,
    /// Outputs that the controller makes of the log.
    commanded: Vec<String>,
}

/// What a controller on a log does, whatever the plant makes of it: rows of a sample after each other.
#[derive(Clone, Debug, PartialEq)]
pub struct Commands {
    /// Inputs of the plant, in the order of the model.
    pub inputs: Vec<f64>,
    /// Outputs of a plant whose states do not move: right for those that show nothing but inputs.
    pub outputs: Vec<f64>,
}

impl<'a> LoggedLoop<'a> {
    /// The same loop on logged outputs; `None` when it has no controller that acts at samples of
    /// the log and uses an output, or is on logged outputs already. What a controller sees between samples is in no log.
    #[must_use]
    pub fn of(nominal: &'a dyn Nominal, ts: SampleTime) -> Option<Self> {
        if nominal.sees_the_log() {
            return None;
        }
        let mut draft = nominal.model().clone().into_draft();
        samples_of_action(draft.controller.as_ref()?, ts)?;
        let names: Vec<String> = draft.outputs.iter().map(|output| output.name.clone()).collect();
        let seen: Vec<String> = {
            let expressions = draft.controller.as_mut()?.expressions_mut();
            let is_seen = |name: &String| expressions.iter().any(|expr| expr.mentions(name));
            names.into_iter().filter(is_seen).collect()
        };
        let wish = |name: &String| draft.fresh_name(&format!("{name}_logged"));
        let replaced: Vec<_> = seen.iter().map(|name| (name.clone(), wish(name))).collect();
        (!replaced.is_empty()).then_some(Self { nominal, replaced, commanded: Vec::new() })
    }

    /// A record with the logged outputs among its inputs, interpolated where they are missing.
    /// One without these outputs stays as it is.
    ///
    /// # Errors
    ///
    /// Never for a record, which has values for all its channels.
    pub fn record(&self, record: &Record) -> Result<Record, fd_model::ModelError> {
        with_logged_outputs(record, &self.replaced, &self.commanded)
    }

    /// The same where the controller makes these outputs of the log, as commands are: they say nothing of the plant, and
    /// are not measured in a [`record`](Self::record).
    #[must_use]
    pub fn with_commanded(self, commanded: &[String]) -> Self {
        Self { commanded: commanded.to_vec(), ..self }
    }

    /// A record as it came, in which what the controller makes of the log is not measured.
    ///
    /// # Errors
    ///
    /// Never for a record, which has values for all its channels.
    pub fn without_commanded(&self, record: &Record) -> Result<Record, fd_model::ModelError> {
        with_logged_outputs(record, &[], &self.commanded)
    }

    /// The model with its controller on logged outputs.
    fn opened(&self, model: &Model) -> Result<Model, ModelError> {
        let mut draft = model.clone().into_draft();
        if let Some(controller) = &mut draft.controller {
            see_logged(controller, model, &self.replaced);
        }
        Model::try_from(draft)
    }

    /// What the controller makes of a log, whatever the plant does with it. `u` are the inputs of the
    /// [simulator](Nominal::simulator) row by row, samples `ts` apart. `None` where it makes no numbers.
    ///
    /// ```
    /// use fd_model::SampleTime;
    /// use fd_sim::{model::Model, simulate::LoggedLoop};
    ///
    /// let model: Model = r#"
    /// version = 1
    /// kind = "equations"
    /// name = "tank"
    /// sample_time = 0.1
    /// inputs = { u = { unit = "m/s" } }
    /// outputs = { y = { unit = "m", value = "h" } }
    /// states = { h = { unit = "m", initial = 0.0, derivative = "u + h" } }
    /// [controller]
    /// sample_time = 0.1
    /// references = { r = { unit = "m" } }
    /// signals = { u = "2*(r - y)" }
    /// "#.parse()?;
    /// let ts = SampleTime::new(0.1)?;
    /// let logged = LoggedLoop::of(&model, ts).ok_or("a sampled controller that uses an output")?;
    /// let commanded = logged.commands(&[1.0, 0.2].repeat(3), ts).ok_or("numbers")?;
    /// assert_eq!(commanded.inputs, [1.6; 3]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn commands(&self, u: &[f64], ts: SampleTime) -> Option<Commands> {
        let mut draft = self.opened(self.nominal.model()).ok()?.into_draft();
        for state in &mut draft.states {
            let at_rest = match &state.law {
                Law::Derivative(_) => Law::Derivative(Expr::from(0.0)),
                Law::Update(_) => Law::Update(Expr::name(&state.name)),
            };
            state.law = at_rest;
        }
        let names = draft.inputs.iter().map(|i| draft.fresh_name(&format!("{}_shown", i.name)));
        let shown = names
            .zip(&draft.inputs)
            .map(|(name, input)| Output::new(name, &input.unit, Expr::name(&input.name)));
        let shown: Vec<Output> = shown.collect();
        let nu = shown.len();
        draft.outputs.splice(0..0, shown);
        let frozen = Model::try_from(draft).ok()?;
        let mut simulator = EquationSimulator::<f64>::at(&frozen, ts).ok()?;
        let samples = u.len() / Simulator::inputs(&simulator).len().max(1);
        let (theta, x0) = (frozen.nominal(), frozen.initial());
        let width = frozen.outputs.len();
        let mut shown = vec![0.0; samples * width];
        let outcome = Simulator::simulate(&mut simulator, &theta, &x0, u, &mut shown);
        let part = |part: std::ops::Range<usize>| -> Vec<f64> {
            shown.chunks_exact(width).flat_map(|row| row[part.clone()].to_vec()).collect()
        };
        (outcome == Outcome::Complete)
            .then(|| Commands { inputs: part(0..nu), outputs: part(nu..width) })
    }
}

impl Nominal for LoggedLoop<'_> {
    fn model(&self) -> &Model {
        self.nominal.model()
    }

    fn patched(&self, model: &Model, ts: SampleTime) -> Result<Box<dyn Simulator>, SimulateError> {
        self.nominal.patched(&self.opened(model)?, ts)
    }

    fn sees_the_log(&self) -> bool {
        true
    }

    fn commanded(&self) -> &[String] {
        &self.commanded
    }

    fn scales(
        &self,
        ts: SampleTime,
        u: &[f64],
        samples: usize,
    ) -> Result<ReplayScales, SimulateError> {
        self.nominal.scales(ts, u, samples)
    }
}
