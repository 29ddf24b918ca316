//! What can be asked of `fdiag watch`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::numbers::{positive, share};

/// After the options in the help text; `docs/watch.md` has more.
pub(crate) const WATCH_HELP: &str = "\
Examples:
  fdiag watch --model model.toml --healthy healthy.csv --format csv < later.csv
  fdiag watch --model model.toml --learn 1400 --sample-time 0.1 --state state < samples.ndjson
  fdiag watch --model model.toml --healthy healthy.csv --format csv --follow growing.csv
  fdiag watch --replay state
  mosquitto_sub -t 'plant/+' | fdiag watch --model model.toml --learn 1400 --sample-time 0.1

Exit codes: as for all commands; 0 also after SIGTERM or Ctrl-C, when all units have been saved.";

#[derive(Debug, Args)]
pub(crate) struct WatchArgs {
    /// Model file of the nominal plant (TOML)
    #[arg(long, value_name = "FILE", required_unless_present = "replay")]
    pub model: Option<PathBuf>,
    /// Choice of residual generator, bias model, detector and rule (TOML)
    #[arg(long, value_name = "FILE")]
    pub spec: Option<PathBuf>,
    /// Logs of the healthy plant (CSV) that all units learn from, one or several; may be repeated
    #[arg(long, value_name = "FILE", num_args = 1.., required_unless_present_any = ["learn", "replay"])]
    pub healthy: Vec<PathBuf>,
    /// Let each unit learn what is normal from its own first N samples instead
    #[arg(long, value_name = "N", conflicts_with = "healthy")]
    pub learn: Option<u64>,
    /// Share of the healthy samples, from their start, to learn the bias from; the alarm threshold is taken from
    /// the rest
    #[arg(long, value_name = "SHARE", default_value_t = 0.7, value_parser = share)]
    pub learn_share: f64,
    /// Column map (TOML) of stream and logs; without it columns are found by channel name
    #[arg(long, value_name = "FILE")]
    pub columns: Option<PathBuf>,
    /// Folder that keeps what must survive a restart; made if it is not there
    #[arg(long, value_name = "DIR")]
    pub state: Option<PathBuf>,
    /// How alarms are raised, held, repeated and shelved (TOML); docs/watch.md has the keys
    #[arg(long, value_name = "FILE")]
    pub alarms: Option<PathBuf>,
    /// Watch nothing: print what the journal of a state folder, which may be in use, or a file of messages tells
    #[arg(long, value_name = "PATH", exclusive = true)]
    pub replay: Option<PathBuf>,
    /// Column that tells units apart; without it there is one, called `plant`
    #[arg(long, value_name = "COLUMN")]
    pub unit: Option<String>,
    /// Column of time; without it one called `time`, `t` or `time_s`
    #[arg(long, value_name = "COLUMN")]
    pub time: Option<String>,
    /// How samples are written
    #[arg(long, value_enum, default_value_t = StreamFormat::Ndjson)]
    pub format: StreamFormat,
    /// Follow this file as it grows, instead of reading standard input
    #[arg(long, value_name = "FILE")]
    pub follow: Option<PathBuf>,
    /// Serve /metrics, /healthz and a live page at this address, such as 127.0.0.1:8080
    #[cfg(feature = "http")]
    #[arg(long, value_name = "ADDRESS")]
    pub http: Option<String>,
    /// Name by which the live page may be reached besides loopback names and ADDRESS, as behind a proxy; may be repeated
    #[cfg(feature = "http")]
    #[arg(long, value_name = "NAME[:PORT]", requires = "http")]
    pub http_host: Vec<String>,
    /// Ask on the live page, and at PREFIX/UNIT/wish of a broker, before a unit is trained again; unanswered, it is not
    #[cfg(any(feature = "http", feature = "mqtt"))]
    #[arg(long)]
    pub ask: bool,
    /// File of one line, a token that answers through a broker have to carry; the live page has one of its own
    #[cfg(any(feature = "http", feature = "mqtt"))]
    #[arg(long, value_name = "FILE", requires = "ask")]
    pub answer_token: Option<PathBuf>,
    /// Broker to take samples from or to tell alarms to (MQTT 3.1.1, not encrypted), such as localhost:1883
    #[cfg(feature = "mqtt")]
    #[arg(long, value_name = "HOST[:PORT]", requires = "state")]
    pub mqtt: Option<String>,
    /// Topic with samples as NDJSON, wildcards allowed; may be repeated; instead of standard input
    #[cfg(feature = "mqtt")]
    #[arg(long, value_name = "TOPIC", requires = "mqtt", conflicts_with = "follow")]
    pub mqtt_in: Vec<String>,
    /// Level of the topic, from 1, that names the unit
    #[cfg(feature = "mqtt")]
    #[arg(long, value_name = "N", requires = "mqtt_in", conflicts_with = "unit",
          value_parser = clap::value_parser!(u16).range(1..))]
    pub mqtt_unit: Option<u16>,
    /// Tell alarms at PREFIX/UNIT/alarm, and the state of each unit, retained, at PREFIX/UNIT/state
    #[cfg(feature = "mqtt")]
    #[arg(long, value_name = "PREFIX", requires = "mqtt")]
    pub mqtt_out: Option<String>,
    /// Name of this client, known to no other; without it one is made and kept in the state
    #[cfg(feature = "mqtt")]
    #[arg(long, value_name = "NAME", requires = "mqtt")]
    pub mqtt_id: Option<String>,
    /// File of two lines, user and password, for the broker
    #[cfg(feature = "mqtt")]
    #[arg(long, value_name = "FILE", requires = "mqtt")]
    pub mqtt_login: Option<PathBuf>,
    /// When the residual of a unit has grown over periods of so many hours, say what it looks like: `fdiag gap` on its
    /// recent samples, in a process of its own
    #[arg(long, value_name = "HOURS", value_parser = positive)]
    pub diagnose: Option<f64>,
    /// Recent samples that are kept of each unit, in memory
    #[arg(long, value_name = "N", default_value_t = 5000, requires = "diagnose",
          value_parser = clap::value_parser!(u32).range(10..=10_000_000))]
    pub diagnose_samples: u32,
    /// Model file that recent samples are compared with, equations for instance; without it that of --model
    #[arg(long, value_name = "FILE", requires = "diagnose")]
    pub diagnose_model: Option<PathBuf>,
    /// Longest time of one such diagnosis, in seconds
    #[arg(long, value_name = "SECONDS", default_value_t = 1800.0, value_parser = not_negative, requires = "diagnose")]
    pub diagnose_limit: f64,
    /// Time between samples, in seconds; without it that of the model or of the first healthy log
    #[arg(long, value_name = "SECONDS", value_parser = positive)]
    pub sample_time: Option<f64>,
    /// Longest hole that is bridged by interpolation, in seconds; without it five samples
    #[arg(long, value_name = "SECONDS", value_parser = positive)]
    pub longest_gap: Option<f64>,
    /// Least time between two savings of a unit, in seconds
    #[arg(long, value_name = "SECONDS", default_value_t = 1.0, value_parser = not_negative)]
    pub save_every: f64,
    /// Most units; samples of further ones are refused
    #[arg(long, value_name = "N", default_value_t = 100_000)]
    pub most_units: usize,
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
