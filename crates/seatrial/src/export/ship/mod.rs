//! A ship with forces as routines of the generated code: one per component that she has, and their sum.

mod components;
pub(crate) mod expression;
mod language;

use std::collections::BTreeSet;

use ship::forces::{Description, Forces, LEAST_SQUARE, Quantity};

pub(crate) use language::{Language, Names};

use super::text::Identifiers;
use components::{crossflow, hull, propeller, rigid_body, rudder, taken as taken_of_wash, thruster, wind};
use expression::{Expression, Function, Lines, Numbers, Routine};

/// Names that the generated code of a ship has of its own.
pub(crate) const RESERVED: &str = "U U_s accelerations runge_kutta rigid_body rates surge sway yaw if_positive root sign sqrt exp \
    atan2";

/// A ship with forces.
#[derive(Clone, Debug, PartialEq)]
pub struct Ship {
    /// Her components, then the masses that they accelerate.
    pub(crate) routines: Vec<Routine>,
    /// State and channels to accelerations.
    pub(crate) accelerations: Routine,
    /// Steps of Runge and Kutta's method in a sample.
    pub(crate) steps: u32,
    /// The indices of the quantities that it takes, in order: its parameters.
    pub(crate) quantities: Vec<usize>,
}

impl Ship {
    /// The ship with these `quantities`, whose model has the variables `channels`, under identifiers of the code.
    pub(crate) fn new(
        forces: &Forces,
        sample_s: f64,
        quantities: &[Quantity],
        channels: &[String],
        names: &mut Identifiers,
    ) -> Self {
        let numbers = Numbers::new(quantities, channels);
        let (mut routines, mut lines) = (Vec::new(), motion(&numbers));
        let mut sums = [Expression::ZERO, Expression::ZERO, Expression::ZERO];
        let mut add = |routine: Routine, result: String| {
            lines.0.push(routine.called(&result));
            for (d, (sum, force)) in sums.iter_mut().zip(&routine.results).enumerate() {
                if *force != Expression::ZERO {
                    *sum = sum.clone() + Expression::Item(result.clone(), d);
                }
            }
            routines.push(routine);
        };
        let mut taken = |name: &str| [names.take(&format!("{name}_forces")), names.take(name)];
        let description = forces.description();
        if !(description.surge.is_empty() && description.sway.is_empty() && description.yaw.is_empty()) {
            let [name, result] = taken("hull");
            add(hull(forces, &numbers, &name), result);
        }
        let mut washes = Vec::new();
        for (i, spec) in description.propeller.iter().enumerate() {
            let [name, result] = taken(&spec.name);
            let behind =
                description.rudder.iter().enumerate().filter(|(k, _)| forces.rudder_input(*k).1 == Some(i));
            let wash = behind.map(|(_, rudder)| taken_of_wash(rudder)).max().unwrap_or(0);
            add(propeller(forces, i, spec, &numbers, &name, wash), result.clone());
            washes.push((spec.name.as_str(), result));
        }
        for (i, spec) in description.rudder.iter().enumerate() {
            let [name, result] = taken(&spec.name);
            let wash = forces.rudder_input(i).1.map(|k| (washes[k].0, washes[k].1.as_str()));
            add(rudder(forces, i, spec, &numbers, &name, wash), result);
        }
        for (i, spec) in description.thruster.iter().enumerate() {
            let [name, result] = taken(&spec.name);
            add(thruster(forces, i, spec, &numbers, &name), result);
        }
        for (i, spec) in description.wind.iter().enumerate() {
            let [name, result] = taken(&spec.name);
            add(wind(forces, i, spec, &numbers, &name), result);
        }
        for spec in &description.crossflow {
            let [name, result] = taken(&spec.name);
            add(crossflow(spec, &numbers, &name), result);
        }
        let body = rigid_body(forces, &numbers, "rigid_body", sums);
        lines.0.push(body.called("rates"));
        routines.push(body);
        let results = (0..3).map(|d| Expression::Item("rates".to_owned(), d)).collect();
        let comment = "Changes per second of u, v [m/s²] and r [rad/s²].".to_owned();
        let accelerations = Routine {
            name: "accelerations".to_owned(),
            comment,
            arguments: Vec::new(),
            lines: lines.0,
            results,
        };
        let most = description.step_s.unwrap_or(sample_s);
        let steps = (sample_s / most - 1e-9).ceil().max(1.0) as u32;
        let accelerations = accelerations.without_unused();
        let mut ship = Self { routines, accelerations, steps, quantities: Vec::new() };
        ship.quantities = ship.taken_quantities().into_iter().collect();
        ship
    }

    /// Calls `seen` for every value in it.
    pub(crate) fn visit(&self, seen: &mut impl FnMut(&Expression)) {
        self.routines.iter().chain([&self.accelerations]).for_each(|routine| routine.visit(seen));
    }

    /// What `of` finds in its values, in the order in which they stand.
    fn gathered<T>(&self, of: impl Fn(&Expression) -> Option<T>) -> Vec<T> {
        let mut gathered = Vec::new();
        self.visit(&mut |value| gathered.extend(of(value)));
        gathered
    }

    /// The indices of the variables that it takes.
    pub(crate) fn channels(&self) -> BTreeSet<usize> {
        let channel = |value: &Expression| if let Expression::Channel(i) = value { Some(*i) } else { None };
        self.gathered(channel).into_iter().collect()
    }

    /// The indices of the quantities that it takes.
    fn taken_quantities(&self) -> BTreeSet<usize> {
        let quantity = |value: &Expression| if let Expression::Quantity(i) = value { Some(*i) } else { None };
        self.gathered(quantity).into_iter().collect()
    }

    /// The functions that it calls, each once.
    fn functions(&self) -> Vec<Function> {
        let called = |value: &Expression| {
            if let Expression::Call(function, _) = value { Some(*function) } else { None }
        };
        let mut once = Vec::new();
        for function in self.gathered(called) {
            if !once.contains(&function) {
                once.push(function);
            }
        }
        once
    }

    /// The names of the states that its accelerations take.
    pub(crate) fn takes_state(&self, name: &str) -> bool {
        let mut takes = false;
        self.accelerations.visit(&mut |value| takes |= *value == Expression::name(name));
        takes
    }

    /// Its routines as text, the accelerations last; `parameter` writes that at an index, `unpack` names state and inputs.
    pub(crate) fn text(
        &self,
        language: Language,
        parameter: &dyn Fn(usize) -> String,
        channels: &[String],
        unpack: &str,
    ) -> String {
        let of_quantity = |i: usize| self.quantities.binary_search(&i).map(parameter).unwrap_or_default();
        let names = Names { parameter: &of_quantity, channels };
        let routines = self.routines.iter().map(|routine| language.routine(routine, &names));
        let helpers = language.helpers(&self.functions());
        let accelerations = language.accelerations(&self.accelerations, unpack, &names);
        [helpers].into_iter().chain(routines).chain([accelerations]).collect()
    }
}

/// The degree of freedom and the text of the term whose parameter has this name.
pub(crate) fn term(description: &Description, name: &str) -> Option<String> {
    let degrees = [("surge", &description.surge), ("sway", &description.sway), ("yaw", &description.yaw)];
    let mut all = degrees.into_iter().flat_map(|(degree, t)| t.iter().map(move |term| (degree, term)));
    let (degree, term) = all.find(|(_, term)| term.parameter == name)?;
    Some(format!("{degree}: {}", term.term))
}

/// The whole speed, that with the sign of u, and u less the approach speed.
fn motion(numbers: &Numbers) -> Lines {
    let [u, v] = ["u", "v"].map(Expression::name);
    let speed = || numbers.get("ship.speed_m_s");
    let mut lines = Lines::default();
    let whole = u.clone() * u.clone() + v.clone() * v + Expression::Number(LEAST_SQUARE);
    let whole = lines.name("U", whole.square_root(), "whole speed [m/s]");
    let slow = || Expression::Number(0.05) * speed();
    let signed = whole * u.clone() / (u.clone() * u.clone() + slow() * slow()).square_root();
    lines.name("U_s", signed, "the same with the sign of u, smooth around 0 [m/s]");
    lines.name("du", u - speed(), "u less the speed of the approach [m/s]");
    lines
}
