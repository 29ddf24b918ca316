//! What stands between the browser and a live page: it takes away that nobody may frame the page, and it has a picture
//! that comes late, so that the browser waits until everything has been drawn.

use std::{
    io::{BufRead, BufReader, Read, Write},
    net::{TcpListener, TcpStream},
    path::Path,
    time::Duration,
};

/// Serves on a port of its own, and returns that; `live` is the address of a monitor, if there is one.
pub(crate) fn serve(live: Option<String>, desk: &Path, late: Duration) -> u16 {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = listener.local_addr().unwrap().port();
    let desk = desk.to_owned();
    std::thread::spawn(move || {
        for browser in listener.incoming() {
            let (browser, live, desk) = (browser.unwrap(), live.clone(), desk.clone());
            // A browser that goes away in the midst of it is done.
            std::thread::spawn(move || answer(browser, live.as_deref(), &desk, late));
        }
    });
    port
}

fn answer(
    mut browser: TcpStream,
    live: Option<&str>,
    desk: &Path,
    late: Duration,
) -> std::io::Result<()> {
    let head = head(&mut BufReader::new(browser.try_clone()?))?;
    let request = head.first().map_or("", String::as_str);
    let path = request.split(' ').nth(1).unwrap_or("/");
    match live {
        // Of the same origin as the page, or it could not look into it.
        Some(_) if path == "/desk.html" => {
            let text = std::fs::read_to_string(desk)?;
            let kind = "Content-Type: text/html\r\nConnection: close";
            write!(browser, "HTTP/1.1 200 OK\r\n{kind}\r\n\r\n{text}")?;
        }
        Some(live) if path != "/late" => {
            let mut monitor = TcpStream::connect(live)?;
            write!(monitor, "GET {path} HTTP/1.1\r\nHost: {live}\r\nConnection: close\r\n\r\n")?;
            let mut from = BufReader::new(monitor);
            for line in self::head(&mut from)? {
                if !line.to_lowercase().starts_with("content-security-policy") {
                    write!(browser, "{line}\r\n")?;
                }
            }
            write!(browser, "\r\n")?;
            // As it comes: a live page has no end.
            let mut piece = [0; 4096];
            while let read @ 1.. = from.read(&mut piece)? {
                browser.write_all(&piece[..read])?;
            }
        }
        _ => {
            std::thread::sleep(late);
            write!(browser, "HTTP/1.1 204 No Content\r\nConnection: close\r\n\r\n")?;
        }
    }
    Ok(())
}

/// The lines of a head.
fn head(from: &mut impl BufRead) -> std::io::Result<Vec<String>> {
    let mut lines = Vec::new();
    loop {
        let mut line = String::new();
        from.read_line(&mut line)?;
        let line = line.trim_end();
        if line.is_empty() {
            return Ok(lines);
        }
        lines.push(line.to_owned());
    }
}
