//! What a client asks for: the head of a request (RFC 9112), as far as a page of a monitor needs it, and no further.

use super::refusal::Refusal;

/// Longest head in bytes, as other servers have it.
pub(super) const LONGEST: usize = 8192;

/// A request line and header fields.
#[derive(Debug)]
pub(super) struct Head {
    pub method: String,
    /// Without what follows `?`.
    pub path: String,
    fields: Vec<(String, String)>,
}

impl Head {
    /// Reads a head, without the empty line that ends it. Lines that go on in the next one, white space before the colon,
    /// and targets with a host in them are refused: proxies do not agree on what they mean.
    pub(super) fn parse(bytes: &[u8]) -> Result<Self, Refusal> {
        let text = String::from_utf8_lossy(bytes);
        let mut lines = text.split("\r\n");
        let request = lines.next().unwrap_or_default();
        let wrong = || Refusal(400, "expected `GET /path HTTP/1.1`".to_owned());
        let mut words = request.split(' ');
        let (Some(method), Some(target), Some("HTTP/1.1" | "HTTP/1.0"), None) =
            (words.next(), words.next(), words.next(), words.next())
        else {
            return Err(wrong());
        };
        let is_method = !method.is_empty() && method.bytes().all(|b| b.is_ascii_uppercase());
        if !is_method || !target.starts_with('/') || !target.bytes().all(|b| b.is_ascii_graphic()) {
            return Err(wrong());
        }
        let fields = lines.map(field).collect::<Result<Vec<_>, Refusal>>()?;
        let path = target.split('?').next().unwrap_or_default();
        Ok(Self { method: method.to_owned(), path: path.to_owned(), fields })
    }

    /// A field that may be there once.
    pub(super) fn field(&self, name: &str) -> Result<Option<&str>, Refusal> {
        let mut found = self.fields.iter().filter(|(field, _)| field.eq_ignore_ascii_case(name));
        match (found.next(), found.next()) {
            (_, Some(_)) => Err(Refusal(400, format!("more than one field `{name}`"))),
            (found, None) => Ok(found.map(|(_, value)| value.as_str())),
        }
    }

    /// Bytes of the body.
    pub(super) fn length(&self) -> Result<usize, Refusal> {
        if self.field("Transfer-Encoding")?.is_some() {
            return Err(Refusal(411, "expected Content-Length, not chunks".to_owned()));
        }
        let wrong = || Refusal(411, "expected Content-Length".to_owned());
        let length = self.field("Content-Length")?.ok_or_else(wrong)?;
        let is_number = length.bytes().all(|b| b.is_ascii_digit());
        if is_number { length.parse().map_err(|_| wrong()) } else { Err(wrong()) }
    }
}

fn field(line: &str) -> Result<(String, String), Refusal> {
    let is_token = |b: u8| b.is_ascii_alphanumeric() || b"!#$%&'*+-.^_`|~".contains(&b);
    match line.split_once(':') {
        Some((name, value))
            if !name.is_empty()
                && name.bytes().all(is_token)
                && !value.chars().any(|c| c.is_control() && c != '\t') =>
        {
            Ok((name.to_owned(), value.trim_matches([' ', '\t']).to_owned()))
        }
        _ => Err(Refusal(400, "expected fields `Name: value`".to_owned())),
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a failure here is a failed test")]
mod tests {
    use super::*;

    #[test]
    fn a_head_is_a_line_and_fields() {
        let head = Head::parse(b"GET /live?x=1 HTTP/1.1\r\nHost:\tlocalhost \r\nA: b:c").unwrap();
        assert_eq!((head.method.as_str(), head.path.as_str()), ("GET", "/live"));
        assert_eq!(head.field("host").unwrap(), Some("localhost"));
        assert_eq!(head.field("a").unwrap(), Some("b:c"));
        assert_eq!(head.field("origin").unwrap(), None);
        assert_eq!(head.length().unwrap_err().0, 411);
    }

    #[test]
    fn what_proxies_do_not_agree_on_is_refused() {
        let wrong: [&[u8]; 14] = [
            b"",
            b"GET",
            b"GET  / HTTP/1.1",
            b"GET / HTTP/1.1 ",
            b"GET / HTTP/2",
            b"get / HTTP/1.1",
            b"GET http://127.0.0.1/ HTTP/1.1",
            b"GET /\x80 HTTP/1.1",
            b"GET / HTTP/1.1\r\n Host: folded",
            b"GET / HTTP/1.1\r\nHost : a",
            b"GET / HTTP/1.1\r\nHost",
            b"GET / HTTP/1.1\r\n: a",
            b"GET / HTTP/1.1\r\nHost: a\nOrigin: b",
            b"GET / HTTP/1.1\r\nHost: a\0",
        ];
        for head in wrong {
            assert_eq!(Head::parse(head).unwrap_err().0, 400, "{}", head.escape_ascii());
        }
        let twice = Head::parse(b"GET / HTTP/1.1\r\nHost: a\r\nhost: a").unwrap();
        assert_eq!(twice.field("Host").unwrap_err().0, 400);
        for length in ["+5", "-1", "5 5", "0x5", "", "99999999999999999999999"] {
            let head = format!("POST / HTTP/1.1\r\nContent-Length: {length}");
            assert_eq!(Head::parse(head.as_bytes()).unwrap().length().unwrap_err().0, 411);
        }
    }
}
