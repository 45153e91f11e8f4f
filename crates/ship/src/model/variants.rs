//! Parameters that a trial cannot determine, because it holds disturbances constant or does not excite their terms.

use std::collections::BTreeMap;
use std::sync::Arc;

use refusal::{Invalid, foreign};

use crate::forces::{Channel, Description, NumberSpec, Similarity};
use crate::model::physics::{VesselFile, described, preset};
use crate::model::{
    Constrained, Constraint, Degree, DegreeOfFreedom, Factor, ForceModel, Formula, Model, ORDER, Product,
    RateChange, Term, Vessel, Written,
};

impl Vessel {
    /// The vessel as simulated trials can identify it. They hold measured disturbances at `simulated`: terms of these are either
    /// zero or a constant that no trial can distinguish from others, so they become known, with their values if these are known.
    #[must_use]
    pub fn with_disturbances_held(self) -> Self {
        // The parameters of forces belong to no terms.
        if self.model.forces.is_some() {
            return self;
        }
        let held = self.held_variables();
        let is_held = |term: &Term| term.products().flatten().any(|Factor { variable, .. }| held[*variable]);
        let degrees = &self.model.degrees;
        let all_of = |degree: &Degree| degree.terms.iter().all(is_held);
        let of_degree = |degree: &Degree| {
            // An equation needs at least one estimated term.
            let none = all_of(degree);
            degree.terms.iter().map(|term| none || !is_held(term)).collect::<Vec<bool>>()
        };
        let kept: Vec<bool> = degrees.iter().flat_map(of_degree).collect();
        self.estimating(&kept)
    }

    /// The vessel with parameter `name` at its value, which is known from then on. A name that it has not changes nothing.
    #[must_use]
    pub fn with_held(self, name: &str) -> Self {
        let kept: Vec<bool> = self.model.parameter_names().map(|parameter| parameter != name).collect();
        self.estimating(&kept)
    }

    /// The vessel of which only those parameters are estimated that are `kept`.
    fn estimating(self, kept: &[bool]) -> Self {
        if !kept.contains(&false) {
            return self;
        }
        let degrees = &self.model.degrees;
        let constrained = self.constrained_but(kept);
        let mut model = self.model.clone();
        let mut first = 0;
        for (degree, whole) in model.degrees.iter_mut().zip(degrees) {
            let values =
                self.nominal.iter().zip(&self.value).map(|(nominal, value)| value.unwrap_or(*nominal));
            let each = values.zip(kept.iter().copied()).skip(first).take(whole.terms.len());
            *degree = without(whole, each);
            first += whole.terms.len();
        }
        let left = |i: &usize| kept[*i];
        let value = (0..kept.len()).filter(left).map(|i| self.value[i]).collect();
        let nominal = (0..kept.len()).filter(left).map(|i| self.nominal[i]).collect();
        Self { model, value, nominal, constrained, ..self }
    }

    /// Per variable, whether simulated trials hold it constant.
    fn held_variables(&self) -> Vec<bool> {
        let mut held = vec![false; self.model.variables.len()];
        self.model.simulated.keys().for_each(|variable| held[*variable] = true);
        for channel in &self.model.derived {
            held[channel.variable] = channel.sources.iter().all(|source| held[*source]);
        }
        held
    }

    /// The constrained parameters if only those that are `kept` are estimated.
    fn constrained_but(&self, kept: &[bool]) -> Vec<Constrained> {
        let known = |i: usize| self.value[i].unwrap_or(self.nominal[i]);
        let place_of = |i: usize| kept[..i].iter().filter(|kept| **kept).count();
        let mut all = self.constrained.clone();
        for parameter in &mut all {
            parameter.constraint = match parameter.constraint {
                Constraint::Tied { to, factor } if kept[to] => Constraint::Tied { to: place_of(to), factor },
                Constraint::Tied { to, factor } => Constraint::Fixed(factor * known(to)),
                fixed => fixed,
            };
        }
        let terms: Vec<(&String, &Term)> = self
            .model
            .degrees
            .iter()
            .flat_map(|degree| degree.parameters.iter().zip(&degree.terms))
            .collect();
        for degree in DegreeOfFreedom::ALL {
            for (place, written) in self.written(degree).into_iter().enumerate() {
                if let Written::Estimated(i) = written
                    && !kept[i]
                {
                    let (name, term) = (terms[i].0.clone(), Term { tied: Vec::new(), ..terms[i].1.clone() });
                    all.push(Constrained {
                        degree,
                        place,
                        name,
                        term,
                        constraint: Constraint::Fixed(known(i)),
                    });
                }
            }
        }
        all.sort_by_key(|parameter| (parameter.degree as usize, parameter.place));
        all
    }
}

/// A degree of freedom in which some terms, with their values, are known.
fn without(degree: &Degree, each: impl Iterator<Item = (f64, bool)>) -> Degree {
    let mut left = Degree { known: degree.known.clone(), intercept: degree.intercept, ..Degree::default() };
    let mut bounds = BTreeMap::new();
    for (i, (value, kept)) in each.enumerate() {
        let term = &degree.terms[i];
        if kept {
            bounds.extend(degree.bounds.get(&i).map(|bound| (left.terms.len(), *bound)));
            left.parameters.push(degree.parameters[i].clone());
            left.terms.push(term.clone());
        } else {
            left.known.push(Product { coefficient: value, factors: term.factors.clone() });
            let tied = term.tied.iter();
            left.known.extend(tied.map(|tied| Product {
                coefficient: value * tied.coefficient,
                factors: tied.factors.clone(),
            }));
        }
    }
    Degree { bounds, ..left }
}

/// Most samples that a step of terms is divided into, and most that are one sample.
const MOST: f64 = 10.0;
const MOST_REPEATED: f64 = 1000.0;

impl Vessel {
    /// The same vessel sampled at another rate \[Hz\]. Forces are integrated in other steps. Terms per sample are repeated, or
    /// divided by Newton's forward formula.
    ///
    /// # Errors
    /// For terms: a rate of which neither is a whole multiple of the other, or above tenfold.
    pub fn at_rate(mut self, rate_hz: f64) -> Result<Self, Invalid> {
        let sample_rate_hz = self.sample_rate_hz;
        self.sample_rate_hz = rate_hz;
        if let Some(moved) = &self.model.forces {
            let forces = moved.forces.clone();
            self.model.forces = Some(Arc::new(ForceModel { forces, sample_s: 1.0 / rate_hz }));
            return Ok(self);
        }
        let refused = |expected: String, remedy: &str| {
            Err(Invalid::new("sampling rate", format!("{rate_hz} Hz wanted"), expected, remedy))
        };
        let whole = |ratio: f64| ((ratio - ratio.round()).abs() <= 1e-9 * ratio).then(|| ratio.round());
        self.model.pace = match (whole(rate_hz / sample_rate_hz), whole(sample_rate_hz / rate_hz)) {
            (Some(1.0), _) => RateChange::Own,
            (Some(by), _) if (2.0..=MOST).contains(&by) => {
                RateChange::Divided { by: by as u32, order: ORDER }
            }
            (_, Some(count)) if (2.0..=MOST_REPEATED).contains(&count) => RateChange::Repeated(count as u32),
            (Some(by), _) if by > MOST => {
                let expected = format!(
                    "at most {} Hz, {MOST} times the vessel's {sample_rate_hz} Hz",
                    MOST * sample_rate_hz
                );
                return refused(expected, "take a lower rate, or a vessel with `model = \"forces\"`");
            }
            _ => {
                let expected = format!("a whole multiple or part of the vessel's {sample_rate_hz} Hz");
                return refused(expected, "take such a rate, or estimate a model at this one");
            }
        };
        Ok(self)
    }
}

/// The channels that forces depend on, of a file.
fn channels(file: &VesselFile) -> Vec<Channel> {
    let channel =
        |name: &str, unit: &str, range| Channel { name: name.to_owned(), unit: unit.to_owned(), range };
    let inputs = file.input.iter().map(|input| channel(&input.name, &input.unit, input.range));
    let measured =
        file.measured.iter().map(|disturbance| channel(&disturbance.name, &disturbance.unit, None));
    let derived = file.derived.iter().map(|derived| channel(&derived.name, &derived.unit, None));
    inputs.chain(measured).chain(derived).collect()
}

impl VesselFile {
    /// The same ship, complete: her preset is put in, and the numbers of \[value\] and \[nominal\] stand at their terms.
    ///
    /// # Errors
    /// What [`Vessel::from_file`] refuses; a ship without forces.
    pub fn completed(self) -> Result<Self, Invalid> {
        let file = if self.preset.is_some() { preset(self)? } else { self };
        Vessel::from_file(file.clone())?;
        let description = described(&file)?.changed(&channels(&file), |name, number| {
            if let Some(value) = file.value.get(name) {
                number.value = Some(*value);
            }
            if let Some(nominal) = file.nominal.get(name) {
                let place = if number.prime.is_some() { &mut number.prime } else { &mut number.nominal };
                *place = Some(*nominal);
            }
        })?;
        Ok(Self {
            preset: None,
            value: Default::default(),
            nominal: Default::default(),
            ..file.with_forces(description)
        })
    }

    /// The same ship, where every free number has a prior: that of `deviations`, its own, or else the usual one; with the
    /// names of those that have the usual one.
    ///
    /// # Errors
    /// A ship without forces; a number of 0 for which nothing is usual.
    pub fn with_usual_priors(self, deviations: &[(String, f64)]) -> Result<(Self, Vec<String>), Invalid> {
        let channels = channels(&self);
        let known = described(&self)?.with_priors(deviations, &channels)?;
        let (description, usual) = known.with_usual_priors(&channels)?;
        Ok((self.with_forces(description), usual))
    }

    /// The same ship without true values, which are not known of another one.
    ///
    /// # Errors
    /// A ship without forces.
    pub fn without_truth(self) -> Result<Self, Invalid> {
        let plain = |number_spec: &mut NumberSpec| {
            let known = number_spec.nominal.is_some() || number_spec.prime.is_some();
            number_spec.value = number_spec.value.filter(|_| !known && number_spec.tied_to.is_none());
        };
        let description = described(&self)?.changed(&channels(&self), |_, number| plain(number))?;
        Ok(self.with_forces(description))
    }

    /// The geometrically similar ship of `length_m` at the same Froude number, in water of this density or in the same.
    /// Her sampling rate has as many samples per length sailed.
    ///
    /// # Errors
    /// A ship without forces, or that is not complete; a length or density that no ship has; a channel or number that no
    /// rule scales.
    pub fn similar(self, length_m: f64, density_kg_m3: Option<f64>) -> Result<Self, Invalid> {
        let description = described(&self)?;
        let by = Similarity::new(&description, length_m, density_kg_m3)?;
        let similar = description.similar(&by, &channels(&self))?;
        let mut file = self.with_forces(similar);
        check_derived(&file, &by)?;
        file.sample_rate_hz = file.sample_rate_hz.map(|rate| by.hertz(rate));
        for input in &mut file.input {
            let unscaled = || unscaled("input", &input.name, &input.unit);
            for end in input.range.iter_mut().flatten().chain(&mut input.dead_band) {
                *end = by.in_unit(*end, &input.unit).ok_or_else(unscaled)?;
            }
            if let Some(rate) = &mut input.rate_per_s {
                *rate = by.per_second(*rate, &input.unit).ok_or_else(unscaled)?;
            }
            input.lag_s = input.lag_s.map(|lag| by.seconds(lag));
            input.hold_s = input.hold_s.map(|hold| by.seconds(hold));
        }
        for disturbance in &mut file.measured {
            if let Some(simulated) = &mut disturbance.simulated {
                let scaled = by.in_unit(*simulated, &disturbance.unit);
                *simulated = scaled
                    .ok_or_else(|| unscaled("measured disturbance", &disturbance.name, &disturbance.unit))?;
            }
        }
        Vessel::from_file(file.clone())?;
        Ok(file)
    }

    fn with_forces(mut self, description: Description) -> Self {
        let Description { density_kg_m3, step_s, ship, surge, sway, yaw, .. } = description;
        (self.density_kg_m3, self.step_s, self.ship) = (Some(density_kg_m3), step_s, Some(ship));
        (self.surge, self.sway, self.yaw) = (surge, sway, yaw);
        (self.propeller, self.rudder, self.thruster) =
            (description.propeller, description.rudder, description.thruster);
        (self.wind, self.crossflow) = (description.wind, description.crossflow);
        self
    }
}

fn unscaled(kind: &str, name: &str, unit: &str) -> Invalid {
    let expected = "a unit that similarity scales, such as rad, 1/s, m/s, N";
    let thing = format!("{kind} `{}`", foreign(name));
    Invalid::new(thing, format!("`{}`", foreign(unit)), expected, "state it in such a unit")
}

/// Refuses derived channels that do not scale as their units do.
fn check_derived(file: &VesselFile, by: &Similarity) -> Result<(), Invalid> {
    let all = channels(file);
    // Rows of a ship and of the similar one, in the order of the channels.
    let first: Vec<f64> = (0..all.len()).map(|i| 0.3 + 0.1 * i as f64).collect();
    for derived in &file.derived {
        let thing = || format!("derived channel `{}`", foreign(&derived.name));
        let Ok(formula) = Formula::parse(&derived.formula) else { continue };
        let mut scaled = Vec::new();
        let mut plain = Vec::new();
        for name in &formula.channels {
            let Some(i) = all.iter().position(|channel| channel.name == *name) else { continue };
            let unit = &all[i].unit;
            plain.push(first[i]);
            scaled.push(by.in_unit(first[i], unit).ok_or_else(|| unscaled("channel", name, unit))?);
        }
        if plain.len() < formula.channels.len() {
            continue;
        }
        let expected = by.in_unit(formula.of(|i| plain[i]), &derived.unit);
        let expected = expected.ok_or_else(|| unscaled("derived channel", &derived.name, &derived.unit))?;
        let computed: f64 = formula.of(|i| scaled[i]);
        if (computed - expected).abs() > 1e-9 * (computed.abs() + expected.abs()) {
            let given = format!(
                "`{}` in `{}`, which do not scale alike",
                foreign(&derived.formula),
                foreign(&derived.unit)
            );
            let expected = "a formula whose unit follows from those of its channels";
            return Err(Invalid::new(
                thing(),
                given,
                expected,
                "correct the unit, or log the channel itself",
            ));
        }
    }
    Ok(())
}

/// `base` with the terms of `lists` for surge, sway and yaw after its own terms, each as text, such as `u |u|`; those that it has
/// already and the constant are left out.
///
/// # Errors
/// A term that cannot be read.
pub fn listed(base: &Model, lists: [&[String]; 3]) -> Result<Model, Invalid> {
    let names: Vec<&str> = base.variables.iter().map(|v| v.name.as_str()).collect();
    let mut model = base.clone();
    for (d, list) in lists.into_iter().enumerate() {
        // The constant is there already.
        for text in list.iter().filter(|text| text.trim() != "1") {
            add(&mut model.degrees[d], d, base, Term::parse(text, &names)?.factors);
        }
    }
    Ok(model)
}

/// Adds the term of `factors`, places among the variables of `base`, to `degree` unless there is one like it. `degree` is that of
/// number `d`, 0 to 2 for surge, sway and yaw; the parameter is named after it and the channels, and as none of `base` is.
pub fn add(degree: &mut Degree, d: usize, base: &Model, factors: Vec<Factor>) {
    let names: Vec<&str> = base.variables.iter().map(|v| v.name.as_str()).collect();
    let form = form(&factors);
    let known = degree.known.iter().map(|known| known.factors.as_slice());
    if form.is_empty()
        || degree
            .terms
            .iter()
            .flat_map(Term::products)
            .chain(known)
            .any(|product| self::form(product) == form)
    {
        return;
    }
    let letter = ["X", "Y", "N"][d];
    let mut name = format!(
        "{letter}_{}",
        text(&factors, "_", |factor, power| {
            let (abs, name) = (if factor.modulus { "abs_" } else { "" }, names[factor.variable]);
            if power > 1 { format!("{abs}{name}_{power}") } else { format!("{abs}{name}") }
        })
    );
    while base.parameter_names().any(|taken| taken == name) {
        name.push_str("_more");
    }
    let text = text(&factors, " ", |factor, power| {
        let name = names[factor.variable];
        let name = if factor.modulus { format!("|{name}|") } else { name.to_owned() };
        if power > 1 { format!("{name}^{power}") } else { name }
    });
    degree.parameters.push(name);
    degree.terms.push(Term::of(text, factors));
}

fn text(factors: &[Factor], between: &str, one: impl Fn(&Factor, usize) -> String) -> String {
    let runs = factors.chunk_by(|a, b| a == b);
    runs.map(|run| one(&run[0], run.len())).collect::<Vec<_>>().join(between)
}

/// By variable its power and whether its sign counts: `|v| v^2` and `|v|^3` are the same.
fn form(factors: &[Factor]) -> Vec<(usize, usize, bool)> {
    let mut variables: Vec<usize> = factors.iter().map(|f| f.variable).collect();
    variables.sort_unstable();
    variables.dedup();
    let of = |variable: usize| {
        let powers = || factors.iter().filter(move |f| f.variable == variable);
        (variable, powers().count(), powers().filter(|f| !f.modulus).count() % 2 == 1)
    };
    variables.into_iter().map(of).collect()
}
