//! Alarms that a broker is to hear: all of the journal, in order, from the place that it has confirmed.

use std::{
    collections::BTreeMap,
    fmt::Write as _,
    sync::{
        Arc, Condvar, Mutex, MutexGuard, PoisonError,
        atomic::{AtomicU64, Ordering},
    },
    time::{Duration, Instant},
};

use fd_watch::{Message, Outbox};
use rumqttc::{Client, Event, LastWill, Packet, QoS, valid_topic};

use super::{
    super::super::{failure::Failure, say::complain},
    Broker, Patience,
};

/// Messages that are on their way at once.
const BATCH: usize = 50;
/// A broker that has not confirmed after so long is tried anew.
const CONFIRMATION: Duration = Duration::from_secs(30);
/// What the topic `PREFIX/monitor` holds.
const STATES: [&str; 2] = [r#"{"state":"watching"}"#, r#"{"state":"gone"}"#];

/// How it stands with a connection.
#[derive(Default)]
struct Link {
    /// Which one it is: an old one has nothing to say any more.
    number: u64,
    confirmed: usize,
    broken: Option<String>,
}

#[derive(Default)]
struct Shared {
    promised: AtomicU64,
    confirmed: AtomicU64,
    link: Mutex<Link>,
    changed: Condvar,
}

/// A thread that tells a broker what the journal holds.
pub(in super::super) struct Outlet {
    shared: Arc<Shared>,
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, Link> {
        self.link.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Outlet {
    /// Starts to tell. Without an end: what the broker did not hear it hears when it is back, or from the next monitor.
    pub(in super::super) fn start(
        broker: Broker,
        prefix: String,
        outbox: Outbox,
        promised: u64,
    ) -> Result<Self, Failure> {
        if prefix.is_empty() || !valid_topic(&prefix) {
            return Err(Failure::of_input(format!("--mqtt-out {prefix}: not a topic")));
        }
        let shared = Arc::new(Shared::default());
        shared.promised.store(promised, Ordering::SeqCst);
        shared.confirmed.store(outbox.confirmed(), Ordering::SeqCst);
        let teller = Teller { broker, prefix, outbox, shared: Arc::clone(&shared) };
        std::thread::spawn(move || teller.run());
        Ok(Self { shared })
    }

    /// So many bytes of the journal are promised now.
    pub(in super::super) fn promised(&self, bytes: u64) {
        if self.shared.promised.swap(bytes, Ordering::SeqCst) != bytes {
            // Under the lock, so that it cannot fall between a look and the wait after it.
            let _link = self.shared.lock();
            self.shared.changed.notify_all();
        }
    }

    /// Bytes of the journal that the broker has not yet confirmed.
    pub(in super::super) fn behind(&self) -> u64 {
        let promised = self.shared.promised.load(Ordering::SeqCst);
        promised.saturating_sub(self.shared.confirmed.load(Ordering::SeqCst))
    }

    /// Waits until the broker has heard everything, at most so long.
    pub(in super::super) fn finish(&self, longest: Duration) {
        let begun = Instant::now();
        while 0 < self.behind() && begun.elapsed() < longest {
            std::thread::sleep(Duration::from_millis(5));
        }
    }
}

struct Teller {
    broker: Broker,
    prefix: String,
    outbox: Outbox,
    shared: Arc<Shared>,
}

impl Teller {
    fn run(mut self) {
        let mut patience = Patience::new();
        let mut is_told = false;
        loop {
            let number = {
                let mut link = self.shared.lock();
                *link = Link { number: link.number + 1, ..Link::default() };
                link.number
            };
            let client = self.connect(number);
            let reason = self.tell(&client, &mut patience, &mut is_told);
            if !std::mem::replace(&mut is_told, true) {
                complain(&format!(
                    "fdiag: {}: {reason}; alarms wait in the journal",
                    self.broker.address()
                ));
            }
            // The thread of the connection ends with its last client.
            let _ = client.try_disconnect();
            drop(client);
            patience.wait();
        }
    }

    /// A connection with a thread of its own, which counts what is confirmed.
    fn connect(&self, number: u64) -> Client {
        let mut options = self.broker.options("-out");
        let topic = format!("{}/monitor", self.prefix);
        options.set_clean_session(true).set_last_will(LastWill::new(
            topic,
            STATES[1],
            QoS::AtLeastOnce,
            true,
        ));
        let (client, mut connection) = Client::new(options, 4 * BATCH);
        let shared = Arc::clone(&self.shared);
        std::thread::spawn(move || {
            for event in connection.iter() {
                let mut link = shared.lock();
                if link.number != number {
                    return;
                }
                match event {
                    Ok(Event::Incoming(Packet::PubAck(_))) => link.confirmed += 1,
                    Ok(_) => continue,
                    Err(error) => {
                        link.broken = Some(error.to_string());
                        shared.changed.notify_all();
                        return;
                    }
                }
                shared.changed.notify_all();
            }
        });
        client
    }

    /// Tells everything that comes, until the connection breaks: the reason.
    fn tell(&mut self, client: &Client, patience: &mut Patience, is_told: &mut bool) -> String {
        let monitor = format!("{}/monitor", self.prefix);
        if let Err(reason) = self.send(client, [(monitor, true, STATES[0].to_owned())]) {
            return reason;
        }
        patience.reached();
        *is_told = false;
        loop {
            let promised = self.shared.promised.load(Ordering::SeqCst);
            let messages = match self.outbox.next(promised, BATCH) {
                Ok(messages) => messages,
                Err(error) => return format!("the journal cannot be read: {error}"),
            };
            if messages.is_empty() {
                let link = self.shared.lock();
                let is_idle = |link: &mut Link| {
                    link.broken.is_none() && self.shared.promised.load(Ordering::SeqCst) == promised
                };
                let waited = self.shared.changed.wait_while(link, is_idle);
                let broken = waited.unwrap_or_else(PoisonError::into_inner).broken.take();
                if let Some(reason) = broken {
                    return reason;
                }
                continue;
            }
            let told = self.send(client, texts(&self.prefix, &messages));
            let kept = told.and_then(|()| self.outbox.confirm().map_err(|e| e.to_string()));
            if let Err(reason) = kept {
                return reason;
            }
            self.shared.confirmed.store(self.outbox.confirmed(), Ordering::SeqCst);
        }
    }

    /// Publishes texts and waits until all are confirmed.
    fn send(
        &self,
        client: &Client,
        texts: impl IntoIterator<Item = (String, bool, String)>,
    ) -> Result<(), String> {
        self.shared.lock().confirmed = 0;
        let mut sent = 0;
        for (topic, retain, text) in texts {
            client
                .try_publish(topic, QoS::AtLeastOnce, retain, text)
                .map_err(|_| "the connection takes no message".to_owned())?;
            sent += 1;
        }
        let waits = |link: &mut Link| link.broken.is_none() && link.confirmed < sent;
        let link = self.shared.lock();
        let waited = self.shared.changed.wait_timeout_while(link, CONFIRMATION, waits);
        let mut link = waited.unwrap_or_else(PoisonError::into_inner).0;
        match link.broken.take() {
            Some(reason) => Err(reason),
            None if link.confirmed < sent => Err("it does not confirm what it is told".to_owned()),
            None => Ok(()),
        }
    }
}

/// What a broker is told: every message, and, retained, how the units are that they are about.
fn texts(prefix: &str, messages: &[Message]) -> Vec<(String, bool, String)> {
    let mut texts = Vec::new();
    let mut latest = BTreeMap::new();
    for message in messages {
        let level = level(message.unit().unwrap_or_default());
        texts.push((format!("{prefix}/{level}/alarm"), false, message.to_json()));
        latest.insert(level, message);
    }
    for (level, message) in latest {
        let state = if matches!(message, Message::Cleared(_)) { "normal" } else { "alarmed" };
        let text = format!(r#"{{"state":"{state}","message":{}}}"#, message.to_json());
        texts.push((format!("{prefix}/{level}/state"), true, text));
    }
    texts
}

/// The name of a unit as one level of a topic: what has a meaning there, and `%`, as `%XX`.
pub(super) fn level(unit: &str) -> String {
    let mut level = String::new();
    for character in unit.chars() {
        if matches!(character, '/' | '+' | '#' | '%') || character.is_control() {
            for byte in character.encode_utf8(&mut [0; 4]).bytes() {
                // Writing to a text does not fail.
                let _ = write!(level, "%{byte:02X}");
            }
        } else {
            level.push(character);
        }
    }
    level
}

#[cfg(test)]
mod tests {
    use super::level;

    #[test]
    fn a_unit_is_one_level_of_a_topic_whatever_its_name() {
        assert_eq!(level("p1"), "p1");
        assert_eq!(level("a/b+c#d%\n"), "a%2Fb%2Bc%23d%25%0A");
    }
}
