//! A ship from her main dimensions: textbook formulas, each with what it leaves open.

use std::f64::consts::PI;

use refusal::{Invalid, check_ranges};
use schemars::JsonSchema;
use serde::Deserialize;

use crate::forces::{
    AddedMass, CrossflowSpec, Description, Inflow, Number, NumberSpec, PropellerSpec, RudderSpec, ShipSpec,
    TermSpec,
};

/// Kinematic viscosity of water at 15 °C \[m²/s\].
const VISCOSITY: f64 = 1.19e-6;
/// Thrust coefficients k₀, k₁, k₂ of a propeller of four blades and a pitch of 0.7 diameters.
const THRUST: [f64; 3] = [0.30, -0.28, -0.14];
/// Drag coefficient of a hull that moves sideways, beside half of the usual non-linear derivatives.
const CROSSFLOW: f64 = 0.25;
/// Part of the non-linear derivatives of sway and yaw that the cross-flow drag leaves.
const HALF: f64 = 0.5;
/// Added mass ahead in the prime system.
const ADDED_SURGE: f64 = 0.02;
/// Models below this length \[m\] have the larger wake of their thick boundary layer.
const MODEL_M: f64 = 10.0;
/// Standard acceleration of gravity \[m/s²\].
pub const GRAVITY: f64 = 9.80665;
/// Ships are up to so many times as fast as Ayre's relation has them.
const FASTER: f64 = 1.6;

/// Ayre's relation of the block coefficient and the Froude number.
fn ayre(block: f64) -> f64 {
    (1.06 - block) / 1.68
}

/// The greatest usual Froude number of a hull with this block coefficient.
pub fn usual_froude(block: f64) -> f64 {
    FASTER * ayre(block.clamp(0.3, 0.85))
}

/// Density of sea water \[kg/m³\].
fn sea_water() -> f64 {
    1025.0
}

/// What is known of a ship before her first trial.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MainDimensions {
    /// Length between perpendiculars \[m\].
    pub length_m: f64,
    /// Moulded breadth \[m\].
    pub beam_m: f64,
    /// Draught \[m\].
    pub draught_m: f64,
    /// Block coefficient: displaced volume over length, beam and draught.
    pub block: f64,
    /// Density of the water \[kg/m³\]; that of the sea without it.
    #[serde(default = "sea_water")]
    pub density_kg_m3: f64,
    /// Service speed \[m/s\]; that of usual ships of this block coefficient without it.
    pub speed_m_s: Option<f64>,
    /// Mass \[kg\]; that of the displaced water without it.
    pub mass_kg: Option<f64>,
    /// Diameter of the propeller \[m\]; that of usual ships of this block coefficient, with a prior, without it.
    pub propeller_diameter_m: Option<f64>,
    /// Area of the rudder \[m²\]; that of usual ships of this block coefficient, with a prior, without it.
    pub rudder_area_m2: Option<f64>,
    /// Height of the rudder \[m\]; 1.25 of the propeller's diameters, up to the draught, without it.
    pub rudder_height_m: Option<f64>,
    /// Rate of the rudder \[deg/s\]; that which SOLAS asks for, faster for ships below 100 m, without it.
    pub rudder_rate_deg_s: Option<f64>,
    /// Centre of mass ahead of amidships \[m\]; that of usual ships of this block coefficient, with a prior, without it.
    pub x_g_m: Option<f64>,
}

/// A ship that was guessed, with inputs `delta` \[rad\] and `n` \[1/s\].
#[derive(Clone, Debug, PartialEq)]
pub struct Guess {
    /// Her forces. Every free number has a prior.
    pub description: Description,
    /// Revolutions that hold her speed \[1/s\].
    pub revolutions: f64,
    /// Where numbers come from, by the names of parameters or by component and key.
    pub sources: Vec<(String, &'static str)>,
}

impl MainDimensions {
    /// The ship.
    ///
    /// # Errors
    /// Dimensions that no ship has, that contradict each other, or for which a formula gives no ship.
    pub fn guess(&self) -> Result<Guess, Invalid> {
        self.check()?;
        let ship = Guesser::new(*self);
        ship.check()?;
        let description = ship.description();
        let revolutions = ship.revolutions();
        let sources = SOURCES.iter().map(|(name, source)| ((*name).to_owned(), *source)).collect();
        Ok(Guess { description, revolutions, sources })
    }

    fn check(&self) -> Result<(), Invalid> {
        let Self {
            length_m: length, beam_m: beam, draught_m: draught, block, density_kg_m3: density, ..
        } = *self;
        check_ranges([
            ("the length", length, 0.3..=600.0, "m"),
            ("the block coefficient", block, 0.3..=0.95, "of the box of length, beam and draught"),
            ("the density", density, 900.0..=1100.0, "kg/m³"),
        ])?;
        let (beams, draughts) = ((length / 12.0, length / 2.5), (beam / 8.0, beam / 1.2));
        within("the beam", beam, beams, "2.5 to 12 beams in the length")?;
        within("the draught", draught, draughts, "1.2 to 8 draughts in the beam")?;
        let froude = |number: f64| number * (GRAVITY * length).sqrt();
        let given = |number: Option<f64>, usual: f64| number.unwrap_or(usual);
        within(
            "the speed",
            given(self.speed_m_s, froude(0.1)),
            (froude(0.03), froude(0.45)),
            "Froude numbers of 0.03 to 0.45",
        )?;
        let displaced = density * block * length * beam * draught;
        let masses = (0.95 * displaced, 1.05 * displaced);
        within(
            "the mass",
            given(self.mass_kg, displaced),
            masses,
            "the mass of the displaced water within 5 %",
        )?;
        let diameter = given(self.propeller_diameter_m, 0.6 * draught);
        within("the propeller's diameter", diameter, (0.2 * draught, draught), "0.2 to 1 draughts")?;
        let side = length * draught;
        let area = given(self.rudder_area_m2, 0.02 * side);
        within("the rudder's area", area, (0.004 * side, 0.08 * side), "0.4 to 8 % of length times draught")?;
        let height = given(self.rudder_height_m, diameter.max(0.75 * draught));
        let heights = (diameter, draught);
        within("the rudder's height", height, heights, "the propeller's diameter to the draught")?;
        let rate = given(self.rudder_rate_deg_s, 2.3);
        within("the rudder's rate", rate, (0.5, 60.0), "degrees per second")?;
        let ahead = given(self.x_g_m, 0.0);
        within(
            "the centre of mass",
            ahead,
            (-0.08 * length, 0.08 * length),
            "within 8 % of the length of amidships",
        )
    }
}

/// Refuses a number beyond its range, whose ends `meaning` explains.
fn within(thing: &str, number: f64, (low, high): (f64, f64), meaning: &str) -> Result<(), Invalid> {
    if (low..=high).contains(&number) {
        return Ok(());
    }
    let expected = format!("{low:.4} to {high:.4}, {meaning}");
    Err(Invalid::new(thing, number.to_string(), expected, "correct it, or describe such a ship by hand"))
}

/// The ship under construction.
struct Guesser {
    main: MainDimensions,
    speed: f64,
    mass: f64,
    diameter: f64,
    area: f64,
    height: f64,
}

/// With four digits: none of a guess is surer.
fn rounded(number: f64) -> f64 {
    format!("{number:.3e}").parse().unwrap_or(number)
}

impl Guesser {
    fn new(main: MainDimensions) -> Self {
        let MainDimensions { length_m, beam_m, draught_m, block, density_kg_m3, .. } = main;
        let froude = ayre(block).clamp(0.08, 0.35);
        let full = block - 0.7;
        let usual = draught_m * (0.622 - 1.06 * full).clamp(0.3, 0.95);
        let diameter = main.propeller_diameter_m.unwrap_or(rounded(usual));
        let area = 0.0176 * libm::exp(-0.95 * full) * length_m * draught_m;
        Self {
            speed: main.speed_m_s.unwrap_or(rounded(froude * (GRAVITY * length_m).sqrt())),
            mass: main.mass_kg.unwrap_or(rounded(density_kg_m3 * block * length_m * beam_m * draught_m)),
            diameter,
            area: main.rudder_area_m2.unwrap_or(rounded(area)),
            height: main.rudder_height_m.unwrap_or(rounded(diameter / 0.8).min(draught_m)),
            main,
        }
    }

    /// Beam over length, beam over draught, draught over length.
    fn ratios(&self) -> [f64; 3] {
        let MainDimensions { length_m, beam_m, draught_m, .. } = self.main;
        [beam_m / length_m, beam_m / draught_m, draught_m / length_m]
    }

    /// Mass in the prime system of ½ρLd.
    fn prime_mass(&self) -> f64 {
        let MainDimensions { length_m, draught_m, density_kg_m3, .. } = self.main;
        self.mass / (0.5 * density_kg_m3 * length_m * length_m * draught_m)
    }

    /// Y_v, Y_r, N_v, N_r in the prime system of ½ρLd: means of three regressions.
    fn derivatives(&self) -> [f64; 4] {
        let all = [self.clarke(), self.kijima(), self.lee_and_shin()];
        [0, 1, 2, 3].map(|i: usize| rounded(all.iter().map(|one| one[i]).sum::<f64>() / 3.0))
    }

    /// Clarke, Gedling and Hine 1983, converted from their prime system of ½ρL². Their Y_r has the added mass ahead, which the
    /// equations of motion have here.
    fn clarke(&self) -> [f64; 4] {
        let [by_length, by_draught, depth] = self.ratios();
        let scale = PI * depth;
        [
            -scale * (1.0 + 0.4 * self.main.block * by_draught),
            -scale * (-0.5 + 2.2 * by_length - 0.08 * by_draught) + ADDED_SURGE,
            -scale * (0.5 + 2.4 * depth),
            -scale * (0.25 + 0.039 * by_draught - 0.56 * by_length),
        ]
    }

    /// Kijima and others 1990.
    fn kijima(&self) -> [f64; 4] {
        let [by_length, _, depth] = self.ratios();
        let (full, k) = (self.main.block * by_length, 2.0 * depth);
        [-(0.5 * PI * k + 1.4 * full), 0.5 * full + ADDED_SURGE, -k, k * k - 0.54 * k]
    }

    /// Lee and Shin, as public programs have them; not verified in print.
    fn lee_and_shin(&self) -> [f64; 4] {
        let [by_length, by_draught, depth] = self.ratios();
        let (block, slender) = (self.main.block, 1.0 / depth);
        let mass = 2.0 * block * by_length;
        [
            0.065 * block * by_draught - 0.4545,
            mass + ADDED_SURGE - 0.115 * block * by_draught + 0.0024 * slender,
            0.0059 * slender - 0.23,
            0.10446 - 0.003724 * slender - 1.393 * depth,
        ]
    }

    /// The added masses of Clarke and others: sway, yaw.
    fn added_masses(&self) -> [f64; 2] {
        let [by_length, by_draught, depth] = self.ratios();
        let (scale, block) = (PI * depth, self.main.block);
        [
            scale * (1.0 + 0.16 * block * by_draught - 5.1 * by_length * by_length),
            scale * (1.0 / 12.0 + 0.017 * block * by_draught - 0.33 * by_length),
        ]
        .map(rounded)
    }

    /// Refuses dimensions at which a formula leaves its range: damping that drives, added masses below 0.
    fn check(&self) -> Result<(), Invalid> {
        let [y_v, _, n_v, n_r] = self.derivatives();
        let [sway, yaw] = self.added_masses();
        let wrong = [
            ("Y_v", -y_v),
            ("N_v", -n_v),
            ("N_r", -n_r),
            ("the added mass in sway", sway),
            ("the added moment of inertia", yaw),
        ]
        .into_iter()
        .find(|(_, number)| *number <= 0.0);
        let Some((name, _)) = wrong else { return Ok(()) };
        let expected = "dimensions nearer to those of the ships that the formulas were fitted to";
        let given = format!("a sign of {name} that no hull has");
        Err(Invalid::new("the dimensions", given, expected, "describe such a ship by hand"))
    }

    /// Resistance in the prime system: friction by the line of ITTC 1957 on a wetted surface by Denny and Mumford, and
    /// what form and waves add: the latter by the fourth power of the speed over Ayre's.
    fn resistance(&self) -> f64 {
        let [_, by_draught, _] = self.ratios();
        let reynolds = self.speed * self.main.length_m / VISCOSITY;
        let line = libm::log10(reynolds) - 2.0;
        let friction = 0.075 / (line * line);
        let froude = self.speed / (GRAVITY * self.main.length_m).sqrt();
        let fast = (froude / ayre(self.main.block).max(0.05)).min(1.3);
        let more = 1.15 + 0.45 * fast.powi(4);
        rounded(more * friction * (1.7 + self.main.block * by_draught))
    }

    /// Taylor's wake of a single screw, larger for models.
    fn wake(&self) -> f64 {
        let model = if self.main.length_m < MODEL_M { 0.05 } else { 0.0 };
        rounded((0.5 * self.main.block - 0.05).max(0.05) + model)
    }

    fn deduction(&self) -> f64 {
        rounded(0.6 * self.wake())
    }

    /// Revolutions at which thrust, less what the hull loses of it, holds the resistance.
    fn revolutions(&self) -> f64 {
        let MainDimensions { length_m, draught_m, .. } = self.main;
        let force = 0.5 * length_m * draught_m * self.speed * self.speed * self.resistance();
        let inflow = (1.0 - self.wake()) * self.speed;
        let [k_0, k_1, k_2] = THRUST;
        let wanted = force / ((1.0 - self.deduction()) * self.diameter * self.diameter);
        let (half, rest) = (0.5 * k_1 * inflow / k_0, (k_2 * inflow * inflow - wanted) / k_0);
        ((half * half - rest).sqrt() - half) / self.diameter
    }

    fn description(&self) -> Description {
        let MainDimensions { draught_m, density_kg_m3, .. } = self.main;
        let [surge, sway, yaw] = self.terms();
        Description {
            density_kg_m3,
            step_s: None,
            ship: self.ship(),
            surge,
            sway,
            yaw,
            propeller: vec![self.propeller()],
            rudder: vec![self.rudder()],
            thruster: Vec::new(),
            wind: Vec::new(),
            crossflow: vec![CrossflowSpec {
                name: "hull".to_owned(),
                draught_m: draught_m.into(),
                drag: share(CROSSFLOW, 0.35),
                strips: None,
            }],
        }
    }

    fn ship(&self) -> ShipSpec {
        let MainDimensions { length_m, draught_m, block, x_g_m, .. } = self.main;
        let [sway, yaw] = self.added_masses().map(Number::Plain);
        let usual = || free(rounded((0.007 + 0.184 * (block - 0.7)) * length_m), rounded(0.013 * length_m));
        ShipSpec {
            length_m,
            draught_m,
            speed_m_s: self.speed,
            area: None,
            mass_kg: self.mass.into(),
            x_g_m: Some(x_g_m.map_or_else(usual, Number::Plain)),
            gyration_m: Some(rounded(0.25 * length_m).into()),
            inertia_kg_m2: None,
            added_mass: AddedMass { surge: ADDED_SURGE.into(), sway, yaw, sway_yaw: None, yaw_sway: None },
            coriolis: None,
        }
    }

    /// Linear terms by three regressions, non-linear ones by Yoshimura and Masumoto 2012. The priors are by how much published
    /// ships differ.
    fn terms(&self) -> [Vec<TermSpec>; 3] {
        let [y_v, y_r, n_v, n_r] = self.derivatives();
        let [by_length, ..] = self.ratios();
        let (resistance, block, [sway_mass, _]) = (self.resistance(), self.main.block, self.added_masses());
        let (full, fine) = (block * by_length, (1.0 - block) / by_length);
        let turning = self.prime_mass() + ADDED_SURGE - y_r;
        let known = |parameter: &str, term_text: &str, prime: f64, part: f64| {
            term(parameter, term_text, prime, rounded(part * prime.abs()))
        };
        let surge = vec![
            known("X_0", "U^2", -resistance, 0.2),
            term("X_vv", "v^2", rounded(1.15 * full - 0.18), 0.04),
            term("X_vr", "v r", rounded(1.91 * full - 0.08 - sway_mass), 0.03),
            term("X_rr", "r^2", rounded(0.008 - 0.085 * full), 0.01),
            TermSpec {
                fixed: true,
                prior: None,
                ..term("X_vvvv", "v^4 / U^2", rounded(1.1 - 6.68 * full), 0.0)
            },
        ];
        let half = |parameter: &str, term_text: &str, prime: f64, prior: f64| {
            term(parameter, term_text, rounded(HALF * prime), prior)
        };
        // A hull that is pushed sideways by what it drifts or turns, and that turns on by its turning, is none.
        let damping = |parameter: &str, term_text: &str, prime: f64, prior: f64| {
            let one = half(parameter, term_text, prime.min(-0.002), prior);
            TermSpec { bounds: Some([f64::NEG_INFINITY, 0.0]), ..one }
        };
        let sway = vec![
            term("Y_0", "U^2", 0.0, 0.003),
            known("Y_v", "v U", y_v, 0.15),
            term("Y_r", "r U", y_r, rounded(0.05 * turning)),
            damping("Y_vvv", "v^3 / U", -0.185 / by_length - 0.48, 0.18),
            half("Y_vvr", "v^2 r / U", -0.75, 0.25),
            damping("Y_vrr", "v r^2 / U", -0.26 * fine - 0.11, 0.06),
            half("Y_rrr", "r^3 / U", -0.051, 0.015),
        ];
        let yaw = vec![
            term("N_0", "U^2", 0.0, 0.001),
            known("N_v", "v U", n_v, 0.15),
            known("N_r", "r U", n_r, 0.1),
            half("N_vvv", "v^3 / U", 0.69 * block - 0.66, 0.06),
            half("N_vvr", "v^2 r / U", 1.55 * full - 0.76, 0.1),
            half("N_vrr", "v r^2 / U", 0.098 - 0.075 * fine, 0.04),
            damping("N_rrr", "r^3 / U", 0.25 * full - 0.056, 0.005),
        ];
        [surge, sway, yaw]
    }

    /// A place so many lengths ahead of amidships.
    fn at(&self, lengths: f64) -> Number {
        rounded(lengths * self.main.length_m).into()
    }

    fn propeller(&self) -> PropellerSpec {
        PropellerSpec {
            name: "propeller".to_owned(),
            input: "n".to_owned(),
            diameter_m: unless(self.main.propeller_diameter_m, self.diameter, 0.085),
            thrust: THRUST.map(Number::Plain),
            deduction: Some(free(self.deduction(), 0.04)),
            wake: Some(free(self.wake(), 0.05)),
            wake_change: Some(2.0.into()),
            wake_ratio: Some([1.3.into(), 1.3.into()]),
            x_m: Some(self.at(-0.48)),
            y_m: None,
            astern: None,
        }
    }

    fn rudder(&self) -> RudderSpec {
        let aspect = self.height * self.height / self.area;
        let full = self.main.block * self.ratios()[0];
        let epsilon = rounded(2.26 - 1.82 * (1.0 - self.wake()));
        let gamma = rounded(1.1 * (2.06 * full + 0.14));
        RudderSpec {
            name: "rudder".to_owned(),
            input: "delta".to_owned(),
            behind: Some("propeller".to_owned()),
            area_m2: unless(self.main.rudder_area_m2, self.area, 0.12),
            height_m: Some(self.height.into()),
            lift_slope: rounded(6.13 * aspect / (aspect + 2.25)).into(),
            epsilon: Some(share(epsilon, 0.13)),
            kappa: Some(share(rounded(0.55 / epsilon), 0.17)),
            gamma: Some([share(gamma, 0.2), share(gamma, 0.2)]),
            ell: Some(free(-0.87, 0.15)),
            deduction: Some(free(0.32, 0.08)),
            interaction: Some(share(rounded(0.8 * 3.6 * full), 0.25)),
            interaction_x_m: Some(self.at(-0.45)),
            x_m: self.at(-0.5),
            y_m: None,
            reversed_flow: None,
            inflow: Some(Inflow::Angle),
        }
    }
}

fn free(nominal: f64, prior: f64) -> Number {
    Number::Table(NumberSpec { nominal: Some(nominal), prior: Some(prior), ..NumberSpec::default() })
}

/// With a prior of this share of itself.
fn share(nominal: f64, part: f64) -> Number {
    free(nominal, rounded(part * nominal))
}

/// A number that was `given`, or that of usual ships, within this share.
fn unless(given: Option<f64>, usual: f64, part: f64) -> Number {
    given.map_or_else(|| share(usual, part), Number::Plain)
}

fn term(parameter: &str, term: &str, prime: f64, prior: f64) -> TermSpec {
    TermSpec {
        parameter: parameter.to_owned(),
        term: term.to_owned(),
        prime: Some(prime),
        prior: Some(prior),
        ..TermSpec::default()
    }
}

const LINEAR: &str =
    "mean of Clarke, Gedling and Hine 1983, Kijima and others 1990, and Lee and Shin (the last not verified)";
const HALVED: &str = "half of Yoshimura and Masumoto 2012: the cross-flow drag has the rest";
const WHOLE: &str = "Yoshimura and Masumoto 2012";
const SYMMETRIC: &str = "0: the hull is symmetric; the screw's side force is small";
const TANKER: &str = "as of published tankers";
const CLARKE: &str = "Clarke, Gedling and Hine 1983";
const SHIPS: &str = "of ten ships by their block coefficients, unless given";

/// Where numbers come from.
const SOURCES: [(&str, &str); 42] = [
    (
        "X_0",
        "ITTC 1957 friction on Denny's surface, times 1.15 for form and up to 1.3 more for waves (not verified)",
    ),
    ("X_vv", WHOLE),
    ("X_vr", WHOLE),
    ("X_rr", WHOLE),
    ("X_vvvv", WHOLE),
    ("Y_0", SYMMETRIC),
    ("Y_v", LINEAR),
    ("Y_r", LINEAR),
    ("Y_vvv", HALVED),
    ("Y_vvr", HALVED),
    ("Y_vrr", HALVED),
    ("Y_rrr", HALVED),
    ("N_0", SYMMETRIC),
    ("N_v", LINEAR),
    ("N_r", LINEAR),
    ("N_vvv", HALVED),
    ("N_vvr", HALVED),
    ("N_vrr", HALVED),
    ("N_rrr", HALVED),
    ("ship.mass_kg", "of the displaced water, unless given"),
    ("ship.x_g_m", SHIPS),
    ("ship.gyration_m", "0.25 lengths, within 10 %"),
    ("ship.speed_m_s", "as given, or by Ayre's relation to the block coefficient"),
    ("ship.added_mass.surge", "0.02; published ships have it within 30 %"),
    ("ship.added_mass.sway", CLARKE),
    ("ship.added_mass.yaw", CLARKE),
    ("propeller.diameter_m", SHIPS),
    ("propeller.thrust.0", "four blades, pitch of 0.7 diameters"),
    ("propeller.deduction", "0.6 of the wake"),
    ("propeller.wake", "Taylor's for one screw: 0.5 C_B - 0.05, and 0.05 more for models"),
    ("propeller.wake_change", TANKER),
    ("propeller.wake_ratio", TANKER),
    ("rudder.area_m2", SHIPS),
    ("rudder.height_m", "1.25 of the propeller's diameters, unless given"),
    ("rudder.lift_slope", "Fujii: 6.13 aspect / (aspect + 2.25)"),
    ("rudder.epsilon", WHOLE),
    ("rudder.kappa", WHOLE),
    ("rudder.gamma.0", "1.1 times Yoshimura and Masumoto 2012"),
    ("rudder.ell", TANKER),
    ("rudder.deduction", TANKER),
    ("rudder.interaction", "0.8 times Yoshimura and Masumoto 2012"),
    ("hull.drag", "what half of the non-linear derivatives leave; chosen by published ships"),
];
