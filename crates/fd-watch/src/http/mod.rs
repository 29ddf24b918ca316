//! The board over HTTP: `/metrics`, `/healthz`, and one live page.

mod answers;

use std::{
    io::{self, Write},
    net::{SocketAddr, ToSocketAddrs},
    sync::{
        Arc,
        atomic::{AtomicUsize, Ordering},
    },
    time::Duration,
};

use tiny_http::{Header, Method, Request, Response, Server};

use crate::board::Board;

/// Most pages that are kept live at once.
const VIEWERS: usize = 5;
/// A page that has nothing new is told so after this long, so that a viewer who has left is noticed.
const SILENCE: Duration = Duration::from_secs(10);
/// The live page.
const PAGE: &str = include_str!("page.html");
/// Nothing is loaded from anywhere, and nobody may frame the page.
const POLICY: &str = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; \
                      connect-src 'self'; img-src data:; frame-ancestors 'none'";

/// Starts to serve a board, and returns the address where it is found. It ends with the process.
///
/// ```
/// use std::sync::Arc;
///
/// let board = Arc::new(fd_watch::Board::default());
/// let address = fd_watch::serve("127.0.0.1:0", board)?;
/// assert_ne!(address.port(), 0);
/// # Ok::<(), std::io::Error>(())
/// ```
///
/// # Errors
///
/// Returns an error when the address is not understood or taken.
pub fn serve(address: impl ToSocketAddrs, board: Arc<Board>) -> io::Result<SocketAddr> {
    let server = Server::http(address).map_err(io::Error::other)?;
    let found = server.server_addr().to_ip();
    let found = found.ok_or_else(|| io::Error::other("not an address of the internet protocol"))?;
    let (viewers, answers) = (Arc::new(AtomicUsize::new(0)), Arc::new(AtomicUsize::new(0)));
    std::thread::spawn(move || {
        for request in server.incoming_requests() {
            if *request.method() == Method::Post && request.url() == "/answer" {
                // Whoever has left does not want to know.
                let _ = answers::take(request, &board, &answers);
            } else {
                answer(request, &board, &viewers);
            }
        }
    });
    Ok(found)
}

fn answer(request: Request, board: &Arc<Board>, viewers: &Arc<AtomicUsize>) {
    let path = request.url().split('?').next().unwrap_or_default().to_owned();
    let is_get = matches!(request.method(), Method::Get | Method::Head);
    // A viewer who has left is not worth a word.
    let _ = match path.as_str() {
        _ if !is_get => {
            request.respond(text(405, "text/plain", "only GET is answered, and POST at /answer\n"))
        }
        "/" => request.respond(text(200, "text/html; charset=utf-8", PAGE)),
        "/metrics" => request.respond(text(200, "text/plain; version=0.0.4", &board.metrics())),
        "/healthz" => {
            let (is_well, json) = board.health();
            request.respond(text(if is_well { 200 } else { 503 }, "application/json", &json))
        }
        "/live" if viewers.fetch_add(1, Ordering::Relaxed) < VIEWERS => {
            let (board, viewers) = (Arc::clone(board), Arc::clone(viewers));
            std::thread::spawn(move || {
                let _ = show(request, &board);
                viewers.fetch_sub(1, Ordering::Relaxed);
            });
            Ok(())
        }
        "/live" => {
            viewers.fetch_sub(1, Ordering::Relaxed);
            request.respond(text(503, "text/plain", "too many pages are open\n"))
        }
        _ => request.respond(text(404, "text/plain", "there are /, /metrics and /healthz\n")),
    };
}

fn text(status: u16, kind: &str, body: &str) -> Response<io::Cursor<Vec<u8>>> {
    let fields = [
        ("Content-Type", kind),
        ("Content-Security-Policy", POLICY),
        ("Cache-Control", "no-store"),
    ];
    let mut response = Response::from_string(body).with_status_code(status);
    for (field, value) in fields {
        if let Ok(header) = Header::from_bytes(field, value) {
            response.add_header(header);
        }
    }
    response
}

/// Server-sent events until the viewer leaves. Written by hand: a body of `tiny_http` waits for 8 kB.
fn show(request: Request, board: &Board) -> io::Result<()> {
    let mut out = request.into_writer();
    let head = "HTTP/1.1 200 OK\r\nContent-Type: text/event-stream\r\nCache-Control: no-store\r\n\
                Connection: close\r\n\r\n";
    let (all, mut place) = board.page();
    write!(out, "{head}event: all\ndata: {all}\n\n")?;
    loop {
        out.flush()?;
        let new = board.wait(&mut place, SILENCE);
        if new.is_empty() {
            write!(out, ": still here\n\n")?;
        }
        for (kind, json) in new {
            write!(out, "event: {kind}\ndata: {json}\n\n")?;
        }
    }
}
