//! DNS rebinding: a page of somebody else whose name begins to mean the monitor once the browser has loaded it.
//!
//! The browser takes page and monitor for one origin then, so that the page can read the monitor's answers and send it
//! JSON, with `Host` and `Origin` alike and its own. What the name server does in an attack, a switch does here: it gives
//! the attacker's page to the first connection, and hands every later one to the monitor as it is.

use std::{
    io::{BufRead, BufReader, Write},
    net::{TcpListener, TcpStream},
    process::{Command, Stdio},
    time::Duration,
};

use serde_json::Value;

use super::{between::serve, browser::chromium};
use crate::{watch_http::asking, watching::Plant};

/// Everything that such a page can try: it reads the live page and its token, listens to events, and confirms.
const ATTACK: &str = r#"
const found = { page: 0, token: null, live: "closed", answer: 0, text: "" };
const show = () => { document.getElementById("found").textContent = JSON.stringify(found); };
const live = new EventSource("/live");
live.addEventListener("all", () => { found.live = "open"; show(); });
fetch("/").then(async page => {
  found.page = page.status;
  const token = /name="token" content="([0-9a-f]+)"/.exec(await page.text());
  found.token = token ? "read" : null;
  const headers = { "Content-Type": "application/json", "X-Fdiag-Token": token ? token[1] : "" };
  const body = JSON.stringify({ id: ID, answer: "confirm" });
  const answer = await fetch("/answer", { method: "POST", headers, body });
  found.answer = answer.status;
  found.text = await answer.text();
  show();
}).catch(error => { found.text = String(error); show(); });
"#;

/// What the page of `evil.example` finds out and does.
fn attack(monitor: &str, id: &str) -> Value {
    let folder = tempfile::tempdir().unwrap();
    // The browser waits for a picture, and the page for what it wants.
    let late = serve(None, &folder.path().join("none"), Duration::from_secs(4));
    let script = ATTACK.replace("ID", &serde_json::to_string(id).unwrap());
    let page = format!(
        "<!doctype html><title>news</title><pre id=\"found\">null</pre>\
         <img hidden src=\"http://127.0.0.1:{late}/late\"><script>{script}</script>"
    );
    let switch = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = switch.local_addr().unwrap().port();
    let monitor = monitor.to_owned();
    std::thread::spawn(move || {
        let mut is_loaded = false;
        for browser in switch.incoming() {
            let (mut browser, monitor) = (browser.unwrap(), monitor.clone());
            if is_loaded {
                std::thread::spawn(move || hand_over(&browser, &monitor));
                continue;
            }
            // A browser may connect beforehand, without a word.
            let mut first = String::new();
            let mut from = BufReader::new(browser.try_clone().unwrap());
            browser.set_read_timeout(Some(Duration::from_millis(500))).unwrap();
            while from.read_line(&mut first).is_ok_and(|read| 2 < read) {}
            if first.starts_with("GET / ") {
                let head = "HTTP/1.1 200 OK\r\nContent-Type: text/html\r\nConnection: close";
                let length = page.len();
                let _ = write!(browser, "{head}\r\nContent-Length: {length}\r\n\r\n{page}");
                is_loaded = true;
            }
        }
    });
    let output = Command::new(chromium())
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--dump-dom"])
        .arg("--host-resolver-rules=MAP evil.example 127.0.0.1")
        .arg(format!("--user-data-dir={}", folder.path().join("profile").display()))
        .arg(format!("http://evil.example:{port}/"))
        .stdin(Stdio::null())
        .output()
        .unwrap();
    let dom = String::from_utf8_lossy(&output.stdout);
    let text = dom.split("<pre id=\"found\">").nth(1).and_then(|rest| rest.split("</pre>").next());
    let text = text.unwrap_or_else(|| panic!("{dom}{}", String::from_utf8_lossy(&output.stderr)));
    serde_json::from_str(&text.replace("&lt;", "<").replace("&amp;", "&")).unwrap()
}

fn hand_over(browser: &TcpStream, monitor: &str) -> std::io::Result<()> {
    let monitor = TcpStream::connect(monitor)?;
    let (mut up, mut down) = (monitor.try_clone()?, browser.try_clone()?);
    std::thread::spawn(move || std::io::copy(&mut &monitor, &mut down));
    std::io::copy(&mut &*browser, &mut up)?;
    up.shutdown(std::net::Shutdown::Write)
}

#[test]
#[ignore = "needs chromium"]
fn in_chromium_a_rebound_name_gets_nothing() {
    let plant = Plant::new();
    let (mut child, address, id) = asking(&plant, "--state state --save-every 0");
    let found = attack(&address, &id);
    println!("{found}");
    assert_eq!(found["page"], 421, "{found}");
    assert_eq!(found["token"], Value::Null, "{found}");
    assert_eq!(found["live"], "closed", "{found}");
    assert_eq!(found["answer"], 421, "{found}");
    std::thread::sleep(Duration::from_millis(500));
    let kept = std::fs::read_to_string(plant.path("state/units/plant.unit")).unwrap();
    assert!(kept.contains(&id), "the question still waits");
    child.kill().unwrap();
    child.wait().unwrap();

    // The attack is one: where somebody states the attacker's name, it reads everything and trains the unit again.
    let (mut child, address, id) = asking(&plant, "--http-host evil.example");
    let found = attack(&address, &id);
    println!("{found}");
    assert_eq!(found["token"], "read", "{found}");
    assert_eq!(found["live"], "open", "{found}");
    assert_eq!(found["text"], "kept\n", "{found}");
    child.kill().unwrap();
    child.wait().unwrap();
}
