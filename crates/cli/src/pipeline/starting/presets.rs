//! Ships that a new study can begin with.

use logs::guess::Needed;
use refusal::Invalid;
use ship::model::VesselFile;

/// A ship that a new study can begin with.
#[derive(Debug)]
pub struct Preset {
    /// Its name.
    pub name: &'static str,
    /// What it is, in a few words.
    pub about: &'static str,
    vessel: &'static str,
    dictionary: &'static str,
    campaign: &'static str,
    flags: &'static str,
    /// Inputs as a table, if a maneuver plays one.
    table: Option<(&'static str, &'static str)>,
    /// The thrusters that its forces are made by, as `ingest.toml` has them.
    thrusters: Option<&'static str>,
    /// `plan.toml` with places to be filled in, and the side of its area \[m\]; none for a ship whose speed nothing commands.
    plan: Option<(&'static str, f64)>,
}

macro_rules! preset {
    ($name:literal, $about:literal, $table:expr, $thrusters:expr, $plan:expr) => {
        Preset {
            name: $name,
            about: $about,
            vessel: include_str!(concat!("../../../presets/", $name, "/vessel.toml")),
            dictionary: include_str!(concat!("../../../presets/", $name, "/dictionary.toml")),
            campaign: include_str!(concat!("../../../presets/", $name, "/campaign.toml")),
            flags: include_str!(concat!("../../../presets/", $name, "/study.mk")),
            table: $table,
            thrusters: $thrusters,
            plan: $plan,
        }
    };
}

/// All of them.
pub const PRESETS: [Preset; 9] = [
    preset!(
        "model-ship",
        "a model ship of 1 m with two azimuth thrusters aft",
        None,
        Some(include_str!("../../../presets/model-ship/thrusters.toml")),
        Some((include_str!("../../../presets/model-ship/plan.toml.in"), 300.0))
    ),
    preset!(
        "coaster",
        "a coaster of 100 m with rudder and propeller, for standard maneuvers",
        None,
        None,
        Some((include_str!("../../../presets/coaster/plan.toml.in"), 16_000.0))
    ),
    preset!(
        "full-scale",
        "a ship of 30 m with azimuth thrusters fore and aft",
        None,
        Some(include_str!("../../../presets/full-scale/thrusters.toml")),
        Some((include_str!("../../../presets/full-scale/plan.toml.in"), 7_000.0))
    ),
    preset!(
        "kvlcc2",
        "a 7 m model of the tanker KVLCC2, with rudder and measured thrust",
        None,
        None,
        Some((include_str!("../../../presets/kvlcc2/plan.toml.in"), 2_800.0))
    ),
    preset!(
        "esso-osaka",
        "a 3 m model of the tanker Esso Osaka, with rudder and propeller",
        Some(("crash-stop.csv", include_str!("../../../presets/esso-osaka/crash-stop.csv"))),
        None,
        Some((include_str!("../../../presets/esso-osaka/plan.toml.in"), 600.0))
    ),
    preset!(
        "esso-osaka-3m",
        "a 3 m model of the tanker Esso Osaka, by forces",
        None,
        None,
        Some((include_str!("../../../presets/esso-osaka-3m/plan.toml.in"), 900.0))
    ),
    preset!("mariner", "the cargo ship Mariner of 160.93 m, by hydrodynamic derivatives", None, None, None),
    preset!(
        "kvlcc2-l7",
        "a 7 m model of the tanker KVLCC2, by the MMG standard method",
        None,
        None,
        Some((include_str!("../../../presets/kvlcc2-l7/plan.toml.in"), 2_100.0))
    ),
    preset!(
        "otter",
        "the uncrewed vessel Otter of 2 m with two propellers, by forces",
        None,
        None,
        Some((include_str!("../../../presets/otter/plan.toml.in"), 500.0))
    ),
];

impl Preset {
    /// The preset called `name`.
    ///
    /// # Errors
    /// No such preset: names them and the nearest.
    pub fn named(name: &str) -> Result<&'static Self, Invalid> {
        let unknown = || Invalid::unknown("preset", name, PRESETS.iter().map(|own| own.name));
        PRESETS.iter().find(|own| own.name == name).ok_or_else(unknown)
    }

    /// The files of a study of it that is simulated.
    pub(super) fn files(&self) -> impl Iterator<Item = (&'static str, &'static str)> {
        let own = [
            ("vessel.toml", self.vessel),
            ("dictionary.toml", self.dictionary),
            ("campaign.toml", self.campaign),
            ("study.mk", self.flags),
        ];
        own.into_iter().chain(self.table)
    }

    /// Its maneuvers.
    pub(super) fn dictionary(&self) -> &'static str {
        self.dictionary
    }

    /// Its simulated trials.
    pub(super) fn campaign(&self) -> &'static str {
        self.campaign
    }

    /// The thrusters that its forces are made by, as `ingest.toml` has them; empty if its inputs are logged.
    pub(super) fn thrusters(&self) -> &'static str {
        self.thrusters.unwrap_or_default()
    }

    /// Its `plan.toml` with places to be filled in, and the side of the area \[m\].
    ///
    /// # Errors
    /// A ship whose speed nothing commands: names those that have one.
    pub(super) fn plan(&self) -> Result<(&'static str, f64), Invalid> {
        self.plan.ok_or_else(|| {
            let others = PRESETS.iter().filter(|own| own.plan.is_some()).map(|own| own.name);
            let expected =
                format!("a ship whose speed can be commanded: {}", others.collect::<Vec<_>>().join(", "));
            let found = format!("{}, {}", self.name, self.about);
            Invalid::new("--chart", found, expected, "begin with one of them")
        })
    }

    /// `vessel.toml` without true parameters, which no real ship has, and with the relative wind where that `is_logged`.
    pub(super) fn without_truth(&self, is_wind_logged: bool) -> String {
        let lines = self.vessel.lines().filter(|line| !line.starts_with("value = "));
        let mut text: String = lines.map(|line| format!("{}\n", without_value(line))).collect();
        for (degree, asymmetry) in STRAIGHT_AHEAD {
            let name = &asymmetry[..3];
            let has_primes = self.is_of_forces() && text.contains("prime = ");
            if has_primes && !text.contains(&format!("\"{name}\"")) {
                let line = format!("  {{ parameter = \"{name}\", term = \"U^2\", {} }},", &asymmetry[4..]);
                text = text.replacen(&format!("\n{degree} = [\n"), &format!("\n{degree} = [\n{line}\n"), 1);
            }
        }
        if is_wind_logged {
            text += MEASURED_WIND;
            text += if self.is_of_forces() { WIND_FORCES } else { "" };
        }
        text
    }

    /// The channels that logs of it must have: speeds and angles of its thrusters, or else its inputs.
    pub(super) fn needed(&self) -> Vec<Needed> {
        let own = |channel: &str, unit: &str| Needed { channel: channel.to_owned(), unit: unit.to_owned() };
        let named = |key: &str, unit: &str| {
            let quoted = |line: &str| Some(line.strip_prefix(key)?.split('"').nth(1)?.to_owned());
            self.thrusters().lines().filter_map(quoted).map(|name| own(&name, unit)).collect::<Vec<_>>()
        };
        let thrusters = [named("speed = ", "1/s"), named("angle = ", "rad")].concat();
        if !thrusters.is_empty() {
            return thrusters;
        }
        // A preset that cannot be parsed needs nothing; a test parses all.
        let vessel = self.vessel.parse::<VesselFile>();
        vessel.map_or(Vec::new(), |vessel| {
            vessel.input.iter().map(|input| own(&input.name, &input.unit)).collect()
        })
    }

    /// Whether forces describe it, in continuous time.
    pub(super) fn is_of_forces(&self) -> bool {
        self.vessel.parse::<VesselFile>().is_ok_and(|vessel| vessel.is_of_forces())
    }

    /// The rate of its model \[Hz\].
    pub(super) fn sample_rate_hz(&self) -> f64 {
        self.vessel.parse::<VesselFile>().ok().and_then(|vessel| vessel.sample_rate_hz).unwrap_or(1.0)
    }
}

/// The force and the moment straight ahead, which logs show and a symmetric hull does not have.
const STRAIGHT_AHEAD: [(&str, &str); 2] =
    [("sway", "Y_0 prime = 0.0, prior = 0.003"), ("yaw", "N_0 prime = 0.0, prior = 0.001")];

/// Channels of a logged wind, as `vessel.toml` has them.
const MEASURED_WIND: &str = r#"
# Speed of the relative wind, and where it comes from, from the bow to starboard. Simulated trials have none.
[[measured]]
name = "wind"
unit = "m/s"
simulated = 0.0

[[measured]]
name = "wind_from"
unit = "rad"
simulated = 0.0
"#;

/// Its forces on a ship of which nothing above water is known: areas as parts of length times draught, usual coefficients of a bluff body.
const WIND_FORCES: &str = r#"
[[wind]]
name = "air"
speed = "wind"
direction = "wind_from"
frontal_area_m2 = { prime = 0.2, fixed = true }
lateral_area_m2 = { prime = 0.5, fixed = true }
surge = [{ nominal = 0.7, prior = 0.5 }]
sway = [{ nominal = 0.8, prior = 0.5 }]
yaw = [{ nominal = 0.0, prior = 0.1 }, { nominal = 0.0, prior = 0.1 }]
"#;

/// A line of tables without the true values in them.
fn without_value(line: &str) -> String {
    let mut parts = line.split(", value = ");
    let first = parts.next().unwrap_or_default();
    let rest = parts.map(|part| &part[part.find([' ', ',']).unwrap_or(part.len())..]);
    std::iter::once(first).chain(rest).collect()
}
