use std::collections::BTreeMap;

use numerics::Arithmetic;
use refusal::{Invalid, choices, foreign, nearest};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::forces::{MOST_FACTORS, parse_power};

choices! {
    /// What a channel is to a search for terms.
    pub enum ChannelRole {
        /// It steers.
        Rudder = "rudder",
        /// A propeller's speed with its sign.
        Propeller = "propeller",
        /// A propeller's speed where it goes ahead, else 0.
        Ahead = "ahead",
        /// A propeller's speed where it goes astern, else 0.
        Astern = "astern",
        /// A thrust, where no propeller's speed is known.
        Thrust = "thrust",
        /// A thruster on port, by its speed or thrust; the first is a pair with the first on starboard, and so on.
        Port = "port",
        /// A thruster on starboard, by its speed or thrust.
        Starboard = "starboard",
        /// The speed of the relative wind.
        Wind = "wind",
        /// The angle that the relative wind comes from, from the bow to starboard.
        WindFrom = "wind-from",
        /// A disturbance that a reflection between port and starboard leaves as it is.
        Even = "even",
        /// A disturbance whose sign a reflection changes.
        Odd = "odd",
    }
}

/// A function of a channel, before it is multiplied with the others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Function {
    /// The channel itself.
    Itself,
    /// `|n|`.
    Modulus,
    /// n where above 0, else 0.
    PositivePart,
    /// n where below 0, else 0.
    NegativePart,
    /// The sine.
    Sine,
    /// The cosine.
    Cosine,
}

/// Names in formulas; [`Function::Itself`] and [`Function::Modulus`] have their own notation.
const FUNCTIONS: [(&str, Function); 4] = [
    ("positive", Function::PositivePart),
    ("negative", Function::NegativePart),
    ("sin", Function::Sine),
    ("cos", Function::Cosine),
];

#[derive(Clone, Debug, PartialEq)]
struct Factor {
    channel: usize,
    function: Function,
    power: i32,
}

#[derive(Clone, Debug, PartialEq)]
struct Monomial {
    coefficient: f64,
    factors: Vec<Factor>,
}

/// A channel computed from others: a product of numbers, channels (`n`), moduli (`|n|`), `positive(n)` (n where above 0,
/// else 0), `negative(n)` (n where below 0, else 0), `sin(a)`, `cos(a)`, each with an optional power `^2`, side by side or
/// with `*` between: `-1 wind^2 cos(gamma)`. Or a sum or difference of such, with blanks around `+` and `-`:
/// `port |port| - starboard |starboard|`.
#[derive(Clone, Debug, PartialEq)]
pub struct Formula {
    /// Its source channels, each once, in the order of appearance; at least one.
    pub channels: Vec<String>,
    /// The summands; at least one.
    products: Vec<Monomial>,
}

/// Why a text is not a [`Formula`].
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("{0}")]
pub struct Malformed(
    /// What is wrong with it.
    pub String,
);

impl Formula {
    /// Parses `text`.
    ///
    /// # Errors
    /// Why it cannot be parsed.
    pub fn parse(text: &str) -> Result<Self, Malformed> {
        let mut formula = Self { channels: Vec::new(), products: Vec::new() };
        let (mut product, mut rest, mut multiplied) = (Monomial::of(1.0), text.trim_start(), true);
        while !rest.is_empty() {
            if let Some((sign, after)) = parse_sign(rest).filter(|_| !multiplied) {
                formula.products.push(std::mem::replace(&mut product, Monomial::of(sign)));
                (rest, multiplied) = (after, true);
                continue;
            }
            let after = formula.parse_factor(&mut product, rest)?;
            rest = after.trim_start();
            multiplied = rest.starts_with('*');
            rest = rest.strip_prefix('*').unwrap_or(rest).trim_start();
        }
        formula.products.push(product);
        if formula.products.iter().any(|product| !product.coefficient.is_finite()) {
            return Err(Malformed("numbers whose product is infinite".to_owned()));
        }
        if formula.products.iter().any(|product| product.factors.is_empty()) {
            return Err(Malformed("no channel".to_owned()));
        }
        if formula.products.iter().map(|product| product.factors.len()).sum::<usize>() > MOST_FACTORS {
            return Err(Malformed(format!("more than {MOST_FACTORS} factors")));
        }
        Ok(formula)
    }

    /// Adds the factor at the start of `text` to `product`; returns the rest.
    fn parse_factor<'a>(&mut self, product: &mut Monomial, text: &'a str) -> Result<&'a str, Malformed> {
        if text.starts_with(|c: char| c.is_ascii_digit() || c == '-' || c == '+' || c == '.') {
            let end = number_end(text);
            let number = text[..end].parse::<f64>().ok().filter(|number| number.is_finite());
            product.coefficient *= number.ok_or_else(|| Malformed(format!("`{}`", &text[..end.max(1)])))?;
            return Ok(&text[end..]);
        }
        let (function, name, after) = parse_operand(text)?;
        let (power, after) = parse_power(after).map_err(Malformed)?;
        let channel = self.channels.iter().position(|c| c == name).unwrap_or_else(|| {
            self.channels.push(name.to_owned());
            self.channels.len() - 1
        });
        product.factors.push(Factor { channel, function, power: power.into() });
        if product.factors.len() > MOST_FACTORS {
            return Err(Malformed(format!("more than {MOST_FACTORS} factors")));
        }
        Ok(after)
    }

    /// The value for the `values` of [`Formula::channels`].
    pub fn evaluate(&self, values: &[f64]) -> f64 {
        self.of(|channel| values[channel])
    }

    /// The value, where `value` returns that of a channel by its index in [`Formula::channels`].
    pub fn of(&self, value: impl Fn(usize) -> f64) -> f64 {
        let products = self.products.iter().map(|product| product.without(usize::MAX, &value));
        products.reduce(|sum, next| sum + next).unwrap_or(0.0)
    }

    /// Whether both are the same product of the same channels up to a constant factor; false for sums.
    pub fn is_multiple_of(&self, other: &Self) -> bool {
        let [powers, others] = [self, other].map(|formula| formula.powers());
        powers.is_some() && powers == others
    }

    /// Whether it is a sum or difference of channels, or half of one: what they measure is what it measures.
    pub fn is_sum_of_channels(&self) -> bool {
        let is_channel = |product: &Monomial| {
            let is_plain =
                matches!(product.factors.as_slice(), [Factor { function: Function::Itself, power: 1, .. }]);
            is_plain && [0.5, 1.0].contains(&product.coefficient.abs())
        };
        self.products.len() > 1 && self.products.iter().all(is_channel)
    }

    /// Channels by name, with their functions and total powers; `None` for a sum of several products.
    fn powers(&self) -> Option<BTreeMap<(&str, u8), i32>> {
        let [product] = self.products.as_slice() else { return None };
        let mut powers = BTreeMap::new();
        for factor in &product.factors {
            let channel = self.channels[factor.channel].as_str();
            *powers.entry((channel, factor.function as u8)).or_insert(0) += factor.power;
        }
        Some(powers)
    }

    /// The formula in another language, in the order of evaluation; `operand` writes a function of the
    /// channel with this index. A power becomes a product of its own.
    pub fn written(&self, operand: impl Fn(Function, usize) -> String) -> String {
        let products: Vec<String> = self.products.iter().map(|product| product.written(&operand)).collect();
        products.join(" + ")
    }

    /// Its derivative by channel `by`, where `value` returns that of a channel by its index in
    /// [`Formula::channels`]. The derivative of a modulus at zero is 0.
    pub fn slope(&self, by: usize, value: impl Fn(usize) -> f64) -> f64 {
        self.products.iter().flat_map(|product| product.slopes(by, &value)).sum()
    }
}

impl Monomial {
    fn of(coefficient: f64) -> Self {
        Self { coefficient, factors: Vec::new() }
    }

    /// The value without one of its factors.
    fn without(&self, left_out: usize, value: &impl Fn(usize) -> f64) -> f64 {
        let others = self.factors.iter().enumerate().filter(|(i, _)| *i != left_out);
        others.fold(self.coefficient, |product, (_, factor)| product * factor.value(value(factor.channel)))
    }

    /// The contributions of its factors to the derivative by channel `by`.
    fn slopes(&self, by: usize, value: &impl Fn(usize) -> f64) -> impl Iterator<Item = f64> {
        let factors = self.factors.iter().enumerate().filter(move |(_, factor)| factor.channel == by);
        factors.map(move |(i, factor)| factor.slope(value(by)) * self.without(i, value))
    }

    fn written(&self, operand: &impl Fn(Function, usize) -> String) -> String {
        let factor = |factor: &Factor| {
            let one = operand(factor.function, factor.channel);
            let all = std::iter::repeat_n(one, factor.power.unsigned_abs() as usize).collect::<Vec<_>>();
            if let [only] = all.as_slice() { only.clone() } else { format!("({})", all.join(" * ")) }
        };
        let number = Some(format!("{:?}", self.coefficient)).filter(|_| self.coefficient != 1.0);
        number.into_iter().chain(self.factors.iter().map(factor)).collect::<Vec<_>>().join(" * ")
    }
}

impl Factor {
    fn value(&self, x: f64) -> f64 {
        self.function.value(x).powi(self.power)
    }

    fn slope(&self, x: f64) -> f64 {
        f64::from(self.power) * self.function.value(x).powi(self.power - 1) * self.function.slope(x)
    }
}

impl Function {
    fn value(self, x: f64) -> f64 {
        match self {
            Self::Itself => x,
            Self::Modulus => x.abs(),
            // Not max or min, which would hide a missing value.
            Self::PositivePart => 0.5 * (x + x.abs()),
            Self::NegativePart => 0.5 * (x - x.abs()),
            Self::Sine => libm::sin(x),
            Self::Cosine => libm::cos(x),
        }
    }

    fn slope(self, x: f64) -> f64 {
        match self {
            Self::Itself => 1.0,
            Self::Modulus => x.sign(),
            Self::PositivePart => 0.5 * (1.0 + x.sign()),
            Self::NegativePart => 0.5 * (1.0 - x.sign()),
            Self::Sine => libm::cos(x),
            Self::Cosine => -libm::sin(x),
        }
    }
}

/// The sign between two products at the start of `text`, which has blanks around it, and the rest.
fn parse_sign(text: &str) -> Option<(f64, &str)> {
    let (sign, after) = text
        .strip_prefix('+')
        .map(|after| (1.0, after))
        .or_else(|| text.strip_prefix('-').map(|after| (-1.0, after)))?;
    after.starts_with(char::is_whitespace).then(|| (sign, after.trim_start()))
}

/// The end of the number at the start of `text`.
fn number_end(text: &str) -> usize {
    let bytes = text.as_bytes();
    let continues = |i: usize| match bytes[i] {
        b'0'..=b'9' | b'.' => true,
        b'+' | b'-' => i == 0 || matches!(bytes[i - 1], b'e' | b'E'),
        b'e' | b'E' => i > 0 && matches!(bytes.get(i + 1), Some(b'0'..=b'9' | b'-' | b'+')),
        _ => false,
    };
    (0..bytes.len()).find(|&i| !continues(i)).unwrap_or(bytes.len())
}

/// Function, channel and the rest.
fn parse_operand(text: &str) -> Result<(Function, &str, &str), Malformed> {
    if let Some(inner) = text.strip_prefix('|') {
        let (name, after) = split_name(inner)?;
        let after = after.strip_prefix('|').ok_or_else(|| Malformed("an unclosed `|`".to_owned()))?;
        return Ok((Function::Modulus, name, after));
    }
    let (name, after) = split_name(text)?;
    let Some(inner) = after.strip_prefix('(') else { return Ok((Function::Itself, name, after)) };
    let known = FUNCTIONS.iter().find(|(known, _)| *known == name);
    let (_, function) = known.ok_or_else(|| Malformed(format!("the function `{name}`")))?;
    let (channel, after) = split_name(inner)?;
    let after = after.strip_prefix(')').ok_or_else(|| Malformed("an unclosed `(`".to_owned()))?;
    Ok((*function, channel, after))
}

fn split_name(text: &str) -> Result<(&str, &str), Malformed> {
    let text = text.trim_start();
    let end = text.find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(text.len());
    if end == 0 {
        let given = text.chars().next().map_or("its end".to_owned(), |c| format!("`{c}`"));
        return Err(Malformed(format!("{given} where a channel should be")));
    }
    Ok((&text[..end], text[end..].trim_start()))
}

/// A channel that is computed from others.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "ModelDerived")]
pub struct DerivedSpec {
    /// Name as used in terms and as a column.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// What it is.
    pub formula: String,
    /// What it is to a search for terms; found by unit and name without it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub role: Option<ChannelRole>,
}

/// A derived channel with its parsed formula.
#[derive(Clone, Debug, PartialEq)]
pub struct DerivedChannel {
    /// Its index in [`crate::model::Model::variables`].
    pub variable: usize,
    /// Its formula.
    pub formula: Formula,
    /// The formula as written.
    pub text: String,
    /// Indices of [`Formula::channels`] in [`crate::model::Model::variables`]: inputs, measured disturbances, other
    /// derived channels.
    pub sources: Vec<usize>,
}

impl DerivedChannel {
    /// Its value in a row of inputs, measured disturbances and derived channels, where the sources are set.
    pub fn value(&self, row: &[f64]) -> f64 {
        self.formula.of(|channel| row[self.sources[channel] - 3])
    }

    /// Whether `found` is `expected` up to rounding.
    pub fn agrees(found: f64, expected: f64) -> bool {
        (found - expected).abs() <= 1e-9 * (found.abs() + expected.abs())
    }
}

/// The channels of `specs`, which are the variables from `first` on with these `names`, each after its sources.
pub(crate) fn derive(
    specs: &[DerivedSpec],
    names: &[&str],
    first: usize,
) -> Result<Vec<DerivedChannel>, Invalid> {
    let one = |(i, spec): (usize, &DerivedSpec)| {
        let formula = Formula::parse(&spec.formula).map_err(|malformed| {
            let given = format!("`{}` with {malformed}", foreign(&spec.formula));
            let expected = "a product such as `positive(n)`, `n |n|` or `-1 wind^2 cos(gamma)`, or a sum such as `port - starboard`";
            refused(&spec.name, &given, expected, "write the formula again")
        })?;
        let sources = formula.channels.iter().map(|name| source(&spec.name, name, names));
        let sources = sources.collect::<Result<_, _>>()?;
        let text = spec.formula.split_whitespace().collect::<Vec<_>>().join(" ");
        Ok(DerivedChannel { variable: first + i, formula, text, sources })
    };
    ordered(specs.iter().enumerate().map(one).collect::<Result<_, _>>()?, names)
}

fn source(of: &str, name: &str, names: &[&str]) -> Result<usize, Invalid> {
    let place = names.iter().position(|known| *known == name);
    if let Some(place) = place.filter(|place| *place >= 3) {
        return Ok(place);
    }
    let known = &names[3..];
    let expected = format!("one of {}", known.join(", "));
    if place.is_some() {
        let remedy = "write the state into the terms that the channel is a factor of";
        return Err(refused(of, &format!("`{name}`, a state"), &expected, remedy));
    }
    let remedy = match nearest(name, known.iter().copied()) {
        Some(near) => format!("did you mean `{near}`?"),
        None => "declare it as [[input]], [[measured]] or [[derived]]".to_owned(),
    };
    Err(refused(of, &format!("`{name}`, which is declared nowhere"), &expected, &remedy))
}

/// Orders the channels so that each follows its sources.
fn ordered(mut left: Vec<DerivedChannel>, names: &[&str]) -> Result<Vec<DerivedChannel>, Invalid> {
    let mut ordered = Vec::with_capacity(left.len());
    while !left.is_empty() {
        let waits =
            |channel: &DerivedChannel| left.iter().find(|other| channel.sources.contains(&other.variable));
        match left.iter().position(|channel| waits(channel).is_none()) {
            Some(ready) => ordered.push(left.remove(ready)),
            None => return Err(circle(&left, names)),
        }
    }
    Ok(ordered)
}

/// The refusal of channels that all wait for another one: from any of them the dependencies lead into a circle.
fn circle(waiting: &[DerivedChannel], names: &[&str]) -> Invalid {
    let name = |place: &usize| names[*place];
    let mut way: Vec<usize> = Vec::new();
    let mut at = waiting.first();
    while let Some(channel) = at.filter(|channel| !way.contains(&channel.variable)) {
        way.push(channel.variable);
        at = waiting.iter().find(|other| channel.sources.contains(&other.variable));
    }
    let start = at.map_or(0, |channel| channel.variable);
    let names: Vec<&str> =
        way.iter().skip_while(|place| **place != start).chain([&start]).map(name).collect();
    let given = format!("a circle: {}", names.join(" from "));
    refused(names[0], &given, "channels that come from inputs and measured disturbances", "break the circle")
}

fn refused(name: &str, found: &str, expected: &str, remedy: &str) -> Invalid {
    Invalid::new(format!("`formula` of derived channel `{name}`"), found, expected, remedy)
}
