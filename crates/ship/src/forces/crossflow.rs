use refusal::{Invalid, check_name, check_ranges};

use crate::forces::components::Surroundings;
use crate::forces::mass::Prime;
use crate::forces::numbers::{At, Builder, Measured};
use crate::forces::{CrossflowSpec, Real};

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
        check_ranges([("strips", f64::from(strips), 2.0..=1000.0, "strips")])?;
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
