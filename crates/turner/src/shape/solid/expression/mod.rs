//! Expressions in x, y and z, or other variables, evaluated with numbers, intervals, and either with a derivative.

mod number;
mod parse;
#[cfg(test)]
mod tests;

pub(in crate::shape) use number::{Dual, Interval, Number};

/// One step of the evaluation on a stack.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Op {
    /// Pushes a number.
    Constant(f64),
    /// Pushes a variable.
    Variable(usize),
    Add,
    Subtract,
    Multiply,
    Divide,
    Negate,
    Minimum,
    Maximum,
    /// The square root of the sum of the squares of two numbers.
    Length,
    /// A power with a whole exponent.
    WholePower(u32),
    /// A power with any other exponent.
    Power(f64),
    Absolute,
    SquareRoot,
    Exponential,
    Logarithm,
    Sine,
    Cosine,
}

/// The largest height of the stack; the parser refuses expressions that need more.
const STACK: usize = 16;

/// A parsed expression.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::shape) struct Expression {
    ops: Vec<Op>,
}

impl Expression {
    /// Its value at a point.
    pub(in crate::shape) fn evaluate<N: Number>(&self, at: [N; 3]) -> N {
        let mut stack = [N::constant(0.0); STACK];
        let mut height = 0;
        for op in &self.ops {
            let top = stack[(height + STACK - 1) % STACK];
            let below = stack[(height + STACK - 2) % STACK];
            let (taken, value) = match *op {
                Op::Constant(v) => (0, N::constant(v)),
                Op::Variable(axis) => (0, at[axis % 3]),
                Op::Add => (2, below + top),
                Op::Subtract => (2, below - top),
                Op::Multiply => (2, below * top),
                Op::Divide => (2, below / top),
                Op::Minimum => (2, below.minimum(top)),
                Op::Maximum => (2, -((-below).minimum(-top))),
                Op::Length => (2, (below.whole_power(2) + top.whole_power(2)).square_root()),
                Op::Negate => (1, -top),
                Op::WholePower(n) => (1, top.whole_power(n)),
                Op::Power(exponent) => (1, top.power(exponent)),
                Op::Absolute => (1, top.absolute()),
                Op::SquareRoot => (1, top.square_root()),
                Op::Exponential => (1, top.exponential()),
                Op::Logarithm => (1, top.logarithm()),
                Op::Sine => (1, top.sine()),
                Op::Cosine => (1, (top + N::constant(std::f64::consts::FRAC_PI_2)).sine()),
            };
            height = (height + 1).saturating_sub(taken);
            stack[(height + STACK - 1) % STACK] = value;
        }
        stack[0]
    }

    /// Bytes beyond its own size.
    pub(super) fn memory(&self) -> usize {
        size_of_val(&self.ops[..])
    }
}
