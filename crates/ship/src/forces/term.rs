//! Terms of hull forces: products of motion and channels, with division.

use std::f64::consts::PI;

use refusal::{Invalid, check_name, foreign};

use crate::forces::mass::Prime;
use crate::forces::numbers::{ANGLES, At, Builder, Driven, Measured, SPEEDS, driven};
use crate::forces::{Channel, CrossflowSpec, Number, Real, TermSpec, WindSpec};

/// Names of what a term can have besides channels; the last four follow from the first two.
pub const MOTION: [&str; 6] = ["u", "v", "r", "U", "U_s", "du"];

/// The motion that terms depend on: u, v, r, U, U_s, du.
pub(crate) type Motion<X> = [X; 6];

/// Added to the square of the speed \[m²/s²\], so that a ship at rest divides by no zero.
pub const LEAST_SQUARE: f64 = 1e-18;

/// The motion of a state, where `speed` is that of the approach \[m/s\].
#[inline(always)]
pub(crate) fn motion<X: Real>([u, v, r]: [X; 3], speed: f64) -> Motion<X> {
    let whole = (u * u + v * v + X::from(LEAST_SQUARE)).root();
    let slow = (0.05 * speed) * (0.05 * speed);
    let signed = (whole * u).over((u * u + X::from(slow)).root());
    [u, v, r, whole, signed, u - X::from(speed)]
}

/// A factor of a term.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Factor {
    /// Its place among the motion u, v, r, U, U_s, du, then the channels.
    pub variable: usize,
    /// Whether it is the modulus.
    pub modulus: bool,
    /// Whether the term is divided by it.
    pub divides: bool,
}

impl Factor {
    /// The channel that it is, if it is none of the motion.
    pub fn channel(self) -> Option<usize> {
        self.variable.checked_sub(MOTION.len())
    }

    /// The name of the motion that it is; empty for a channel.
    pub fn motion(self) -> &'static str {
        MOTION.get(self.variable).copied().unwrap_or_default()
    }

    /// Whether it is the yaw rate.
    pub fn is_yaw_rate(self) -> bool {
        self.motion() == "r"
    }

    /// 1, or −1 where it divides.
    pub fn power(self) -> i32 {
        if self.divides { -1 } else { 1 }
    }
}

/// The factors of a term, each once for every power.
pub(crate) fn factors(spec: &TermSpec, channels: &[Channel]) -> Result<Vec<Factor>, Invalid> {
    Parser { spec, channels }.factors()
}

/// A parameter and what it multiplies.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Term {
    parameter: At,
    /// What one of the prime system is in SI units.
    prime: f64,
    factors: Vec<Factor>,
}

impl Term {
    /// A term of the equation of degree of freedom `d`.
    ///
    /// # Errors
    /// A text that is no term, a division by what can be 0, or numbers that contradict each other.
    pub fn new(
        spec: &TermSpec,
        d: usize,
        channels: &[Channel],
        prime: &Prime,
        builder: &mut Builder,
    ) -> Result<Self, Invalid> {
        let factors = factors(spec, channels)?;
        let measured = measured(spec, &factors, d, channels, prime)?;
        let prime = measured.prime.unwrap_or(1.0);
        let parameter = builder.parameter(&spec.parameter, &spec.number(), measured)?;
        Ok(Self { parameter, prime, factors })
    }

    /// Its powers of v and r together, and what it adds to a force in the prime system where v is `drift` yaw rates and the
    /// yaw rate is 1; none for terms with channels, with `du`, or without v and r.
    pub fn lateral(&self, numbers: &[f64], drift: f64) -> Option<(u32, f64)> {
        let (mut order, mut product) = (0, self.parameter.of(numbers) / self.prime);
        for factor in &self.factors {
            match factor.motion() {
                "v" => {
                    order += factor.power();
                    product *= if factor.modulus { drift.abs() } else { drift };
                }
                "r" => order += factor.power(),
                "u" | "U" | "U_s" => {}
                _ => return None,
            }
        }
        u32::try_from(order).ok().filter(|order| *order > 0).map(|order| (order, product))
    }

    /// What one of the prime system is in SI units.
    pub fn prime(&self) -> f64 {
        self.prime
    }

    /// Its factors, in order.
    pub fn factors(&self) -> &[Factor] {
        &self.factors
    }

    /// Parameter times product.
    #[inline(always)]
    pub fn value<X: Real>(&self, numbers: &[X], motion: &Motion<X>, channel: &impl Fn(usize) -> X) -> X {
        let mut product = self.parameter.of(numbers);
        for factor in &self.factors {
            let variable = match motion.get(factor.variable) {
                Some(value) => *value,
                None => channel(factor.variable - MOTION.len()),
            };
            let variable = if factor.modulus { variable.modulus() } else { variable };
            product = if factor.divides { product.over(variable) } else { product * variable };
        }
        product
    }
}

/// The unit of a term's parameter, and its scale in the prime system.
fn measured(
    spec: &TermSpec,
    factors: &[Factor],
    d: usize,
    channels: &[Channel],
    prime: &Prime,
) -> Result<Measured, Invalid> {
    let (mut speeds, mut rates) = (0_i32, 0_i32);
    let mut units = String::new();
    for factor in factors {
        let sign = factor.power();
        let unit = match factor.channel() {
            None => {
                speeds += sign;
                rates += if factor.variable == 2 { sign } else { 0 };
                if factor.variable == 2 { "rad/s" } else { "m/s" }
            }
            Some(channel) => {
                let unit = channels[channel].unit.as_str();
                if spec.prime.is_some() && !["rad", "1", ""].contains(&unit) {
                    let given =
                        format!("`prime` with channel `{}` in `{}`", channels[channel].name, foreign(unit));
                    let expected = "channels in rad or without a unit in terms of the prime system";
                    return Err(refused(
                        spec,
                        &given,
                        expected,
                        "write the number as `nominal`, in SI units",
                    ));
                }
                unit
            }
        };
        let joint = if factor.divides { " / " } else { " × " };
        units.push_str(if units.is_empty() && !factor.divides { "" } else { joint });
        units.push_str(unit);
    }
    let force = ["N", "N", "N m"][d];
    let unit = if units.is_empty() { force.to_owned() } else { format!("{force} per ({})", units.trim()) };
    let lengths = prime.length.powi(rates + i32::from(d == 2));
    Ok(Measured::si(&unit).or_prime(prime.force() * lengths * prime.speed.powi(2 - speeds)))
}

fn refused(spec: &TermSpec, found: &str, expected: &str, remedy: &str) -> Invalid {
    Invalid::new(called(spec), found, expected, remedy)
}

fn called(spec: &TermSpec) -> String {
    format!("term `{}` of parameter `{}`", foreign(&spec.term), foreign(&spec.parameter))
}

struct Parser<'a> {
    spec: &'a TermSpec,
    channels: &'a [Channel],
}

impl Parser<'_> {
    fn factors(&self) -> Result<Vec<Factor>, Invalid> {
        let text = self.spec.term.trim();
        let (mut factors, mut rest, mut divides) = (Vec::new(), text, false);
        if text.is_empty() {
            return Err(self.malformed("no factor"));
        }
        while !rest.is_empty() {
            rest = self.factor(rest, divides, &mut factors)?;
            if factors.len() > MOST_FACTORS {
                return Err(self.malformed(&format!("more than {MOST_FACTORS} factors")));
            }
            divides = rest.starts_with('/');
            let joined = rest.starts_with(['/', '*']);
            rest = rest.strip_prefix(['/', '*']).unwrap_or(rest).trim_start();
            if joined && rest.is_empty() {
                return Err(self.malformed("nothing after its last `/` or `*`"));
            }
        }
        Ok(factors)
    }

    /// Adds the factor at the start of `text`; returns the rest.
    fn factor<'t>(
        &self,
        text: &'t str,
        divides: bool,
        factors: &mut Vec<Factor>,
    ) -> Result<&'t str, Invalid> {
        if let Some(rest) =
            text.strip_prefix('1').filter(|rest| !rest.starts_with(|c: char| c.is_alphanumeric()))
        {
            return Ok(rest.trim_start());
        }
        let (modulus, name, rest) = parse_name(text).map_err(|fault| self.malformed(&fault))?;
        let variable = self.variable(name)?;
        let (power, rest) = parse_power(rest).map_err(|fault| self.malformed(&fault))?;
        if divides {
            self.check_division(name, variable)?;
        }
        factors.extend(std::iter::repeat_n(Factor { variable, modulus, divides }, power.into()));
        Ok(rest.trim_start())
    }

    fn variable(&self, name: &str) -> Result<usize, Invalid> {
        let known = || MOTION.into_iter().chain(self.channels.iter().map(|channel| channel.name.as_str()));
        match known().position(|known| known == name) {
            Some(variable) => Ok(variable),
            None if name.is_empty() => Err(self.malformed("a character that begins no name")),
            None => Err(Invalid::unknown(called(self.spec), name, known())),
        }
    }

    /// A ship's speed is kept from 0; no other motion is, and channels are only by their range.
    fn check_division(&self, name: &str, variable: usize) -> Result<(), Invalid> {
        if MOTION.get(variable) == Some(&"U") {
            return Ok(());
        }
        let channel = variable.checked_sub(MOTION.len()).and_then(|channel| self.channels.get(channel));
        if channel.and_then(|channel| channel.range).is_some_and(|[low, high]| low > 0.0 || high < 0.0) {
            return Ok(());
        }
        let given = format!("a division by `{name}`, which can be 0");
        let expected = "a division by `U`, or by an input whose `range` is without 0";
        Err(refused(
            self.spec,
            &given,
            expected,
            "state such a `range`, or write the term without this division",
        ))
    }

    fn malformed(&self, found: &str) -> Invalid {
        let expected = "names, |names|, powers from 1 to 9 and divisions, such as `v^2 r / U`";
        refused(self.spec, found, expected, "correct the term")
    }
}

/// What all components see at a moment.
pub(crate) struct Surroundings<'a, X> {
    /// u, v, r, U, U_s, du.
    pub motion: Motion<X>,
    /// The channels.
    pub channel: &'a dyn Fn(usize) -> X,
    /// Density of the water \[kg/m³\].
    pub density: X,
    /// Length of the ship \[m\].
    pub length: f64,
}

impl<X: Real> Surroundings<'_, X> {
    /// A channel in the unit of a component.
    #[inline(always)]
    pub fn driven(&self, driven: Driven) -> X {
        let value = (self.channel)(driven.channel);
        if driven.factor == 1.0 { value } else { value.times(driven.factor) }
    }
}

/// Drag of the water that flows across the hull: ½ρ d C_d |v + x r| (v + x r), summed over strips.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Crossflow {
    draught: At,
    drag: At,
    /// Where the strips are ahead of the origin \[m\].
    strips: Vec<f64>,
    /// Length of a strip \[m\].
    strip: f64,
}

impl Crossflow {
    /// # Errors
    /// Fewer than 2 or more than 1000 strips, or numbers that contradict each other.
    pub fn new(spec: &CrossflowSpec, prime: &Prime, builder: &mut Builder) -> Result<Self, Invalid> {
        let name = spec.name.as_str();
        check_name("`name` of a cross-flow", name)?;
        let strips = spec.strips.unwrap_or(21);
        let metres = Measured::si("m").or_prime(prime.draught);
        let draught = builder.number(name, "draught_m", Some(&spec.draught_m), 0.0, metres)?;
        let drag = builder.number(name, "drag", Some(&spec.drag), 0.0, Measured::pure())?;
        let strip = prime.length / f64::from(strips - 1);
        let strips = (0..strips).map(|i| f64::from(i) * strip - 0.5 * prime.length).collect();
        Ok(Self { draught, drag, strips, strip })
    }

    /// The force to starboard \[N\] and the moment \[N m\].
    #[inline(always)]
    pub fn forces<X: Real>(&self, numbers: &[X], around: &Surroundings<X>) -> [X; 3] {
        let [_, v, r, ..] = around.motion;
        let (mut force, mut moment) = (X::ZERO, X::ZERO);
        for x in &self.strips {
            let across = v + r.times(*x);
            let drag = across * across.modulus();
            force += drag;
            moment += drag.times(*x);
        }
        let factor =
            around.density.times(-0.5 * self.strip) * self.draught.of(numbers) * self.drag.of(numbers);
        [X::ZERO, factor * force, factor * moment]
    }
}

/// Most harmonics of a component of the wind's force.
const MOST: usize = 20;

/// Wind as seen from the ship, on areas above water. It is multiplied here, sample by sample, not in means.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Wind {
    speed: Driven,
    direction: Driven,
    density: At,
    areas: [At; 2],
    /// Coefficients of surge, sway and yaw, from the first harmonic on.
    harmonics: [Vec<At>; 3],
}

impl Wind {
    /// # Errors
    /// Unknown or unfit channels, too many harmonics, numbers that contradict each other.
    pub fn new(
        spec: &WindSpec,
        channels: &[Channel],
        prime: &Prime,
        builder: &mut Builder,
    ) -> Result<Self, Invalid> {
        let name = spec.name.as_str();
        check_name("`name` of a wind", name)?;
        let speed = driven(channels, name, "speed", &spec.speed, SPEEDS)?;
        let direction = driven(channels, name, "direction", &spec.direction, ANGLES)?;
        let area = || Measured::si("m²").or_prime(prime.length * prime.draught);
        let mut all = |key: &str, numbers: &[Number]| {
            if numbers.len() > MOST {
                let given = format!("{} harmonics", numbers.len());
                let thing = format!("`{key}` of wind `{name}`");
                return Err(Invalid::new(thing, given, format!("at most {MOST}"), "remove the others"));
            }
            let one = |(i, number)| {
                builder.number(name, &format!("{key}.{}", i + 1), Some(number), 0.0, Measured::pure())
            };
            numbers.iter().enumerate().map(one).collect::<Result<Vec<_>, _>>()
        };
        let harmonics = [all("surge", &spec.surge)?, all("sway", &spec.sway)?, all("yaw", &spec.yaw)?];
        let air = spec.air_density_kg_m3.as_ref();
        let areas = [
            builder.number(name, "frontal_area_m2", Some(&spec.frontal_area_m2), 0.0, area())?,
            builder.number(name, "lateral_area_m2", Some(&spec.lateral_area_m2), 0.0, area())?,
        ];
        let density = builder.number(name, "air_density_kg_m3", air, 1.225, Measured::si("kg/m³"))?;
        Ok(Self { speed, direction, density, areas, harmonics })
    }

    /// The channels of its speed and direction.
    pub fn inputs(&self) -> [Driven; 2] {
        [self.speed, self.direction]
    }

    /// The channel of its direction, which goes around, and half a turn in its unit.
    pub fn turning(&self) -> (usize, f64) {
        (self.direction.channel, PI / self.direction.factor)
    }

    /// The force ahead and to starboard \[N\] and the moment \[N m\].
    #[inline(always)]
    pub fn forces<X: Real>(&self, numbers: &[X], around: &Surroundings<X>) -> [X; 3] {
        let (speed, direction) = (around.driven(self.speed), around.driven(self.direction));
        let pressure = (self.density.of(numbers) * speed * speed).times(-0.5);
        let most = self.harmonics.iter().map(Vec::len).max().unwrap_or(0);
        let mut sums = [X::ZERO; 3];
        for k in 0..most {
            let (sine, cosine) = direction.times((k + 1) as f64).sine_and_cosine();
            for (sum, (series, part)) in sums.iter_mut().zip(self.harmonics.iter().zip([cosine, sine, sine]))
            {
                if let Some(coefficient) = series.get(k) {
                    *sum += coefficient.of(numbers) * part;
                }
            }
        }
        let [frontal, lateral] = self.areas.map(|area| area.of(numbers) * pressure);
        [frontal * sums[0], lateral * sums[1], lateral * sums[2].times(around.length)]
    }
}

/// Most factors of a term, and of a formula.
pub(crate) const MOST_FACTORS: usize = 32;

/// Whether a modulus is at the start of `text`, the name there, and the rest; the name is empty where none begins.
pub(crate) fn parse_name(text: &str) -> Result<(bool, &str, &str), String> {
    let (modulus, start) = match text.strip_prefix('|') {
        Some(inner) => (true, inner.trim_start()),
        None => (false, text),
    };
    let end = start.find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(start.len());
    let (name, mut after) = start.split_at(end);
    if modulus {
        after = after.trim_start().strip_prefix('|').ok_or("an unclosed `|`")?;
    }
    Ok((modulus, name, after))
}

/// The power at the start of `text`, 1 if there is none, and the rest.
pub(crate) fn parse_power(text: &str) -> Result<(u8, &str), String> {
    let Some(exponent) = text.trim_start().strip_prefix('^') else { return Ok((1, text)) };
    let exponent = exponent.trim_start();
    let end = exponent.find(|c: char| !c.is_ascii_digit()).unwrap_or(exponent.len());
    match exponent[..end].parse() {
        Ok(power @ 1..=9) => Ok((power, &exponent[end..])),
        _ => Err("a power that is no whole number from 1 to 9".to_owned()),
    }
}
