//! The two streams of the protocol, for a program that runs code of others.

use std::{
    fs::File,
    io::{BufReader, Error, stderr, stdin, stdout},
    os::fd::AsFd,
};

use rustix::stdio::{dup2_stdin, dup2_stdout};

/// Standard input and output as they were, for the protocol alone: from now on whatever this process reads from its
/// standard input is empty, and whatever it prints is on its standard error.
pub(in super::super) fn own_streams() -> Result<(BufReader<File>, File), Error> {
    let input = stdin().as_fd().try_clone_to_owned()?;
    let output = stdout().as_fd().try_clone_to_owned()?;
    dup2_stdin(File::open("/dev/null")?)?;
    dup2_stdout(stderr())?;
    Ok((BufReader::new(input.into()), output.into()))
}
