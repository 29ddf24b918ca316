//! Patched models as files: the simulator with the cause in it.

use fd_gap::{
    diagnose::{Cause, Diagnosis, Verdict, adjustable},
    road::CauseList,
};
use fd_sim::model::Model;
use schemars::JsonSchema;
use serde::Serialize;

use super::{
    data::Data,
    log_part::Role,
    subject::Subject,
    words::{self, with_strength},
};

/// A patched model as a file beside the report.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, JsonSchema)]
pub struct PatchedModel {
    /// Name of the file.
    pub file: String,
    /// What it is, in words.
    pub content: String,
    /// Its text; not serialised.
    #[serde(skip)]
    pub text: String,
}

/// The best explanation, then the others that are tied with it.
pub(super) fn patched_models(
    subject: &Subject,
    diagnosis: &Diagnosis,
    road: Option<&CauseList>,
    data: &Data,
) -> Vec<PatchedModel> {
    let fitted = data.parts.iter().filter(|part| part.role == Role::Fit);
    let logs: Vec<&str> = fitted.map(|part| part.file.as_str()).collect();
    let logs = logs.join(", ");
    let content = match diagnosis.verdict {
        Verdict::NoGap => "the model with its parameters refitted: there is no gap".to_owned(),
        Verdict::Pair => diagnosis.pairs.first().map_or_else(String::new, |pair| {
            format!(
                "the model with {} and {}",
                with_strength(&pair.causes[0]),
                with_strength(&pair.causes[1])
            )
        }),
        verdict => {
            let with = diagnosis.causes.first().map_or_else(String::new, with_strength);
            let doubt = match verdict {
                Verdict::NoneOfThese => ", the best of the known effects, which is not the cause",
                Verdict::Unclear => ", one of several candidates",
                _ => "",
            };
            format!("the model with {with}{doubt}")
        }
    };
    let first = match (road, diagnosis.verdict, diagnosis.pairs.first()) {
        (Some(road), ..) => {
            let causes: Vec<String> =
                road.causes.iter().map(|listed| words::cause(&listed.cause)).collect();
            let content = format!("the model with {}", words::list(&causes, "and"));
            file("patched.toml".to_owned(), content, &logs, &subject.text(&road.model))
        }
        (None, verdict, pair) => {
            let causes: Vec<&Cause> = match (verdict, pair) {
                (Verdict::NoGap, _) => Vec::new(),
                (Verdict::Pair, Some(pair)) => pair.causes.iter().collect(),
                _ => diagnosis.causes.iter().take(1).collect(),
            };
            let model = to_go_on_from(&diagnosis.best.model, &causes, subject.model());
            file("patched.toml".to_owned(), content, &logs, &subject.text(&model))
        }
    };
    let mut files = vec![first];
    if diagnosis.verdict == Verdict::Tied {
        let tied = diagnosis.tied.iter().filter_map(|id| diagnosis.cause(*id));
        for (i, cause) in tied.enumerate().skip(1) {
            let content = format!("the model with {}, which fits as well", with_strength(cause));
            files.push(file(
                format!("patched-{}.toml", i + 1),
                content,
                &logs,
                &subject.text(&to_go_on_from(&cause.model, &[cause], subject.model())),
            ));
        }
    }
    files
}

/// The model with what was found of the causes open to adjustment, so that a study of it goes on from there.
fn to_go_on_from(model: &Model, causes: &[&Cause], nominal: &Model) -> Model {
    let mut draft = adjustable(model, causes.iter().copied()).into_draft();
    // What follows a log has innovations in the place of noise.
    for (output, known) in draft.outputs.iter_mut().zip(&nominal.outputs) {
        output.noise = known.noise;
    }
    Model::try_from(draft).unwrap_or_else(|_| model.clone())
}

fn file(file: String, content: String, logs: &str, model: &str) -> PatchedModel {
    let text = format!(
        "# Written by `fdiag gap`: {content}.\n\
         # Parameters and the initial state are those fitted to {logs}.\n\
         # What the effect added is at the end of each table.\n\
         {model}"
    );
    PatchedModel { file, content, text }
}
