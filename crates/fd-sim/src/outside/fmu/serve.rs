//! The side of an FMU that has a process of its own.

use std::{io, path::Path};

use super::{
    super::{
        error::OutsideError,
        process::{Widths, answer, greet, heard, own_streams},
        programs,
        source::{Instance, Source},
        stated::Stated,
    },
    Fmu,
    described::Described,
    fault::fault,
};

/// Serves an FMU on standard input and output, for whoever speaks the protocol of programs, until that one says goodbye or
/// is gone. `stated` is what is said of it; without it, what the other side says.
///
/// The process is meant to do nothing else: what the FMU prints goes to standard error from now on, and a crash of the
/// FMU ends the process.
///
/// ```no_run
/// fd_sim::outside::serve_fmu(std::path::Path::new("plant.fmu"), None)?;
/// # Ok::<(), fd_sim::outside::OutsideError>(())
/// ```
///
/// # Errors
///
/// Returns what is wrong with the FMU or with what is said of it, that one of its calls has failed for good, or that the
/// other side does not speak the protocol.
pub fn serve_fmu(path: &Path, stated: Option<Stated>) -> Result<(), OutsideError> {
    let file = path.display().to_string();
    programs::check(&file, || "the library in it".to_owned())?;
    let spoken = |error: io::Error| {
        error.downcast::<OutsideError>().unwrap_or_else(|error| {
            fault(&file, "who asks", "the process protocol", &error.to_string())
        })
    };
    // Before its library is loaded: that may print.
    let (mut input, mut output) = own_streams().map_err(spoken)?;
    let heard = heard(&mut input).map_err(spoken)?;
    let fmu = Fmu::of(Described::read(path, &stated.unwrap_or(heard))?, true)?;
    // What fails at once fails before it is said that all is well.
    let first = fmu.open()?;
    let mut hello = fmu.loaded.described.stated.clone();
    if let Some(powers) = &mut hello.powers {
        // Where each run needs a fresh instance, it is made here.
        (powers.rollout, powers.resets) = (true, true);
    }
    greet(&hello, &mut output).map_err(spoken)?;
    let widths = Widths::of_contract(fmu.contract());
    let more = || -> Result<Box<dyn Instance>, OutsideError> { fmu.open() };
    answer(widths, vec![first], &more, input, output).map_err(spoken)
}
