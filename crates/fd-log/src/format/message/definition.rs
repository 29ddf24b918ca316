//! Definitions of ROS 2 messages as recordings store them (`ros2msg`): the text of the message, and behind lines of `=`
//! the texts of those it is made of.

use super::{Count, Definitions, Field, Kind, Number};

/// All definitions of a schema, by names such as `geometry_msgs/Point`; nothing if a line makes no sense.
pub(in crate::format) fn parse(root: &str, text: &str) -> Option<Definitions> {
    let mut definitions = Definitions::new();
    let mut name = short(root);
    let mut fields = Vec::new();
    for line in text.lines() {
        let line = line.split('#').next().unwrap_or_default().trim();
        if line.starts_with("=====") {
            definitions.insert(std::mem::take(&mut name), std::mem::take(&mut fields));
        } else if let Some(next) = line.strip_prefix("MSG:") {
            name = short(next.trim());
        } else if !line.is_empty() && !is_constant(line) {
            fields.push(field(line, &name)?);
        }
    }
    definitions.insert(name, fields);
    Some(definitions)
}

/// `sensor_msgs/msg/Imu` and `sensor_msgs/Imu` are the same.
pub(in crate::format) fn short(name: &str) -> String {
    name.replace("/msg/", "/")
}

/// Whether a line states a number, as `uint8 OK=0`, which takes no bytes.
fn is_constant(line: &str) -> bool {
    let rest = line.split_once(char::is_whitespace).map_or("", |(_, rest)| rest.trim_start());
    rest.trim_start_matches(|c: char| c.is_alphanumeric() || c == '_').trim_start().starts_with('=')
}

/// A field: its type, its name, and a value that it has if nobody gives one.
fn field(line: &str, of: &str) -> Option<Field> {
    let (kind, rest) = line.split_once(char::is_whitespace)?;
    let rest = rest.trim_start();
    let end = rest.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(rest.len());
    let name = rest.get(..end)?;
    let (base, count) = match kind.split_once('[') {
        None => (kind, Count::One),
        Some((base, size)) => {
            let size = size.strip_suffix(']')?;
            let is_bound = size.is_empty() || size.starts_with("<=");
            (base, if is_bound { Count::Sequence } else { Count::Fixed(size.parse().ok()?) })
        }
    };
    // `string<=20` is a text like any other.
    let base = base.split_once("<=").map_or(base, |(base, _)| base);
    let kind = match Number::parse(base) {
        Some(number) => Kind::Number(number),
        None if base == "string" => Kind::Text,
        None if base == "wstring" => return None,
        None if base.contains('/') => Kind::Message(short(base)),
        // Of the same package, but for the one that ROS spells without.
        None if base == "Header" => Kind::Message("std_msgs/Header".to_owned()),
        None => Kind::Message(format!("{}/{base}", of.split_once('/').map_or("", |(p, _)| p))),
    };
    (!name.is_empty()).then(|| Field { name: name.to_owned(), kind, count })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_are_told_from_constants_and_comments() {
        let text = "# a state\nuint8 OK=0\nuint8 BAD = 1 # why\nstd_msgs/Header header\nPoint[<=4] points\n\
                    string<=10[] name\nfloat64[3] q 1.0\n===\n=====\nMSG: std_msgs/msg/Header\nint32 seq\n";
        assert_eq!(parse("a_msgs/msg/State", text), None, "a line of three signs is no end");
        let definitions = parse("a_msgs/msg/State", &text.replace("===\n=====", "======")).unwrap();
        let fields = &definitions["a_msgs/State"];
        let counts: Vec<Count> = fields.iter().map(|field| field.count).collect();
        assert_eq!(counts, [Count::One, Count::Sequence, Count::Sequence, Count::Fixed(3)]);
        assert_eq!(fields[1].kind, Kind::Message("a_msgs/Point".to_owned()));
        assert_eq!(definitions["std_msgs/Header"][0].name, "seq");
    }
}
