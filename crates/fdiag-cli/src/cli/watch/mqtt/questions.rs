//! Questions to whoever listens to a broker, and their answers: whether to train a unit again.
//!
//! `PREFIX/UNIT/wish` holds, retained, the question that waits, and nothing when none does. What the broker holds is compared
//! with what is asked whenever the connection begins: a question of an earlier monitor goes away. An answer comes at
//! `PREFIX/UNIT/answer` in a session that lasts, and is acknowledged when it has been dealt with.

use std::{
    collections::BTreeMap,
    sync::{
        Arc, Mutex, MutexGuard, PoisonError,
        mpsc::{Receiver, SyncSender, sync_channel},
    },
};

use fd_watch::{Message, What};
use rumqttc::{Client, Event, Packet, Publish, QoS, SubscribeFilter};
use serde::Deserialize;

use super::{Broker, Patience, outlet::level};

/// Answers that may wait.
const WAITING: usize = 100;
/// Longest answer in bytes; the name of a unit has at most 200 characters.
const LONGEST: usize = 4096;
/// Texts that may wait for the connection: a question of every unit at once, and then some.
const TEXTS: usize = 1 << 17;

/// What is published as an answer.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Published {
    id: String,
    answer: Said,
    token: Option<String>,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Said {
    Confirm,
    Refuse,
}

/// A question and its answer, or what is wrong with it.
type Judged = Result<(String, bool), String>;

/// An answer that came, to be acknowledged.
pub(in super::super) struct Reply {
    client: Client,
    receipt: Publish,
    /// The unit as a level of the topic.
    level: String,
    said: Result<Published, String>,
}

/// Who asks.
pub(in super::super) struct Questions {
    shared: Arc<Mutex<Shared>>,
    replies: Receiver<Reply>,
}

struct Shared {
    /// What topics begin with.
    prefix: String,
    client: Option<Client>,
    /// The question of each unit that has one, by its level of a topic.
    waiting: BTreeMap<String, String>,
    /// Levels of units whose answer is being kept.
    answered: Vec<String>,
    /// What answers have to carry, if anything.
    token: Option<String>,
}

fn lock(shared: &Mutex<Shared>) -> MutexGuard<'_, Shared> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Questions {
    /// Starts to ask: first what is asked already, of unit and question.
    pub(in super::super) fn start(
        broker: Broker,
        prefix: String,
        token: Option<String>,
        asked: impl Iterator<Item = (String, String)>,
    ) -> Self {
        let waiting = asked.map(|(unit, id)| (level(&unit), id)).collect();
        let answered = Vec::new();
        let shared = Shared { prefix: prefix.clone(), client: None, waiting, answered, token };
        let shared = Arc::new(Mutex::new(shared));
        let (sender, replies) = sync_channel(WAITING);
        let asker = Asker { broker, prefix, shared: Arc::clone(&shared), sender };
        std::thread::spawn(move || asker.run());
        Self { shared, replies }
    }

    /// Takes from what was said who asks, and who does no more. That a question was answered the broker hears when the
    /// answer is [settled](Self::settle).
    pub(in super::super) fn hear(&self, messages: &[Message]) {
        for message in messages {
            let Message::Event(event) = message else { continue };
            let Some(unit) = &event.unit else { continue };
            let (mut shared, level) = (lock(&self.shared), level(unit));
            match &event.what {
                What::RetrainingWanted { id } => {
                    shared.waiting.insert(level.clone(), id.clone());
                    shared.tell(&level);
                }
                What::RetrainingWithdrawn { .. } => {
                    shared.waiting.remove(&level);
                    shared.tell(&level);
                }
                What::RetrainingAnswered { .. } => {
                    shared.waiting.remove(&level);
                    shared.answered.push(level);
                }
                _ => {}
            }
        }
    }

    /// Answers have been kept: their questions go away.
    pub(in super::super) fn settle(&self) {
        let mut shared = lock(&self.shared);
        let answered = std::mem::take(&mut shared.answered);
        for level in &answered {
            shared.tell(level);
        }
    }

    /// Answers that came meanwhile: whom to thank, and either question and answer or what is wrong.
    pub(in super::super) fn replies(&self) -> Vec<(Reply, Judged)> {
        let shared = lock(&self.shared);
        let judged = |reply: Reply| {
            let outcome = match &reply.said {
                Err(why) => Err(why.clone()),
                Ok(Published { token, .. }) if shared.token.is_some() && shared.token != *token => {
                    Err("expected the `token` of --answer-token".to_owned())
                }
                Ok(Published { id, .. }) if shared.waiting.get(&reply.level) != Some(id) => {
                    Err(format!("`{}` does not ask `{id}` (any more)", reply.level))
                }
                Ok(Published { id, answer, .. }) => {
                    Ok((id.clone(), matches!(answer, Said::Confirm)))
                }
            };
            (reply, outcome)
        };
        self.replies.try_iter().map(judged).collect()
    }
}

impl Reply {
    /// The broker may forget it.
    pub(in super::super) fn sign(self) {
        let _ = self.client.try_ack(&self.receipt);
    }
}

impl Shared {
    /// Tells the broker what a unit asks. Without a connection the next one begins with it.
    fn tell(&self, level: &str) {
        if let Some(client) = &self.client {
            let text = self.waiting.get(level).map_or_else(String::new, |id| text(id));
            let _ = client.try_publish(
                format!("{}/{level}/wish", self.prefix),
                QoS::AtLeastOnce,
                true,
                text,
            );
        }
    }
}

/// A question as it is retained.
fn text(id: &str) -> String {
    serde_json::json!({ "id": id, "answers": ["confirm", "refuse"] }).to_string()
}

struct Asker {
    broker: Broker,
    prefix: String,
    shared: Arc<Mutex<Shared>>,
    sender: SyncSender<Reply>,
}

impl Asker {
    fn run(&self) {
        let mut patience = Patience::new();
        loop {
            let mut options = self.broker.options("-ask");
            options.set_clean_session(false).set_manual_acks(true);
            let (client, mut connection) = Client::new(options, TEXTS);
            for event in connection.iter() {
                match event {
                    Ok(Event::Incoming(Packet::ConnAck(_))) => {
                        patience.reached();
                        self.begin(&client);
                    }
                    Ok(Event::Incoming(Packet::Publish(message))) => {
                        if !self.take(&message, &client) {
                            return;
                        }
                    }
                    Ok(_) => {}
                    Err(_) => break,
                }
            }
            lock(&self.shared).client = None;
            patience.wait();
        }
    }

    /// Asks for answers and for what the broker holds, and says what is asked.
    fn begin(&self, client: &Client) {
        let filter = |what: &str| {
            SubscribeFilter::new(format!("{}/+/{what}", self.prefix), QoS::AtLeastOnce)
        };
        let _ = client.try_subscribe_many([filter("answer"), filter("wish")]);
        let mut shared = lock(&self.shared);
        shared.client = Some(client.clone());
        for level in shared.waiting.keys() {
            shared.tell(level);
        }
    }

    /// Takes what came; false when nobody listens any more.
    fn take(&self, message: &Publish, client: &Client) -> bool {
        let mut receipt = Publish::new("", message.qos, Vec::new());
        receipt.pkid = message.pkid;
        let rest = message.topic.strip_prefix(&self.prefix);
        let rest = rest.and_then(|rest| rest.strip_prefix('/')).unwrap_or_default();
        let (level, what) = rest.split_once('/').unwrap_or_default();
        if what == "wish" {
            let shared = lock(&self.shared);
            // Its own echo, mostly; else what an earlier monitor has asked.
            let asked = shared.waiting.get(level).map_or_else(String::new, |id| text(id));
            if message.payload != asked.as_bytes() {
                shared.tell(level);
            }
        }
        if what != "answer" {
            // Also what an earlier monitor of another prefix has subscribed to.
            let _ = client.try_ack(&receipt);
            return true;
        }
        let said = if LONGEST < message.payload.len() {
            Err(format!("longer than {LONGEST} bytes"))
        } else {
            let read = serde_json::from_slice(&message.payload);
            read.map_err(|error| {
                format!("expected {{\"id\": ..., \"answer\": \"confirm\" or \"refuse\"}}: {error}")
            })
        };
        let reply = Reply { client: client.clone(), receipt, level: level.to_owned(), said };
        self.sender.send(reply).is_ok()
    }
}
