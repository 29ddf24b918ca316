//! Whoever can make a browser ask, and who else may not.

use super::{asking, body, get, get_as, leaving, live, post, token};
use crate::watching::{Plant, text};

/// Whoever is asked confirms on the page, and it is kept before it is acknowledged.
#[test]
fn whoever_is_asked_can_answer_on_the_page() {
    let plant = Plant::new();
    let state = "--state state --save-every 1000000";
    let (mut child, address, id) = asking(&plant, state);
    let address = address.as_str();
    let token = token(&body(address, "/"));
    let fields = |kind: &str| {
        format!(
            "Host: {address}\r\nOrigin: http://{address}\r\nX-Fdiag-Token: {token}\r\nContent-Type: {kind}"
        )
    };
    let json = fields("application/json");
    let confirm = format!("{{\"id\":\"{id}\",\"answer\":\"confirm\"}}");

    assert_eq!(post(address, &fields("text/plain"), &confirm).0, 415);
    assert_eq!(post(address, &json, "{\"id\":1}").0, 400);
    assert_eq!(post(address, &json, &" ".repeat(5000)).0, 413);
    assert_eq!(post(address, &json, "{\"id\":\"x\",\"answer\":\"confirm\"}").0, 409);
    assert_eq!(get(address, "/answer").1, 404);
    assert_eq!(post(address, &json, &confirm), (200, "kept\n".to_owned()));
    child.kill().unwrap();
    child.wait().unwrap();
    let kept = std::fs::read_to_string(plant.path("state/units/plant.unit")).unwrap();
    assert!(kept.contains("\"wish\":null"), "the answer outlives a kill");

    let line = format!(
        "watch --model model.toml --spec spec.toml --healthy healthy.csv --ask --http 127.0.0.1:0 {state}"
    );
    let again = text(&plant.run(&line, &leaving(400..420)).stdout);
    assert!(again.contains("training-started"), "{again}");
}

/// Another page, by its own name, by rebinding the monitor's address to it, or from another port of this machine; and
/// whoever has not read the page.
#[test]
fn whoever_is_not_the_page_changes_nothing() {
    let plant = Plant::new();
    std::fs::write(plant.path("token"), "0123456789abcdef\n").unwrap();
    let (mut child, address, id) =
        asking(&plant, "--http-host plant.example --answer-token token --state state");
    let address = address.as_str();
    let page = token(&body(address, "/"));
    let confirm = format!("{{\"id\":\"{id}\",\"answer\":\"confirm\"}}");
    let ask = |host: &str, origin: &str, token: &str, more: &str| {
        let fields = format!(
            "Host: {host}\r\n{origin}\r\nX-Fdiag-Token: {token}\r\nContent-Type: application/json{more}"
        );
        post(address, &fields, &confirm).0
    };
    let own = format!("Origin: http://{address}");
    let rebound = ask("evil.example", "Origin: http://evil.example", &page, "");
    assert_eq!(rebound, 421, "it was 200 before");
    assert_eq!(ask(address, "Origin: http://evil.example", &page, ""), 403);
    assert_eq!(ask(address, "Origin: http://127.0.0.1:1", &page, ""), 403);
    assert_eq!(ask(address, "Origin: null", &page, ""), 403);
    assert_eq!(ask(address, "X-No: origin", &page, ""), 403);
    assert_eq!(ask(address, &own, "", ""), 403);
    assert_eq!(ask(address, &own, &page[1..], ""), 403);
    assert_eq!(ask(address, &own, &page, "\r\nSec-Fetch-Site: cross-site"), 403);
    assert_eq!(ask(address, &own, &page, &format!("\r\nHost: {address}")), 400, "two hosts");
    let kept = std::fs::read_to_string(plant.path("state/units/plant.unit")).unwrap_or_default();
    assert!(!kept.contains("\"wish\":null") || kept.is_empty(), "{kept}");

    // A script that knows the stated token, and a page behind a proxy that speaks TLS.
    assert_eq!(ask(address, &own, "0123456789abcdef", ""), 200);
    let behind = ask("plant.example", "Origin: https://plant.example", &page, "");
    assert_eq!(behind, 409, "let in; the question is answered already");
    child.kill().unwrap();
    child.wait().unwrap();
}

/// Nothing is shown under a name that is not the monitor's.
#[test]
fn whoever_asks_for_somebody_else_sees_nothing() {
    let plant = Plant::new();
    let (mut child, address) = live(&plant, "--http-host plant.example");
    for path in ["/", "/live", "/metrics", "/healthz", "/nothing"] {
        assert_eq!(get_as(&address, "evil.example", path).1, 421, "{path}");
    }
    for host in ["localhost", "localhost:9", "127.0.0.1", "[::1]:80", "plant.example:443"] {
        assert_eq!(get_as(&address, host, "/healthz").1, 200, "{host}");
    }
    child.kill().unwrap();
    child.wait().unwrap();
}

/// What a token may be, and where names are expected.
#[test]
fn wrong_names_and_tokens_are_refused() {
    let plant = Plant::new();
    let line = "watch --model model.toml --healthy healthy.csv --http 127.0.0.1:0 --ask";
    let refuses = |more: &str, why: &str| {
        let output = plant.run(&format!("{line} {more}"), "");
        assert_eq!(output.status.code(), Some(3), "{more}");
        assert!(text(&output.stderr).contains(why), "{output:?}");
    };
    refuses("--http-host http://plant.example/", "expected NAME[:PORT]");
    std::fs::write(plant.path("short"), "secret").unwrap();
    std::fs::write(plant.path("two"), "0123456789abcdef\n0123456789abcdef\n").unwrap();
    refuses("--answer-token short", "16 to 200");
    refuses("--answer-token two", "one line");
    refuses("--answer-token /dev/zero", "limit");
    refuses("--answer-token none", "none");
}
