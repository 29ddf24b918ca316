//! A broker that is none, or a bad one: bytes of the test's own on a socket.

use std::{
    collections::{BTreeMap, VecDeque},
    io::{Read, Write},
    net::{Shutdown, TcpListener, TcpStream},
    sync::{Arc, Mutex},
    time::Duration,
};

/// Messages that are on their way at once.
const IN_FLIGHT: usize = 20;

/// What is done to a client that connects, in place of what should be.
#[derive(Clone)]
pub struct Misdeed {
    /// What it is sent.
    pub bytes: Vec<u8>,
    /// Whether the connection is cut then; otherwise it is for the client to end it.
    pub is_cut: bool,
}

/// Messages that a client has not confirmed, and those that it has sent.
#[derive(Default)]
pub struct Post {
    /// By topic, in order.
    pub waiting: VecDeque<(String, String)>,
    /// What was heard, by topic.
    pub heard: BTreeMap<String, Vec<String>>,
    /// Clients that did not end a connection that they should have.
    pub patient: usize,
    /// Connections to each kind of client.
    pub connections: BTreeMap<&'static str, usize>,
}

pub struct Imposter {
    pub port: u16,
    pub post: Arc<Mutex<Post>>,
}

pub fn connack(session: u8) -> Vec<u8> {
    vec![0x20, 2, session, 0]
}

pub fn packet(first: u8, parts: &[&[u8]]) -> Vec<u8> {
    let body = parts.concat();
    let mut bytes = vec![first];
    let mut rest = body.len();
    loop {
        let low = u8::try_from(rest % 128).unwrap();
        rest /= 128;
        bytes.push(if 0 < rest { low | 128 } else { low });
        if rest == 0 {
            break;
        }
    }
    [bytes, body].concat()
}

fn prefixed(text: &str) -> Vec<u8> {
    [&u16::try_from(text.len()).unwrap().to_be_bytes()[..], text.as_bytes()].concat()
}

/// A message at quality of service 1.
pub fn publish(number: u16, topic: &str, text: &str) -> Vec<u8> {
    packet(0x32, &[&prefixed(topic), &number.to_be_bytes(), text.as_bytes()])
}

/// A message at quality of service 0.
pub fn shout(topic: &str, text: &[u8]) -> Vec<u8> {
    packet(0x30, &[&prefixed(topic), text])
}

/// Two bytes as a number.
fn number(bytes: &[u8]) -> u16 {
    u16::from_be_bytes([bytes[0], bytes[1]])
}

/// A packet of a client: its first byte, and what is behind its length.
fn read(stream: &mut TcpStream) -> Option<(u8, Vec<u8>)> {
    let mut byte = [0];
    stream.read_exact(&mut byte).ok()?;
    let (first, mut length, mut shift) = (byte[0], 0_usize, 0);
    loop {
        stream.read_exact(&mut byte).ok()?;
        length |= usize::from(byte[0] & 127) << shift;
        shift += 7;
        if byte[0] < 128 {
            break;
        }
    }
    let mut body = vec![0; length];
    stream.read_exact(&mut body).ok()?;
    Some((first, body))
}

impl Imposter {
    /// To the connections of its samples and of its alarms a client gets these misdeeds, one each; after them all is
    /// well, but for so many cuts in the midst of a message.
    pub fn new(
        of_samples: Vec<Misdeed>,
        of_alarms: Vec<Misdeed>,
        waiting: VecDeque<(String, String)>,
        mut cuts: usize,
    ) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let port = listener.local_addr().unwrap().port();
        let post = Arc::new(Mutex::new(Post { waiting, ..Post::default() }));
        let shared = Arc::clone(&post);
        std::thread::spawn(move || {
            let (mut of_samples, mut of_alarms) = (of_samples.into_iter(), of_alarms.into_iter());
            for stream in listener.incoming() {
                let mut stream = stream.unwrap();
                stream.set_read_timeout(Some(Duration::from_secs(30))).unwrap();
                let Some((0x10, connect)) = read(&mut stream) else { continue };
                let is_alarms = String::from_utf8_lossy(&connect).contains("-out");
                let kind = if is_alarms { "alarms" } else { "samples" };
                *shared.lock().unwrap().connections.entry(kind).or_default() += 1;
                let misdeed = if is_alarms { of_alarms.next() } else { of_samples.next() };
                let is_cut = misdeed.is_none() && !is_alarms && 0 < cuts;
                cuts -= usize::from(is_cut);
                let post = Arc::clone(&shared);
                std::thread::spawn(move || match misdeed {
                    Some(misdeed) => wrong(stream, &misdeed, &post),
                    None if is_alarms => hear(stream, &post),
                    None => deliver(stream, &post, is_cut),
                });
            }
        });
        Self { port, post }
    }
}

fn wrong(mut stream: TcpStream, misdeed: &Misdeed, post: &Mutex<Post>) {
    // Whoever has gone already need not hear it.
    let _ = stream.write_all(&misdeed.bytes);
    if misdeed.is_cut {
        let _ = stream.shutdown(Shutdown::Both);
        return;
    }
    let mut rest = Vec::new();
    stream.set_read_timeout(Some(Duration::from_secs(10))).unwrap();
    if let Err(error) = stream.read_to_end(&mut rest)
        && error.kind() == std::io::ErrorKind::WouldBlock
    {
        post.lock().unwrap().patient += 1;
    }
}

/// Takes what is told, and confirms it.
fn hear(mut stream: TcpStream, post: &Mutex<Post>) {
    let _ = stream.write_all(&connack(0));
    while let Some((first, body)) = read(&mut stream) {
        if first & 0xf0 == 0x30 {
            let (length, rest) = body.split_at(2);
            let (topic, rest) = rest.split_at(usize::from(number(length)));
            let [topic, text] = [topic, &rest[2..]].map(|b| String::from_utf8(b.to_vec()).unwrap());
            post.lock().unwrap().heard.entry(topic).or_default().push(text);
            let _ = stream.write_all(&packet(0x40, &[&rest[..2]]));
        } else if first == 0xc0 {
            let _ = stream.write_all(&[0xd0, 0]);
        }
    }
}

/// Sends what waits, again whatever was not confirmed; cuts the line after a hundred messages if it is to.
fn deliver(mut stream: TcpStream, post: &Mutex<Post>, is_cut: bool) {
    let _ = stream.write_all(&connack(1));
    let (mut sent, mut confirmed) = (0_usize, 0_usize);
    loop {
        // What is confirmed is no longer there, so the first that waits is number `confirmed`.
        while sent - confirmed < IN_FLIGHT {
            let Some((topic, text)) = post.lock().unwrap().waiting.get(sent - confirmed).cloned()
            else {
                break;
            };
            let message = publish(u16::try_from(sent % 60_000 + 1).unwrap(), &topic, &text);
            if is_cut && sent == 100 {
                let _ = stream.write_all(&message[..message.len() / 2]);
                let _ = stream.shutdown(Shutdown::Both);
                return;
            }
            if stream.write_all(&message).is_err() {
                return;
            }
            sent += 1;
        }
        let Some((first, body)) = read(&mut stream) else { return };
        match first {
            0x40 => {
                // Receipts come in the order of the messages.
                assert_eq!(usize::from(number(&body)), confirmed % 60_000 + 1);
                confirmed += 1;
                post.lock().unwrap().waiting.pop_front();
            }
            0x82 => drop(stream.write_all(&packet(0x90, &[&body[..2], &[1]]))),
            0xc0 => drop(stream.write_all(&[0xd0, 0])),
            _ => return,
        }
    }
}
