//! Patched models as files: the simulator with the cause in it.

use fd_gap::diagnose::{Cause, Diagnosis, Verdict};

use super::{data::Data, findings::file_name, report::CauseReport, subject::Subject};

/// A patched model as a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct PatchedFile {
    /// Name of the file.
    pub(super) file: String,
    /// What it is.
    pub(super) content: String,
    /// Its text.
    pub(super) text: String,
}

/// The best explanation, then the others that are tied with it.
pub(super) fn patched_files(
    subject: &Subject,
    diagnosis: &Diagnosis,
    data: &Data,
) -> Vec<PatchedFile> {
    let logs: Vec<String> =
        data.parts.iter().filter(|p| !p.is_held_out).map(|p| file_name(&p.file)).collect();
    let logs = logs.join(", ");
    let name = |cause: &Cause| {
        let cause = CauseReport::of(cause);
        match cause.strength.as_str() {
            "" => cause.name,
            strength => format!("{} ({strength})", cause.name),
        }
    };
    let content = match diagnosis.verdict {
        Verdict::NoGap => "the model with its parameters refitted: there is no gap".to_owned(),
        Verdict::Pair => diagnosis.pairs.first().map_or_else(String::new, |pair| {
            format!("the model with {} and {}", name(&pair.causes[0]), name(&pair.causes[1]))
        }),
        verdict => {
            let with = diagnosis.causes.first().map_or_else(String::new, name);
            let doubt = match verdict {
                Verdict::NoneOfThese => ", the best of the known effects, which is not the cause",
                Verdict::Unclear => ", one of several candidates",
                _ => "",
            };
            format!("the model with {with}{doubt}")
        }
    };
    let mut files =
        vec![file("patched.toml".to_owned(), content, &logs, &subject.text(&diagnosis.best.model))];
    if diagnosis.verdict == Verdict::Tied {
        let tied = diagnosis.tied.iter().filter_map(|id| diagnosis.cause(*id));
        for (i, cause) in tied.enumerate().skip(1) {
            let content = format!("the model with {}, which fits as well", name(cause));
            files.push(file(
                format!("patched-{}.toml", i + 1),
                content,
                &logs,
                &subject.text(&cause.model),
            ));
        }
    }
    files
}

fn file(file: String, content: String, logs: &str, model: &str) -> PatchedFile {
    let text = format!(
        "# Written by `fdiag gap`: {content}.\n\
         # Parameters and the initial state are those fitted to {logs}.\n\
         # What the effect added is at the end of each table.\n\
         {model}"
    );
    PatchedFile { file, content, text }
}
