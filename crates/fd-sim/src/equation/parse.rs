//! Tokens to a tree: a Pratt parser that also checks numbers against conditions. What is begun and not finished lies on
//! a stack of its own, so that nesting costs nothing of the thread's.

use std::sync::Arc;

use std::str::FromStr;

use super::{
    error::{Found, Span, SyntaxError, SyntaxProblem},
    expr::{Binary, Comparison, Cond, Expr, Lookup, Unary},
    token::{Kind, RESERVED, Token, tokens},
};

/// Deepest nesting of a tree: keeps every recursive walk far away from the end of the stack.
pub(crate) const MAX_DEPTH: usize = 256;

/// Most of what may be begun and not finished. A level of the tree needs at most two, one for an operand and one for its
/// parentheses, so that every tree within [`MAX_DEPTH`] can be read back.
const MAX_NESTING: usize = 2 * MAX_DEPTH + 2;

/// How strongly operators hold their operands, from the weakest to the strongest.
mod power {
    pub(super) const OR: u8 = 1;
    pub(super) const AND: u8 = 3;
    pub(super) const NOT: u8 = 5;
    pub(super) const COMPARISON: u8 = 7;
    pub(super) const SUM: u8 = 9;
    pub(super) const PRODUCT: u8 = 11;
    pub(super) const NEGATION: u8 = 13;
    pub(super) const POWER: u8 = 15;
}

impl Expr {
    /// Parses an expression whose value is a number.
    ///
    /// ```
    /// # use fd_sim::equation::Expr;
    /// let error = Expr::parse("m*g*l*sin(theta)/)").unwrap_err();
    /// assert!(error.to_string().starts_with("expected a number or name, found `)`, in column 18"));
    /// ```
    ///
    /// # Errors
    ///
    /// Returns what is wrong and where.
    pub fn parse(text: &str) -> Result<Self, SyntaxError> {
        let mut parser = Parser { text, tokens: tokens(text)?, next: 0 };
        let node = parser.expression()?;
        if parser.peek().kind != Kind::End {
            return Err(parser.expected("an operator or the end"));
        }
        parser.number(node)
    }
}

impl FromStr for Expr {
    type Err = SyntaxError;

    fn from_str(text: &str) -> Result<Self, SyntaxError> {
        Self::parse(text)
    }
}

struct Parser<'a> {
    text: &'a str,
    tokens: Vec<Token>,
    next: usize,
}

struct Node {
    value: Value,
    span: Span,
    depth: usize,
}

enum Value {
    Number(Expr),
    Truth(Cond),
}

enum Infix {
    Arithmetic(Binary),
    Compare(Comparison),
    And,
    Or,
}

/// What waits for an operand.
enum Open {
    /// An operator, for its right side.
    Infix(Infix, Node),
    /// `not` or a minus.
    Not(Span),
    Minus(Span),
    /// A parenthesis.
    Parenthesis(Span),
    /// A function, for its next argument.
    Call(Token, Vec<Node>),
}

/// What stands where an operand should.
enum Prefix {
    Operand(Node),
    /// An operand has to follow, whose operators are at least so strong.
    Open(Open, u8),
}

impl Parser<'_> {
    fn peek(&self) -> &Token {
        // The list ends with `End`, which `advance` never passes.
        &self.tokens[self.next]
    }

    fn advance(&mut self) -> Token {
        let token = self.tokens[self.next].clone();
        if token.kind != Kind::End {
            self.next += 1;
        }
        token
    }

    fn word(&self, token: &Token) -> &str {
        &self.text[token.span.clone()]
    }

    fn at_symbol(&self, symbol: &str) -> bool {
        self.peek().kind == Kind::Symbol && self.word(self.peek()) == symbol
    }

    fn error(&self, span: Span, problem: SyntaxProblem) -> SyntaxError {
        SyntaxError { text: self.text.to_owned(), span, problem }
    }

    fn expected(&self, expected: &'static str) -> SyntaxError {
        let token = self.peek();
        let found = token.found(self.text);
        self.error(token.span.clone(), SyntaxProblem::Expected { expected, found })
    }

    fn symbol(&mut self, symbol: &str, expected: &'static str) -> Result<Token, SyntaxError> {
        if self.at_symbol(symbol) { Ok(self.advance()) } else { Err(self.expected(expected)) }
    }

    fn expression(&mut self) -> Result<Node, SyntaxError> {
        // With each the weakest operator that may follow its operand.
        let mut open: Vec<(Open, u8)> = Vec::new();
        let mut weakest = 0;
        loop {
            if open.len() == MAX_NESTING {
                return Err(self.too_deep(self.peek().span.clone()));
            }
            let mut node = match self.prefix()? {
                Prefix::Operand(node) => node,
                Prefix::Open(what, inner) => {
                    open.push((what, weakest));
                    weakest = inner;
                    continue;
                }
            };
            // What the operand completes, up to what needs a further one.
            loop {
                if let Some((infix, strength)) = self.infix()
                    && weakest <= strength
                {
                    self.advance();
                    open.push((Open::Infix(infix, node), weakest));
                    // `^` groups to the right, everything else to the left.
                    weakest = if strength == power::POWER { strength } else { strength + 1 };
                    break;
                }
                let Some((what, outer)) = open.pop() else { return Ok(node) };
                weakest = outer;
                let (end, depth) = (node.span.end, node.depth + 1);
                node = match what {
                    Open::Infix(infix, left) => self.join(&infix, left, node)?,
                    Open::Not(at) => {
                        let value = Value::Truth(Cond::Not(Arc::new(self.truth(node)?)));
                        self.node(value, at.start..end, depth)?
                    }
                    Open::Minus(at) => {
                        let value = Value::Number(Expr::unary(Unary::Neg, self.number(node)?));
                        self.node(value, at.start..end, depth)?
                    }
                    Open::Parenthesis(at) => {
                        let close = self.symbol(")", "`)` or an operator")?;
                        Node { span: at.start..close.span.end, ..node }
                    }
                    Open::Call(function, mut arguments) => {
                        arguments.push(node);
                        if self.at_symbol(",") {
                            self.advance();
                            open.push((Open::Call(function, arguments), weakest));
                            weakest = 0;
                            break;
                        }
                        self.called(&function, arguments)?
                    }
                };
            }
        }
    }

    fn infix(&self) -> Option<(Infix, u8)> {
        let token = self.peek();
        if !matches!(token.kind, Kind::Symbol | Kind::Name) {
            return None;
        }
        Some(match self.word(token) {
            "or" => (Infix::Or, power::OR),
            "and" => (Infix::And, power::AND),
            "<" => (Infix::Compare(Comparison::Less), power::COMPARISON),
            "<=" => (Infix::Compare(Comparison::LessEqual), power::COMPARISON),
            ">" => (Infix::Compare(Comparison::Greater), power::COMPARISON),
            ">=" => (Infix::Compare(Comparison::GreaterEqual), power::COMPARISON),
            "==" => (Infix::Compare(Comparison::Equal), power::COMPARISON),
            "+" => (Infix::Arithmetic(Binary::Add), power::SUM),
            "-" => (Infix::Arithmetic(Binary::Sub), power::SUM),
            "*" => (Infix::Arithmetic(Binary::Mul), power::PRODUCT),
            "/" => (Infix::Arithmetic(Binary::Div), power::PRODUCT),
            "^" => (Infix::Arithmetic(Binary::Pow), power::POWER),
            _ => return None,
        })
    }

    fn join(&self, infix: &Infix, left: Node, right: Node) -> Result<Node, SyntaxError> {
        let span = left.span.start..right.span.end;
        let depth = left.depth.max(right.depth);
        let value = match infix {
            Infix::Arithmetic(operator) => {
                Value::Number(Expr::binary(*operator, self.number(left)?, self.number(right)?))
            }
            Infix::Compare(comparison) => {
                Value::Truth(Cond::compare(*comparison, self.number(left)?, self.number(right)?))
            }
            Infix::And => {
                Value::Truth(Cond::And(Arc::new(self.truth(left)?), Arc::new(self.truth(right)?)))
            }
            Infix::Or => {
                Value::Truth(Cond::Or(Arc::new(self.truth(left)?), Arc::new(self.truth(right)?)))
            }
        };
        self.node(value, span, depth + 1)
    }

    fn prefix(&mut self) -> Result<Prefix, SyntaxError> {
        let token = self.peek().clone();
        match token.kind {
            Kind::Number(value) => {
                self.advance();
                let node = self.node(Value::Number(Expr::Number(value)), token.span, 1)?;
                Ok(Prefix::Operand(node))
            }
            Kind::Name if self.word(&token) == "not" => {
                self.advance();
                Ok(Prefix::Open(Open::Not(token.span), power::NOT))
            }
            Kind::Name if !matches!(self.word(&token), "and" | "or") => self.name_or_call(),
            Kind::Symbol if self.word(&token) == "-" => self.negation(),
            Kind::Symbol if self.word(&token) == "(" => {
                self.advance();
                Ok(Prefix::Open(Open::Parenthesis(token.span), 0))
            }
            _ => Err(self.expected("a number or name")),
        }
    }

    /// A minus before a literal belongs to the literal, unless a power binds it first: `-2` is a
    /// number, `-2^2` is `-(2^2)`, `-(2)` is a change of sign.
    fn negation(&mut self) -> Result<Prefix, SyntaxError> {
        let minus = self.advance();
        if let Kind::Number(value) = self.peek().kind {
            let literal = self.advance();
            if !self.at_symbol("^") {
                let span = minus.span.start..literal.span.end;
                let node = self.node(Value::Number(Expr::Number(-value)), span, 1)?;
                return Ok(Prefix::Operand(node));
            }
            self.next -= 1;
        }
        Ok(Prefix::Open(Open::Minus(minus.span), power::NEGATION))
    }

    fn name_or_call(&mut self) -> Result<Prefix, SyntaxError> {
        let token = self.advance();
        let name = self.word(&token).to_owned();
        if !self.at_symbol("(") {
            if RESERVED.contains(&name.as_str())
                && !matches!(name.as_str(), "pi" | "t" | "dt" | "first")
            {
                return Err(self.expected("`(` and the arguments of the function"));
            }
            let node = self.node(Value::Number(Expr::Name(name)), token.span, 1)?;
            return Ok(Prefix::Operand(node));
        }
        self.advance();
        if self.at_symbol(")") {
            return Ok(Prefix::Operand(self.called(&token, Vec::new())?));
        }
        Ok(Prefix::Open(Open::Call(token, Vec::new()), 0))
    }

    /// A function with all its arguments.
    fn called(&mut self, function: &Token, arguments: Vec<Node>) -> Result<Node, SyntaxError> {
        let close = self.symbol(")", "`,`, `)` or an operator")?;
        let depth = 1 + arguments.iter().map(|argument| argument.depth).max().unwrap_or(0);
        let span = function.span.start..close.span.end;
        let name = self.word(function).to_owned();
        let value = self.call(&name, &function.span, arguments)?;
        self.node(Value::Number(value), span, depth)
    }

    fn call(&self, name: &str, at: &Span, arguments: Vec<Node>) -> Result<Expr, SyntaxError> {
        if let Some((_, function)) = Unary::NAMED.iter().find(|(known, _)| *known == name) {
            let [x] = self.arguments(name, at, arguments)?;
            return Ok(Expr::unary(*function, self.number(x)?));
        }
        if let Some((_, function)) = Binary::NAMED.iter().find(|(known, _)| *known == name) {
            let [a, b] = self.arguments(name, at, arguments)?;
            return Ok(Expr::binary(*function, self.number(a)?, self.number(b)?));
        }
        match name {
            "clamp" => {
                let [x, low, high] = self.arguments(name, at, arguments)?;
                Ok(Expr::clamp(self.number(x)?, self.number(low)?, self.number(high)?))
            }
            "if" => {
                let [condition, value, otherwise] = self.arguments(name, at, arguments)?;
                Ok(Expr::choice(
                    self.truth(condition)?,
                    self.number(value)?,
                    self.number(otherwise)?,
                ))
            }
            "slope" => {
                let [table, x] = self.arguments(name, at, arguments)?;
                let span = table.span.clone();
                let Expr::Name(table) = self.number(table)? else {
                    let found = Found::Token(self.text[span.clone()].to_owned());
                    let expected = "the name of a table";
                    return Err(self.error(span, SyntaxProblem::Expected { expected, found }));
                };
                Ok(Expr::Lookup(Lookup::Slope, table, Arc::new(self.number(x)?)))
            }
            _ if RESERVED.contains(&name) => {
                Err(self.error(at.clone(), SyntaxProblem::Reserved(name.to_owned())))
            }
            _ => {
                let [x] = self.arguments(name, at, arguments)?;
                Ok(Expr::Lookup(Lookup::Value, name.to_owned(), Arc::new(self.number(x)?)))
            }
        }
    }

    fn arguments<const N: usize>(
        &self,
        function: &str,
        at: &Span,
        arguments: Vec<Node>,
    ) -> Result<[Node; N], SyntaxError> {
        let found = arguments.len();
        arguments.try_into().map_err(|_| {
            let function = function.to_owned();
            self.error(at.clone(), SyntaxProblem::Arguments { function, expected: N, found })
        })
    }

    fn number(&self, node: Node) -> Result<Expr, SyntaxError> {
        match node.value {
            Value::Number(expr) => Ok(expr),
            Value::Truth(_) => Err(self.error(
                node.span,
                SyntaxProblem::Expected { expected: "a number", found: Found::Condition },
            )),
        }
    }

    fn truth(&self, node: Node) -> Result<Cond, SyntaxError> {
        match node.value {
            Value::Truth(cond) => Ok(cond),
            Value::Number(_) => Err(self.error(
                node.span,
                SyntaxProblem::Expected {
                    expected: "a condition such as `x < 1`",
                    found: Found::Number,
                },
            )),
        }
    }

    fn node(&self, value: Value, span: Span, depth: usize) -> Result<Node, SyntaxError> {
        if MAX_DEPTH < depth { Err(self.too_deep(span)) } else { Ok(Node { value, span, depth }) }
    }

    fn too_deep(&self, span: Span) -> SyntaxError {
        self.error(span, SyntaxProblem::TooDeep { limit: MAX_DEPTH })
    }
}
