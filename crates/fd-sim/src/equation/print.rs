//! A tree to text, with no more parentheses than needed: `parse(print(e)) == e`.

use std::fmt;

use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error};

use super::expr::{Binary, Comparison, Cond, Expr, Lookup, Unary};

/// How tightly a node holds together; a child of lower rank than its place gets parentheses.
mod rank {
    pub(super) const OR: u8 = 1;
    pub(super) const AND: u8 = 2;
    pub(super) const NOT: u8 = 3;
    pub(super) const COMPARISON: u8 = 4;
    pub(super) const SUM: u8 = 5;
    pub(super) const PRODUCT: u8 = 6;
    pub(super) const NEGATION: u8 = 7;
    pub(super) const POWER: u8 = 8;
    pub(super) const ATOM: u8 = 9;
}

impl fmt::Display for Expr {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(value) => number(*value, f),
            Self::Name(name) => f.write_str(name),
            Self::Unary(Unary::Neg, x) => match **x {
                // `-2` would be read back as a literal.
                Self::Number(value) if value.is_sign_positive() => write!(f, "-({x})"),
                _ => write!(f, "-{}", place(&**x, rank::NEGATION)),
            },
            Self::Unary(function, x) => write!(f, "{}({x})", function.name()),
            Self::Binary(operator, a, b) => binary(*operator, a, b, f),
            Self::Clamp(arguments) => {
                let [x, low, high] = &**arguments;
                write!(f, "clamp({x}, {low}, {high})")
            }
            Self::If(condition, value, otherwise) => {
                write!(f, "if({condition}, {value}, {otherwise})")
            }
            Self::Lookup(Lookup::Value, table, x) => write!(f, "{table}({x})"),
            Self::Lookup(Lookup::Slope, table, x) => write!(f, "slope({table}, {x})"),
        }
    }
}

impl fmt::Display for Cond {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Compare(comparison, a, b) => write!(f, "{a} {} {b}", comparison.symbol()),
            Self::And(a, b) => {
                write!(f, "{} and {}", place(&**a, rank::AND), place(&**b, rank::NOT))
            }
            Self::Or(a, b) => write!(f, "{} or {}", place(&**a, rank::OR), place(&**b, rank::AND)),
            Self::Not(a) => write!(f, "not {}", place(&**a, rank::NOT)),
        }
    }
}

impl Comparison {
    fn symbol(self) -> &'static str {
        match self {
            Self::Less => "<",
            Self::LessEqual => "<=",
            Self::Greater => ">",
            Self::GreaterEqual => ">=",
            Self::Equal => "==",
        }
    }
}

fn number(value: f64, f: &mut fmt::Formatter<'_>) -> fmt::Result {
    if value.is_nan() {
        f.write_str("(0/0)")
    } else if value.is_infinite() {
        f.write_str(if value < 0.0 { "(-1/0)" } else { "(1/0)" })
    } else {
        // `{:?}` is the shortest text that reads back as the same number.
        let text = format!("{value:?}");
        f.write_str(text.strip_suffix(".0").unwrap_or(&text))
    }
}

fn binary(operator: Binary, a: &Expr, b: &Expr, f: &mut fmt::Formatter<'_>) -> fmt::Result {
    let (symbol, left, right) = match operator {
        Binary::Add => (" + ", rank::SUM, rank::PRODUCT),
        Binary::Sub => (" - ", rank::SUM, rank::PRODUCT),
        Binary::Mul => ("*", rank::PRODUCT, rank::NEGATION),
        Binary::Div => ("/", rank::PRODUCT, rank::NEGATION),
        Binary::Pow => ("^", rank::ATOM, rank::NEGATION),
        Binary::Atan2 => return write!(f, "atan2({a}, {b})"),
        Binary::Min => return write!(f, "min({a}, {b})"),
        Binary::Max => return write!(f, "max({a}, {b})"),
    };
    write!(f, "{}{symbol}{}", place(a, left), place(b, right))
}

trait Ranked: fmt::Display {
    fn rank(&self) -> u8;
}

impl Ranked for Expr {
    fn rank(&self) -> u8 {
        match self {
            Self::Number(value) if value.is_sign_negative() && value.is_finite() => rank::NEGATION,
            Self::Unary(Unary::Neg, _) => rank::NEGATION,
            Self::Binary(Binary::Add | Binary::Sub, ..) => rank::SUM,
            Self::Binary(Binary::Mul | Binary::Div, ..) => rank::PRODUCT,
            Self::Binary(Binary::Pow, ..) => rank::POWER,
            _ => rank::ATOM,
        }
    }
}

impl Ranked for Cond {
    fn rank(&self) -> u8 {
        match self {
            Self::Or(..) => rank::OR,
            Self::And(..) => rank::AND,
            Self::Not(_) => rank::NOT,
            Self::Compare(..) => rank::COMPARISON,
        }
    }
}

/// A node in a place that needs a rank.
struct Placed<'a, N> {
    node: &'a N,
    at_least: u8,
}

fn place<N: Ranked>(node: &N, at_least: u8) -> Placed<'_, N> {
    Placed { node, at_least }
}

impl<N: Ranked> fmt::Display for Placed<'_, N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let node = self.node;
        if node.rank() < self.at_least { write!(f, "({node})") } else { write!(f, "{node}") }
    }
}

impl Serialize for Expr {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for Expr {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = String::deserialize(deserializer)?;
        Self::parse(&text).map_err(D::Error::custom)
    }
}
