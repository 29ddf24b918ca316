//! `fdiag watch`: next to the plant, for months.

#[cfg(feature = "mqtt")]
mod brokers;
#[cfg(feature = "mqtt")]
mod deliveries;
mod failures;
mod feed;
#[cfg(feature = "mqtt")]
mod mqtt;
mod nightly;
mod pulse;
mod replay;
mod study;
mod watching;

#[cfg(feature = "mqtt")]
use std::sync::mpsc::Receiver;
use std::{
    io::BufWriter,
    path::Path,
    sync::{Arc, atomic::AtomicBool},
    time::Duration,
};

use fd_log::{ColumnMap, LogMap, read_log};
use fd_watch::{
    AlarmSettings, Board, Format, InputMap, Learning, Monitor, Plan, Request, RowReader,
    StateFolder,
};
use fdiag::{
    core::Limits,
    model::{
        SampleTime,
        file::{LinearModel, read_text},
    },
    sim::outside::OUTSIDE_KINDS,
    spec::PipelineSpec,
};
use signal_hook::consts::{SIGINT, SIGTERM};

use self::{
    nightly::Nightly,
    pulse::Pulse,
    study::{Studies, StudyPlan},
    watching::Watching,
};
use super::{
    args_watch::{StreamFormat, WatchArgs},
    bounds,
    failure::{ExitCode, Failure},
    given::given,
    say::{is_watched, remark},
};

pub(crate) fn run(args: &WatchArgs) -> Result<ExitCode, Failure> {
    if let Some(journal) = &args.replay {
        return replay::run(journal);
    }
    if asks_nobody(args) {
        return Err(Failure::of_input(
            "--ask: nobody could answer; say --http, --mqtt-out or both",
        ));
    }
    let (plan, map) = plan(args)?;
    let diagnosing = diagnosing(args, &plan)?;
    let format = match args.format {
        StreamFormat::Ndjson => Format::Ndjson,
        StreamFormat::Csv => Format::Csv,
    };
    let mut input = InputMap::new(map);
    if let Some(unit) = &args.unit {
        input = input.with_units(unit);
    }
    let mut monitor = Monitor::new(plan);
    let (state, unsure) = match &args.state {
        Some(folder) => {
            let opened = StateFolder::open(folder, &mut monitor);
            let (state, unsure) = opened.map_err(failures::of_state)?;
            (Some(state), unsure)
        }
        None => (None, Vec::new()),
    };
    // Before the input is touched: a signal that comes now must not lose what is read.
    let stop = Arc::new(AtomicBool::new(false));
    for signal in [SIGTERM, SIGINT] {
        signal_hook::flag::register(signal, Arc::clone(&stop))
            .map_err(|error| Failure::analysis(format!("signals cannot be heard: {error}")))?;
    }
    bounds::told(Arc::clone(&stop));
    #[cfg(feature = "mqtt")]
    let (listened, brokers) = brokers(args, state.as_ref(), &monitor)?;
    #[cfg(not(feature = "mqtt"))]
    let listened = None;
    let feed = match (&args.follow, listened) {
        (_, Some(listened)) => listened,
        (Some(path), None) => feed::follow(path).map_err(|error| Failure::input(path, error))?,
        (None, None) => feed::stream(std::io::stdin()),
    };
    if is_watched() {
        let units = monitor.units().len();
        remark(&format!("watching; {units} units restored, {} alarms told again", unsure.len()));
    }
    let mut watching = Watching {
        monitor,
        rows: RowReader::new(format, input),
        format,
        state,
        out: BufWriter::new(std::io::stdout().lock()),
        pulse: Pulse::new(board(args)?),
        #[cfg(feature = "mqtt")]
        brokers,
        stop,
        next: None,
        diagnosing,
        is_short: false,
        cannot_save: false,
        save_every: Duration::from_secs_f64(args.save_every),
    };
    watching.say(&unsure)?;
    watching.replay()?;
    watching.run(&feed)?;
    if is_watched() {
        let (counts, units) = (watching.monitor.counts(), watching.monitor.units().len());
        remark(&format!("{} samples of {units} units, {} alarms", counts.rows, counts.alarms));
    }
    // All is saved; what was watched is not over.
    Ok(if bounds::is_over() { ExitCode(6) } else { ExitCode::SUCCESS })
}

/// Whether there are to be questions, and no place for them.
fn asks_nobody(args: &WatchArgs) -> bool {
    let places = [
        #[cfg(feature = "http")]
        args.http.is_some(),
        #[cfg(feature = "mqtt")]
        args.mqtt_out.is_some(),
        // Without either there is no `--ask`.
        cfg!(not(any(feature = "http", feature = "mqtt"))),
    ];
    #[cfg(any(feature = "http", feature = "mqtt"))]
    let places = places.into_iter().chain([!args.ask]);
    !places.into_iter().any(|is_place| is_place)
}

/// Studies of units that have moved away from their model, if they are wanted.
fn diagnosing(args: &WatchArgs, plan: &Plan) -> Result<Option<(Nightly, Studies)>, Failure> {
    let Some(hours) = args.diagnose else { return Ok(None) };
    let model = args.diagnose_model.as_deref().map_or_else(|| model_file(args), Ok)?.to_owned();
    // What is found to be wrong in some night should be found now.
    let text = read_text(&model, Limits::default().bytes);
    let text = text.map_err(|error| Failure::input(&model, error))?;
    let kind = text.parse::<toml::Table>().ok().and_then(|table| table.get("kind").cloned());
    if let Some(kind) = kind.as_ref().and_then(toml::Value::as_str)
        && OUTSIDE_KINDS.contains(&kind)
    {
        let reason = format!(
            "--diagnose: a model of kind `{kind}` would be executed, and a monitor runs no programs: expected \
             `equations` or `state-space`; `fdiag gap` diagnoses with it"
        );
        return Err(Failure::input(model, reason));
    }
    let mut header = "time [s]".to_owned();
    for channel in plan.model().input_channels().iter().chain(&plan.model().output_channels()) {
        let name = format!("{} [{}]", channel.name, channel.unit);
        if name.contains([',', '"', '\n']) {
            return Err(Failure::of_input(format!(
                "--diagnose: `{name}` cannot be a column of a log"
            )));
        }
        header.push(',');
        header.push_str(&name);
    }
    let longest = Duration::from_secs_f64(args.diagnose_limit);
    let nightly = Nightly::new(3600.0 * hours, args.diagnose_samples);
    Ok(Some((nightly, Studies::start(StudyPlan { model, longest, header }))))
}

/// Samples from a broker and alarms to it, as far as the options ask for them.
#[cfg(feature = "mqtt")]
fn brokers(
    args: &WatchArgs,
    state: Option<&StateFolder>,
    monitor: &Monitor,
) -> Result<(Option<Receiver<feed::Chunk>>, brokers::Brokers), Failure> {
    let mut brokers = brokers::Brokers::default();
    // The command line asks for both or none.
    let (Some(state), Some(_)) = (state, &args.mqtt) else { return Ok((None, brokers)) };
    let name = state.name().map_err(failures::of_state)?;
    let Some(broker) = mqtt::Broker::of(args, &name)? else { return Ok((None, brokers)) };
    if args.mqtt_in.is_empty() && args.mqtt_out.is_none() {
        return Err(Failure::of_input("--mqtt: say --mqtt-in, --mqtt-out or both"));
    }
    if let Some(prefix) = args.mqtt_out.clone() {
        let outbox = state.outbox().map_err(failures::of_state)?;
        let promised = state.promised();
        let outlet = mqtt::Outlet::start(broker.clone(), prefix.clone(), outbox, promised)?;
        brokers.outlet = Some(outlet);
        if args.ask {
            let asked = monitor
                .units()
                .filter_map(|unit| Some((unit.name.to_owned(), unit.wish?.to_owned())));
            let token = answer_token(args)?;
            let questions = mqtt::Questions::start(broker.clone(), prefix, token, asked);
            brokers.questions = Some(questions);
        }
    }
    if args.mqtt_in.is_empty() {
        return Ok((None, brokers));
    }
    if args.format == StreamFormat::Csv {
        return Err(Failure::of_input("--mqtt-in: messages are NDJSON (--format ndjson)"));
    }
    let unit_level = args.mqtt_unit.map(usize::from);
    let inlet = mqtt::Inlet { broker, topics: args.mqtt_in.clone(), unit_level };
    Ok((Some(inlet.start()?), brokers))
}

/// What answers from outside the page have to carry.
#[cfg(any(feature = "http", feature = "mqtt"))]
fn answer_token(args: &WatchArgs) -> Result<Option<String>, Failure> {
    let Some(path) = &args.answer_token else { return Ok(None) };
    let text = read_text(path, 1000).map_err(|error| Failure::input(path, error))?;
    let token = text.trim_end();
    if !(16..=200).contains(&token.len()) || !token.bytes().all(|byte| byte.is_ascii_graphic()) {
        let why = "expected one line of 16 to 200 letters, digits and signs, without spaces";
        return Err(Failure::input(path, why));
    }
    Ok(Some(token.to_owned()))
}

/// What whoever looks is shown, when an address for it was given.
#[cfg(feature = "http")]
fn board(args: &WatchArgs) -> Result<Option<Arc<Board>>, Failure> {
    let Some(address) = &args.http else { return Ok(None) };
    let board = Arc::new(Board::default());
    let access = fd_watch::Access { hosts: args.http_host.clone(), token: answer_token(args)? };
    let found = fd_watch::serve(address, &access, Arc::clone(&board))
        .map_err(|error| Failure::of_input(format!("--http {address}: {error}")))?;
    // The port may have been left to the system.
    remark(&format!("live page: http://{found}/"));
    if found.ip().is_unspecified() && access.hosts.is_empty() {
        remark("only requests to a loopback name are served; --http-host states further names");
    }
    Ok(Some(board))
}

#[cfg(not(feature = "http"))]
#[expect(clippy::unnecessary_wraps, reason = "as with the feature")]
fn board(_: &WatchArgs) -> Result<Option<Arc<Board>>, Failure> {
    Ok(None)
}

/// The file of the model, without which clap lets only a replay through.
fn model_file(args: &WatchArgs) -> Result<&Path, Failure> {
    args.model.as_deref().ok_or_else(|| Failure::of_input("--model: expected a file"))
}

/// What is watched, and where it is found in the stream.
fn plan(args: &WatchArgs) -> Result<(Plan, LogMap), Failure> {
    let spec = given(args.spec.as_deref(), PipelineSpec::read)?;
    let model = LinearModel::read(model_file(args)?).map_err(Failure::of_input)?;
    let map = given(args.columns.as_deref(), LogMap::read)?;
    let mut map = map.unwrap_or_else(|| LogMap::for_model(&model));
    let mut channels = map.inputs.iter().chain(&map.outputs);
    let not_on_line = |channel: &ColumnMap| match channel {
        ColumnMap { constant: Some(_), .. } => Some("constant"),
        ColumnMap { expression: Some(_), .. } => Some("expression"),
        ColumnMap { wraps: true, .. } => Some("wraps"),
        _ => None,
    };
    if let Some((channel, what)) = channels.find_map(|c| Some((c, not_on_line(c)?))) {
        let why = format!(
            "column map: `{what}` of channel `{}` is not for samples that come on line",
            channel.name
        );
        return Err(Failure::of_input(why));
    }
    if let Some(time) = &args.time {
        map.time.column = Some(time.clone());
    }
    let stated = args.sample_time.map(SampleTime::new).transpose().map_err(Failure::of_input)?;
    let mut step = stated.or(model.system.sample_time());
    let mut logs = Vec::new();
    for path in &args.healthy {
        let mut reading = map.clone();
        reading.resample.sample_time =
            step.map(SampleTime::seconds).or(reading.resample.sample_time);
        let log = read_log(path, &reading).map_err(Failure::of_input)?;
        // All logs are brought onto the time base of the first.
        step.get_or_insert(log.record.ts());
        logs.push(log.record);
    }
    let learning = match args.learn {
        Some(samples) => Learning::Stream { samples },
        None => Learning::Logs(logs),
    };
    let longest_gap = args.longest_gap.or(map.resample.max_gap_s);
    let request = Request {
        spec: spec.unwrap_or_default(),
        share_to_learn: args.learn_share,
        sample_time: stated,
        longest_gap,
        most_units: args.most_units,
        #[cfg(any(feature = "http", feature = "mqtt"))]
        ask: args.ask,
        alarms: given(args.alarms.as_deref(), AlarmSettings::read)?.unwrap_or_default(),
        ..Request::new(model, learning)
    };
    Ok((request.plan().map_err(failures::of_plan)?, map))
}
