//! The Python literals in headers of arrays: texts, whole numbers, truths, tuples, lists and dicts of them.

/// A value.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Literal {
    Text(String),
    Number(u64),
    Truth(bool),
    List(Vec<Literal>),
    Dict(Vec<(Literal, Literal)>),
}

/// Values may be nested this deep.
const DEEPEST: usize = 8;

impl Literal {
    /// Reads one value and nothing behind it.
    pub(super) fn parse(text: &str) -> Option<Self> {
        let mut rest = text;
        let value = value(&mut rest, 0)?;
        rest.trim_ascii().is_empty().then_some(value)
    }

    /// The value of a key of a dict.
    pub(super) fn get(&self, wanted: &str) -> Option<&Self> {
        let Self::Dict(entries) = self else { return None };
        let entry = entries.iter().find(|(key, _)| key.text() == Some(wanted));
        entry.map(|(_, value)| value)
    }

    pub(super) fn text(&self) -> Option<&str> {
        if let Self::Text(text) = self { Some(text) } else { None }
    }

    pub(super) fn list(&self) -> Option<&[Self]> {
        if let Self::List(values) = self { Some(values) } else { None }
    }

    /// Whole numbers of a list.
    pub(super) fn numbers(&self) -> Option<Vec<u64>> {
        let number = |value: &Self| if let Self::Number(n) = value { Some(*n) } else { None };
        self.list()?.iter().map(number).collect()
    }
}

fn value(rest: &mut &str, depth: usize) -> Option<Literal> {
    *rest = rest.trim_ascii_start();
    let first = rest.chars().next().filter(|_| depth < DEEPEST)?;
    match first {
        '\'' | '"' => {
            let (text, after) = rest.get(1..)?.split_once(first)?;
            *rest = after;
            // Nothing that numpy writes for numbers needs an escape.
            (!text.contains('\\')).then(|| Literal::Text(text.to_owned()))
        }
        '(' | '[' => {
            *rest = rest.get(1..)?;
            let mut values = Vec::new();
            while !ended(rest, if first == '(' { ')' } else { ']' }) {
                values.push(value(rest, depth + 1)?);
                comma(rest);
            }
            Some(Literal::List(values))
        }
        '{' => {
            *rest = rest.get(1..)?;
            let mut entries = Vec::new();
            while !ended(rest, '}') {
                let key = value(rest, depth + 1)?;
                *rest = rest.trim_ascii_start().strip_prefix(':')?;
                entries.push((key, value(rest, depth + 1)?));
                comma(rest);
            }
            Some(Literal::Dict(entries))
        }
        '0'..='9' => {
            let end = rest.find(|c: char| !c.is_ascii_digit()).unwrap_or(rest.len());
            let number = rest.get(..end)?.parse().ok()?;
            *rest = rest.get(end..)?;
            // Python 2 wrote long numbers with a letter.
            *rest = rest.strip_prefix('L').unwrap_or(rest);
            Some(Literal::Number(number))
        }
        _ => [("True", true), ("False", false)].into_iter().find_map(|(word, truth)| {
            *rest = rest.strip_prefix(word)?;
            Some(Literal::Truth(truth))
        }),
    }
}

fn ended(rest: &mut &str, close: char) -> bool {
    *rest = rest.trim_ascii_start();
    let after = rest.strip_prefix(close);
    *rest = after.unwrap_or(rest);
    after.is_some()
}

fn comma(rest: &mut &str) {
    *rest = rest.trim_ascii_start();
    *rest = rest.strip_prefix(',').unwrap_or(rest);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headers_are_read_and_rubbish_is_not() {
        let header = Literal::parse("{'descr': [('a', '<f8', (2,))], 'f': False, 's': (5L,), } \n");
        let header = header.unwrap();
        assert_eq!(header.get("s").unwrap().numbers(), Some(vec![5]));
        assert_eq!(header.get("f"), Some(&Literal::Truth(false)));
        let field = &header.get("descr").unwrap().list().unwrap()[0];
        assert_eq!(field.list().unwrap()[0].text(), Some("a"));
        for rubbish in ["", "{", "{'a': }", "(1", "'a", "{'a': 1} 2", "-1", "99999999999999999999"]
        {
            assert_eq!(Literal::parse(rubbish), None, "{rubbish}");
        }
        assert_eq!(Literal::parse(&"(".repeat(1 << 20)), None);
    }
}
