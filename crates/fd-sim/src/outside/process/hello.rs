//! The first line of each side.

use serde::{Deserialize, Serialize};

use super::{
    super::{contract::Contract, error::OutsideError, stated::Stated},
    child::{Child, brief},
    frame::PROTOCOL_VERSION,
    program::Process,
};

/// What this program says.
#[derive(Serialize)]
struct Ours<'a> {
    fdiag: &'static str,
    version: u32,
    /// What the file says of the simulator.
    stated: &'a Stated,
}

/// What the simulator answers: the contract, or what of it the file leaves out.
#[derive(Deserialize)]
struct Theirs {
    version: u32,
    #[serde(flatten)]
    own: Stated,
}

/// Says hello, and takes the answer for the contract where the file leaves something out.
pub(super) fn hello(child: &mut Child, process: &Process) -> Result<Contract, OutsideError> {
    let (what, deadline) = ("hello", child.deadline());
    let ours = Ours { fdiag: "process", version: PROTOCOL_VERSION, stated: &process.stated };
    let wrong = |child: &Child, found: String| {
        child.protocol(what, "a line of JSON with `version` and the contract".to_owned(), found)
    };
    let mut line = serde_json::to_vec(&ours).map_err(|e| wrong(child, e.to_string()))?;
    line.push(b'\n');
    child.send(&line, what, deadline)?;
    let line = child.receive_line(what, deadline)?;
    let text = String::from_utf8_lossy(&line).into_owned();
    let theirs: Theirs = serde_json::from_str(&text)
        .map_err(|e| wrong(child, format!("`{}` ({e})", brief(&text))))?;
    if theirs.version != PROTOCOL_VERSION {
        let expected = format!("version {PROTOCOL_VERSION} of the protocol");
        return Err(child.protocol(what, expected, format!("version {}", theirs.version)));
    }
    let place = format!("hello of `{}`", process.shown());
    theirs.own.check(&place)?;
    process.stated.clone().over(theirs.own, "the model file")?.settle(&place)
}
