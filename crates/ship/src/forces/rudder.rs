use refusal::{Invalid, check_name, foreign};

use crate::forces::channels::{ANGLES, Driven, driven};
use crate::forces::components::Surroundings;
use crate::forces::mass::Prime;
use crate::forces::numbers::{At, Builder, Measured};
use crate::forces::propeller::{Propeller, Wash};
use crate::forces::{Channel, Inflow, Number, Real, RudderSpec};

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
    let Some(at) = propellers.iter().position(|own| own.name == *name) else {
        let found = format!("`{}`", foreign(name));
        let known: Vec<&str> = propellers.iter().map(|own| own.name.as_str()).collect();
        let expected = match known.is_empty() {
            true => "a [[propeller]], of which there is none".to_owned(),
            false => format!("a propeller: {}", known.join(", ")),
        };
        return Err(Invalid::new(thing, found, expected, "describe that propeller, or remove `behind`"));
    };
    if spec.height_m.is_none() {
        let expected = "`height_m`, which says how much of the rudder is in the jet";
        return Err(Invalid::new(thing, "no `height_m`", expected, "add it"));
    }
    Ok(Some(at))
}
