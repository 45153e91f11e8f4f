//! Expressions of the generated code, independent of the language.

use std::ops::{Add, Div, Mul, Sub};

use Expression::{Binary, Call, Number};

/// A value that the generated code computes. Operations with 0 and 1 that change nothing are left out, so that a ship
/// without a property has no code for it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Expression {
    /// A number.
    Number(f64),
    /// A number of the ship, by its index among [`ship::forces::Forces::quantities`].
    Quantity(usize),
    /// A variable of the model, by its index.
    Channel(usize),
    /// A name within a routine.
    Name(String),
    /// A result of a routine.
    Item(String, usize),
    /// An operation on two values.
    Binary(Operation, Box<[Self; 2]>),
    /// A function of values.
    Call(Function, Vec<Self>),
}

/// Sum, difference, product or quotient.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Operation {
    Sum,
    Difference,
    Product,
    Quotient,
}

/// A function that every language has, or that is written with the model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Function {
    Modulus,
    SquareRoot,
    Exponential,
    Sine,
    Cosine,
    /// The angle of a vector by its components across and ahead.
    Angle,
    /// The square root, 0 below 0.
    Root,
    /// −1, 0 or 1.
    Sign,
    /// The second value where the first is above 0, else the third.
    IfPositive,
}

impl Expression {
    pub const ZERO: Self = Number(0.0);
    pub const ONE: Self = Number(1.0);

    pub fn name(name: &str) -> Self {
        Self::Name(name.to_owned())
    }

    fn binary(operation: Operation, one: Self, other: Self) -> Self {
        Binary(operation, Box::new([one, other]))
    }

    pub fn modulus(self) -> Self {
        Call(Function::Modulus, vec![self])
    }

    pub fn square_root(self) -> Self {
        Call(Function::SquareRoot, vec![self])
    }

    pub fn root(self) -> Self {
        Call(Function::Root, vec![self])
    }

    pub fn sign(self) -> Self {
        Call(Function::Sign, vec![self])
    }

    pub fn exponential(self) -> Self {
        if self == Self::ZERO { Self::ONE } else { Call(Function::Exponential, vec![self]) }
    }

    pub fn sine(self) -> Self {
        if self == Self::ZERO { Self::ZERO } else { Call(Function::Sine, vec![self]) }
    }

    pub fn cosine(self) -> Self {
        if self == Self::ZERO { Self::ONE } else { Call(Function::Cosine, vec![self]) }
    }

    /// The angle of a vector with this component across and that component `ahead`.
    pub fn angle(self, ahead: Self) -> Self {
        Call(Function::Angle, vec![self, ahead])
    }

    /// `then` where this is above 0, else `other`.
    pub fn if_positive(self, then: Self, other: Self) -> Self {
        if then == other { then } else { Call(Function::IfPositive, vec![self, then, other]) }
    }

    /// Calls `seen` for this value and all that it is made of.
    pub fn visit(&self, seen: &mut impl FnMut(&Self)) {
        seen(self);
        match self {
            Binary(_, both) => both.iter().for_each(|own| own.visit(seen)),
            Call(_, all) => all.iter().for_each(|own| own.visit(seen)),
            _ => {}
        }
    }
}

impl Add for Expression {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        match (self, other) {
            (Self::ZERO, own) | (own, Self::ZERO) => own,
            (one, other) => Self::binary(Operation::Sum, one, other),
        }
    }
}

impl Sub for Expression {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        match (self, other) {
            (own, Self::ZERO) => own,
            (Number(one), Number(other)) => Number(one - other),
            (one, other) => Self::binary(Operation::Difference, one, other),
        }
    }
}

impl Mul for Expression {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        match (self, other) {
            (Self::ZERO, _) | (_, Self::ZERO) => Self::ZERO,
            (Self::ONE, own) | (own, Self::ONE) => own,
            (one, other) => Self::binary(Operation::Product, one, other),
        }
    }
}

impl Mul<f64> for Expression {
    type Output = Self;
    fn mul(self, factor: f64) -> Self {
        self * Number(factor)
    }
}

impl Div for Expression {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        match (self, other) {
            (Self::ZERO, _) => Self::ZERO,
            (own, Self::ONE) => own,
            (one, other) => Self::binary(Operation::Quotient, one, other),
        }
    }
}
