//! Functions of the generated code, independent of the language.

use std::collections::BTreeSet;

use super::expression::Expression;

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
            Self::Results { arguments, .. } => arguments.iter().for_each(|own| own.visit(seen)),
            Self::Sum(_) => {}
            Self::Repeat(_, lines) => lines.iter().for_each(|own| own.visit(seen)),
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
        self.results.iter().for_each(|own| own.visit(&mut |value| names(&mut used, value)));
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
        self.lines.iter().for_each(|own| own.visit(seen));
        self.results.iter().for_each(|own| own.visit(seen));
    }

    /// Whether it takes parameters.
    pub fn has_parameters(&self) -> bool {
        let mut found = false;
        self.visit(&mut |value| found |= matches!(value, Expression::Quantity(_)));
        self.lines.iter().for_each(|own| found |= matches!(own, Line::Results { parameters: true, .. }));
        found
    }

    /// The line that calls it for what `name` then has.
    pub fn called(&self, name: &str) -> Line {
        Line::Results {
            name: name.to_owned(),
            routine: self.name.clone(),
            arguments: self.arguments.iter().map(|(_, own)| own.clone()).collect(),
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
