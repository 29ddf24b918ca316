//! The targets: what is given an input, which nothing may break. `tests/suite/fuzz` and the engine in `fuzz/`, which is guided
//! by coverage, share them.

#[cfg(feature = "mqtt")]
mod brokers;
mod files;
mod monitor;
mod texts;

use std::{
    fs,
    path::{Path, PathBuf},
};

/// What takes an input, and says in words what became of it.
pub type Run = Box<dyn Fn(&[u8]) -> String>;

/// Something that takes inputs.
pub struct Target {
    /// Its name, also that of its corpus.
    pub name: &'static str,
    /// Good inputs, and those that failed once.
    pub seeds: Vec<Vec<u8>>,
    /// Inputs that together reach what a guided search has reached beyond the seeds.
    pub corpus: Vec<Vec<u8>>,
    /// Must neither panic nor last.
    pub run: Run,
}

impl Target {
    fn new(
        name: &'static str,
        mut seeds: Vec<Vec<u8>>,
        run: impl Fn(&[u8]) -> String + 'static,
    ) -> Self {
        seeds.extend(found(name));
        let corpus = unpacked(&fs::read(corpus(name)).unwrap_or_default());
        Self { name, seeds, corpus, run: Box::new(run) }
    }
}

/// One list, and a test of each.
macro_rules! targets {
    ($($(#[$only:meta])? $module:ident :: $target:ident),* $(,)?) => {
        /// All targets by the names of their functions.
        #[allow(dead_code, reason = "the ordinary tests name each, the guided engine picks from the list")]
        pub const ALL: &[(&str, fn() -> Target)] = &[$($(#[$only])? (stringify!($target), $module::$target)),*];

        $($(#[$only])?
        #[cfg(test)]
        #[test]
        fn $target() {
            super::engine::fuzz(&$module::$target());
        })*
    };
}

targets![
    texts::models,
    texts::expressions,
    texts::specs,
    texts::linear_models,
    texts::column_maps,
    texts::simulators_of_their_own,
    texts::descriptions_of_fmus,
    files::csv,
    files::ndjson,
    files::csv_and_gzip,
    files::ndjson_and_zstandard,
    files::npz,
    files::npy,
    files::mcap,
    files::rosbag,
    files::ulog,
    files::hdf5,
    files::mat,
    files::parquet,
    files::questions_of_the_process_protocol,
    files::answers_of_the_process_protocol,
    monitor::streams_of_ndjson,
    monitor::streams_of_csv,
    monitor::messages_of_brokers,
    #[cfg(feature = "mqtt")]
    brokers::packets_of_brokers,
    monitor::memories_of_units,
    monitor::learned_rows,
    monitor::journals,
    monitor::kept_samples,
    monitor::damaged_memories_of_units,
    monitor::snapshots,
];

/// The folder of the whole project, from any package in it.
fn root() -> &'static Path {
    let own = Path::new(env!("CARGO_MANIFEST_DIR"));
    own.ancestors().find(|folder| folder.join("ARCHITECTURE.md").exists()).unwrap_or(own)
}

/// Files of the project as seeds.
fn seeds(files: &[&str]) -> Vec<Vec<u8>> {
    let read =
        |file: &&str| fs::read(root().join(file)).unwrap_or_else(|error| panic!("{file}: {error}"));
    files.iter().map(read).collect()
}

/// Inputs that failed once.
fn found(name: &str) -> Vec<Vec<u8>> {
    let entries = fs::read_dir(root().join("crates/fdiag-cli/tests/suite/fuzz/found")).unwrap();
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    let is_own = |path: &&PathBuf| {
        path.file_name().unwrap().to_string_lossy().starts_with(&format!("{name}-"))
    };
    paths.iter().filter(is_own).map(|path| fs::read(path).unwrap()).collect()
}

/// The file of a corpus.
pub fn corpus(name: &str) -> PathBuf {
    root().join(format!("crates/fdiag-cli/tests/suite/fuzz/corpus/{name}"))
}

/// Inputs from one file: of each its length as four bytes, then itself.
fn unpacked(mut bytes: &[u8]) -> Vec<Vec<u8>> {
    let mut inputs = Vec::new();
    while let Some((length, rest)) = bytes.split_first_chunk() {
        let (input, rest) = rest.split_at(u32::from_le_bytes(*length) as usize);
        inputs.push(input.to_vec());
        bytes = rest;
    }
    inputs
}
