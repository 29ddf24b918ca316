//! `fdiag demo`: both halves of the method on one page, on files that it lays beside the page.

use std::{
    fs,
    path::{Path, PathBuf},
};

use clap::Args;
use fd_page::{page as gap_page, run_pictures};
use fd_report::{Line, Page, Picture};
use fdiag::{
    core::Limits,
    gap_study::{self, GapStudy, HeldOutChoice, Request as GapRequest},
    model::figure,
    spec::PipelineSpec,
    training::Trace,
};
use serde::Serialize;

use crate::logs::{LogStudy, Request, Traces};

use super::{
    failure::{ExitCode, Failure},
    output::{Output, OutputArgs},
    pool::pool,
    progress::{Bar, Stages},
    say::remark,
};

/// After the options in the help text.
pub(crate) const DEMO_HELP: &str = "\
Then, with files of your own:
  fdiag compensate --help
  fdiag gap --help";

#[derive(Debug, Args)]
pub(crate) struct DemoArgs {
    #[command(flatten)]
    output: OutputArgs,
}

/// A jet engine with errors of up to 10 % in its model, as `fdiag-lab engine --write-files` makes it: healthy runs, and
/// one in which the temperature sensor `T_7` drifts by 0.5 %.
const ENGINE: [(&str, &str); 6] = [
    ("model.toml", include_str!("../../demo/engine/model.toml")),
    ("spec.toml", include_str!("../../demo/engine/spec.toml")),
    ("healthy-1.csv", include_str!("../../demo/engine/healthy-1.csv")),
    ("healthy-2.csv", include_str!("../../demo/engine/healthy-2.csv")),
    ("healthy-3.csv", include_str!("../../demo/engine/healthy-3.csv")),
    ("today.csv", include_str!("../../demo/engine/today.csv")),
];
/// A cart whose simulator lacks dry friction: `examples/gap/quick-start`.
const CART: [(&str, &str); 3] = [
    ("model.toml", include_str!("../../demo/cart/model.toml")),
    ("monday.csv", include_str!("../../demo/cart/monday.csv")),
    ("friday.csv", include_str!("../../demo/cart/friday.csv")),
];

/// Size of the pictures that are written as files, in pixels.
const PICTURE_SIZE: (u32, u32) = (720, 400);

/// What both halves found.
#[derive(Serialize)]
struct Demo<'a> {
    compensation: &'a LogStudy,
    gap: &'a gap_study::Report,
}

pub(crate) fn run(args: &DemoArgs) -> Result<ExitCode, Failure> {
    let output = Output::prepare(&args.output)?;
    let out = &args.output.out;
    let (engine, cart) = (lay(out, "engine", &ENGINE)?, lay(out, "cart", &CART)?);
    let pool = pool(args.output.threads)?;

    let (bias, traces) = pool.install(|| compensate(&engine))?;
    let page = bias.page(&traces).map_err(Failure::analysis)?;
    output.write("engine/report.html", &page.to_html())?;
    remark("1 of 2 is done: engine/report.html");

    let study = pool.install(|| gap(&cart))?;
    let page = gap_page(&study).map_err(Failure::analysis)?;
    output.write("cart/report.html", &page.to_html())?;
    for model in &study.report.models {
        output.write(&format!("cart/{}", model.file), &model.text)?;
    }

    let said = headline(&bias, &study);
    let mut page = Page::new("fdiag in half a minute", &said);
    first_half(&mut page, &output, &bias, &traces, out)?;
    second_half(&mut page, &output, &study, out)?;
    let demo = Demo { compensation: &bias, gap: &study.report };
    output.finish(&said, &[], page, &demo, &[])?;
    Ok(ExitCode::SUCCESS)
}

/// Writes files to a directory below `out`.
fn lay(out: &Path, name: &str, files: &[(&str, &str)]) -> Result<PathBuf, Failure> {
    let directory = out.join(name);
    fs::create_dir_all(&directory).map_err(|error| Failure::output(&directory, error))?;
    for (file, text) in files {
        let path = directory.join(file);
        fdiag::model::file::write_atomically(&path, |out| out.write_all(text.as_bytes()))
            .map_err(|error| Failure::output(&path, error))?;
    }
    Ok(directory)
}

fn compensate(engine: &Path) -> Result<(LogStudy, Traces), Failure> {
    let healthy = ENGINE.iter().filter(|(name, _)| name.starts_with("healthy"));
    let request = Request {
        model: engine.join("model.toml"),
        healthy: healthy.map(|(name, _)| engine.join(name)).collect(),
        logs: vec![engine.join("today.csv")],
        columns: None,
        spec: PipelineSpec::read(&engine.join("spec.toml")).map_err(Failure::of_input)?,
        share_to_learn: 0.7,
        limits: Limits::default(),
    };
    let progress = Bar::new("logs");
    let studied = request.read().and_then(|material| LogStudy::run(&material, &progress));
    progress.finish()?;
    studied.map_err(Failure::analysis)
}

fn gap(cart: &Path) -> Result<GapStudy, Failure> {
    let plain = GapRequest::new(cart.join("model.toml"), [cart.join("monday.csv")]);
    let held_out = HeldOutChoice::Logs(vec![cart.join("friday.csv")]);
    let progress = Stages::new();
    let study = GapStudy::run(&GapRequest { held_out, ..plain }, &progress);
    progress.finish();
    study.map_err(Failure::analysis)
}

/// Both answers.
fn headline(bias: &LogStudy, study: &GapStudy) -> String {
    let [without, with] = alarms(bias);
    format!(
        "1. A temperature sensor of a jet engine drifts by 0.5 % from 10 s on: {without} without compensation, {with} \
         with it. 2. What the simulator of a cart lacks: {}",
        study.report.headline
    )
}

/// When the faulty log raises its first alarm, without and with compensation.
fn alarms(bias: &LogStudy) -> [String; 2] {
    let (without, with) = bias.logs.last().map_or((None, None), |log| log.first_alarm_s);
    let said = |alarm: Option<f64>| {
        alarm.map_or("no alarm".to_owned(), |t| format!("an alarm at {} s", figure(t)))
    };
    [said(without), said(with)]
}

fn first_half(
    page: &mut Page,
    output: &Output<'_>,
    bias: &LogStudy,
    traces: &Traces,
    out: &Path,
) -> Result<(), Failure> {
    page.heading("1. Learn the bias, and see the fault");
    page.text(
        "The model of this engine is wrong by up to 10 %. That shows in the residual, measured minus predicted, as a bias, \
         and the threshold has to stand above it. fdiag learned the bias from healthy runs; in a later run it simulates \
         it from the fuel flow alone and subtracts it, so that a fault cannot hide in it.",
    );
    let pictures = pictures(bias, traces);
    page.gallery(&pictures).map_err(Failure::analysis)?;
    for ((picture, _), name) in pictures.iter().zip(["before", "after"]) {
        output.write(&format!("engine/{name}.svg"), &svg(picture)?)?;
    }
    page.details(
        "The same on the command line",
        command(
            out,
            "engine",
            &[
                "compensate --model model.toml --spec spec.toml",
                "--healthy healthy-1.csv --healthy healthy-2.csv --healthy healthy-3.csv",
                "--log today.csv",
            ],
        ),
    );
    Ok(())
}

fn second_half(
    page: &mut Page,
    output: &Output<'_>,
    study: &GapStudy,
    out: &Path,
) -> Result<(), Failure> {
    page.heading("2. Name the cause of the bias");
    page.text(
        "A cart on a rail, pushed by a motor; its simulator knows mass and bearing drag. fdiag refitted both within their \
         tolerances, tried every effect of its library at every place, and judged the winner on a log that no fit has seen.",
    );
    page.text(study.report.headline.clone());
    if let Some(trace) = &study.trace {
        let pictures = run_pictures(trace);
        page.gallery(&pictures).map_err(Failure::analysis)?;
        if let Some((picture, _)) = pictures.first() {
            output.write("cart/gap.svg", &svg(picture)?)?;
        }
    }
    page.details(
        "The same on the command line",
        command(out, "cart", &["gap --model model.toml --log monday.csv --held-out friday.csv"]),
    );
    Ok(())
}

/// The residual of the faulty log before and after compensation.
fn pictures(bias: &LogStudy, traces: &Traces) -> Vec<(Picture, String)> {
    let Some((without, with)) = traces.last() else { return Vec::new() };
    let scale = bias.residuals.first().map_or(1.0, |residual| residual.scale);
    let before = picture("Before compensation", without, &without.residual, scale);
    let after = picture("After compensation", with, &with.compensated, scale);
    [before, after].into_iter().zip(alarms(bias)).collect()
}

fn svg(picture: &Picture) -> Result<String, Failure> {
    let (width, height) = PICTURE_SIZE;
    picture.to_svg(width, height).map_err(Failure::analysis)
}

/// A residual against its threshold.
fn picture(title: &str, trace: &Trace, residual: &[f64], scale: f64) -> Picture {
    let own = residual.iter().step_by(trace.channels.max(1)).map(|v| v * scale);
    let mut picture = Picture {
        title: title.to_owned(),
        x_label: "time [s]".to_owned(),
        y_label: "residual [1]".to_owned(),
        lines: vec![Line::new("residual", trace.time.iter().copied().zip(own))],
        ..Picture::default()
    };
    if let Some(threshold) = trace.threshold.last().map(|threshold| threshold * scale) {
        picture.levels = vec![(threshold, "threshold".to_owned()), (-threshold, String::new())];
    }
    if let Some(k) = trace.first_alarm(0) {
        picture.marks.push((trace.time[k], "first alarm".to_owned()));
    }
    picture
}

/// A command as it is typed in a directory.
fn command(out: &Path, directory: &str, lines: &[&str]) -> String {
    format!("cd {}\nfdiag {}", out.join(directory).display(), lines.join(" \\\n    "))
}
