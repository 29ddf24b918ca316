//! A message of a broker, and its receipt.

use std::time::Instant;

use rumqttc::{Client, Publish};

use super::backlog::Admitted;

/// Says to the broker that a message may be forgotten.
pub(in super::super) struct Receipt {
    pub(super) client: Client,
    pub(super) message: Publish,
}

impl Receipt {
    /// Hands it over. Over a connection that broke meanwhile it is not sent: the broker delivers the message again.
    pub(in super::super) fn sign(self) {
        let _ = self.client.try_ack(&self.message);
    }
}

/// A message of a broker.
pub(in super::super) struct Delivery {
    /// The unit that its topic names, if topics do.
    pub unit: Option<String>,
    /// Lines of samples.
    pub payload: Vec<u8>,
    /// When it came.
    pub read: Instant,
    /// To be signed when the samples are safe; none where nobody waits for one.
    pub receipt: Option<Receipt>,
    /// Its place among those that wait.
    pub room: Admitted,
}
