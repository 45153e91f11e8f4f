use std::f64::consts::PI;

use refusal::{Invalid, check_name};

use crate::forces::channels::{ANGLES, Driven, SPEEDS, driven};
use crate::forces::components::Surroundings;
use crate::forces::mass::Prime;
use crate::forces::numbers::{At, Builder, Measured};
use crate::forces::{Channel, Number, Real, WindSpec};

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
                let found = format!("{} harmonics", numbers.len());
                let thing = format!("`{key}` of wind `{name}`");
                return Err(Invalid::new(thing, found, format!("at most {MOST}"), "remove the others"));
            }
            let one = |(i, own)| {
                builder.number(name, &format!("{key}.{}", i + 1), Some(own), 0.0, Measured::pure())
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
            for (sum, (own, part)) in sums.iter_mut().zip(self.harmonics.iter().zip([cosine, sine, sine])) {
                if let Some(coefficient) = own.get(k) {
                    *sum += coefficient.of(numbers) * part;
                }
            }
        }
        let [frontal, lateral] = self.areas.map(|own| own.of(numbers) * pressure);
        [frontal * sums[0], lateral * sums[1], lateral * sums[2].times(around.length)]
    }
}
