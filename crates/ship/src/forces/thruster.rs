use std::f64::consts::PI;

use refusal::{Invalid, check_name};

use crate::forces::channels::{ANGLES, Driven, FORCES, driven};
use crate::forces::components::Surroundings;
use crate::forces::mass::Prime;
use crate::forces::numbers::{At, Builder, Measured};
use crate::forces::{Channel, Curve, Number, Real, ThrusterSpec};

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
            Direction::Azimuth(own) => Some((own.channel, PI / own.factor)),
            Direction::Fixed(_) => None,
        }
    }

    /// The force ahead and to starboard \[N\] and the moment \[N m\].
    #[inline(always)]
    pub fn forces<X: Real>(&self, numbers: &[X], around: &Surroundings<X>) -> [X; 3] {
        let input = around.driven(self.input);
        let angle = match self.direction {
            Direction::Azimuth(own) => around.driven(own),
            Direction::Fixed(own) => own.of(numbers).times(PI / 180.0),
        };
        let (sine, cosine) = angle.sine_and_cosine();
        let [x, y] = self.place.map(|own| own.of(numbers));
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
    let refuse = |found: &str, expected: &str, remedy: &str| {
        Err(Invalid::new(format!("[[thruster]] `{}`", spec.name), found, expected, remedy))
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
