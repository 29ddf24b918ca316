//! Samples from a broker, alarms to it (MQTT 3.1.1).
//!
//! In: a persistent session at quality of service 1. A message is acknowledged only after its samples are in the state folder, so what
//! a kill interrupts the broker sends again. Out: a cursor over the journal, moved on only when the broker has
//! acknowledged, so what it does not hear while it is away it hears later.

mod backlog;
mod delivery;
mod inlet;
mod outlet;
mod questions;

use std::{
    path::Path,
    time::{Duration, Instant},
};

use fdiag::model::file::read_text;
use rumqttc::MqttOptions;

pub(super) use self::{
    delivery::{Delivery, Receipt},
    inlet::Inlet,
    outlet::Outlet,
    questions::Questions,
};
use super::super::{args_watch::WatchArgs, failure::Failure};

/// Port when none is given.
const PORT: u16 = 1883;
/// A broker that has heard nothing for 1.5 times as long takes the connection for broken.
const KEEP_ALIVE: Duration = Duration::from_secs(20);
/// First and longest wait between two attempts to reach a broker.
const PATIENCE: (Duration, Duration) = (Duration::from_millis(100), Duration::from_secs(5));
/// As large as MQTT allows: a message that is refused here would be sent again for ever. What is too long for a line
/// is left out where lines are read.
const LARGEST: usize = 268_435_455;

/// How a broker is reached.
#[derive(Clone, Debug)]
pub(super) struct Broker {
    host: String,
    port: u16,
    login: Option<(String, String)>,
    /// A name that no other client of the broker has.
    client: String,
}

impl Broker {
    /// The broker that the options name, if any.
    pub(super) fn of(args: &WatchArgs, own_name: &str) -> Result<Option<Self>, Failure> {
        let Some(address) = &args.mqtt else { return Ok(None) };
        let wrong = || Failure::of_input(format!("--mqtt {address}: expected HOST or HOST:PORT"));
        // An address of the 6th version is written in brackets, as in `[::1]:1883`.
        let (host, port) = match address.rsplit_once(':') {
            Some((host, port)) if !host.is_empty() && !port.ends_with(']') => {
                (host, port.parse().map_err(|_| wrong())?)
            }
            _ => (address.as_str(), PORT),
        };
        let host = host.trim_start_matches('[').trim_end_matches(']').to_owned();
        if host.is_empty() || host.contains('/') {
            return Err(wrong());
        }
        let login = args.mqtt_login.as_deref().map(login).transpose()?;
        let client = args.mqtt_id.clone().unwrap_or_else(|| format!("fdiag-{own_name}"));
        Ok(Some(Self { host, port, login, client }))
    }

    fn address(&self) -> String {
        format!("{}:{}", self.host, self.port)
    }

    fn options(&self, suffix: &str) -> MqttOptions {
        let client = format!("{}{suffix}", self.client);
        let mut options = MqttOptions::new(client, self.host.clone(), self.port);
        options.set_keep_alive(KEEP_ALIVE).set_max_packet_size(LARGEST, LARGEST);
        if let Some((user, password)) = &self.login {
            options.set_credentials(user, password);
        }
        options
    }
}

/// Two lines: user and password.
fn login(path: &Path) -> Result<(String, String), Failure> {
    let text = read_text(path, 10_000).map_err(|error| Failure::input(path, error))?;
    let mut lines = text.lines();
    match (lines.next(), lines.next()) {
        (Some(user), Some(password)) if !user.is_empty() => {
            Ok((user.to_owned(), password.to_owned()))
        }
        _ => Err(Failure::input(path, "expected two lines: user and password")),
    }
}

/// Waits before the next attempt, longer each time, until a connection has lasted for longer than the longest wait: two
/// monitors of one name, whom a broker throws out in turn, would else spend their days with it.
struct Patience {
    next: Duration,
    reached: Option<Instant>,
}

impl Patience {
    fn new() -> Self {
        Self { next: PATIENCE.0, reached: None }
    }

    /// There is a connection.
    fn reached(&mut self) {
        self.reached = Some(Instant::now());
    }

    fn wait(&mut self) {
        if self.reached.take().is_some_and(|since| PATIENCE.1 < since.elapsed()) {
            self.next = PATIENCE.0;
        }
        std::thread::sleep(self.next);
        self.next = (2 * self.next).min(PATIENCE.1);
    }
}
