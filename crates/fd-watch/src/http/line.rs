//! One connection: a request that comes in time, an answer that is taken in time.

use std::{
    io::{self, Read, Write},
    net::{Shutdown, TcpStream},
    time::{Duration, Instant},
};

use super::{
    head::{self, Head},
    refusal::Refusal,
};

/// Longest time in which a request has to be here, however slowly it comes, and its answer has to be taken.
pub(super) const PATIENCE: Duration = Duration::from_secs(10);
/// Longest time and most bytes that a client which is still sending is listened to, so that it can read why it was refused.
const FAREWELL: (Duration, usize) = (Duration::from_secs(1), 1 << 16);
/// Nothing is loaded from anywhere, and nobody may frame the page.
const POLICY: &str = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; \
                      connect-src 'self'; img-src data:; frame-ancestors 'none'";

/// A connection with one request.
pub(super) struct Line {
    stream: TcpStream,
    until: Instant,
    /// What came after the head.
    rest: Vec<u8>,
    is_head_only: bool,
}

impl Line {
    pub(super) fn new(stream: TcpStream) -> io::Result<Self> {
        stream.set_write_timeout(Some(PATIENCE))?;
        Ok(Self { stream, until: Instant::now() + PATIENCE, rest: Vec::new(), is_head_only: false })
    }

    /// The next bytes, in time.
    fn read(&mut self, into: &mut [u8]) -> Result<usize, Refusal> {
        let late = || Refusal(408, format!("no request within {PATIENCE:?}"));
        let left = self.until.saturating_duration_since(Instant::now());
        if left.is_zero() || self.stream.set_read_timeout(Some(left)).is_err() {
            return Err(late());
        }
        match self.stream.read(into) {
            Ok(0) => Err(Refusal(400, "the request ends too early".to_owned())),
            Ok(read) => Ok(read),
            Err(error) if error.kind() == io::ErrorKind::Interrupted => Ok(0),
            Err(_) => Err(late()),
        }
    }

    /// The head of the request.
    pub(super) fn head(&mut self) -> Result<Head, Refusal> {
        let mut bytes = Vec::new();
        let mut piece = [0; 1024];
        loop {
            let searched = bytes.len().saturating_sub(3);
            let read = self.read(&mut piece)?;
            bytes.extend_from_slice(&piece[..read]);
            let end = bytes[searched..].windows(4).position(|four| four == b"\r\n\r\n");
            let end = end.map(|at| searched + at);
            if head::LONGEST < end.unwrap_or(bytes.len()) {
                return Err(Refusal(431, format!("a head has at most {} bytes", head::LONGEST)));
            }
            let Some(end) = end else { continue };
            self.rest = bytes.split_off(end + 4);
            bytes.truncate(end);
            let head = Head::parse(&bytes)?;
            self.is_head_only = head.method == "HEAD";
            return Ok(head);
        }
    }

    /// The body of so many bytes.
    pub(super) fn body(&mut self, length: usize) -> Result<Vec<u8>, Refusal> {
        let mut body = std::mem::take(&mut self.rest);
        let mut piece = [0; 1024];
        while body.len() < length {
            let read = self.read(&mut piece)?;
            body.extend_from_slice(&piece[..read]);
        }
        body.truncate(length);
        Ok(body)
    }

    /// Answers, and ends the connection.
    pub(super) fn answer(mut self, status: u16, kind: &str, body: &str) -> io::Result<()> {
        let head = format!(
            "HTTP/1.1 {status} {}\r\nContent-Type: {kind}\r\nContent-Length: {}\r\n\
             Content-Security-Policy: {POLICY}\r\nX-Content-Type-Options: nosniff\r\n\
             Referrer-Policy: no-referrer\r\nCache-Control: no-store\r\nConnection: close\r\n\r\n",
            reason(status),
            body.len()
        );
        let body = if self.is_head_only { "" } else { body };
        self.stream.write_all((head + body).as_bytes())?;
        self.stream.shutdown(Shutdown::Write)?;
        // A connection that is closed while bytes are unread takes the answer with it.
        let end = Instant::now() + FAREWELL.0;
        let mut piece = [0; 1024];
        let mut heard = 0;
        while heard < FAREWELL.1 {
            let left = end.saturating_duration_since(Instant::now());
            if left.is_zero() {
                break;
            }
            self.stream.set_read_timeout(Some(left))?;
            match self.stream.read(&mut piece)? {
                0 => break,
                read => heard += read,
            }
        }
        Ok(())
    }

    /// Answers with a status and why.
    pub(super) fn refuse(self, Refusal(status, why): &Refusal) -> io::Result<()> {
        self.answer(*status, "text/plain; charset=utf-8", &format!("{why}\n"))
    }

    /// Begins an answer that has no end, and hands out where to write it.
    pub(super) fn begin(mut self, kind: &str) -> io::Result<TcpStream> {
        let head = format!(
            "HTTP/1.1 200 OK\r\nContent-Type: {kind}\r\nX-Content-Type-Options: nosniff\r\n\
             Cache-Control: no-store\r\nX-Accel-Buffering: no\r\nConnection: close\r\n\r\n"
        );
        self.stream.write_all(head.as_bytes())?;
        Ok(self.stream)
    }
}

fn reason(status: u16) -> &'static str {
    match status {
        200 => "OK",
        403 => "Forbidden",
        404 => "Not Found",
        405 => "Method Not Allowed",
        408 => "Request Timeout",
        409 => "Conflict",
        411 => "Length Required",
        413 => "Content Too Large",
        415 => "Unsupported Media Type",
        421 => "Misdirected Request",
        431 => "Request Header Fields Too Large",
        503 => "Service Unavailable",
        _ => "Bad Request",
    }
}
