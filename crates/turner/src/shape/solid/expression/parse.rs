//! The parser of expressions: recursive descent to operations on a stack.

use super::{Expression, Op, STACK};
use crate::schema::error::nearest;
use crate::schema::{ErrorCode, SceneError};

/// Most operations of an expression.
const MAX_OPS: usize = 1024;
/// Deepest nesting of parentheses and signs.
const MAX_DEPTH: usize = 64;

/// Names that an expression may contain besides its variables.
const NAMES: [&str; 10] = ["pi", "abs", "sqrt", "exp", "ln", "sin", "cos", "min", "max", "length"];

struct Parser<'a> {
    text: &'a str,
    /// Names of variables, at most three.
    variables: &'a [&'a str],
    /// Position in bytes.
    at: usize,
    ops: Vec<Op>,
    depth: usize,
}

impl Expression {
    /// Parses an expression in x, y and z.
    ///
    /// Errors: whatever is no expression, with the position, what was found and what was expected.
    pub(in crate::shape::solid) fn parse(text: &str) -> Result<Expression, SceneError> {
        Expression::parse_in(text, &["x", "y", "z"])
    }

    /// Parses an expression in up to three variables.
    ///
    /// Errors: as [`Expression::parse`].
    pub(in crate::shape) fn parse_in(text: &str, variables: &[&str]) -> Result<Expression, SceneError> {
        let mut parser = Parser { text, variables, at: 0, ops: Vec::new(), depth: 0 };
        parser.sum()?;
        if parser.peek().is_some() {
            return Err(parser.expected("an operator or the end"));
        }
        let mut height: usize = 0;
        for op in &parser.ops {
            height = match op {
                Op::Constant(_) | Op::Variable(_) => height + 1,
                Op::Add
                | Op::Subtract
                | Op::Multiply
                | Op::Divide
                | Op::Minimum
                | Op::Maximum
                | Op::Length => height.saturating_sub(1),
                _ => height,
            };
            if height > STACK {
                let message = format!(
                    "the expression nests too deeply: it needs more than {STACK} intermediate values"
                );
                return Err(SceneError::new(ErrorCode::TooLarge, message)
                    .help("reorder it: a + (b + c) as a + b + c"));
            }
        }
        Ok(Expression { ops: parser.ops })
    }
}

impl<'a> Parser<'a> {
    /// The next character that is not a space.
    fn peek(&mut self) -> Option<char> {
        let rest = &self.text[self.at..];
        self.at += rest.len() - rest.trim_start().len();
        self.text[self.at..].chars().next()
    }

    fn accept(&mut self, wanted: char) -> bool {
        let found = self.peek() == Some(wanted);
        if found {
            self.at += wanted.len_utf8();
        }
        found
    }

    fn expected(&mut self, what: &str) -> SceneError {
        let found = match self.peek() {
            Some(c) => format!("found \"{}\"", c.escape_debug()),
            None => "found the end".to_owned(),
        };
        let column = self.text[..self.at].chars().count() + 1;
        let message = format!("expected {what} at character {column} of the expression, {found}");
        SceneError::new(ErrorCode::Syntax, message)
    }

    fn push(&mut self, op: Op) -> Result<(), SceneError> {
        if self.ops.len() >= MAX_OPS {
            let message = format!("the expression has more than {MAX_OPS} operations");
            return Err(SceneError::new(ErrorCode::TooLarge, message));
        }
        self.ops.push(op);
        Ok(())
    }

    fn nested(&mut self, inner: impl Fn(&mut Self) -> Result<(), SceneError>) -> Result<(), SceneError> {
        self.depth += 1;
        if self.depth > MAX_DEPTH {
            let message = format!("the expression nests deeper than {MAX_DEPTH} levels");
            return Err(SceneError::new(ErrorCode::TooLarge, message));
        }
        let result = inner(self);
        self.depth -= 1;
        result
    }

    fn sum(&mut self) -> Result<(), SceneError> {
        self.chain(Self::product, [('+', Op::Add), ('-', Op::Subtract)])
    }

    fn product(&mut self) -> Result<(), SceneError> {
        self.chain(Self::sign, [('*', Op::Multiply), ('/', Op::Divide)])
    }

    /// Operands with operators of one precedence between them, from left to right.
    fn chain(
        &mut self,
        operand: impl Fn(&mut Self) -> Result<(), SceneError>,
        operators: [(char, Op); 2],
    ) -> Result<(), SceneError> {
        operand(self)?;
        while let Some((_, op)) = operators.iter().find(|(sign, _)| self.accept(*sign)) {
            operand(self)?;
            self.push(*op)?;
        }
        Ok(())
    }

    /// −x^2 is −(x²).
    fn sign(&mut self) -> Result<(), SceneError> {
        if self.accept('-') {
            self.nested(Self::sign)?;
            return self.push(Op::Negate);
        }
        if self.accept('+') {
            return self.nested(Self::sign);
        }
        self.power()
    }

    fn power(&mut self) -> Result<(), SceneError> {
        self.primary()?;
        while self.accept('^') {
            let negative = self.accept('-');
            let Some(exponent) = self.number()? else {
                return Err(self.expected("a number as exponent"));
            };
            let whole = exponent.floor() == exponent && exponent <= 64.0;
            self.push(if whole { Op::WholePower(exponent as u32) } else { Op::Power(exponent) })?;
            if negative {
                // x^-n = 1 / x^n
                let power = self.ops.pop();
                let base = self.last_operand();
                self.ops.insert(base, Op::Constant(1.0));
                self.ops.extend(power);
                self.push(Op::Divide)?;
            }
        }
        Ok(())
    }

    /// The index of the first operation of the last operand.
    fn last_operand(&self) -> usize {
        let mut wanted = 1usize;
        for (i, op) in self.ops.iter().enumerate().rev() {
            match op {
                Op::Constant(_) | Op::Variable(_) => wanted -= 1,
                Op::Add
                | Op::Subtract
                | Op::Multiply
                | Op::Divide
                | Op::Minimum
                | Op::Maximum
                | Op::Length => {
                    wanted += 1;
                }
                _ => {}
            }
            if wanted == 0 {
                return i;
            }
        }
        0
    }

    /// A number without sign, if one comes next.
    fn number(&mut self) -> Result<Option<f64>, SceneError> {
        if !self.peek().is_some_and(|c| c.is_ascii_digit() || c == '.') {
            return Ok(None);
        }
        let rest = &self.text[self.at..];
        let digits = |text: &str| text.len() - text.trim_start_matches(|c: char| c.is_ascii_digit()).len();
        let mut end = digits(rest);
        if rest[end..].starts_with('.') {
            end += 1 + digits(&rest[end + 1..]);
        }
        if let Some(after) = rest[end..].strip_prefix(['e', 'E']) {
            let sign = usize::from(after.starts_with(['+', '-']));
            let count = digits(&after[sign..]);
            end += if count > 0 { 1 + sign + count } else { 0 };
        }
        match rest[..end].parse::<f64>() {
            Ok(v) if v.is_finite() => {
                self.at += end;
                Ok(Some(v))
            }
            _ => Err(self.expected("a number")),
        }
    }

    fn primary(&mut self) -> Result<(), SceneError> {
        if let Some(v) = self.number()? {
            return self.push(Op::Constant(v));
        }
        if self.accept('(') {
            self.nested(Self::sum)?;
            return if self.accept(')') { Ok(()) } else { Err(self.expected("`)`")) };
        }
        if !self.peek().is_some_and(|c| c.is_ascii_alphabetic()) {
            let variables = self.variables.join(", ");
            return Err(self.expected(&format!("a number, {variables}, a function or `(`")));
        }
        let rest = &self.text[self.at..];
        let end = rest.find(|c: char| !(c.is_ascii_alphanumeric() || c == '_')).unwrap_or(rest.len());
        let name = &rest[..end];
        if let Some(i) = self.variables.iter().position(|v| *v == name) {
            self.at += end;
            return self.push(Op::Variable(i));
        }
        match name {
            "pi" => {
                self.at += end;
                self.push(Op::Constant(std::f64::consts::PI))
            }
            name if NAMES.contains(&name) => {
                self.at += end;
                self.call(name)
            }
            name => {
                let column = self.text[..self.at].chars().count() + 1;
                let message = format!("there is no \"{name}\" in expressions (character {column})");
                let names = [self.variables, &NAMES].concat();
                Err(SceneError::new(ErrorCode::UnknownName, message).help(match nearest(name, &names) {
                    Some(near) => format!("write `{near}`"),
                    None => format!("valid: {}", names.join(", ")),
                }))
            }
        }
    }

    /// The arguments of a function.
    fn call(&mut self, name: &str) -> Result<(), SceneError> {
        if !self.accept('(') {
            return Err(self.expected("`(`"));
        }
        let (op, several) = match name {
            "abs" => (Op::Absolute, false),
            "sqrt" => (Op::SquareRoot, false),
            "exp" => (Op::Exponential, false),
            "ln" => (Op::Logarithm, false),
            "sin" => (Op::Sine, false),
            "cos" => (Op::Cosine, false),
            "min" => (Op::Minimum, true),
            "max" => (Op::Maximum, true),
            _ => (Op::Length, true),
        };
        self.nested(Self::sum)?;
        if !several {
            self.push(op)?;
        } else if self.peek() != Some(',') {
            return Err(self.expected("`,` and another argument"));
        }
        while several && self.accept(',') {
            self.nested(Self::sum)?;
            self.push(op)?;
        }
        if self.accept(')') { Ok(()) } else { Err(self.expected("`)`")) }
    }
}
