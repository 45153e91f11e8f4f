//! What no ship is, and what is unusual of ships: most such numbers are mistakes of unit, sign, system or scale.

use refusal::{Invalid, foreign};

use crate::forces::guess::{GRAVITY, usual_froude};
use crate::forces::usual::{of_component, of_powers, powers};
use crate::forces::{Area, Description, Forces};

/// How far beyond its usual size, in standard deviations of its prior, a number may be.
const FAR: f64 = 10.0;
/// Beyond all numbers.
const MOST: f64 = f64::INFINITY;

/// Numbers of components by kind and key, what they are compared with, and four bounds: what no ship is below, what a usual one
/// is not below, not above, and what no ship is above.
const PARTS: [(&str, &str, Over, [f64; 4]); 13] = [
    ("propeller", "diameter_m", Over::Draught, [1e-3, 0.15, 1.2, 10.0]),
    ("propeller", "thrust.0", Over::One, [0.0, 0.05, 1.5, 10.0]),
    ("propeller", "x_m", Over::Length, [-1.1, -0.6, -0.2, 1.1]),
    ("propeller", "y_m", Over::Length, [-0.6, -0.3, 0.3, 0.6]),
    ("rudder", "x_m", Over::Length, [-1.1, -0.6, -0.2, 1.1]),
    ("rudder", "interaction_x_m", Over::Length, [-1.1, -0.7, -0.2, 1.1]),
    ("rudder", "y_m", Over::Length, [-0.6, -0.3, 0.3, 0.6]),
    ("rudder", "area_m2", Over::Side, [1e-6, 0.003, 0.1, 1.0]),
    ("rudder", "height_m", Over::Draught, [1e-3, 0.15, 1.3, 10.0]),
    ("rudder", "lift_slope", Over::One, [0.0, 0.3, 8.0, 100.0]),
    ("thruster", "x_m", Over::Length, [-1.1, -0.6, 0.6, 1.1]),
    ("thruster", "y_m", Over::Length, [-0.6, -0.3, 0.3, 0.6]),
    ("crossflow", "draught_m", Over::Draught, [0.0, 0.3, 1.3, 10.0]),
];

/// Sums of terms of surge, sway and yaw: powers of v and r, in words, and between which they usually are.
const SUMS: [([usize; 2], &str, [f64; 2]); 3] =
    [([0, 0], "U²", [-0.5, -1e-3]), ([1, 0], "v U", [-3.0, -0.03]), ([0, 1], "r U", [-0.5, -3e-3])];

const SPEED: &str = "give the approach's speed in m/s at this length: 1 kn is 0.514 m/s";
const MASS: &str = "give the mass in kg without added mass, and length and draught of the same ship";
const SYSTEM: &str =
    "give numbers of the prime system as `prime`, in that of `area`, and SI units as `nominal`";
const ADDED: &str = "write numbers above 0, where they make her heavier, as −X_u̇, −Y_v̇ and −N_ṙ do: plain ones and `prime` in \
                     the prime system, `nominal` in SI units";
const INERTIA: &str =
    "give the gyration about the centre of gravity in m, or the moment of inertia about the origin in kg m²";

/// What a number of a component is compared with.
#[derive(Clone, Copy)]
enum Over {
    One,
    Length,
    Draught,
    Side,
}

impl Over {
    /// Of what it is a part, and how to give it.
    fn words(self) -> [&'static str; 2] {
        match self {
            Self::One => ["", "correct it: angles are in rad"],
            Self::Length => [
                "of the length",
                "give metres from amidships, ahead and to starboard positive; lengths stand under `prime`",
            ],
            Self::Draught => ["of the draught", "give metres at this ship's scale"],
            Self::Side => ["of length times draught", "give m² at this ship's scale"],
        }
    }
}

/// A number, or what follows from several, and between which it is.
struct Check {
    thing: String,
    found: String,
    ratio: f64,
    bounds: [f64; 4],
    of: &'static str,
    remedy: &'static str,
}

impl Check {
    fn is_within(&self, low: usize, high: usize) -> bool {
        self.bounds[low] <= self.ratio && self.ratio <= self.bounds[high]
    }

    fn refused(&self, low: usize, high: usize, remedy: String) -> Invalid {
        let expected = match (self.bounds[low], self.bounds[high]) {
            (low, MOST) => format!("at least {low} {}", self.of),
            (low, high) if low == -MOST => format!("at most {high} {}", self.of),
            (low, high) => format!("{low} to {high} {}", self.of),
        };
        Invalid::new(self.thing.clone(), self.found.clone(), expected.trim_end(), remedy)
    }
}

impl Forces {
    /// Refuses numbers `theta` with which she is no ship or, unless `accepts_unusual`, an unusual one.
    ///
    /// # Errors
    /// The first number that no ship has, else the first unusual one, with the names of the others.
    pub fn gate(&self, theta: &[f64], accepts_unusual: bool) -> Result<(), Invalid> {
        let checks = StatedNumbers::new(self, theta).checks(self);
        if let Some(check) = checks.iter().find(|check| !check.is_within(0, 3)) {
            return Err(check.refused(0, 3, check.remedy.to_owned()));
        }
        let mut unusual = checks.iter().filter(|check| !check.is_within(1, 2));
        let Some(first) = unusual.next().filter(|_| !accepts_unusual) else { return Ok(()) };
        let mut others: Vec<&str> = unusual.map(|check| check.thing.as_str()).collect();
        others.retain(|thing| *thing != first.thing);
        others.dedup();
        let also =
            if others.is_empty() { String::new() } else { format!("; unusual, too: {}", others.join(", ")) };
        let remedy =
            format!("{}, or write `unusual = \"accepted\"` above the file's tables{also}", first.remedy);
        Err(first.refused(1, 2, remedy))
    }

    /// The greatest usual Froude number of a hull as full as hers, and its speed \[m/s\].
    pub fn usual_speed(&self) -> (f64, f64) {
        let numbers = StatedNumbers::new(self, &self.nominal());
        (numbers.froude(), numbers.froude() * (GRAVITY * numbers.length).sqrt())
    }
}

/// The numbers of a ship.
struct StatedNumbers<'a> {
    ship: &'a Description,
    length: f64,
    draught: f64,
    mass: f64,
    /// Those that are stated, by name, in SI units.
    all: Vec<(String, f64)>,
    checks: Vec<Check>,
}

impl<'a> StatedNumbers<'a> {
    fn new(forces: &'a Forces, theta: &[f64]) -> Self {
        let ship = forces.description();
        let stated = forces.quantities(theta).into_iter().filter(|quantity| quantity.stated);
        let all = stated.map(|stated| (stated.name, stated.value)).collect();
        let (length, draught) = (ship.ship.length_m, ship.ship.draught_m);
        let mut numbers = Self { ship, length, draught, mass: 0.0, all, checks: Vec::new() };
        numbers.mass = numbers.of("ship.mass_kg").unwrap_or_default();
        numbers
    }

    fn of(&self, name: &str) -> Option<f64> {
        self.all.iter().find(|stated| stated.0 == name).map(|stated| stated.1)
    }

    fn put(&mut self, name: &str, found: String, ratio: f64, bounds: [f64; 4], words: [&'static str; 2]) {
        let [of, remedy] = words;
        self.checks.push(Check { thing: format!("`{}`", foreign(name)), found, ratio, bounds, of, remedy });
    }

    fn checks(mut self, forces: &Forces) -> Vec<Check> {
        self.size();
        self.inertia();
        self.derivatives(forces);
        self.components();
        self.checks
    }

    /// Displaced volume over length squared and draught: block coefficient times beam over length.
    fn fullness(&self) -> f64 {
        self.mass / (self.ship.density_kg_m3 * self.length * self.length * self.draught)
    }

    /// The greatest usual Froude number, where the beam is 2.8 draughts as of usual ships.
    fn froude(&self) -> f64 {
        usual_froude(self.fullness() * self.length / (2.8 * self.draught))
    }

    fn size(&mut self) {
        let (length, draught, speed) = (self.length, self.draught, self.ship.ship.speed_m_s);
        let (density, block) = (self.ship.density_kg_m3, 5.0 * self.fullness());
        let given = format!("{density} kg/m³");
        self.put(
            "density_kg_m3",
            given,
            density,
            [0.0, 980.0, 1040.0, MOST],
            ["kg/m³", "give that of the water"],
        );
        let given = format!("{draught} m, {} of the length", short(draught / length));
        self.put("draught_m", given, draught / length, [2e-3, 0.01, 0.18, 0.6], ["of the length", MASS]);
        let [mass, low, high] = [self.mass, block, 1.7 * block].map(short);
        let given =
            format!("{mass} kg: a block coefficient of {low} to {high} with a beam of 1/5 to 1/8.5 lengths");
        self.put("mass_kg", given, block, [0.025, 0.15, 1.0, 5.0], ["with 1/5", MASS]);
        let froude = speed / (GRAVITY * length).sqrt();
        let given = format!("{speed} m/s, a Froude number of {}", short(froude));
        let most = (100.0 * self.froude()).round() / 100.0;
        self.put("speed_m_s", given, froude, [1e-3, 0.01, most, 5.0], ["for a hull as full as this", SPEED]);
        // A full and slow ship has her centre of gravity ahead.
        let aft = if self.fullness() > 0.12 && froude < 0.19 { -0.02 } else { -0.1 };
        let x_g = self.of("ship.x_g_m").unwrap_or_default() / length;
        let words = ["lengths ahead, as of ships that are as full and as fast", Over::Length.words()[1]];
        self.put("x_g_m", format!("{} lengths ahead", short(x_g)), x_g, [-0.5, aft, 0.1, 0.5], words);
    }

    fn inertia(&mut self) {
        let (length, mass) = (self.length, self.mass);
        let x_g = self.of("ship.x_g_m").unwrap_or_default();
        let gyration = self.of("ship.gyration_m").unwrap_or_default();
        let (key, number, square) = match self.of("ship.inertia_kg_m2") {
            Some(inertia) => ("inertia_kg_m2", inertia, inertia / mass - x_g * x_g),
            None => ("gyration_m", gyration, gyration * gyration),
        };
        let share = square.signum() * square.abs().sqrt() / length;
        let given = match square < 0.0 {
            true => {
                format!("{} kg m², less than mass times x_g², {}", short(number), short(mass * x_g * x_g))
            }
            false => format!("{}, a gyration of {} lengths", short(number), short(share)),
        };
        let words = ["lengths about the centre of gravity", INERTIA];
        self.put(key, given, share, [0.0, 0.15, 0.35, 0.5], words);
        for (key, over, [least, low, high]) in [
            ("surge", mass, [0.0, 0.005, 0.5]),
            ("sway", mass, [0.0, 0.1, 6.0]),
            ("yaw", mass * square.abs(), [0.0, 0.03, 15.0]),
            ("sway_yaw", mass * length, [-MOST, -0.5, 0.5]),
            ("yaw_sway", mass * length, [-MOST, -0.5, 0.5]),
        ] {
            let name = format!("ship.added_mass.{key}");
            let Some(number) = self.of(&name).filter(|number| *number != 0.0) else { continue };
            let given = format!("{} in SI units, {} of the ship's own", short(number), short(number / over));
            self.put(&name, given, number / over, [least, low, high, MOST], ["of the ship's own", ADDED]);
        }
    }

    fn derivatives(&mut self, forces: &Forces) {
        // By ½ρL², where the ship's forces are, numbers are smaller.
        let area =
            if self.ship.ship.area == Some(Area::LengthSquared) { self.length / self.draught } else { 1.0 };
        let mut sums = [(0.0, String::new()), (0.0, String::new()), (0.0, String::new())];
        for (d, specs) in self.ship.terms().into_iter().enumerate() {
            for (i, spec) in specs.iter().enumerate() {
                let Some(powers) = powers(forces.factors(d, i)) else { continue };
                let number = self.of(&spec.parameter).unwrap_or_default() / forces.terms[d][i].prime() * area;
                if SUMS[d].0 == powers {
                    sums[d] = (sums[d].0 + number, spec.parameter.clone());
                }
                let Some(deviation) = of_powers(d, powers) else { continue };
                // Resistance of small craft is greater.
                let most = FAR * deviation * if (d, powers) == (0, [0, 0]) { 2.5 } else { 1.0 };
                let given = format!("{} in the prime system of ½ρLd", short(number));
                self.put(&spec.parameter, given, number, [-MOST, -most, most, MOST], ["there", SYSTEM]);
            }
        }
        for ((sum, name), (_, words, [low, high])) in sums.into_iter().zip(SUMS).filter(|sum| sum.0.0 != 0.0)
        {
            let given = format!("{} in the prime system of ½ρLd, all terms in {words}", short(sum));
            let words = ["there: what slows her down is negative", SYSTEM];
            self.put(&name, given, sum, [-MOST, low, high, MOST], words);
        }
    }

    fn components(&mut self) {
        let ship = self.ship;
        for (name, key, deviation) in of_component(ship) {
            let name = format!("{name}.{key}");
            let Some(number) = self.of(&name) else { continue };
            let most = FAR * deviation;
            let words = ["", "give a share of 1, or of the length"];
            self.put(&name, short(number), number, [-MOST, -most, most, MOST], words);
        }
        let propellers = ship.propeller.iter().map(|propeller| ("propeller", &propeller.name));
        let rudders = ship.rudder.iter().map(|rudder| ("rudder", &rudder.name));
        let thrusters = ship.thruster.iter().map(|thruster| ("thruster", &thruster.name));
        let hulls = ship.crossflow.iter().map(|hull| ("crossflow", &hull.name));
        for (kind, name) in propellers.chain(rudders).chain(thrusters).chain(hulls) {
            for (_, key, over, bounds) in PARTS.iter().filter(|part| part.0 == kind) {
                self.part(name, key, *over, *bounds);
            }
        }
    }

    /// A number of a component, if it is stated. Places abeam are on the side that the component is called by.
    fn part(&mut self, owner: &str, key: &str, over: Over, mut bounds: [f64; 4]) {
        let name = format!("{owner}.{key}");
        let Some(number) = self.of(&name) else { return };
        let sides = ["starboard", "port"].map(|side| key == "y_m" && owner.to_lowercase().contains(side));
        match sides {
            [true, false] => bounds[1] = 0.0,
            [false, true] => bounds[2] = 0.0,
            _ => {}
        }
        let size = match over {
            Over::One => 1.0,
            Over::Length => self.length,
            Over::Draught => self.draught,
            Over::Side => self.length * self.draught,
        };
        let near = if bounds[2] == -0.2 && number.abs() < 0.2 * size { "amidships, " } else { "" };
        let given = format!("{}, {near}{} {}", short(number), short(number / size), over.words()[0]);
        self.put(&name, given.trim_end().to_owned(), number / size, bounds, over.words());
    }
}

/// With three digits.
fn short(number: f64) -> String {
    let rounded: f64 = format!("{number:.2e}").parse().unwrap_or(number);
    let plain = rounded == 0.0 || (1e-3..1e6).contains(&rounded.abs());
    if plain { rounded.to_string() } else { format!("{rounded:e}") }
}
