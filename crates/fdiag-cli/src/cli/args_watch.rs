//! What can be asked of `fdiag watch`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::args::{positive, share};

/// After the options in the help text; `docs/watch.md` has more.
pub(crate) const WATCH_HELP: &str = "\
Examples:
  fdiag watch --model model.toml --healthy healthy.csv --format csv < later.csv
  fdiag watch --model model.toml --learn 1400 --unit rig --state state < samples.ndjson
  fdiag watch --model model.toml --healthy healthy.csv --format csv --follow growing.csv
  mosquitto_sub -t 'plant/+' | fdiag watch --model model.toml --learn 1400 --unit rig

Exit codes: as for all commands; 0 also after SIGTERM or Ctrl-C, when all units have been saved.";

#[derive(Debug, Args)]
pub(crate) struct WatchArgs {
    /// Model file of the nominal plant (TOML)
    #[arg(long, value_name = "FILE")]
    pub(crate) model: PathBuf,
    /// Choice of residual generator, bias model, detector and rule (TOML)
    #[arg(long, value_name = "FILE")]
    pub(crate) spec: Option<PathBuf>,
    /// Log of the healthy plant (CSV) that all units learn from, several times for several runs
    #[arg(long, value_name = "FILE", required_unless_present = "learn")]
    pub(crate) healthy: Vec<PathBuf>,
    /// Let each unit learn what is normal from its own first N samples instead
    #[arg(long, value_name = "N", conflicts_with = "healthy")]
    pub(crate) learn: Option<u64>,
    /// Share of the healthy samples, from their start, to learn the bias from; the alarm threshold is taken from
    /// the rest
    #[arg(long, value_name = "SHARE", default_value_t = 0.7, value_parser = share)]
    pub(crate) learn_share: f64,
    /// Column map (TOML) of stream and logs; without it columns are found by channel name
    #[arg(long, value_name = "FILE")]
    pub(crate) columns: Option<PathBuf>,
    /// Folder that keeps what must survive a restart; made if it is not there
    #[arg(long, value_name = "DIR")]
    pub(crate) state: Option<PathBuf>,
    /// Column that tells units apart; without it there is one, called `plant`
    #[arg(long, value_name = "COLUMN")]
    pub(crate) unit: Option<String>,
    /// Column of time; without it one called `time`, `t` or `time_s`
    #[arg(long, value_name = "COLUMN")]
    pub(crate) time: Option<String>,
    /// How samples are written
    #[arg(long, value_enum, default_value_t = StreamFormat::Ndjson)]
    pub(crate) format: StreamFormat,
    /// Follow this file as it grows, instead of reading standard input
    #[arg(long, value_name = "FILE")]
    pub(crate) follow: Option<PathBuf>,
    /// Serve /metrics, /healthz and a live page at this address, such as 127.0.0.1:8080
    #[cfg(feature = "http")]
    #[arg(long, value_name = "ADDRESS")]
    pub(crate) http: Option<String>,
    /// Time between samples, in seconds; without it that of the model or of the first healthy log
    #[arg(long, value_name = "SECONDS", value_parser = positive)]
    pub(crate) sample_time: Option<f64>,
    /// Longest hole that is bridged by interpolation, in seconds; without it five samples
    #[arg(long, value_name = "SECONDS", value_parser = positive)]
    pub(crate) longest_gap: Option<f64>,
    /// Least time between two savings of a unit, in seconds
    #[arg(long, value_name = "SECONDS", default_value_t = 1.0, value_parser = not_negative)]
    pub(crate) save_every: f64,
    /// Most units; samples of further ones are refused
    #[arg(long, value_name = "N", default_value_t = 100_000)]
    pub(crate) most_units: usize,
}

/// How samples are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum StreamFormat {
    /// One JSON object per line
    Ndjson,
    /// A header, then lines of cells
    Csv,
}

/// A number of seconds that a clock can count.
fn not_negative(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(number) if (0.0..1e9).contains(&number) => Ok(number),
        _ => Err("expected a number of seconds, 0 or more".to_owned()),
    }
}
