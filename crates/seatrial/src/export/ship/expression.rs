//! Expressions of the generated code, independent of the language.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::{Add, Div, Mul, Sub};

use ship::forces::{Driven, Quantity, QuantitySource};

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
            Binary(_, both) => both.iter().for_each(|value| value.visit(seen)),
            Call(_, all) => all.iter().for_each(|value| value.visit(seen)),
            _ => {}
        }
    }
}

impl Add for Expression {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        match (self, other) {
            (Self::ZERO, value) | (value, Self::ZERO) => value,
            (one, other) => Self::binary(Operation::Sum, one, other),
        }
    }
}

impl Sub for Expression {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        match (self, other) {
            (value, Self::ZERO) => value,
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
            (Self::ONE, value) | (value, Self::ONE) => value,
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
            (value, Self::ONE) => value,
            (one, other) => Self::binary(Operation::Quotient, one, other),
        }
    }
}

// The numbers of a ship as values of the generated code.

/// The numbers of a ship by name, and the identifiers of her channels.
pub(crate) struct Numbers<'a> {
    quantities: &'a [Quantity],
    places: BTreeMap<&'a str, usize>,
    /// The identifiers of the model's variables, states first.
    pub channels: &'a [String],
}

impl<'a> Numbers<'a> {
    pub fn new(quantities: &'a [Quantity], channels: &'a [String]) -> Self {
        let places = quantities.iter().enumerate().map(|(i, quantity)| (quantity.name.as_str(), i)).collect();
        Self { quantities, places, channels }
    }

    /// A number: a parameter, a multiple of one, or its default where the ship does not state it; 0 without such a number.
    pub fn get(&self, name: &str) -> Expression {
        let Some(i) = self.places.get(name) else { return Expression::ZERO };
        let quantity = &self.quantities[*i];
        match &quantity.source {
            _ if !quantity.stated => Expression::Number(quantity.value),
            QuantitySource::Tied { to, factor } => {
                let other =
                    self.places.get(to.as_str()).map_or(Expression::ZERO, |j| Expression::Quantity(*j));
                Expression::Number(*factor) * other
            }
            _ => Expression::Quantity(*i),
        }
    }

    /// The number `key` of `component`.
    pub fn of(&self, component: &str, key: &str) -> Expression {
        self.get(&format!("{component}.{key}"))
    }

    /// The numbers `key.0` and `key.1` of `component`.
    pub fn both(&self, component: &str, key: &str) -> [Expression; 2] {
        [0, 1].map(|i| self.of(component, &format!("{key}.{i}")))
    }

    /// A channel in the unit of a component.
    pub fn driven(&self, driven: Driven) -> Expression {
        Expression::Channel(3 + driven.channel) * driven.factor
    }
}

/// The motion that components depend on, as arguments: u, v, r, the whole speed, that with the sign of u, and u less the
/// approach speed.
pub(crate) fn motion() -> Vec<(String, Expression)> {
    ship::forces::MOTION.iter().map(|name| ((*name).to_owned(), Expression::name(name))).collect()
}

// Functions of the generated code, independent of the language.

/// A function of the generated code: parameters and arguments to results.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Routine {
    /// Its name.
    pub name: String,
    /// What it computes, with its results.
    pub comment: String,
    /// The names of its arguments, and what callers pass for them.
    pub arguments: Vec<(String, Expression)>,
    /// What it computes first.
    pub lines: Vec<Line>,
    /// What it returns.
    pub results: Vec<Expression>,
}

/// A line of a routine.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Line {
    /// Names a value, with a comment.
    Let(String, Expression, &'static str),
    /// Names the results of a routine of so many with these arguments; whether it takes parameters.
    Results { name: String, routine: String, arguments: Vec<Expression>, count: usize, parameters: bool },
    /// Names a sum from 0.
    Sum(String),
    /// Adds to a sum.
    Grow(String, Expression),
    /// Does its lines with `i` from 0 on, so many times.
    Repeat(u32, Vec<Line>),
}

impl Line {
    fn visit(&self, seen: &mut impl FnMut(&Expression)) {
        match self {
            Self::Let(_, value, _) | Self::Grow(_, value) => value.visit(seen),
            Self::Results { arguments, .. } => arguments.iter().for_each(|value| value.visit(seen)),
            Self::Sum(_) => {}
            Self::Repeat(_, lines) => lines.iter().for_each(|line| line.visit(seen)),
        }
    }
}

/// The names that a value has.
fn names(used: &mut BTreeSet<String>, value: &Expression) {
    if let Expression::Name(name) | Expression::Item(name, _) = value {
        used.insert(name.clone());
    }
}

impl Routine {
    /// The same without lines and arguments that no result needs.
    pub fn without_unused(mut self) -> Self {
        let mut used = BTreeSet::new();
        self.results.iter().for_each(|result| result.visit(&mut |value| names(&mut used, value)));
        let mut kept = Vec::new();
        for line in self.lines.into_iter().rev() {
            let unused = matches!(&line, Line::Let(name, ..) if !used.contains(name));
            if !unused {
                line.visit(&mut |value| names(&mut used, value));
                kept.push(line);
            }
        }
        kept.reverse();
        self.lines = kept;
        self.arguments.retain(|(name, _)| used.contains(name));
        self
    }

    /// Calls `seen` for every value in it.
    pub fn visit(&self, seen: &mut impl FnMut(&Expression)) {
        self.lines.iter().for_each(|line| line.visit(seen));
        self.results.iter().for_each(|result| result.visit(seen));
    }

    /// Whether it takes parameters.
    pub fn has_parameters(&self) -> bool {
        let mut takes_any = false;
        self.visit(&mut |value| takes_any |= matches!(value, Expression::Quantity(_)));
        self.lines.iter().for_each(|l| takes_any |= matches!(l, Line::Results { parameters: true, .. }));
        takes_any
    }

    /// The line that calls it for what `name` then has.
    pub fn called(&self, name: &str) -> Line {
        Line::Results {
            name: name.to_owned(),
            routine: self.name.clone(),
            arguments: self.arguments.iter().map(|(_, value)| value.clone()).collect(),
            count: self.results.len(),
            parameters: self.has_parameters(),
        }
    }
}

/// Lines in the making: each named value is returned as a name.
#[derive(Default)]
pub(crate) struct Lines(pub Vec<Line>);

impl Lines {
    /// Names a value, unless it is a plain number or name.
    pub fn name(&mut self, name: &str, value: Expression, comment: &'static str) -> Expression {
        if matches!(value, Expression::Number(_) | Expression::Name(_)) {
            return value;
        }
        self.0.push(Line::Let(name.to_owned(), value, comment));
        Expression::name(name)
    }
}
