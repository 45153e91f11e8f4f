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
/// Resistance over that of friction: form and waves of usual ships.
const RESISTANCE: f64 = 1.3;
/// Thrust coefficients k₀, k₁, k₂ of a propeller of four blades and a pitch of 0.7 diameters.
const THRUST: [f64; 3] = [0.30, -0.28, -0.14];
/// Drag coefficient of a hull that is towed sideways.
const CROSSFLOW: f64 = 0.8;
/// Added mass ahead over mass.
const ADDED_SURGE: f64 = 0.07;
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
    /// Diameter of the propeller \[m\]; 0.6 draughts without it.
    pub propeller_diameter_m: Option<f64>,
    /// Area of the rudder \[m²\]; by a classification society's rule without it.
    pub rudder_area_m2: Option<f64>,
    /// Height of the rudder \[m\]; 0.75 draughts, or the propeller's diameter if that is more, without it.
    pub rudder_height_m: Option<f64>,
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
        within("the rudder's height", height, heights, "the propeller's diameter to the draught")
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
        let beams = beam_m / length_m;
        let diameter = main.propeller_diameter_m.unwrap_or(rounded(0.6 * draught_m));
        let area = 0.01 * length_m * draught_m * (1.0 + 25.0 * beams * beams);
        Self {
            speed: main.speed_m_s.unwrap_or(rounded(froude * (GRAVITY * length_m).sqrt())),
            mass: main.mass_kg.unwrap_or(rounded(density_kg_m3 * block * length_m * beam_m * draught_m)),
            diameter,
            area: main.rudder_area_m2.unwrap_or(rounded(area)),
            height: main.rudder_height_m.unwrap_or(diameter.max(rounded(0.75 * draught_m))),
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

    /// Clarke, Gedling and Hine 1983: Y_v, Y_r, N_v, N_r in the prime system of ½ρLd, to which their own, of ½ρL², is
    /// converted. Their Y_r has the added mass ahead, which the equations of motion have here.
    fn derivatives(&self) -> [f64; 4] {
        let [by_length, by_draught, depth] = self.ratios();
        let scale = PI * depth;
        [
            -scale * (1.0 + 0.4 * self.main.block * by_draught),
            -scale * (-0.5 + 2.2 * by_length - 0.08 * by_draught) + ADDED_SURGE * self.prime_mass(),
            -scale * (0.5 + 2.4 * depth),
            -scale * (0.25 + 0.039 * by_draught - 0.56 * by_length),
        ]
        .map(rounded)
    }

    /// The same authors' added masses: sway, yaw, sway by yaw acceleration, yaw by sway acceleration.
    fn added_masses(&self) -> [f64; 4] {
        let [by_length, by_draught, depth] = self.ratios();
        let (scale, block) = (PI * depth, self.main.block);
        [
            scale * (1.0 + 0.16 * block * by_draught - 5.1 * by_length * by_length),
            scale * (1.0 / 12.0 + 0.017 * block * by_draught - 0.33 * by_length),
            scale * (0.67 * by_length - 0.0033 * by_draught * by_draught),
            scale * (1.1 * by_length - 0.041 * by_draught),
        ]
        .map(rounded)
    }

    /// Refuses dimensions at which a formula leaves its range: damping that drives, added masses below 0.
    fn check(&self) -> Result<(), Invalid> {
        let [y_v, _, n_v, n_r] = self.derivatives();
        let [sway, yaw, ..] = self.added_masses();
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
    /// what form and waves add.
    fn resistance(&self) -> f64 {
        let [_, by_draught, _] = self.ratios();
        let reynolds = self.speed * self.main.length_m / VISCOSITY;
        let line = libm::log10(reynolds) - 2.0;
        let friction = 0.075 / (line * line);
        rounded(RESISTANCE * friction * (1.7 + self.main.block * by_draught))
    }

    /// Taylor's wake of a single screw.
    fn wake(&self) -> f64 {
        rounded((0.5 * self.main.block - 0.05).max(0.05))
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
                drag: free(CROSSFLOW, 0.4),
                strips: None,
            }],
        }
    }

    fn ship(&self) -> ShipSpec {
        let MainDimensions { length_m, draught_m, .. } = self.main;
        let [sway, yaw, sway_yaw, yaw_sway] = self.added_masses().map(Number::Plain);
        ShipSpec {
            length_m,
            draught_m,
            speed_m_s: self.speed,
            area: None,
            mass_kg: self.mass.into(),
            x_g_m: Some(0.0.into()),
            gyration_m: Some(rounded(0.25 * length_m).into()),
            inertia_kg_m2: None,
            added_mass: AddedMass {
                surge: rounded(ADDED_SURGE * self.prime_mass()).into(),
                sway,
                yaw,
                sway_yaw: Some(sway_yaw),
                yaw_sway: Some(yaw_sway),
            },
            coriolis: None,
        }
    }

    fn terms(&self) -> [Vec<TermSpec>; 3] {
        let [y_v, y_r, n_v, n_r] = self.derivatives();
        let resistance = self.resistance();
        let surge = vec![
            term("X_0", "U^2", -resistance, rounded(0.5 * resistance)),
            term("X_vv", "v^2", 0.0, 0.1),
            term("X_vr", "v r", 0.0, 0.1),
            term("X_rr", "r^2", 0.0, 0.05),
        ];
        let sway = vec![
            term("Y_0", "U^2", 0.0, 0.003),
            term("Y_v", "v U", y_v, 0.3),
            term("Y_r", "r U", y_r, 0.1),
            term("Y_vvr", "v^2 r / U", 0.0, 1.0),
            term("Y_vrr", "v r^2 / U", 0.0, 1.0),
        ];
        let yaw = vec![
            term("N_0", "U^2", 0.0, 0.001),
            term("N_v", "v U", n_v, 0.1),
            term("N_r", "r U", n_r, 0.05),
            term("N_vvr", "v^2 r / U", 0.0, 0.5),
            term("N_vrr", "v r^2 / U", 0.0, 0.3),
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
            diameter_m: self.diameter.into(),
            thrust: THRUST.map(Number::Plain),
            deduction: Some(free(self.deduction(), 0.3)),
            wake: Some(free(self.wake(), 0.3)),
            wake_change: Some(2.0.into()),
            wake_ratio: Some([1.3.into(), 1.3.into()]),
            x_m: Some(self.at(-0.48)),
            y_m: None,
            astern: None,
        }
    }

    fn rudder(&self) -> RudderSpec {
        let aspect = self.height * self.height / self.area;
        RudderSpec {
            name: "rudder".to_owned(),
            input: "delta".to_owned(),
            behind: Some("propeller".to_owned()),
            area_m2: self.area.into(),
            height_m: Some(self.height.into()),
            lift_slope: rounded(6.13 * aspect / (aspect + 2.25)).into(),
            epsilon: Some(free(1.1, 0.4)),
            kappa: Some(free(0.5, 0.3)),
            gamma: Some([free(0.5, 0.4), free(0.5, 0.4)]),
            ell: Some(free(-0.8, 0.5)),
            deduction: Some(free(0.35, 0.4)),
            interaction: Some(free(0.3, 0.4)),
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

fn term(parameter: &str, term: &str, prime: f64, prior: f64) -> TermSpec {
    TermSpec {
        parameter: parameter.to_owned(),
        term: term.to_owned(),
        prime: Some(prime),
        prior: Some(prior),
        ..TermSpec::default()
    }
}

const CLARKE: &str = "Clarke, Gedling and Hine 1983";
const DRAGGED: &str = "0: the cross-flow drag has its part; the prior leaves room for more";
const OPEN: &str = "0 unless known; the prior is that of other ships";
const TANKER: &str = "as of published tankers";

/// Where numbers come from.
const SOURCES: [(&str, &str); 40] = [
    ("X_0", "ITTC 1957 friction on Denny's surface, times 1.3 for form and waves; within half of it"),
    ("X_vv", OPEN),
    ("X_vr", OPEN),
    ("X_rr", OPEN),
    ("Y_0", "0: the hull is symmetric; the screw's side force is small"),
    ("Y_v", CLARKE),
    ("Y_r", "Clarke, Gedling and Hine 1983, without the added mass ahead"),
    ("Y_vvr", DRAGGED),
    ("Y_vrr", DRAGGED),
    ("N_0", "0: the hull is symmetric; the screw's side force is small"),
    ("N_v", CLARKE),
    ("N_r", CLARKE),
    ("N_vvr", DRAGGED),
    ("N_vrr", DRAGGED),
    ("ship.mass_kg", "of the displaced water, unless given"),
    ("ship.x_g_m", "amidships: state it where the trim is known"),
    ("ship.gyration_m", "0.25 lengths, within 10 %"),
    ("ship.speed_m_s", "as given, or by Ayre's relation to the block coefficient"),
    ("ship.added_mass.surge", "7 % of the mass; textbooks have 5 to 10 %"),
    ("ship.added_mass.sway", "Clarke, Gedling and Hine 1983; within about 15 %"),
    ("ship.added_mass.yaw", "Clarke, Gedling and Hine 1983; within about 25 %"),
    ("ship.added_mass.sway_yaw", CLARKE),
    ("ship.added_mass.yaw_sway", CLARKE),
    ("propeller.diameter_m", "0.6 draughts, unless given"),
    ("propeller.thrust.0", "four blades, pitch of 0.7 diameters"),
    ("propeller.deduction", "0.6 of the wake"),
    ("propeller.wake", "Taylor's for one screw: 0.5 C_B - 0.05"),
    ("propeller.wake_change", TANKER),
    ("propeller.wake_ratio", TANKER),
    ("rudder.area_m2", "classification rule: L d (1 + 25 B²/L²) / 100, unless given"),
    ("rudder.height_m", "0.75 draughts, unless given"),
    ("rudder.lift_slope", "Fujii: 6.13 aspect / (aspect + 2.25)"),
    ("rudder.epsilon", TANKER),
    ("rudder.kappa", TANKER),
    ("rudder.gamma.0", TANKER),
    ("rudder.ell", TANKER),
    ("rudder.deduction", TANKER),
    ("rudder.interaction", TANKER),
    ("rudder.interaction_x_m", TANKER),
    ("hull.drag", "drag of a hull towed sideways"),
];
