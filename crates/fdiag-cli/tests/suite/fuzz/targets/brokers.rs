//! Bytes that a broker sends: packets as the client of the monitor reads them, and the session that goes on with them.

use std::ops::ControlFlow::{Break, Continue};

use rumqttc::{
    ConnAck, ConnectReturnCode, Event, Incoming, MqttState, Packet, PubAck, Publish, QoS, Request,
    SubAck, Subscribe, SubscribeReasonCode, mqttbytes::Error,
};

use super::Target;

/// As the monitor has it.
const LARGEST: usize = 268_435_455;

fn bytes(packets: &[Packet]) -> Vec<u8> {
    let mut all = Vec::new();
    for packet in packets {
        let mut some = std::iter::empty::<u8>().collect();
        packet.write(&mut some, LARGEST).unwrap();
        all.extend_from_slice(&some);
    }
    all
}

fn sample(number: u16, qos: QoS) -> Packet {
    let mut message = Publish::new("plant/a", qos, "{\"time\":1,\"u\":0.1,\"T\":0.2}\n");
    message.pkid = number;
    Packet::Publish(message)
}

/// A session that has subscribed, and told two alarms.
fn session() -> MqttState {
    let mut state = MqttState::new(100, true);
    let wanted = Subscribe::new("plant/+", QoS::AtLeastOnce);
    state.handle_outgoing_packet(Request::Subscribe(wanted)).unwrap();
    for text in ["first", "second"] {
        let alarm = Publish::new("fdiag/a/alarm", QoS::AtLeastOnce, text);
        state.handle_outgoing_packet(Request::Publish(alarm)).unwrap();
    }
    state
}

/// What becomes of a packet: whether the connection lasts, in words.
fn taken(packet: Incoming, state: &mut MqttState) -> std::ops::ControlFlow<String> {
    if let Packet::Publish(message) = &packet {
        // As a receipt does, when the samples are safe.
        let receipt = match message.qos {
            QoS::AtMostOnce => None,
            QoS::AtLeastOnce => Some(Request::PubAck(PubAck::new(message.pkid))),
            QoS::ExactlyOnce => Some(Request::PubRec(rumqttc::PubRec::new(message.pkid))),
        };
        if let Some(receipt) = receipt {
            state.handle_outgoing_packet(receipt).unwrap();
        }
    }
    match state.handle_incoming_packet(packet) {
        Ok(answer) => {
            let mut some = std::iter::empty::<u8>().collect();
            if let Some(packet) = answer {
                packet.write(&mut some, LARGEST).unwrap();
            }
            Continue(())
        }
        Err(error) => Break(error.to_string()),
    }
}

pub fn packets_of_brokers() -> Target {
    let begun = Packet::ConnAck(ConnAck::new(ConnectReturnCode::Success, true));
    let codes = vec![SubscribeReasonCode::Success(QoS::AtLeastOnce), SubscribeReasonCode::Failure];
    let own = [
        vec![Packet::SubAck(SubAck::new(1, codes)), sample(7, QoS::AtLeastOnce)],
        vec![Packet::PubAck(PubAck::new(2)), Packet::PubAck(PubAck::new(3)), Packet::PingResp],
        vec![sample(1, QoS::ExactlyOnce), Packet::PubRel(rumqttc::PubRel::new(1))],
        vec![sample(0, QoS::AtMostOnce), begun, Packet::Disconnect],
    ];
    let own = own.iter().map(|packets| bytes(packets)).collect();
    Target::new("packets", own, |input| {
        let mut stream = input.iter().copied().collect();
        let (mut state, mut said) = (session(), String::new());
        loop {
            match Packet::read(&mut stream, LARGEST) {
                Ok(packet) => {
                    said.push_str(format!("{packet:?}").split('(').next().unwrap_or_default());
                    if let Break(why) = taken(packet, &mut state) {
                        return format!("{said}: {why}");
                    }
                }
                Err(Error::InsufficientBytes(_)) => break,
                Err(error) => return format!("{said}: {error}"),
            }
        }
        let events = state.events.drain(..).filter(|event| matches!(event, Event::Incoming(_)));
        format!("{said} {} {:?}", events.count(), state.clean().len())
    })
}
