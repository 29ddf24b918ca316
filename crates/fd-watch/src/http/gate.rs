//! Who is let in: names of this server, origins of its own page, tokens.
//!
//! A page of somebody else can make a browser send requests here, and by DNS rebinding even read the answers, since the
//! browser takes both servers for one. What it cannot do is name this server in `Host`, or its page in `Origin`.

use std::{io, net::IpAddr};

use super::{head::Head, refusal::Refusal};

/// Who may look at a board, and who may answer its questions.
///
/// Without more, only requests to a loopback name are served, and only the page itself can answer.
///
/// ```
/// let access = fd_watch::Access { hosts: vec!["plant.example".into()], ..Default::default() };
/// assert!(access.token.is_none());
/// ```
#[derive(Clone, Debug, Default)]
pub struct Access {
    /// Further names (`plant.example`, `192.0.2.7:8080`) by which the page is reached, for instance through a proxy. A
    /// name without a port stands for all ports.
    pub hosts: Vec<String>,
    /// What answers that do not come from the page have to carry; without it only the page can answer.
    pub token: Option<String>,
}

/// [`Access`] with a token that the page carries.
pub(super) struct Gate {
    hosts: Vec<Host>,
    page: String,
    stated: Option<String>,
}

/// A name or an address, and a port.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Host {
    name: String,
    port: Option<u16>,
}

impl Host {
    /// `name`, `name:port`, `[address]:port`; in small letters.
    fn parse(text: &str) -> Option<Self> {
        let (name, port) = match text.rsplit_once(':') {
            Some((name, port)) if !text.ends_with(']') => {
                let is_number = !port.is_empty() && port.bytes().all(|b| b.is_ascii_digit());
                (name, Some(is_number.then(|| port.parse().ok())??))
            }
            _ => (text, None),
        };
        let bare = name.strip_prefix('[').and_then(|name| name.strip_suffix(']'));
        let is_name = |b: u8| b.is_ascii_alphanumeric() || b"-._".contains(&b);
        let is_sound = match bare {
            Some(bare) => bare.parse::<IpAddr>().is_ok_and(|address| address.is_ipv6()),
            None => !name.is_empty() && name.bytes().all(is_name),
        };
        is_sound.then(|| Self { name: bare.unwrap_or(name).to_ascii_lowercase(), port })
    }

    fn is_loopback(&self) -> bool {
        let address = self.name.parse::<IpAddr>();
        self.name == "localhost" || address.is_ok_and(|address| address.is_loopback())
    }

    /// Whether this stands for another one: a name without a port for all ports.
    fn covers(&self, other: &Self) -> bool {
        self.name == other.name && (self.port.is_none() || self.port == other.port)
    }
}

impl Gate {
    /// A gate of a server at this address.
    pub(super) fn new(access: &Access, address: &str) -> io::Result<Self> {
        let wrong = |text: &str| {
            io::Error::new(io::ErrorKind::InvalidInput, format!("`{text}`: expected NAME[:PORT]"))
        };
        let stated = |text: &String| Host::parse(text).ok_or_else(|| wrong(text));
        let mut hosts = access.hosts.iter().map(stated).collect::<io::Result<Vec<_>>>()?;
        // Where it listens is stated as well, unless that is everywhere.
        let own = Host::parse(address).map(|host| Host { port: None, ..host });
        let is_one = |host: &Host| {
            host.name.parse::<IpAddr>().map_or(true, |address| !address.is_unspecified())
        };
        hosts.extend(own.filter(is_one));
        let mut bytes = [0; 16];
        getrandom::fill(&mut bytes).map_err(io::Error::other)?;
        let page = format!("{:032x}", u128::from_be_bytes(bytes));
        Ok(Self { hosts, page, stated: access.token.clone() })
    }

    /// The token that the page carries.
    pub(super) fn page_token(&self) -> &str {
        &self.page
    }

    /// Whether a request is for this server.
    pub(super) fn names_us(&self, head: &Head) -> Result<(), Refusal> {
        let host = head.field("Host")?.unwrap_or_default();
        let is_ours = |found: &Host| {
            found.is_loopback() || self.hosts.iter().any(|stated| stated.covers(found))
        };
        if Host::parse(host).is_some_and(|found| is_ours(&found)) {
            return Ok(());
        }
        let shown: String = host.chars().take(100).collect();
        let why = format!("nothing is served under the name `{shown}`; --http-host states names");
        Err(Refusal(421, why))
    }

    /// Whether it is the page itself that asks, as far as the browser says who does. Other programs may say nothing.
    pub(super) fn is_own_page(head: &Head) -> Result<(), Refusal> {
        let site = head.field("Sec-Fetch-Site")?;
        let origin = head.field("Origin")?;
        let is_same = site.is_none_or(|site| site == "same-origin" || site == "none");
        if is_same && origin.is_none_or(|origin| is_origin(origin, head)) {
            return Ok(());
        }
        Err(Refusal(403, "another page has asked for this".to_owned()))
    }

    /// Whether a request may change something.
    pub(super) fn may_answer(&self, head: &Head) -> Result<(), Refusal> {
        Self::is_own_page(head)?;
        if head.field("Origin")?.is_none() {
            let why = "expected Origin, the address of the page, such as http://127.0.0.1:8080";
            return Err(Refusal(403, why.to_owned()));
        }
        let given = head.field("X-Fdiag-Token")?.unwrap_or_default();
        let tokens = [Some(&self.page), self.stated.as_ref()];
        // Both are compared, whichever fits.
        let fits = tokens.map(|token| token.is_some_and(|token| is_same(token, given)));
        if fits.contains(&true) {
            return Ok(());
        }
        let why = "expected X-Fdiag-Token, as the page carries it or --answer-token states it; \
                   a page that was open before the monitor started has to be loaded again";
        Err(Refusal(403, why.to_owned()))
    }
}

/// Whether an origin is that of the page of this very request: the scheme is a proxy's affair.
fn is_origin(origin: &str, head: &Head) -> bool {
    let Ok(Some(host)) = head.field("Host") else { return false };
    let schemes = [("http://", 80), ("https://", 443)];
    schemes.iter().any(|(scheme, port)| {
        let with_port = |text| {
            let host = Host::parse(text)?;
            Some(Host { port: host.port.or(Some(*port)), ..host })
        };
        let origin = origin.strip_prefix(scheme).and_then(with_port);
        origin.is_some() && origin == with_port(host)
    })
}

/// Compares in a time that does not depend on where two tokens differ.
fn is_same(token: &str, given: &str) -> bool {
    let differing = token.bytes().zip(given.bytes()).fold(0, |sum, (a, b)| sum | (a ^ b));
    token.len() == given.len() && differing == 0
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a failure here is a failed test")]
mod tests {
    use super::*;

    fn gate(address: &str, hosts: &[&str]) -> Gate {
        let hosts = hosts.iter().map(|host| (*host).to_owned()).collect();
        Gate::new(&Access { hosts, token: Some("secret".to_owned()) }, address).unwrap()
    }

    fn head(fields: &str) -> Head {
        Head::parse(format!("POST /answer HTTP/1.1\r\n{fields}").as_bytes()).unwrap()
    }

    #[test]
    fn loopback_and_what_was_stated_is_us() {
        let gate = gate("192.0.2.7:8080", &["plant.example", "other.example:8443"]);
        let ours = [
            "localhost",
            "LocalHost:9000",
            "127.0.0.1:8080",
            "127.3.2.1",
            "[::1]:8080",
            "192.0.2.7:8080",
            "plant.example:77",
            "Plant.Example",
            "other.example:8443",
        ];
        for host in ours {
            assert!(gate.names_us(&head(&format!("Host: {host}"))).is_ok(), "{host}");
        }
        let others = [
            "",
            "evil.example",
            "evil.example:8080",
            "localhost.evil.example",
            "127.0.0.1.evil.example",
            "plant.example.",
            "other.example",
            "other.example:443",
            "192.0.2.8",
            "0.0.0.0",
            "[::]",
            "[::1",
            "::1",
            "localhost:",
            "localhost:x",
            "localhost:+80",
            "localhost:99999",
            "localhost@evil.example",
            "localhost, evil.example",
            "evil.example#localhost",
            "127.1",
            "2130706433",
        ];
        for host in others {
            let refused = gate.names_us(&head(&format!("Host: {host}")));
            assert_eq!(refused.unwrap_err().0, 421, "{host}");
        }
        assert_eq!(gate.names_us(&head("A: b")).unwrap_err().0, 421);
        assert!(Gate::new(&Access { hosts: vec!["a/b".into()], token: None }, "[::]:1").is_err());
    }

    #[test]
    fn who_listens_everywhere_has_stated_nothing() {
        for address in ["0.0.0.0:8080", "[::]:8080"] {
            let gate = gate(address, &[]);
            assert!(gate.names_us(&head("Host: 0.0.0.0:8080")).is_err());
            assert!(gate.names_us(&head("Host: localhost:8080")).is_ok());
        }
    }

    #[test]
    fn only_the_page_itself_changes_anything() {
        let gate = gate("127.0.0.1:8080", &["plant.example"]);
        let token = gate.page_token().to_owned();
        let may = |host: &str, origin: &str, token: &str| {
            let fields = format!("Host: {host}\r\nOrigin: {origin}\r\nX-Fdiag-Token: {token}");
            gate.may_answer(&head(&fields)).is_ok()
        };
        assert!(may("127.0.0.1:8080", "http://127.0.0.1:8080", &token));
        assert!(may("127.0.0.1:8080", "http://127.0.0.1:8080", "secret"));
        assert!(may("plant.example", "https://plant.example", &token));
        assert!(may("plant.example:443", "https://plant.example", &token));
        assert!(may("plant.example", "http://plant.example:80", &token));
        let others = [
            "null",
            "",
            "http://evil.example",
            "http://127.0.0.1:3000",
            "http://localhost:8080",
            "http://127.0.0.1",
            "https://127.0.0.1",
            "127.0.0.1:8080",
            "ftp://127.0.0.1:8080",
            "http://127.0.0.1:8080/",
            "http://127.0.0.1:8080.evil.example",
        ];
        for origin in others {
            assert!(!may("127.0.0.1:8080", origin, &token), "{origin}");
        }
        for wrong in ["", "secre", "secret2", &token[1..], &token.to_uppercase().replace('0', "O")]
        {
            assert!(!may("127.0.0.1:8080", "http://127.0.0.1:8080", wrong), "{wrong}");
        }
        let silent = format!("Host: localhost\r\nX-Fdiag-Token: {token}");
        assert!(gate.may_answer(&head(&silent)).is_err(), "whoever does not say where from");
        let other = "Host: localhost:8080\r\nSec-Fetch-Site: same-site";
        assert!(Gate::is_own_page(&head(other)).is_err());
        assert!(Gate::is_own_page(&head("Host: localhost")).is_ok());
    }
}
