//! The simulator of a model file, with what its user knows better than the file.

use std::{fmt, fs, io, path::Path};

use crate::engine_plant::{ENGINE_KIND, EngineFile, engine_effects};
use fd_core::{Limits, Resource};
use fd_effect::{Effect, library, natives, with_default_sites, with_inner_places};
use fd_gap::{fit::FitError, reading::Mistake};
use fd_model::{
    Channel, Record, SampleTime, Shown, figure,
    file::{LinearModel, read_text},
};
use fd_sim::{
    model::{Draft, Law, LinearOptions, LoadError, Model},
    outside::{OUTSIDE_KINDS, OutsideFile, OutsideSimulator},
    simulate::{EquationSimulator, Nominal, Shell, SimulateError, Simulator, check_limits},
};

use super::{
    error::GapError,
    followed::with_followed,
    request::{Named, Request},
};

/// Kinds of model files that can be diagnosed.
const KINDS: &str = "`equations`, `state-space`, `process`, `fmu` or `engine17`";

/// Milliseconds that a diagnosis takes for one integration step of its logs, all candidates and fits
/// together, for a model of one state and for models of two or three with a cause that is hard to find.
const STEP_MS: [f64; 2] = [1.0, 20.0];

/// What is diagnosed: the simulator of a model file, with the tolerances and the noise of a request.
///
/// Models with equations and linear ones get a site of forces at every state equation; the engine
/// has its own places. It prints as the text of a model file.
#[derive(Debug)]
pub struct Subject {
    nominal: Box<dyn Nominal>,
    engine: Option<EngineFile>,
    outside: Option<Outside>,
}

/// A simulator outside of this program, with the file that it was told of by and the shell that it is diagnosed in.
#[derive(Debug)]
struct Outside {
    /// None of a simulator that was lent.
    file: Option<OutsideFile>,
    simulator: OutsideSimulator,
    shell: Shell,
}

impl Subject {
    /// The subject of a request.
    ///
    /// # Errors
    ///
    /// Returns what is wrong with the model file or a setting.
    pub fn of(request: &Request) -> Result<Self, GapError> {
        let path = &request.model;
        let file = path.display().to_string();
        let unread =
            |error: io::Error| LoadError::Read { file: file.clone(), message: error.to_string() };
        let bytes = fs::metadata(path).map_err(unread)?.len();
        request.limits.check(Resource::Bytes, Shown(&file).to_string(), bytes as f64)?;
        Self::of_text(request, &read_text(path, request.limits.bytes).map_err(unread)?)
    }

    /// The subject of a request, from the text of its model file, which need not be there: its path is for
    /// messages, and where relative paths in it begin.
    ///
    /// ```
    /// use fdiag::gap_study::{Request, Subject};
    ///
    /// let text = r#"
    /// version = 1
    /// kind = "equations"
    /// name = "lag"
    /// sample_time = 0.1
    /// inputs = { u = { unit = "1" } }
    /// states = { x = { unit = "1", initial = 0.0, derivative = "u - x" } }
    /// outputs = { y = { unit = "1", value = "x" } }
    /// "#;
    /// let subject = Subject::of_text(&Request::new("lag.toml", ["monday.csv"]), text)?;
    /// assert_eq!(subject.model().name, "lag");
    /// # Ok::<(), fdiag::gap_study::GapError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// As [`Subject::of`].
    pub fn of_text(request: &Request, text: &str) -> Result<Self, GapError> {
        check_calibration(request)?;
        let path = &request.model;
        let file = path.display().to_string();
        // What is no TOML at all is an error of the reader of equations, which says where.
        let kind = text.parse::<toml::Table>().ok();
        let kind = kind.as_ref().and_then(|table| table.get("kind")).and_then(toml::Value::as_str);
        match kind {
            Some("equations") | None => {
                let model = text.parse().map_err(|error| LoadError::Model { file, error })?;
                Self::of_equations(request, &model)
            }
            Some("state-space") => {
                let linear = LinearModel::parse(&file, text)?;
                let ts = linear.system.sample_time();
                let (inputs, outputs) = (linear.input_channels(), linear.output_channels());
                let ts = ts.map_or_else(|| pace(request, &inputs, &outputs), Ok)?;
                let model = Model::from_linear(&linear, ts, &LinearOptions::default());
                let model = model.map_err(|error| LoadError::Model { file, error })?;
                Self::of_equations(request, &model)
            }
            Some(kind) if OUTSIDE_KINDS.contains(&kind) => {
                Self::of_outside(request, OutsideFile::parse(path, text)?)
            }
            Some(ENGINE_KIND) => Self::of_engine(request, EngineFile::parse(&file, text)?),
            Some(found) => {
                Err(GapError::Kind { file: path.clone(), found: found.to_owned(), expected: KINDS })
            }
        }
    }

    fn of_equations(request: &Request, model: &Model) -> Result<Self, GapError> {
        let file = request.model.display().to_string();
        let model =
            with_followed(request, model).map_err(|error| LoadError::Model { file, error })?;
        let model = told(request, &with_default_sites(&model))?;
        let simulate = |error| GapError::Simulate(Box::new(error));
        check_limits(&model, SampleTime::new(model.sample_time)?, &request.limits)
            .map_err(simulate)?;
        Ok(Self { nominal: Box::new(model), engine: None, outside: None })
    }

    fn of_outside(request: &Request, file: OutsideFile) -> Result<Self, GapError> {
        let simulator = file.open()?;
        let shell = file.shell(&simulator)?;
        let model = told(request, shell.model())?;
        let shell = shell.with_model(model)?;
        let nominal = Box::new(shell.clone());
        let outside = Outside { file: Some(file), simulator, shell };
        Ok(Self { nominal, engine: None, outside: Some(outside) })
    }

    /// A simulator that this program has of somebody else, and for which there is no file. `equations` are those
    /// around it that a diagnosis has written; without any, there are no effects in it.
    ///
    /// # Errors
    ///
    /// Returns an error when a setting of the request is wrong, or the equations are not those of this simulator.
    pub fn lent(
        request: &Request,
        simulator: OutsideSimulator,
        equations: Option<&str>,
    ) -> Result<Self, GapError> {
        check_calibration(request)?;
        let mut shell = simulator.shell()?;
        if let Some(text) = equations {
            shell = shell.with_model(text.parse().map_err(SimulateError::from)?)?;
        }
        let model = told(request, shell.model())?;
        let shell = shell.with_model(model)?;
        let nominal = Box::new(shell.clone());
        Ok(Self { nominal, engine: None, outside: Some(Outside { file: None, simulator, shell }) })
    }

    fn of_engine(request: &Request, engine: EngineFile) -> Result<Self, GapError> {
        let error = |error| EngineFile::error(&request.model, error);
        let ts = match engine.sample_time() {
            Some(seconds) => SampleTime::new(seconds)?,
            None => pace(request, &engine.inputs(), &engine.outputs())?,
        };
        let nominal = engine.nominal(ts).map_err(error)?;
        let model = told(request, nominal.model())?;
        let nominal = engine.nominal_as(ts, model).map_err(error)?;
        Ok(Self { nominal, engine: Some(engine), outside: None })
    }

    /// The same subject with a parameter mended; `None` where that is not what is wrong, or makes no model.
    pub(super) fn mended(&self, mistake: &Mistake) -> Option<Self> {
        let is_text = self.engine.is_none() && self.outside.is_none();
        let is_parameter = matches!(mistake, Mistake::Parameter { .. }) && is_text;
        let model = is_parameter.then(|| mistake.mended_model(self.model()))??;
        Some(Self { nominal: Box::new(model), engine: None, outside: None })
    }

    /// Compares the work for the fitted logs with the limit, before it is begun.
    pub(super) fn check_cost(&self, fitted: &[Record], limits: &Limits) -> Result<(), GapError> {
        let is_text = self.engine.is_none() && self.outside.is_none();
        let Some(ts) = fitted.first().map(Record::ts).filter(|_| is_text) else {
            return Ok(());
        };
        let simulate = |error| GapError::Simulate(Box::new(error));
        let simulator = EquationSimulator::<f64>::at(self.model(), ts).map_err(simulate)?;
        let samples: usize = fitted.iter().map(Record::len).sum();
        let steps = samples as f64 * simulator.substeps() as f64;
        let [least, most] = seconds(steps).map(|seconds| seconds / 3600.0);
        let what = format!(
            "{samples} samples of {} integration steps each, {} to {} hours on one thread (fewer samples \
             or a longer `step` in the model take less; --yes begins it all the same)",
            simulator.substeps(),
            figure(least),
            figure(most),
        );
        Ok(limits.check(Resource::Steps, what, steps)?)
    }

    /// Seconds that a diagnosis of so many samples takes on one thread, at least and at most; `None` where it is not
    /// known.
    pub(super) fn cost(&self, samples: usize, ts: SampleTime) -> Option<[f64; 2]> {
        let is_text = self.engine.is_none() && self.outside.is_none();
        let simulator = EquationSimulator::<f64>::at(self.model(), ts).ok().filter(|_| is_text)?;
        Some(seconds(samples as f64 * simulator.substeps() as f64))
    }

    /// The same simulator outside of this program, started again and without a copy; `None` where there is no file
    /// of one.
    ///
    /// # Errors
    ///
    /// Returns why it cannot be started.
    pub fn started_anew(&self) -> Result<Option<OutsideSimulator>, GapError> {
        let file = self.outside.as_ref().and_then(|outside| outside.file.as_ref());
        Ok(file.map(OutsideFile::open).transpose()?)
    }

    /// The same subject with names for the terms of its sums, which are places for effects; `None` for the engine.
    pub(super) fn with_inner_places(&self) -> Option<Self> {
        let model = with_inner_places(self.model());
        let is_text = self.engine.is_none() && self.outside.is_none();
        let is_open = is_text && !model.definitions.is_empty();
        is_open.then(|| Self { nominal: Box::new(model), engine: None, outside: None })
    }

    /// The simulator.
    #[must_use]
    pub fn nominal(&self) -> &dyn Nominal {
        &*self.nominal
    }

    /// The simulator outside of this program that it is, if it is one.
    #[must_use]
    pub fn outside(&self) -> Option<&OutsideSimulator> {
        self.outside.as_ref().map(|outside| &outside.simulator)
    }

    /// The same with the shell that it is diagnosed in.
    pub(super) fn black_box(&self) -> Option<(&OutsideSimulator, &Shell)> {
        self.outside.as_ref().map(|Outside { simulator, shell, .. }| (simulator, shell))
    }

    /// An error of a study, with what went wrong last with a simulator outside of this program, which may be why.
    pub(super) fn explained(&self, error: GapError) -> GapError {
        match self.outside().and_then(OutsideSimulator::trouble) {
            Some(trouble) => {
                GapError::Outside { error: Box::new(error), trouble: Box::new(trouble) }
            }
            None => error,
        }
    }

    /// The model that effects are spliced into.
    #[must_use]
    pub fn model(&self) -> &Model {
        self.nominal.model()
    }

    /// The text of a file of the simulator with effects in it; of one that has no file, the equations around it.
    #[must_use]
    pub fn text(&self, patched: &Model) -> String {
        match (&self.engine, &self.outside) {
            (Some(engine), _) => engine.text(patched),
            (_, Some(Outside { file: Some(file), .. })) => file.text(patched),
            _ => patched.to_string(),
        }
    }

    /// What it may lack.
    pub(super) fn effects(&self) -> Vec<Box<dyn Effect>> {
        let mut effects = if self.engine.is_some() { engine_effects() } else { library() };
        effects.extend(self.outside.iter().flat_map(|outside| natives(&outside.shell)));
        effects
    }

    /// Channels of logs: inputs, then outputs.
    #[must_use]
    pub fn channels(&self) -> [Vec<Channel>; 2] {
        let model = self.model();
        if let Some(Outside { simulator, .. }) = &self.outside {
            return [simulator.inputs().to_vec(), simulator.outputs().to_vec()];
        }
        self.engine.as_ref().map_or_else(
            || [model.external_inputs(), model.output_channels()],
            |engine| [engine.inputs(), engine.outputs()],
        )
    }

    /// Whether it is sampled itself, or has a sampled controller, and so keeps its own pace.
    pub(super) fn keeps_pace(&self) -> bool {
        if let Some(engine) = &self.engine {
            return engine.sample_time().is_some();
        }
        if self.outside.is_some() {
            return true;
        }
        let model = self.model();
        let controller = model.controller.as_ref().and_then(|controller| controller.sample_time);
        let is_discrete = !model.states.is_empty()
            && model.states.iter().all(|state| matches!(state.law, Law::Update(_)));
        controller.is_some() || is_discrete
    }
}

/// The text of its model file.
impl fmt::Display for Subject {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text(self.model()))
    }
}

/// Seconds that a diagnosis takes for so many steps of integration, at least and at most.
fn seconds(steps: f64) -> [f64; 2] {
    STEP_MS.map(|ms| 1e-3 * ms * steps)
}

fn check_calibration(request: &Request) -> Result<(), GapError> {
    if let Some(replicas) = request.calibrate {
        request.limits.check(Resource::Models, "--calibrate", replicas as f64)?;
    }
    Ok(())
}

/// A model with the tolerances and the noise of a request.
fn told(request: &Request, model: &Model) -> Result<Model, GapError> {
    let mut draft = model.clone().into_draft();
    for Named { name, value } in &request.tolerances {
        let known = draft.parameters.iter().map(|p| p.name.clone()).collect();
        let parameter = draft.parameters.iter_mut().find(|p| p.name == *name);
        let parameter = parameter.ok_or_else(|| GapError::Unknown {
            option: "--tolerance",
            what: "parameter",
            name: name.clone(),
            known,
        })?;
        parameter.tolerance = *value;
    }
    for Named { name, value } in &request.noise {
        let known = draft.outputs.iter().map(|o| o.name.clone()).collect();
        let output = draft.outputs.iter_mut().find(|o| o.name == *name);
        let output = output.ok_or_else(|| GapError::Unknown {
            option: "--noise",
            what: "output",
            name: name.clone(),
            known,
        })?;
        if *value <= 0.0 {
            let expected = "a standard deviation above 0";
            let found = format!("{name}={value}");
            return Err(GapError::Setting { option: "--noise", expected, found });
        }
        output.noise = Some(*value);
    }
    settled(draft, &request.model)
}

/// A draft as the model of a file.
pub(super) fn settled(draft: Draft, file: &Path) -> Result<Model, GapError> {
    let file = file.display().to_string();
    Ok(Model::try_from(draft).map_err(|error| LoadError::Model { file, error })?)
}

/// The time between samples where the model says none: that of the request, or of the first log.
fn pace(
    request: &Request,
    inputs: &[Channel],
    outputs: &[Channel],
) -> Result<SampleTime, GapError> {
    if let Some(seconds) = request.resample.sample_time {
        return Ok(SampleTime::new(seconds)?);
    }
    let map = request.map(inputs, outputs);
    let first = request.logs.first().ok_or(FitError::NoLog)?;
    Ok(request.read(first, &map)?.record.ts())
}
