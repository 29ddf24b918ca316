//! Trees to bytecode, with every common part computed once.

use std::collections::HashMap;

use thiserror::Error;

use super::{
    evaluate::whole_exponent,
    expr::{Binary, Cond, Expr},
    fuse::fuse,
    instruction::{Instruction, Operation},
    order::{Cycle, in_order_of_use},
    place::{Key, Place},
    program::Program,
    table::Table,
};

/// What the names in a set of expressions stand for.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scope {
    /// Inputs that change rarely, such as parameters.
    pub slow: Vec<String>,
    /// Inputs that change with every evaluation, such as states.
    pub fast: Vec<String>,
    /// Named expressions, in any order.
    pub definitions: Vec<(String, Expr)>,
    /// Named tables.
    pub tables: Vec<(String, Table)>,
}

/// Expressions cannot be compiled.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum CompileError {
    /// A name that the scope does not have.
    #[error("`{0}` is not defined")]
    UnknownName(String),
    /// A table that the scope does not have.
    #[error("there is no function or table `{0}`")]
    UnknownTable(String),
    /// Definitions that need themselves.
    #[error("definitions go round in a circle: {}", path.join(" → "))]
    Cycle {
        /// Each uses the next; the last is the first.
        path: Vec<String>,
    },
    /// More than 2³² slots.
    #[error("the expressions are too long")]
    TooLong,
}

impl From<Cycle> for CompileError {
    fn from(Cycle(path): Cycle) -> Self {
        Self::Cycle { path }
    }
}

impl Program {
    /// Compiles `expressions`, of which the results will be in the same order.
    ///
    /// Equal parts are computed once; only parts that are the same operation on the same operands
    /// (in either order for sums and products, which commute exactly) are merged, so the values
    /// are those of [`Expr::evaluate`] to the bit.
    ///
    /// # Errors
    ///
    /// Returns the first name that `scope` does not have, or definitions in a circle. An unused
    /// definition is not looked at.
    pub fn compile(scope: &Scope, expressions: &[Expr]) -> Result<Self, CompileError> {
        let mut compiler = Compiler::new(scope);
        let definitions: Vec<(&str, &Expr)> =
            scope.definitions.iter().map(|(name, expr)| (name.as_str(), expr)).collect();
        for index in in_order_of_use(&definitions, expressions)? {
            let (name, expr) = definitions[index];
            let place = compiler.expr(expr)?;
            compiler.names.insert(name, place);
        }
        let results: Vec<Place> =
            expressions.iter().map(|expr| compiler.expr(expr)).collect::<Result<_, _>>()?;
        compiler.finish(&results)
    }
}

struct Compiler<'a> {
    scope: &'a Scope,
    names: HashMap<&'a str, Place>,
    tables: HashMap<&'a str, usize>,
    constants: Vec<f64>,
    known_constants: HashMap<u64, Place>,
    known: HashMap<Key, Place>,
    instructions: Vec<(Key, Place)>,
}

impl<'a> Compiler<'a> {
    fn new(scope: &'a Scope) -> Self {
        let slow = scope.slow.iter().enumerate().map(|(i, name)| (name.as_str(), Place::Slow(i)));
        let fast = scope.fast.iter().enumerate().map(|(i, name)| (name.as_str(), Place::Fast(i)));
        let tables = scope.tables.iter().enumerate().map(|(i, (name, _))| (name.as_str(), i));
        Self {
            scope,
            names: slow.chain(fast).collect(),
            tables: tables.collect(),
            constants: Vec::new(),
            known_constants: HashMap::new(),
            known: HashMap::new(),
            instructions: Vec::new(),
        }
    }

    fn constant(&mut self, value: f64) -> Place {
        *self.known_constants.entry(value.to_bits()).or_insert_with(|| {
            self.constants.push(value);
            Place::Constant(self.constants.len() - 1)
        })
    }

    fn emit(&mut self, operation: Operation, mut operands: [Place; 3]) -> Place {
        if matches!(operation, Operation::Add | Operation::Mul) && operands[1] < operands[0] {
            operands.swap(0, 1);
        }
        let key = (operation, operands);
        if let Some(place) = self.known.get(&key) {
            return *place;
        }
        let is_slow = operands.into_iter().all(Place::is_slow);
        let place = Place::Result(self.instructions.len(), is_slow);
        self.instructions.push((key, place));
        self.known.insert(key, place);
        place
    }

    fn emit1(&mut self, operation: Operation, a: Place) -> Place {
        self.emit(operation, [a, Place::Other(0), Place::Other(0)])
    }

    fn emit2(&mut self, operation: Operation, a: Place, b: Place) -> Place {
        self.emit(operation, [a, b, Place::Other(0)])
    }

    fn expr(&mut self, expr: &Expr) -> Result<Place, CompileError> {
        Ok(match expr {
            Expr::Number(value) => self.constant(*value),
            Expr::Name(name) => match self.names.get(name.as_str()) {
                Some(place) => *place,
                None if name == "pi" => self.constant(std::f64::consts::PI),
                None => return Err(CompileError::UnknownName(name.clone())),
            },
            Expr::Unary(function, x) => {
                let x = self.expr(x)?;
                self.emit1(Operation::Unary(*function), x)
            }
            Expr::Binary(operator, a, b) => {
                let a = self.expr(a)?;
                if let (Binary::Pow, Some(exponent)) = (operator, whole_exponent(b)) {
                    return Ok(self.emit1(Operation::Power(exponent), a));
                }
                let b = self.expr(b)?;
                let operation = match operator {
                    Binary::Add => Operation::Add,
                    Binary::Sub => Operation::Sub,
                    Binary::Mul => Operation::Mul,
                    Binary::Div => Operation::Div,
                    function => Operation::Binary(*function),
                };
                self.emit2(operation, a, b)
            }
            Expr::Clamp(arguments) => {
                let [x, low, high] = &**arguments;
                let operands = [self.expr(x)?, self.expr(low)?, self.expr(high)?];
                self.emit(Operation::Clamp, operands)
            }
            Expr::If(condition, value, otherwise) => {
                let operands = [self.cond(condition)?, self.expr(value)?, self.expr(otherwise)?];
                self.emit(Operation::Select, operands)
            }
            Expr::Lookup(kind, table, x) => {
                let x = self.expr(x)?;
                let table = self
                    .tables
                    .get(table.as_str())
                    .ok_or_else(|| CompileError::UnknownTable(table.clone()))?;
                let table = Place::Other(*table);
                self.emit2(Operation::Lookup(*kind), x, table)
            }
        })
    }

    fn cond(&mut self, cond: &Cond) -> Result<Place, CompileError> {
        Ok(match cond {
            Cond::Compare(comparison, a, b) => {
                let (a, b) = (self.expr(a)?, self.expr(b)?);
                self.emit2(Operation::Compare(*comparison), a, b)
            }
            Cond::And(a, b) => {
                let (a, b) = (self.cond(a)?, self.cond(b)?);
                self.emit2(Operation::And, a, b)
            }
            Cond::Or(a, b) => {
                let (a, b) = (self.cond(a)?, self.cond(b)?);
                self.emit2(Operation::Or, a, b)
            }
            Cond::Not(a) => {
                let a = self.cond(a)?;
                self.emit1(Operation::Not, a)
            }
        })
    }

    fn finish(self, results: &[Place]) -> Result<Program, CompileError> {
        let (slow, fast) = (self.scope.slow.len(), self.scope.fast.len());
        let first_result = slow + fast + self.constants.len();
        let slots = first_result + self.instructions.len();
        if u32::try_from(slots).is_err() {
            return Err(CompileError::TooLong);
        }
        #[expect(clippy::cast_possible_truncation, reason = "below `slots`, which was checked")]
        let slot = |place: Place| {
            (match place {
                Place::Slow(i) | Place::Other(i) => i,
                Place::Fast(i) => slow + i,
                Place::Constant(i) => slow + fast + i,
                Place::Result(i, _) => first_result + i,
            }) as u32
        };
        let mut program = Program {
            slow,
            fast,
            slots,
            prologue: Vec::new(),
            body: Vec::new(),
            results: results.iter().map(|place| slot(*place)).collect(),
            tables: self.scope.tables.iter().map(|(_, table)| table.clone()).collect(),
            constants: self.constants,
        };
        for ((operation, operands), place) in fuse(self.instructions, results) {
            let [a, b, c] = operands.map(slot);
            let instruction = Instruction { operation, to: slot(place), a, b, c };
            if place.is_slow() { &mut program.prologue } else { &mut program.body }
                .push(instruction);
        }
        Ok(program)
    }
}
