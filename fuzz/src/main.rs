//! One target of `crates/fdiag-cli/tests/suite/fuzz/targets`, run by libFuzzer: `FDIAG_FUZZ_TARGET` says which, by the name of
//! its function. `fuzz/run.sh` begins with its seeds, and keeps the inputs that together reach what was reached.
#![no_main]
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a failure here is a finding"
)]

#[path = "../../crates/fdiag-cli/tests/suite/fuzz/targets/mod.rs"]
mod targets;

use std::{
    cell::RefCell,
    env, fs, panic,
    path::{Path, PathBuf},
};

use libfuzzer_sys::fuzz_target;
use targets::{ALL, Target};

thread_local! {
    static TARGET: RefCell<Option<Target>> = const { RefCell::new(None) };
}
/// Most bytes of a corpus that is kept.
const MOST: usize = 24 << 10;

/// The target that is named, or all that is wanted of it but a search.
fn choose() {
    // The hook of libFuzzer ends the program at every panic, also where a reader catches those of a library of others.
    // A panic that comes out of a target ends it without that hook.
    drop(panic::take_hook());
    let name = env::var("FDIAG_FUZZ_TARGET").unwrap_or_default();
    let Some((_, target)) = ALL.iter().find(|(known, _)| *known == name) else {
        let known: Vec<&str> = ALL.iter().map(|(known, _)| *known).collect();
        panic!("FDIAG_FUZZ_TARGET: expected one of {known:?}, found {name:?}");
    };
    let target = target();
    let wanted = |key| env::var_os(key).map(PathBuf::from);
    if let Some(folder) = wanted("FDIAG_FUZZ_UNPACK") {
        unpack(&target, &folder);
    } else if let Some(folder) = wanted("FDIAG_FUZZ_PACK") {
        pack(target.name, &folder);
    } else {
        TARGET.with(|chosen| chosen.replace(Some(target)));
        return;
    }
    std::process::exit(0);
}

/// Writes seeds and corpus, each into a folder of its own.
fn unpack(target: &Target, folder: &Path) {
    for (kind, inputs) in [("seeds", &target.seeds), ("inputs", &target.corpus)] {
        for (i, input) in inputs.iter().enumerate() {
            fs::write(folder.join(format!("{kind}/{kind}-{i}")), input).expect("written");
        }
    }
}

/// Writes the corpus of a target, the shortest inputs first.
fn pack(name: &str, folder: &Path) {
    let mut inputs: Vec<Vec<u8>> = fs::read_dir(folder)
        .expect("a folder")
        .map(|entry| fs::read(entry.expect("an entry").path()).expect("an input"))
        .collect();
    inputs.sort_by_key(|input| (input.len(), input.clone()));
    let mut packed = Vec::new();
    for input in inputs {
        if packed.len() + input.len() + 4 <= MOST {
            packed.extend(u32::try_from(input.len()).expect("short").to_le_bytes());
            packed.extend(input);
        }
    }
    fs::write(targets::corpus(name), packed).expect("written");
}

fuzz_target!(
    init: choose(),
    |data: &[u8]| {
        TARGET.with_borrow(|target| drop(target.as_ref().map(|target| (target.run)(data))));
    }
);
