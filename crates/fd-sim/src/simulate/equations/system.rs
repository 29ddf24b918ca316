//! The compiled parts of a model that all its simulators share.

use fd_core::Limits;
use fd_model::{Channel, SampleTime};

use super::super::{
    error::SimulateError,
    flat::{FIRST_STATE, SampledControl, flatten},
    limits::check_delays,
    simulator::{Initial, Port},
    timing::Timing,
};
use crate::{
    equation::{CompileError, Expr, Program, Scope},
    model::{Hold, Law, Model, Parameter, State},
};

/// Programs and descriptions of a model. All programs have the same fast inputs: time, whether it
/// is the first step of a run, states, external inputs (ports last), held control signals, signs,
/// delayed values.
#[derive(Clone, Debug)]
pub(in crate::simulate) struct System {
    pub ts: SampleTime,
    pub(super) timing: Timing,
    pub(super) hold: Hold,
    pub(super) nx: usize,
    pub inputs: Vec<Channel>,
    pub(super) ports: Vec<Port>,
    pub channels: Vec<Channel>,
    pub(super) parameters: Vec<Parameter>,
    pub initial: Vec<Initial>,
    pub(super) is_continuous: bool,
    pub(super) rates: Program,
    pub(super) updates: Program,
    /// States that the updates write to.
    pub(super) updated: Vec<usize>,
    pub(super) outputs: Program,
    /// Velocities of the signs.
    pub(super) velocities: Program,
    /// The states that they are, if all of them are states.
    pub(super) rubbing: Option<Vec<usize>>,
    /// Whether outputs depend on signs.
    pub(super) shows_signs: bool,
    /// Delayed expressions in order of use, one program each.
    pub(super) delays: Vec<Program>,
    /// Whether each of them moves within an integration step.
    pub(super) moving: Vec<bool>,
    /// Times of the delays, in seconds.
    pub(super) delay_times: Program,
    pub(super) control: Option<Control>,
}

/// A sampled controller.
#[derive(Clone, Debug)]
pub(super) struct Control {
    /// Signals, then states.
    pub program: Program,
    pub signals: usize,
    /// States that it writes to.
    pub updates: Vec<usize>,
}

impl System {
    /// Compiles a model of which the inputs named in `ports` (with the site they belong to) are
    /// ports.
    pub(in crate::simulate) fn new(
        model: &Model,
        ts: SampleTime,
        ports: &[(String, Port)],
    ) -> Result<Self, SimulateError> {
        let names: Vec<String> = ports.iter().map(|(input, _)| input.clone()).collect();
        let flat = flatten(model, &names);
        let limits = Limits::default();
        let timing = Timing::choose(model, &flat, ts, &limits)?;
        check_delays(model, timing, &limits)?;
        let (updated, updates): (Vec<usize>, Vec<Expr>) = flat.updates.into_iter().unzip();
        let (delayed, times): (Vec<Expr>, Vec<Expr>) = flat.delays.into_iter().unzip();
        let delays = delayed.into_iter().map(|expr| Program::compile(&flat.scope, &[expr]));
        let delays = delays.collect::<Result<Vec<Program>, _>>()?;
        let moving = moving(&delays, model, &flat.scope);
        let control = flat.control.map(|control| Control::new(&flat.scope, control)).transpose()?;
        let outputs = Program::compile(&flat.scope, &flat.outputs)?;
        let signs = model.signs.iter().map(|sign| sign.name.as_str());
        let shows_signs = signs
            .filter_map(|sign| flat.scope.fast.iter().position(|f| f == sign))
            .any(|place| outputs.reads(place));
        let states = &flat.scope.fast[FIRST_STATE..FIRST_STATE + flat.states];
        let state = |velocity: &Expr| states.iter().position(|s| *velocity == Expr::name(s));
        let mut inputs = model.external_inputs();
        inputs.retain(|channel| !names.contains(&channel.name));
        let initial = model.all_states().map(|state| Initial {
            channel: Channel::new(&state.name, &state.unit),
            value: state.initial,
            tolerance: state.tolerance,
        });
        Ok(Self {
            ts,
            timing,
            hold: model.hold,
            nx: flat.states,
            inputs,
            ports: ports.iter().map(|(_, port)| port.clone()).collect(),
            channels: model.output_channels(),
            parameters: model.parameters.clone(),
            initial: initial.collect(),
            is_continuous: model.all_states().any(|s| matches!(s.law, Law::Derivative(_))),
            rates: Program::compile(&flat.scope, &flat.rates)?,
            updates: Program::compile(&flat.scope, &updates)?,
            updated,
            rubbing: flat.velocities.iter().map(state).collect(),
            velocities: Program::compile(&flat.scope, &flat.velocities)?,
            shows_signs,
            outputs,
            delays,
            moving,
            delay_times: Program::compile(&flat.scope, &times)?,
            control,
        })
    }
}

/// Which of the delayed expressions, each after those that it uses, move within an integration step.
fn moving(delays: &[Program], model: &Model, scope: &Scope) -> Vec<bool> {
    let is_continuous = |state: &State| matches!(state.law, Law::Derivative(_));
    let states: Vec<bool> = model.all_states().map(is_continuous).collect();
    let others = scope.fast.len() - FIRST_STATE - states.len() - delays.len();
    // The time moves; what is called `first` does not, nor do signals of a sampled controller.
    let fast = [true, false].into_iter().chain(states);
    let mut moves: Vec<bool> =
        fast.chain(std::iter::repeat_n(model.hold != Hold::Zero, others)).collect();
    for delay in delays {
        let is_moving = (0..moves.len()).any(|i| moves[i] && delay.reads(i));
        moves.push(is_moving);
    }
    moves.split_off(scope.fast.len() - delays.len())
}

impl Control {
    fn new(scope: &Scope, control: SampledControl) -> Result<Self, CompileError> {
        let signals = control.signals.len();
        let (updates, laws): (Vec<usize>, Vec<Expr>) = control.updates.into_iter().unzip();
        let all: Vec<Expr> = control.signals.into_iter().chain(laws).collect();
        Ok(Self { program: Program::compile(scope, &all)?, signals, updates })
    }
}
