//! Mass, added mass, and the products of mass and yaw rate.

use refusal::Invalid;

use crate::forces::numbers::{At, Builder, Measured};
use crate::forces::{Area, Coriolis, Real, ShipSpec};

/// What numbers of the prime system are in SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Prime {
    pub density: f64,
    pub length: f64,
    pub draught: f64,
    pub speed: f64,
    area: Area,
}

impl Prime {
    /// Of a ship in water of that density.
    ///
    /// # Errors
    /// A size or speed that is not above 0.
    pub fn new(density: f64, ship: &ShipSpec) -> Result<Self, Invalid> {
        let ShipSpec { length_m: length, draught_m: draught, speed_m_s: speed, area, .. } = ship;
        let area = area.unwrap_or(Area::LengthDraught);
        Ok(Self { density, length: *length, draught: *draught, speed: *speed, area })
    }

    /// ½ρ times the area \[kg/m\].
    pub fn force(&self) -> f64 {
        let width = if self.area == Area::LengthSquared { self.length } else { self.draught };
        0.5 * self.density * self.length * width
    }
}

/// The inertia of a ship.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Mass {
    mass: At,
    x_g: At,
    /// About the centre of gravity the radius of gyration, or about the origin the moment of inertia.
    gyration: Result<At, At>,
    /// Surge, sway, yaw, sway by yaw, yaw by sway.
    added: [At; 5],
    coriolis: Coriolis,
}

/// A mass of unit kg mᵏ.
fn mass(prime: &Prime, unit: &str, power: i32) -> Measured {
    let scale = prime.force() * prime.length * prime.length.powi(power);
    Measured { mass: true, ..Measured::si(unit).or_prime(scale) }
}

impl Mass {
    /// # Errors
    /// Two moments of inertia or none, or numbers that contradict each other.
    pub fn new(ship: &ShipSpec, prime: &Prime, builder: &mut Builder) -> Result<Self, Invalid> {
        let metres = || Measured::si("m").or_prime(prime.length);
        let mass_kg = builder.number("ship", "mass_kg", Some(&ship.mass_kg), 0.0, mass(prime, "kg", 0))?;
        let x_g = builder.number("ship", "x_g_m", ship.x_g_m.as_ref(), 0.0, metres())?;
        let gyration = match (&ship.gyration_m, &ship.inertia_kg_m2) {
            (Some(gyration), None) => {
                let measured = Measured { mass: true, ..metres() };
                Ok(builder.number("ship", "gyration_m", Some(gyration), 0.0, measured)?)
            }
            (None, Some(inertia)) => {
                Err(builder.number("ship", "inertia_kg_m2", Some(inertia), 0.0, mass(prime, "kg m²", 2))?)
            }
            (both, _) => {
                let given =
                    if both.is_some() { "`gyration_m` and `inertia_kg_m2`" } else { "neither of them" };
                let expected = "`gyration_m` or `inertia_kg_m2`";
                return Err(Invalid::new("[ship]", given, expected, "give the one that is known"));
            }
        };
        let added = &ship.added_mass;
        let mut number = |key: &str, written: Option<&crate::forces::Number>, unit: &str, power: i32| {
            let measured = Measured { plain_prime: true, ..mass(prime, unit, power) };
            builder.number("ship.added_mass", key, written, 0.0, measured)
        };
        let added = [
            number("surge", Some(&added.surge), "kg", 0)?,
            number("sway", Some(&added.sway), "kg", 0)?,
            number("yaw", Some(&added.yaw), "kg m²", 2)?,
            number("sway_yaw", added.sway_yaw.as_ref(), "kg m", 1)?,
            number("yaw_sway", added.yaw_sway.as_ref(), "kg m", 1)?,
        ];
        Ok(Self {
            mass: mass_kg,
            x_g,
            gyration,
            added,
            coriolis: ship.coriolis.unwrap_or(Coriolis::WithoutMunk),
        })
    }

    /// The inertia with these numbers.
    pub fn with<X: Real>(&self, numbers: &[X]) -> Inertia<X> {
        let (mass, x_g) = (self.mass.of(numbers), self.x_g.of(numbers));
        let [m_x, m_y, j, a, b] = self.added.map(|number| number.of(numbers));
        let inertia = match self.gyration {
            Ok(gyration) => mass * (gyration.of(numbers).squared() + x_g.squared()),
            Err(inertia) => inertia.of(numbers),
        };
        let first = mass * x_g;
        let [[m_v, m_vr], [m_rv, m_r]] = [[mass + m_y, first + a], [first + b, inertia + j]];
        let determinant = m_v * m_r - m_vr * m_rv;
        let over = |x: X| x.over(determinant);
        let lateral = [[over(m_r), over(m_vr).negated()], [over(m_rv).negated(), over(m_v)]];
        let inverse = (X::ONE.over(mass + m_x), lateral);
        Inertia {
            coriolis: self.coriolis,
            surge: mass + m_x,
            sway: mass + m_y,
            first,
            coupling: (a + b).times(0.5),
            inverse,
        }
    }
}

/// The inertia of a ship, and its inverse.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Inertia<X> {
    coriolis: Coriolis,
    surge: X,
    sway: X,
    /// Mass times x_G.
    first: X,
    /// Added mass of sway and yaw together.
    coupling: X,
    inverse: (X, [[X; 2]; 2]),
}

impl<X: Real> Inertia<X> {
    /// Whether it can be accelerated: every number is finite, and masses are above 0.
    pub fn is_sound(&self, place: X::Place) -> bool {
        let (ahead, lateral) = self.inverse;
        let diagonal = [ahead, lateral[0][0], lateral[1][1]].map(|entry| entry.at(place));
        diagonal.iter().all(|entry| entry.is_finite() && *entry > 0.0)
    }

    /// Changes per second of u, v and r under these forces ahead and to starboard \[N\] and that moment \[N m\].
    #[inline(always)]
    pub fn accelerations(&self, [u, v, r]: [X; 3], forces: [X; 3]) -> [X; 3] {
        let [ahead, starboard, moment] = match self.coriolis {
            Coriolis::Absent => forces,
            Coriolis::WithoutMunk | Coriolis::Full => {
                let surge = self.sway * v * r + self.first * r * r;
                let sway = self.surge * u * r;
                let yaw = self.first * u * r;
                [forces[0] + surge, forces[1] - sway, forces[2] - yaw]
            }
        };
        let (ahead, moment) = match self.coriolis {
            Coriolis::Full => {
                let munk = (self.sway - self.surge) * u * v + self.coupling * u * r;
                (ahead + self.coupling * r * r, moment - munk)
            }
            _ => (ahead, moment),
        };
        let (by_ahead, lateral) = self.inverse;
        [
            ahead * by_ahead,
            lateral[0][0] * starboard + lateral[0][1] * moment,
            lateral[1][0] * starboard + lateral[1][1] * moment,
        ]
    }
}
