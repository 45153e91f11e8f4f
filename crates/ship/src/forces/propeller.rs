use std::f64::consts::PI;

use refusal::{Invalid, check_name};

use crate::forces::channels::{Driven, REVOLUTIONS, driven};
use crate::forces::components::Surroundings;
use crate::forces::mass::Prime;
use crate::forces::numbers::{At, Builder, Measured};
use crate::forces::{Channel, Number, PropellerSpec, Real};

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
        let [k_0, k_1, k_2] = &spec.thrust;
        let thrust = [
            pure("thrust.0", Some(k_0), 0.0)?,
            pure("thrust.1", Some(k_1), 0.0)?,
            pure("thrust.2", Some(k_2), 0.0)?,
        ];
        let deduction = pure("deduction", spec.deduction.as_ref(), 0.0)?;
        let wake = pure("wake", spec.wake.as_ref(), 0.0)?;
        let wake_change = pure("wake_change", spec.wake_change.as_ref(), 0.0)?;
        let [port, starboard] =
            [0, 1].map(|i: usize| spec.wake_ratio.as_ref().map(|wake_ratio| &wake_ratio[i]));
        let wake_ratio = [pure("wake_ratio.0", port, 1.0)?, pure("wake_ratio.1", starboard, 1.0)?];
        let astern = astern(spec, &mut pure)?;
        let diameter =
            builder.number(name, "diameter_m", Some(&spec.diameter_m), 0.0, metres().above_zero())?;
        let place = [
            builder.number(name, "x_m", spec.x_m.as_ref(), 0.0, metres())?,
            builder.number(name, "y_m", spec.y_m.as_ref(), 0.0, metres())?,
        ];
        let name = spec.name.clone();
        Ok(Self {
            name,
            revolutions,
            diameter,
            thrust,
            deduction,
            wake,
            wake_change,
            wake_ratio,
            place,
            astern,
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
        let [k_0, k_1, k_2] = self.thrust.map(|own| own.of(numbers));
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
    let Some(own) = &spec.astern else { return Ok(None) };
    let mut both = |key: &str, numbers: Option<&[Number; 2]>| {
        let mut one = |i: usize| pure(&format!("astern.{key}.{i}"), numbers.map(|own| &own[i]), 0.0);
        Ok::<_, Invalid>([one(0)?, one(1)?])
    };
    Ok(Some([
        both("surge", Some(&own.surge))?,
        both("sway", own.sway.as_ref())?,
        both("yaw", own.yaw.as_ref())?,
    ]))
}

/// Refuses an input that reverses a propeller whose thrust law holds ahead only.
fn check_ahead(spec: &PropellerSpec, channel: &Channel) -> Result<(), Invalid> {
    let low = channel.range.map(|[low, _]| low);
    if spec.astern.is_some() || low.is_some_and(|low| low >= 0.0) {
        return Ok(());
    }
    let found = match low {
        Some(low) => format!("`range` of input `{}` from {low}", channel.name),
        None => format!("input `{}` without a `range`", channel.name),
    };
    let expected = "a lowest setting of 0 or more: without `astern` its thrust law holds ahead only";
    let remedy = "state such a `range`, or the coefficients `astern`";
    Err(Invalid::new(format!("[[propeller]] `{}`", spec.name), found, expected, remedy))
}
