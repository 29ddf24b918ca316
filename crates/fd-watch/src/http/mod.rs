//! The board over HTTP: `/metrics`, `/healthz`, one live page, and answers that are given on it.
//!
//! A server of its own, since it has to say no to what general ones allow: names that are not its own, heads that trickle,
//! clients that never read.

mod answers;
mod crowd;
mod gate;
mod head;
mod line;
mod refusal;

use std::{
    io::{self, Write},
    net::{SocketAddr, TcpListener, TcpStream},
    sync::Arc,
    thread::Builder,
    time::{Duration, Instant},
};

pub use self::gate::Access;
use self::{
    crowd::{Crowd, Places},
    gate::Gate,
    line::Line,
    refusal::Refusal,
};
use crate::board::Board;

/// Most pages that are kept live at once.
const VIEWERS: usize = 20;
/// A page that has nothing new is told so after this long, so that a viewer who has left is noticed.
const SILENCE: Duration = Duration::from_secs(10);
/// A live page is cut off after this long, and its browser comes again; whoever does not read does not.
const AUDIENCE: Duration = Duration::from_secs(300);
/// Answers that are dealt with at once.
const ANSWERS: usize = 5;
/// Wait after a connection that the system could not give.
const BREATH: Duration = Duration::from_millis(100);
/// The live page, and where its token goes.
const PAGE: &str = include_str!("page.html");
const TOKEN: &str = "{{token}}";

struct Server {
    gate: Gate,
    board: Arc<Board>,
    page: String,
    crowd: Crowd,
    viewers: Places,
    answers: Places,
}

/// Starts to serve a board at an address (`127.0.0.1:8080`, port 0 for any), and returns the address where it is found. It
/// ends with the process.
///
/// Served are requests that name a loopback host, the host of `address`, or one that [`Access`] states; all others get
/// status 421. What changes something also needs an `Origin` of the page and a token.
///
/// ```
/// use std::sync::Arc;
///
/// let board = Arc::new(fd_watch::Board::default());
/// let address = fd_watch::serve("127.0.0.1:0", &fd_watch::Access::default(), board)?;
/// assert_ne!(address.port(), 0);
/// # Ok::<(), std::io::Error>(())
/// ```
///
/// # Errors
///
/// Returns an error when the address is not understood or taken, when a host of `access` is no name, or when the system has
/// no random numbers.
pub fn serve(address: &str, access: &Access, board: Arc<Board>) -> io::Result<SocketAddr> {
    let gate = Gate::new(access, address)?;
    let listener = TcpListener::bind(address)?;
    let found = listener.local_addr()?;
    let page = PAGE.replace(TOKEN, gate.page_token());
    let (viewers, answers) = (Places::new(VIEWERS), Places::new(ANSWERS));
    let server = Server { gate, board, page, crowd: Crowd::default(), viewers, answers };
    let server = Arc::new(server);
    Builder::new().name("http".to_owned()).spawn(move || {
        for (number, stream) in (0..).zip(listener.incoming()) {
            let Ok(stream) = stream else {
                std::thread::sleep(BREATH);
                continue;
            };
            // Where no thread or file is to be had, the connection ends.
            if server.crowd.enter(number, &stream).is_ok() {
                let host = Arc::clone(&server);
                if Builder::new().spawn(move || host.meet(number, stream)).is_err() {
                    server.crowd.leave(number);
                }
            }
        }
    })?;
    Ok(found)
}

impl Server {
    /// Deals with a connection. A client that has left is not worth a word.
    fn meet(&self, number: u64, stream: TcpStream) {
        if let Ok(line) = Line::new(stream) {
            let _ = self.talk(number, line);
        }
        self.crowd.leave(number);
    }

    fn talk(&self, number: u64, mut line: Line) -> io::Result<()> {
        let head = line.head();
        let head = head.and_then(|head| self.gate.names_us(&head).map(|()| head));
        let head = match head {
            Ok(head) => head,
            Err(refusal) => return line.refuse(&refusal),
        };
        match (head.method.as_str(), head.path.as_str()) {
            ("POST", "/answer") => {
                let Some(_place) = self.answers.take() else {
                    return line.refuse(&Refusal(503, "too many answers at once".to_owned()));
                };
                match answers::take(&head, &mut line, &self.gate, &self.board) {
                    Ok(()) => line.answer(200, "text/plain", "kept\n"),
                    Err(refusal) => line.refuse(&refusal),
                }
            }
            ("GET", "/live") => {
                if let Err(refusal) = Gate::is_own_page(&head) {
                    return line.refuse(&refusal);
                }
                let Some(_place) = self.viewers.take() else {
                    return line.refuse(&Refusal(503, "too many pages are open".to_owned()));
                };
                self.crowd.leave(number);
                show(line, &self.board)
            }
            ("GET" | "HEAD", "/") => line.answer(200, "text/html; charset=utf-8", &self.page),
            ("GET" | "HEAD", "/metrics") => {
                line.answer(200, "text/plain; version=0.0.4", &self.board.metrics())
            }
            ("GET" | "HEAD", "/healthz") => {
                let (is_well, json) = self.board.health();
                line.answer(if is_well { 200 } else { 503 }, "application/json", &json)
            }
            ("GET" | "HEAD", _) => {
                line.refuse(&Refusal(404, "there are /, /metrics and /healthz".to_owned()))
            }
            _ => line.refuse(&Refusal(405, "only GET is answered, and POST at /answer".to_owned())),
        }
    }
}

/// Server-sent events, until the viewer leaves or does not read.
fn show(line: Line, board: &Board) -> io::Result<()> {
    let end = Instant::now() + AUDIENCE;
    let mut out = line.begin("text/event-stream")?;
    let (all, mut place) = board.page();
    write!(out, "retry: 500\nevent: all\ndata: {all}\n\n")?;
    while Instant::now() < end {
        let new = board.wait(&mut place, SILENCE);
        let mut text = Vec::new();
        if new.is_empty() {
            text.extend_from_slice(b": still here\n\n");
        }
        for (kind, json) in new {
            write!(text, "event: {kind}\ndata: {json}\n\n")?;
        }
        out.write_all(&text)?;
    }
    Ok(())
}
