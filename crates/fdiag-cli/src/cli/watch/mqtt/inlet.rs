//! Samples that a broker delivers.

use std::{
    sync::{
        Arc,
        mpsc::{Receiver, SyncSender, sync_channel},
    },
    time::Instant,
};

use fd_watch::What;
use rumqttc::{
    Client, Event, Packet, Publish, QoS, SubscribeFilter, SubscribeReasonCode, valid_filter,
};

use super::{
    super::{super::failure::Failure, feed::Chunk},
    Broker, Patience,
    backlog::Backlog,
    delivery::{Delivery, Receipt},
};

/// Messages that may wait: beyond them the broker has to.
const WAITING: usize = 1000;
/// Receipts on their way to the broker: a session has no more message numbers.
const RECEIPTS: usize = 1 << 17;

/// What is wanted of a broker.
#[derive(Clone, Debug)]
pub(in super::super) struct Inlet {
    pub broker: Broker,
    /// Topic filters.
    pub topics: Vec<String>,
    /// The level of the topic, from 1, that names the unit.
    pub unit_level: Option<usize>,
}

impl Inlet {
    /// Starts to listen; it never ends.
    pub(in super::super) fn start(self) -> Result<Receiver<Chunk>, Failure> {
        if let Some(wrong) = self.topics.iter().find(|topic| !valid_filter(topic)) {
            return Err(Failure::of_input(format!("--mqtt-in {wrong}: not a topic filter")));
        }
        let (sender, receiver) = sync_channel(WAITING);
        std::thread::spawn(move || self.listen(&sender));
        Ok(receiver)
    }

    fn listen(&self, sender: &SyncSender<Chunk>) {
        let backlog = Arc::new(Backlog::default());
        let mut patience = Patience::new();
        let mut is_told = false;
        loop {
            // Each connection is one of its own, so that a receipt of an old one can never be taken for a message of a
            // new one.
            let mut options = self.broker.options("");
            options.set_clean_session(false).set_manual_acks(true);
            let (client, mut connection) = Client::new(options, RECEIPTS);
            for event in connection.iter() {
                let sent = match event {
                    Ok(Event::Incoming(packet)) => {
                        if matches!(packet, Packet::ConnAck(_)) {
                            patience.reached();
                            is_told = false;
                        }
                        self.take(packet, &client, &backlog, sender)
                    }
                    Ok(Event::Outgoing(_)) => true,
                    Err(error) => {
                        let (broker, reason) = (self.broker.address(), error.to_string());
                        let what = What::Disconnected { broker, reason };
                        if !std::mem::replace(&mut is_told, true)
                            && sender.send(Chunk::Told(what)).is_err()
                        {
                            return;
                        }
                        break;
                    }
                };
                // The monitor has ended.
                if !sent {
                    return;
                }
            }
            drop(connection);
            patience.wait();
        }
    }

    /// Takes what came; false when nobody listens any more.
    fn take(
        &self,
        packet: Packet,
        client: &Client,
        backlog: &Arc<Backlog>,
        sender: &SyncSender<Chunk>,
    ) -> bool {
        let chunk = match packet {
            Packet::ConnAck(found) => {
                let filter = |topic: &String| SubscribeFilter::new(topic.clone(), QoS::AtLeastOnce);
                // Also in a session that lasts: the topics may be others than last time.
                let _ = client.try_subscribe_many(self.topics.iter().map(filter));
                let (broker, session) = (self.broker.address(), found.session_present);
                Chunk::Connected(What::Connected { broker, session })
            }
            Packet::SubAck(answer)
                if answer.return_codes.contains(&SubscribeReasonCode::Failure) =>
            {
                let reason = "the broker refuses a subscription".to_owned();
                Chunk::Told(What::Disconnected { broker: self.broker.address(), reason })
            }
            Packet::Publish(message) => {
                let level = |level: usize| message.topic.split('/').nth(level.saturating_sub(1));
                // A topic that is too short names a unit of no name, which is told as such.
                let unit = self.unit_level.map(|n| level(n).unwrap_or_default().to_owned());
                let mut receipt = Publish::new("", message.qos, Vec::new());
                receipt.pkid = message.pkid;
                let receipt = Receipt { client: client.clone(), message: receipt };
                let room = backlog.admit(message.topic.len() + message.payload.len());
                Chunk::Delivered(Delivery {
                    unit,
                    payload: message.payload.to_vec(),
                    read: Instant::now(),
                    receipt: (message.qos != QoS::AtMostOnce).then_some(receipt),
                    room,
                })
            }
            _ => return true,
        };
        sender.send(chunk).is_ok()
    }
}
