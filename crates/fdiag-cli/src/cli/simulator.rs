//! `fdiag simulator`: simulators of users, checked; models, served.

use std::{
    fmt::Write as _,
    path::{Path, PathBuf},
    time::Duration,
};

use clap::{Args, Subcommand};
use fd_report::Table;
use fdiag::{
    core::Limits,
    gap_study::{Cost, Request, SimulatorCheck, Subject},
    model::{
        SampleTime, duration, figure,
        file::{LinearModel, read_text},
    },
    sim::{
        equation::Expr,
        model::{LinearOptions, Model},
        outside::{
            Checked, Contract, Drive, Grade, OutsideError, OutsideFile, OutsideSimulator, Process,
            Stated, serve, serve_fmu, stated,
        },
        simulate::{EquationSimulator, Simulator as _},
    },
};

use super::{
    failure::{ExitCode, Failure},
    say::say,
};

#[derive(Debug, Subcommand)]
pub(crate) enum SimulatorCommand {
    /// Run a simulator and say what it is, what is wrong with it, and what a diagnosis will cost
    ///
    /// Checks that runs are finite and repeatable, that nothing is left of the run before, that whole
    /// runs, steps and measurements agree, that outputs are smooth enough for slopes, and that every
    /// parameter, initial state, input and port moves some output. Ends with exit code 1 when
    /// something is broken.
    #[command(after_help = CHECK_HELP)]
    Check(CheckArgs),
    /// Serve a model with equations, or an FMU, on standard input and output, for whoever speaks the protocol
    ///
    /// What an FMU prints goes to standard error. `fdiag` runs FMUs by this command, unless their model files say
    /// otherwise.
    #[command(after_help = SERVE_HELP)]
    Serve(ServeArgs),
}

const CHECK_HELP: &str = "\
Examples:
  fdiag simulator check cart.toml
  fdiag simulator check --amplitude 2.4 -- python3 examples/process/cart.py";

const SERVE_HELP: &str = "\
Examples: a model that is diagnosed as if it were somebody's program, and an FMU
  fdiag simulator check -- fdiag simulator serve examples/gap/quick-start/model.toml
  fdiag simulator check -- fdiag simulator serve plant.fmu --step 0.01";

#[derive(Debug, Args)]
pub(crate) struct CheckArgs {
    /// Model file (TOML) of kind `process` or `fmu`
    #[arg(value_name = "MODEL", required_unless_present = "command", conflicts_with = "command")]
    model: Option<PathBuf>,
    /// A program with its arguments, after `--`; it says itself what it is
    #[arg(value_name = "COMMAND", last = true)]
    command: Vec<String>,
    /// Inputs are steps of random height between minus and plus this
    #[arg(long, value_name = "SIZE", default_value_t = 1.0)]
    amplitude: f64,
    /// Samples of a run
    #[arg(long, value_name = "N", default_value_t = 500, value_parser = clap::value_parser!(u32).range(2..))]
    samples: u32,
    /// The longest time that an answer of a COMMAND may take, in seconds
    #[arg(long, value_name = "SECONDS", default_value_t = 30.0)]
    timeout: f64,
}

#[derive(Debug, Args)]
pub(crate) struct ServeArgs {
    /// Model file (TOML) of kind `equations`, `state-space` or `fmu`; or an FMU, with what the other side says of it
    #[arg(value_name = "MODEL")]
    model: PathBuf,
    /// Time between steps, in seconds, instead of what the model says
    #[arg(long, value_name = "SECONDS")]
    step: Option<f64>,
}

pub(crate) fn run(command: &SimulatorCommand) -> Result<ExitCode, Failure> {
    match command {
        SimulatorCommand::Check(args) => check_simulator(args),
        SimulatorCommand::Serve(args) => serve_model(args),
    }
}

fn check_simulator(args: &CheckArgs) -> Result<ExitCode, Failure> {
    let opened = match &args.model {
        Some(model) => of_file(model)?,
        None => of_command(args),
    };
    let simulator = match opened {
        Ok(simulator) => simulator,
        Err(error @ OutsideError::Forbidden { .. }) => return Err(Failure::of_input(error)),
        Err(error) => {
            say(&format!("Broken: {error}\n"))?;
            return Ok(ExitCode(1));
        }
    };
    let (contract, workers) = (simulator.contract().clone(), simulator.workers());
    let inputs = contract.inputs.len();
    let drive = Drive::random(args.samples as usize, inputs, args.amplitude);
    let check = SimulatorCheck::of_outside(simulator, drive);

    let mut text = describe(&contract);
    text += &findings(&check);
    if let Some(note) = &check.note {
        let _ = writeln!(text, "note: {note}");
    }
    if let Some(trouble) = &check.trouble {
        let _ = writeln!(text, "BROKEN: {trouble}");
    }
    if check.run.is_finite() {
        text += &cost(&check, workers);
    }
    text += match (check.is_broken(), check.worst()) {
        (true, _) => "\nBroken: a diagnosis with this simulator would go wrong.\n",
        (_, Grade::Doubt) => "\nUsable, with the doubts above.\n",
        _ => "\nIn order.\n",
    };
    say(&text)?;
    Ok(if check.is_broken() { ExitCode(1) } else { ExitCode::SUCCESS })
}

fn of_file(model: &Path) -> Result<Result<OutsideSimulator, OutsideError>, Failure> {
    let text =
        read_text(model, Limits::default().bytes).map_err(|error| Failure::input(model, error))?;
    let file = OutsideFile::parse(model, &text).map_err(Failure::of_input)?;
    Ok(file.open())
}

fn of_command(args: &CheckArgs) -> Result<OutsideSimulator, OutsideError> {
    let mut process = Process::new(&args.command);
    process.timeout = Duration::try_from_secs_f64(args.timeout).unwrap_or(Duration::from_secs(30));
    OutsideSimulator::new(process.contract()?, process, 1)
}

fn describe(contract: &Contract) -> String {
    let mut text = format!("{}, a step every {} s\n", contract.name, contract.ts.seconds());
    let powers = contract.powers;
    let can = [
        (powers.step, "step by step"),
        (!powers.resets, "a start for each run"),
        (powers.rollout, "whole runs in one call"),
        (powers.measure, "outputs before a step"),
        (powers.states, "shows its states"),
    ];
    let can: Vec<&str> = can.into_iter().filter(|(can, _)| *can).map(|(_, what)| what).collect();
    let _ = writeln!(text, "Powers: {}", can.join(", "));
    let mut table = Table::new("Contract", &["what", "name", "unit", "value", "known to"]);
    let mut row = |what: &str, name: &str, unit: &str, value: String, known: String| {
        table.push([what.to_owned(), name.to_owned(), unit.to_owned(), value, known]);
    };
    for c in &contract.inputs {
        row("input", &c.name, &c.unit, String::new(), String::new());
    }
    for (c, noise) in contract.outputs.iter().zip(&contract.noise) {
        let noise = noise.map_or_else(String::new, |noise| format!("noise {}", figure(noise)));
        row("output", &c.name, &c.unit, String::new(), noise);
    }
    let lent = contract.parameters.len() - contract.natives.len();
    for p in &contract.parameters[..lent] {
        let known = format!("{} %", figure(100.0 * p.tolerance));
        row("parameter", &p.name, &p.unit, figure(p.value), known);
    }
    for x in &contract.initial {
        let known = x.tolerance.map_or_else(|| "exactly".to_owned(), figure);
        row("initial state", &x.channel.name, &x.channel.unit, figure(x.value), known);
    }
    for native in &contract.natives {
        let (p, name) = (&native.parameter, format!("{}@{}", native.label, native.place));
        row("native effect", &name, &p.unit, figure(p.value), format!("rests; `{}`", p.name));
    }
    for (port, motion) in contract.ports.iter().zip(&contract.motion) {
        let moves = [&motion.position, &motion.velocity].into_iter().flatten();
        let moves: Vec<&str> = moves.map(String::as_str).collect();
        let moves =
            if moves.is_empty() { String::new() } else { format!("moves {}", moves.join(", ")) };
        row("port", &port.channel.name, &port.channel.unit, String::new(), moves);
    }
    let _ = writeln!(text, "\n{}\n", table.to_text(100));
    text
}

fn findings(check: &SimulatorCheck) -> String {
    let mut text = String::new();
    for Checked { what, grade, text: finding } in &check.findings {
        let grade = match grade {
            Grade::Fine => "fine",
            Grade::Doubt => "DOUBT",
            Grade::Broken => "BROKEN",
        };
        let _ = writeln!(text, "{grade:6}  {what}: {finding}");
    }
    text
}

fn cost(check: &SimulatorCheck, workers: usize) -> String {
    let mut text = format!(
        "\nA run of {} samples takes {} ms in one call",
        check.samples,
        figure(1e3 * check.run),
    );
    if check.steps.is_finite() {
        let each = figure(1e6 * check.steps / check.samples as f64);
        let _ = write!(text, " and {} ms by steps ({each} us each)", figure(1e3 * check.steps));
    }
    let _ = writeln!(
        text,
        ".\nA diagnosis with logs of that length, with {workers} worker{}, takes about",
        if workers == 1 { "" } else { "s" },
    );
    for Cost { what, runs, seconds } in &check.costs {
        let time = duration(*seconds);
        let runs = runs.map_or_else(String::new, |runs| format!(" for {runs} runs"));
        let _ = writeln!(text, "  {time}{runs} ({what})");
    }
    text
}

/// The text of a model file of a kind.
fn text_of(file: &Path, kind: &str) -> Option<String> {
    let text = read_text(file, Limits::default().bytes).ok()?;
    let table = text.parse::<toml::Table>().ok()?;
    (table.get("kind")?.as_str()? == kind).then_some(text)
}

/// The FMU that is to be served, and what is said of it here.
fn fmu_of(args: &ServeArgs) -> Result<Option<(PathBuf, Option<Stated>)>, Failure> {
    let model = &args.model;
    if model.is_dir() || model.extension().is_some_and(|extension| extension == "fmu") {
        let said = args.step.map(|step| Stated { sample_time: Some(step), ..Stated::default() });
        return Ok(Some((model.clone(), said)));
    }
    let Some(text) = text_of(model, "fmu") else { return Ok(None) };
    let file = OutsideFile::parse(model, &text).map_err(Failure::of_input)?;
    Ok(file.fmu().map(|(path, stated)| {
        let sample_time = args.step.or(stated.sample_time);
        (path, Some(Stated { sample_time, ..stated.clone() }))
    }))
}

/// A linear model as equations, at the step that is wanted or else at its own.
fn of_linear(file: &Path, text: &str, step: Option<SampleTime>) -> Result<Model, Failure> {
    let linear =
        LinearModel::parse(&file.display().to_string(), text).map_err(Failure::of_input)?;
    let ts = linear.system.sample_time().or(step);
    let ts =
        ts.ok_or_else(|| Failure::input(file, "it states no sample time: say --step SECONDS"))?;
    Model::from_linear(&linear, ts, &LinearOptions::default())
        .map_err(|error| Failure::input(file, error))
}

fn serve_model(args: &ServeArgs) -> Result<ExitCode, Failure> {
    if let Some((fmu, said)) = fmu_of(args)? {
        serve_fmu(&fmu, said).map_err(Failure::of_input)?;
        return Ok(ExitCode::SUCCESS);
    }
    let step = args.step.map(SampleTime::new).transpose().map_err(Failure::of_input)?;
    let model = &if let Some(text) = text_of(&args.model, "state-space") {
        of_linear(&args.model, &text, step)?
    } else {
        let request = Request::new(&args.model, Vec::<PathBuf>::new());
        Subject::of(&request).map_err(Failure::of_input)?.model().clone()
    };
    let own = SampleTime::new(model.sample_time).map_err(Failure::of_input);
    let ts = step.map_or(own, Ok)?;
    let mut simulator =
        EquationSimulator::<f64>::with_ports(model, ts).map_err(Failure::analysis)?;
    let noise: Vec<Option<f64>> = model.outputs.iter().map(|output| output.noise).collect();
    let mut hello = stated(&model.name, &simulator, &noise);
    for (port, site) in hello.ports.iter_mut().zip(&model.sites) {
        // A motion that is measured as it is.
        let shown = |motion: &Option<Expr>| {
            let motion = motion.as_ref()?;
            let output = model.outputs.iter().find(|output| output.value == *motion)?;
            Some(output.name.clone())
        };
        (port.position, port.velocity) = (shown(&site.position), shown(&site.velocity));
    }
    let (input, output) = (std::io::stdin().lock(), std::io::stdout().lock());
    serve(&mut simulator, &hello, input, output).map_err(Failure::analysis)?;
    Ok(ExitCode::SUCCESS)
}
