//! The numbers of a ship as values of the generated code.

use std::collections::BTreeMap;

use ship::forces::{Driven, Quantity, QuantitySource};

use super::expression::Expression;

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
    ship::forces::MOTION.iter().map(|own| ((*own).to_owned(), Expression::name(own))).collect()
}
