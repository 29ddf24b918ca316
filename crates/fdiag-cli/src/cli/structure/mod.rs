//! `fdiag structure`: which faults a model can show at all, by which tests, and what more sensors would add.

mod args;
mod pictures;
mod study;
mod tables;

use std::path::{Path, PathBuf};

use fd_report::Page;
use fd_structure::equations::EquationModel;
use fdiag::{
    gap_study::{Request, Subject},
    model::{
        SampleTime,
        file::{LinearModel, read_text},
    },
    sim::model::{LinearOptions, Model},
};

pub(crate) use self::args::{STRUCTURE_HELP, StructureArgs};
use self::study::Study;
use super::{
    failure::{ExitCode, Failure},
    output::Output,
};

pub(crate) fn run(args: &StructureArgs) -> Result<ExitCode, Failure> {
    let model = model(args)?;
    let equations = EquationModel::new(&model, &args.faults).map_err(Failure::of_input)?;
    let output = Output::prepare(&args.output)?;
    let study = Study::of(&equations, args)?;
    let tables = study.tables();

    let structure = pictures::structure(&study);
    let isolability = pictures::isolability(&study);
    let drawn = |matrix: &fd_report::Matrix| matrix.to_svg().map_err(Failure::analysis);
    output.write("structure.svg", &drawn(&structure)?)?;
    output.write("isolability.svg", &drawn(&isolability)?)?;

    let headline = study.headline();
    let mut page = Page::new(format!("Structure of {}", study.model.name()), headline.clone());
    page.heading("Faults");
    page.matrix(&isolability, pictures::ISOLABILITY).map_err(Failure::analysis)?;
    page.heading("Equations");
    page.matrix(&structure, pictures::STRUCTURE).map_err(Failure::analysis)?;
    page.heading("Tables");
    for table in &tables {
        page.table(table.clone());
    }
    output.finish(&headline, &tables, page, &study, &[&args.model])?;
    Ok(ExitCode::SUCCESS)
}

/// A model with equations; what has none has no structure.
fn model(args: &StructureArgs) -> Result<Model, Failure> {
    let file = &args.model;
    let request = Request::new(file, Vec::<PathBuf>::new());
    // Whatever is not small and readable is refused before it is looked into.
    let text = read_text(file, request.limits.bytes).ok();
    let kind = text.as_ref().and_then(|text| text.parse::<toml::Table>().ok());
    let kind = kind.as_ref().and_then(|table| table.get("kind")).and_then(toml::Value::as_str);
    match (kind, &text) {
        (Some("state-space"), Some(text)) => return linear(file, text),
        (Some("equations") | None, _) | (_, None) => {}
        (Some(kind), _) => {
            let reason = format!(
                "a model of kind `{kind}` has no equations to look into: expected `equations` or \
                 `state-space`"
            );
            return Err(Failure::input(file, reason));
        }
    }
    let subject = Subject::of(&request).map_err(Failure::of_input)?;
    Ok(subject.model().clone())
}

/// A linear model as equations. One without a sample time gets that of a second, on which its structure does not depend.
fn linear(file: &Path, text: &str) -> Result<Model, Failure> {
    let linear =
        LinearModel::parse(&file.display().to_string(), text).map_err(Failure::of_input)?;
    let second = SampleTime::new(1.0).map_err(Failure::of_input)?;
    let ts = linear.system.sample_time().unwrap_or(second);
    Model::from_linear(&linear, ts, &LinearOptions::default())
        .map_err(|error| Failure::input(file, error))
}
