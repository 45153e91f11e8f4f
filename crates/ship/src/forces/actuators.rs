use std::f64::consts::PI;

use refusal::{Invalid, check_name, foreign};

use super::term::Surroundings;
use crate::forces::mass::Prime;
use crate::forces::numbers::{ANGLES, At, Builder, Driven, FORCES, Measured, REVOLUTIONS, driven};
use crate::forces::{Channel, Curve, Inflow, Number, PropellerSpec, Real, RudderSpec, ThrusterSpec};

/// A propeller: thrust T = ρD²(k₀(nD)² + k₁ nD u_P + k₂ u_P²) ahead, and forces of its own astern.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Propeller {
    pub name: String,
    pub revolutions: Driven,
    pub diameter: At,
    thrust: [At; 3],
    deduction: At,
    wake: At,
    wake_change: At,
    wake_ratio: [At; 2],
    place: [At; 2],
    /// Of n|n| and n u_P, in surge, sway and yaw.
    astern: Option<[[At; 2]; 3]>,
}

/// What a propeller does to the water behind it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wash<X> {
    /// Speed of the water that flows to it \[m/s\].
    pub inflow: X,
    /// Speed of its jet far behind it \[m/s\].
    pub jet: X,
    /// Its revolutions times its diameter where it is reversed, else 0 \[m/s\].
    pub reversed: X,
    /// Its diameter \[m\].
    pub diameter: X,
}

impl Propeller {
    /// # Errors
    /// Unknown or unfit channels, numbers that contradict each other, a ship that reverses it without astern coefficients.
    pub fn new(
        spec: &PropellerSpec,
        channels: &[Channel],
        prime: &Prime,
        builder: &mut Builder,
    ) -> Result<Self, Invalid> {
        let name = spec.name.as_str();
        check_name("`name` of a propeller", name)?;
        let revolutions = driven(channels, name, "input", &spec.input, REVOLUTIONS)?;
        check_ahead(spec, &channels[revolutions.channel])?;
        let metres = || Measured::si("m").or_prime(prime.length);
        let mut pure = |key: &str, number: Option<&Number>, default: f64| {
            builder.number(name, key, number, default, Measured::pure())
        };
        let [k_0, k_1, k_2] = spec.thrust.each_ref().map(Some);
        let ratio = |i: usize| spec.wake_ratio.as_ref().map(|ratios| &ratios[i]);
        // In the order of the parameters.
        Ok(Self {
            name: spec.name.clone(),
            revolutions,
            thrust: [pure("thrust.0", k_0, 0.0)?, pure("thrust.1", k_1, 0.0)?, pure("thrust.2", k_2, 0.0)?],
            deduction: pure("deduction", spec.deduction.as_ref(), 0.0)?,
            wake: pure("wake", spec.wake.as_ref(), 0.0)?,
            wake_change: pure("wake_change", spec.wake_change.as_ref(), 0.0)?,
            wake_ratio: [pure("wake_ratio.0", ratio(0), 1.0)?, pure("wake_ratio.1", ratio(1), 1.0)?],
            astern: astern(spec, &mut pure)?,
            diameter: builder.number(
                name,
                "diameter_m",
                Some(&spec.diameter_m),
                0.0,
                metres().above_zero(),
            )?,
            place: [
                builder.number(name, "x_m", spec.x_m.as_ref(), 0.0, metres())?,
                builder.number(name, "y_m", spec.y_m.as_ref(), 0.0, metres())?,
            ],
        })
    }

    /// Whether it has forces at negative revolutions.
    pub fn is_reversed(&self) -> bool {
        self.astern.is_some()
    }

    /// u_P: the speed of the water that flows to it \[m/s\].
    #[inline(always)]
    fn inflow<X: Real>(&self, numbers: &[X], around: &Surroundings<X>) -> X {
        let [u, v, r, speed, ..] = around.motion;
        let turning = (self.place[0].of(numbers) * r).over(speed);
        let drift = v.negated().angle(u.modulus()) - turning;
        let ratio = drift.if_positive(self.wake_ratio[0].of(numbers), self.wake_ratio[1].of(numbers));
        let share = X::ONE - (self.wake_change.of(numbers) * drift.modulus()).negated().exponential();
        (X::ONE - self.wake.of(numbers)) * (X::ONE + share * (ratio - X::ONE)) * u
    }

    /// Its force ahead and to starboard \[N\] and its moment \[N m\], and its wash.
    #[inline(always)]
    pub fn forces<X: Real>(&self, numbers: &[X], around: &Surroundings<X>) -> ([X; 3], Wash<X>) {
        let n = around.driven(self.revolutions);
        let (ahead, reversed) = (n.if_positive(n, X::ZERO), n.if_positive(X::ZERO, n));
        let (diameter, inflow) = (self.diameter.of(numbers), self.inflow(numbers, around));
        let [k_0, k_1, k_2] = self.thrust.map(|number| number.of(numbers));
        let tip = ahead * diameter;
        // Thrust over ρD².
        let thrust = k_0 * tip * tip + k_1 * tip * inflow + k_2 * inflow * inflow;
        let jet = (inflow * inflow + thrust.times(8.0 / PI)).root();
        let wash = Wash { inflow, jet, reversed: reversed * diameter, diameter };
        let square = diameter * diameter * around.density;
        let mut forces = [(X::ONE - self.deduction.of(numbers)) * square * thrust, X::ZERO, X::ZERO];
        if let Some(astern) = &self.astern {
            let [by_square, by_inflow] =
                [wash.reversed * reversed.modulus() * diameter, wash.reversed * inflow];
            let force = |[a, b]: [At; 2]| square * (a.of(numbers) * by_square + b.of(numbers) * by_inflow);
            let [surge, sway, yaw] = astern.map(force);
            forces = [forces[0] + surge, sway, yaw.times(around.length)];
        }
        forces[2] = forces[2] - self.place[1].of(numbers) * forces[0];
        (forces, wash)
    }
}

/// The places of its coefficients astern.
fn astern(
    spec: &PropellerSpec,
    pure: &mut impl FnMut(&str, Option<&Number>, f64) -> Result<At, Invalid>,
) -> Result<Option<[[At; 2]; 3]>, Invalid> {
    let Some(reversed) = &spec.astern else { return Ok(None) };
    let mut both = |key: &str, numbers: Option<&[Number; 2]>| {
        let mut one = |i: usize| pure(&format!("astern.{key}.{i}"), numbers.map(|list| &list[i]), 0.0);
        Ok::<_, Invalid>([one(0)?, one(1)?])
    };
    Ok(Some([
        both("surge", Some(&reversed.surge))?,
        both("sway", reversed.sway.as_ref())?,
        both("yaw", reversed.yaw.as_ref())?,
    ]))
}

/// Refuses an input that reverses a propeller whose thrust law holds ahead only.
fn check_ahead(spec: &PropellerSpec, channel: &Channel) -> Result<(), Invalid> {
    let low = channel.range.map(|[low, _]| low);
    if spec.astern.is_some() || low.is_some_and(|low| low >= 0.0) {
        return Ok(());
    }
    let given = match low {
        Some(low) => format!("`range` of input `{}` from {low}", channel.name),
        None => format!("input `{}` without a `range`", channel.name),
    };
    let expected = "a lowest setting of 0 or more: without `astern` its thrust law holds ahead only";
    let remedy = "state such a `range`, or the coefficients `astern`";
    Err(Invalid::new(format!("[[propeller]] `{}`", spec.name), given, expected, remedy))
}

/// The longest lag and dead time \[s\].
const LONGEST_S: f64 = 1e4;

/// Which way a thruster pushes.
#[derive(Clone, Debug, PartialEq)]
enum Direction {
    /// A channel has its angle.
    Azimuth(Driven),
    /// Its angle is this number \[°\].
    Fixed(At),
}

/// A thruster: its force is the input, or a coefficient times its square.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Thruster {
    input: Driven,
    curve: Curve,
    direction: Direction,
    place: [At; 2],
    ahead: At,
    astern: At,
    /// Of |input| times the speed along it, for a square law.
    loss: Option<At>,
    /// Time constant and dead time \[s\], where they are not 0 for certain.
    pub delay: Option<[At; 2]>,
}

impl Thruster {
    /// # Errors
    /// Unknown or unfit channels, two directions, numbers that are missing or contradict each other.
    pub fn new(
        spec: &ThrusterSpec,
        channels: &[Channel],
        prime: &Prime,
        builder: &mut Builder,
    ) -> Result<Self, Invalid> {
        let name = spec.name.as_str();
        check_name("`name` of a thruster", name)?;
        let square = spec.curve == Curve::Square;
        let input = driven(channels, name, "input", &spec.input, if square { &[] } else { FORCES })?;
        check(spec)?;
        let mut number = |key: &str, number: Option<&Number>, default: f64, measured: Measured| {
            builder.number(name, key, number, default, measured)
        };
        let metres = || Measured::si("m").or_prime(prime.length);
        let unit = channels[input.channel].unit.as_str();
        let coefficient = || match square {
            true => Measured::si(&format!("N per ({unit})²")),
            false => Measured::pure(),
        };
        let direction = match &spec.angle {
            Some(angle) => Direction::Azimuth(driven(channels, name, "angle", angle, ANGLES)?),
            None => Direction::Fixed(number("angle_deg", spec.angle_deg.as_ref(), 0.0, Measured::si("°"))?),
        };
        let place = [
            number("x_m", Some(&spec.x_m), 0.0, metres())?,
            number("y_m", spec.y_m.as_ref(), 0.0, metres())?,
        ];
        let ahead = number("ahead", spec.ahead.as_ref(), 1.0, coefficient())?;
        let astern = match &spec.astern {
            Some(_) => number("astern", spec.astern.as_ref(), 1.0, coefficient())?,
            None => ahead,
        };
        let loss = spec.loss.as_ref();
        let loss = loss
            .map(|_| number("loss", loss, 0.0, Measured::si("N s/m per unit of the input")))
            .transpose()?;
        let seconds = || Measured { range: [0.0, LONGEST_S], ..Measured::si("s") };
        let delay = match (&spec.lag_s, &spec.dead_time_s) {
            (None, None) => None,
            (lag, dead) => Some([
                number("lag_s", lag.as_ref(), 0.0, seconds())?,
                number("dead_time_s", dead.as_ref(), 0.0, seconds())?,
            ]),
        };
        Ok(Self { input, curve: spec.curve, direction, place, ahead, astern, loss, delay })
    }

    /// The channel of its input.
    pub fn input(&self) -> usize {
        self.input.channel
    }

    /// The channels of its input and of its angle.
    pub fn inputs(&self) -> (Driven, Option<Driven>) {
        match self.direction {
            Direction::Azimuth(angle) => (self.input, Some(angle)),
            Direction::Fixed(_) => (self.input, None),
        }
    }

    /// The channel of its angle, which goes around, and half a turn in its unit.
    pub fn turning(&self) -> Option<(usize, f64)> {
        match self.direction {
            Direction::Azimuth(angle) => Some((angle.channel, PI / angle.factor)),
            Direction::Fixed(_) => None,
        }
    }

    /// The force ahead and to starboard \[N\] and the moment \[N m\].
    #[inline(always)]
    pub fn forces<X: Real>(&self, numbers: &[X], around: &Surroundings<X>) -> [X; 3] {
        let input = around.driven(self.input);
        let angle = match self.direction {
            Direction::Azimuth(angle) => around.driven(angle),
            Direction::Fixed(angle) => angle.of(numbers).times(PI / 180.0),
        };
        let (sine, cosine) = angle.sine_and_cosine();
        let [x, y] = self.place.map(|number| number.of(numbers));
        let coefficient = input.if_positive(self.ahead.of(numbers), self.astern.of(numbers));
        let force = match self.loss {
            None if self.curve == Curve::Force => coefficient * input,
            None => coefficient * input * input.modulus(),
            Some(loss) => {
                let [u, v, r, ..] = around.motion;
                let along = (u - y * r) * cosine + (v + x * r) * sine;
                input.modulus() * (coefficient * input - loss.of(numbers) * along)
            }
        };
        [force * cosine, force * sine, force * (x * sine - y * cosine)]
    }
}

/// Refuses keys that say nothing together.
fn check(spec: &ThrusterSpec) -> Result<(), Invalid> {
    let refuse = |given: &str, expected: &str, remedy: &str| {
        Err(Invalid::new(format!("[[thruster]] `{}`", spec.name), given, expected, remedy))
    };
    if spec.angle.is_some() && spec.angle_deg.is_some() {
        return refuse("`angle` and `angle_deg`", "a channel or a fixed angle", "remove one of them");
    }
    match spec.curve {
        Curve::Square if spec.ahead.is_none() => {
            refuse("`curve = \"square\"` without `ahead`", "its coefficient `ahead`", "add it")
        }
        Curve::Force if spec.loss.is_some() => refuse(
            "`loss` of a thruster whose input is its force",
            "`loss` with `curve = \"square\"`",
            "remove it",
        ),
        _ => Ok(()),
    }
}

/// A rudder, as in the MMG standard method, behind a propeller or in open water.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Rudder {
    pub angle: Driven,
    /// The propeller in front of it.
    pub behind: Option<usize>,
    area: At,
    height: At,
    lift_slope: At,
    epsilon: At,
    kappa: At,
    gamma: [At; 2],
    ell: At,
    deduction: At,
    interaction: At,
    interaction_x: At,
    place: [At; 2],
    reversed_flow: At,
    inflow: Inflow,
}

impl Rudder {
    /// # Errors
    /// Unknown or unfit channels, a propeller that does not exist, numbers that are missing or contradict each other.
    pub fn new(
        spec: &RudderSpec,
        propellers: &[Propeller],
        channels: &[Channel],
        prime: &Prime,
        builder: &mut Builder,
    ) -> Result<Self, Invalid> {
        let name = spec.name.as_str();
        check_name("`name` of a rudder", name)?;
        let angle = driven(channels, name, "input", &spec.input, ANGLES)?;
        let behind = behind(spec, propellers)?;
        let length = prime.length;
        let mut number = |key: &str, number: Option<&Number>, default: f64, power: i32| {
            let measured = match power {
                0 => Measured::pure(),
                1 => Measured::si("m").or_prime(length),
                _ => Measured::si("m²").or_prime(length * prime.draught),
            };
            let measured = if key == "height_m" { measured.above_zero() } else { measured };
            builder.number(name, key, number, default, measured)
        };
        let gamma = |i: usize| spec.gamma.as_ref().map(|gamma| &gamma[i]);
        Ok(Self {
            angle,
            behind,
            area: number("area_m2", Some(&spec.area_m2), 0.0, 2)?,
            height: number("height_m", spec.height_m.as_ref(), 1.0, 1)?,
            lift_slope: number("lift_slope", Some(&spec.lift_slope), 0.0, 0)?,
            epsilon: number("epsilon", spec.epsilon.as_ref(), 1.0, 0)?,
            kappa: number("kappa", spec.kappa.as_ref(), 0.0, 0)?,
            gamma: [number("gamma.0", gamma(0), 1.0, 0)?, number("gamma.1", gamma(1), 1.0, 0)?],
            ell: number("ell", spec.ell.as_ref(), -0.5, 0)?,
            deduction: number("deduction", spec.deduction.as_ref(), 0.0, 0)?,
            interaction: number("interaction", spec.interaction.as_ref(), 0.0, 0)?,
            interaction_x: number("interaction_x_m", spec.interaction_x_m.as_ref(), 0.0, 1)?,
            place: [number("x_m", Some(&spec.x_m), 0.0, 1)?, number("y_m", spec.y_m.as_ref(), 0.0, 1)?],
            reversed_flow: number("reversed_flow", spec.reversed_flow.as_ref(), 0.0, 0)?,
            inflow: spec.inflow.unwrap_or(Inflow::Velocity),
        })
    }

    /// u_R: the speed of the flow along it \[m/s\], by the signs of what it is made of, so that it passes through 0 astern.
    #[inline(always)]
    fn along<X: Real>(&self, numbers: &[X], u: X, wash: Option<&Wash<X>>) -> X {
        let epsilon = self.epsilon.of(numbers);
        let Some(wash) = wash else { return epsilon * u };
        let jet = wash.inflow + self.kappa.of(numbers) * (wash.jet - wash.inflow);
        let share = wash.diameter.over(self.height.of(numbers));
        let square = share * jet * jet.modulus() + (X::ONE - share) * wash.inflow * wash.inflow.modulus();
        let along = square.sign() * square.modulus().root();
        epsilon * along + self.reversed_flow.of(numbers) * wash.reversed
    }

    /// v_R: the speed of the flow across it, to port \[m/s\].
    #[inline(always)]
    fn across<X: Real>(&self, numbers: &[X], around: &Surroundings<X>) -> X {
        let [u, v, r, speed, ..] = around.motion;
        let drift = match self.inflow {
            Inflow::Velocity => v.negated(),
            Inflow::Angle => speed * v.negated().angle(u),
        };
        let across = drift - self.ell.of(numbers) * r.times(around.length);
        across.if_positive(self.gamma[0].of(numbers), self.gamma[1].of(numbers)) * across
    }

    /// F_N: the force normal to it, over the density.
    #[inline(always)]
    fn normal<X: Real>(&self, numbers: &[X], angle: X, along: X, across: X) -> X {
        let flow = across.angle(along.modulus());
        let sign = along.negated().if_positive(X::ZERO - X::ONE, X::ONE);
        let (sine, _) = (angle - sign * flow).sine_and_cosine();
        let pressure = (along * along + across * across).times(0.5);
        sign * pressure * self.area.of(numbers) * self.lift_slope.of(numbers) * sine
    }

    /// The force ahead and to starboard \[N\] and the moment \[N m\].
    #[inline(always)]
    pub fn forces<X: Real>(&self, numbers: &[X], around: &Surroundings<X>, wash: Option<&Wash<X>>) -> [X; 3] {
        let angle = around.driven(self.angle);
        let along = self.along(numbers, around.motion[0], wash);
        let normal = self.normal(numbers, angle, along, self.across(numbers, around)) * around.density;
        let (sine, cosine) = angle.sine_and_cosine();
        let interaction = self.interaction.of(numbers);
        let ahead = (X::ONE - self.deduction.of(numbers)) * normal * sine;
        let starboard = normal * cosine;
        let arm = self.place[0].of(numbers) + interaction * self.interaction_x.of(numbers);
        let moment = self.place[1].of(numbers) * ahead - arm * starboard;
        [ahead.negated(), ((X::ONE + interaction) * starboard).negated(), moment]
    }
}

/// The propeller that is named, whose jet needs the rudder's height.
fn behind(spec: &RudderSpec, propellers: &[Propeller]) -> Result<Option<usize>, Invalid> {
    let Some(name) = &spec.behind else { return Ok(None) };
    let thing = format!("`behind` of rudder `{}`", foreign(&spec.name));
    let Some(at) = propellers.iter().position(|propeller| propeller.name == *name) else {
        let given = format!("`{}`", foreign(name));
        let known: Vec<&str> = propellers.iter().map(|propeller| propeller.name.as_str()).collect();
        let expected = match known.is_empty() {
            true => "a [[propeller]], of which there is none".to_owned(),
            false => format!("a propeller: {}", known.join(", ")),
        };
        return Err(Invalid::new(thing, given, expected, "describe that propeller, or remove `behind`"));
    };
    if spec.height_m.is_none() {
        let expected = "`height_m`, which says how much of the rudder is in the jet";
        return Err(Invalid::new(thing, "no `height_m`", expected, "add it"));
    }
    Ok(Some(at))
}
