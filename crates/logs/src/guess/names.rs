//! What the name of a column says.

use crate::{UNITS, unit};

/// A channel that logs of ships have, and the words by which columns are called after it.
pub(super) struct Role {
    pub(super) channel: &'static str,
    pub(super) unit: &'static str,
    /// Whether it is of use, but not needed.
    pub(super) is_optional: bool,
    words: Words,
}

/// Sets of words; all words of one must stand in the name.
type Words = &'static [&'static [&'static str]];

const fn needed(channel: &'static str, unit: &'static str, words: Words) -> Role {
    Role { channel, unit, is_optional: false, words }
}

const fn helpful(channel: &'static str, unit: &'static str, words: Words) -> Role {
    Role { channel, unit, is_optional: true, words }
}

/// Channels of the motion, and further ones.
pub(super) const ROLES: &[Role] = &[
    needed("y_u", "m/s", &[&["surge"], &["speed", "forward"], &["u"]]),
    needed("y_v", "m/s", &[&["sway"], &["speed", "starboard"], &["v"], &["vm"]]),
    needed("y_r", "rad/s", &[&["yaw", "rate"], &["yawrate"], &["rot"], &["turn", "rate"], &["r"]]),
    needed("x", "m", &[&["north"], &["northing"], &["x"]]),
    needed("y", "m", &[&["east"], &["easting"], &["y"]]),
    needed("psi", "rad", &[&["heading"], &["hdg"], &["yaw"], &["psi"]]),
    needed("latitude_deg", "deg", &[&["latitude"], &["lat"]]),
    needed("longitude_deg", "deg", &[&["longitude"], &["lon"], &["lng"]]),
    helpful("roll", "rad", &[&["roll"], &["phi"]]),
    helpful("wind", "m/s", &[&["wind", "relative"], &["wind", "apparent"]]),
    helpful("wind_from", "rad", &[&["wind", "relative"], &["wind", "apparent"]]),
];

/// Words for what a ship is steered with, by the beginning of the channel's name.
const STEERED: &[(&str, &[&[&str]])] = &[
    ("delta", &[&["rudder"], &["helm"], &["delta"]]),
    ("thrust", &[&["thrust"]]),
    ("n", &[&["rpm"], &["rps"], &["propeller"], &["prop"], &["shaft"], &["thruster"]]),
    ("alpha", &[&["azimuth"], &["thruster"]]),
];

/// Words of names that are no channel: orders, errors and resets, statistics, what batteries and engines have.
const OTHERS: &str = "\
    set setpoint sp command commanded cmd order ordered target goal desired demand reference ref error err reset std \
    stddev sigma var variance cov covariance rms accuracy noise innovation innov residual bias offset limit max \
    min count counter valid flag flags quality ratio gain voltage volt volts current amp amps battery batt bat cell \
    temperature temp pressure humidity charge fuel accel acceleration acc jerk dot pitch";

/// Words of forces, which no motion, angle or shaft is called.
const FORCES: &str = "force moment torque";

/// Words of rates, and of angles.
const RATES: &str = "rate speed velocity vel velo angvel angvelo";
const ANGLES: &str = "angle azimuth direction";

/// Words that say which of several, or how a symbol was found.
const COMMON: &str = "\
    hat mid measured meas actual act feedback fb filtered filt estimated est body ship port ps starboard stbd sb \
    left right fore aft data value ground log";

/// Words of either side of a ship, the channel's first.
const SIDES: [&str; 2] = ["port ps left p l", "starboard stbd sb right s r"];

/// Symbols, which name other things too, and the words that may stand beside each.
const SYMBOLS: &[(&str, &str)] = &[
    ("u", "velo vel velocity speed surge linear"),
    ("v", "velo vel velocity speed sway linear"),
    ("vm", "velo vel velocity speed sway"),
    ("r", "angvelo angvel angular velocity yaw rate"),
    ("x", "position pos north coordinate"),
    ("y", "position pos east coordinate"),
    ("psi", "heading yaw angle"),
    ("phi", "roll angle"),
    ("n", "prop propeller shaft rpm rps engine rev revs"),
    ("delta", "rudder helm steering"),
];

/// Endings of names of columns after an underscore, each with its unit; also those of no channel.
const ENDINGS: &str = "\
    mps m/s, radps rad/s, degps deg/s, rad_s rad/s, deg_s deg/s, m_s m/s, rpm rpm, rps rps, rad rad, deg \
    deg, kn kn, kN kN, Nm N m, ms ms, m m, s s, N N, V V, mV mV, A A, mA mA, degC degC, pct %";

/// Units in brackets that are no channel's, besides those of [`UNITS`].
const FOREIGN: &str = "degC °C C degF K bar mbar mA Ah mAh Wh kWh l/h dB g deg/s^2 rad/s^2";

/// The name of a column, taken apart.
#[derive(Clone, Debug, PartialEq)]
pub struct Named {
    /// Its words in lower case, without the unit.
    words: Vec<String>,
    /// Where those of the field begin, after the topic and the fields that it is part of.
    field: usize,
    /// The capital letter that it begins with, where the first word is no more.
    capital: Option<char>,
    /// The unit that it says.
    pub unit: Option<&'static str>,
}

impl Named {
    /// What `column` says.
    pub fn of(column: &str) -> Self {
        let (name, unit) = in_brackets(column).or_else(|| at_end(column)).unwrap_or((column, None));
        let words = |text| -> Vec<&str> {
            str::split(text, |c: char| !c.is_alphanumeric()).filter(|word| !word.is_empty()).collect()
        };
        let all = words(name);
        let last = name.split(['.', '/']).map(|part| words(part).len()).rfind(|count| *count > 0);
        let capital =
            all.first().and_then(|word| word.parse().ok()).filter(|letter: &char| letter.is_uppercase());
        let field = all.len() - last.unwrap_or(0);
        Self { words: all.into_iter().map(str::to_lowercase).collect(), field, capital, unit }
    }

    /// Whether it is called a time.
    pub fn is_time(&self) -> bool {
        const TIMES: [&str; 7] = ["t", "time", "timestamp", "datetime", "utc", "stamp", "seconds"];
        self.words.iter().any(|word| TIMES.contains(&word.as_str()))
            && self.unit.is_none_or(|name| unit(name).is_some_and(|unit| unit.si == "s"))
    }

    /// Whether it says which ship the log is of.
    pub fn is_identity(&self) -> bool {
        const SHIPS: [&str; 5] = ["mmsi", "imo", "ship", "vessel", "hull"];
        let is_named = |word: &String| SHIPS.contains(&word.as_str());
        let others = ["name", "id", "number", "no"];
        self.words.iter().any(is_named)
            && self.words.iter().all(|word| is_named(word) || others.contains(&word.as_str()))
    }

    /// Whether its numbers can be those of `channel` in `wanted`, as far as its name says: shafts turn in either unit.
    pub fn measures(&self, channel: &str, wanted: &str) -> bool {
        let is_motion = || ROLES.iter().any(|role| role.channel == channel);
        let is_of_shaft = wanted == "1/s" || wanted == "rad/s" && !is_motion();
        let others = match wanted {
            "m" | "rad" | "deg" => RATES,
            _ if is_of_shaft => ANGLES,
            _ => "",
        };
        let is_other = self.words[self.field..].iter().any(|word| is_among(word, others));
        let is_exact = self.likeness(channel) == Some(0);
        (is_exact || !is_other)
            && self.unit.is_none_or(|unit| {
                if is_of_shaft { crate::shaft_factor(unit, wanted) } else { crate::factor(unit, wanted) }
                    .is_some()
            })
    }

    /// How likely it is `channel`: 0 if it is called so, larger numbers the less it is; `None` if nothing says so.
    pub fn likeness(&self, channel: &str) -> Option<usize> {
        let parts: Vec<&str> = channel.split('_').collect();
        let is_lower = channel.chars().all(|c| !c.is_uppercase());
        // `Y` and `N` are forces, `U` and `V` whole speeds, unless the unit says otherwise.
        if is_lower && self.capital.is_some_and(|letter| self.unit.is_none() || "UV".contains(letter)) {
            return None;
        }
        if self.words.join("_") == channel.to_lowercase() {
            return Some(0);
        }
        let says = |word: &str| self.words.iter().any(|other| other == word);
        let is_force = |word: &String| parts[0] != "thrust" && is_among(word, FORCES);
        if self.is_other() || self.words.iter().any(is_force) {
            return None;
        }
        // Over the ground, and wind that the ship does not feel: no channel of a model.
        if ["cog", "sog", "course"].into_iter().any(says) || says("wind") && says("true") {
            return None;
        }
        let role = ROLES.iter().find(|role| role.channel == channel).map(|role| role.words);
        let steered = STEERED.iter().find(|(name, _)| parts[0] == *name).map(|(_, words)| *words);
        let number = parts.get(1).filter(|part| part.chars().all(|c| c.is_ascii_digit()));
        let sets = role.or(steered)?;
        let is_wind = |set: &[&str]| set.contains(&"wind");
        let side = SIDES.iter().find(|words| parts.contains(&words.split(' ').next().unwrap_or_default()));
        if side.is_some_and(|words| !self.words.iter().any(|word| is_among(word, words))) {
            return None;
        }
        let fits = |set: &&[&str]| {
            self.has(set) && number.is_none_or(|number| says(number)) && (is_wind(set) || !says("wind"))
        };
        sets.iter().position(fits).map(|place| place + 1).or_else(|| self.begins(parts[0]))
    }

    /// Whether it is called an order, an error, a battery's or another thing that is no channel.
    pub fn is_other(&self) -> bool {
        self.words.iter().any(|word| is_among(word, OTHERS))
    }

    /// A name that begins with a channel of one letter, such as `n_prop`.
    fn begins(&self, channel: &str) -> Option<usize> {
        (channel.len() == 1 && self.has(&[channel])).then_some(9)
    }

    /// Whether all words of `set` are in it; a single letter must come first, and symbols beside no other things.
    fn has(&self, set: &[&str]) -> bool {
        let is_own = |symbol: &str| {
            let known = SYMBOLS.iter().find(|(other, _)| *other == symbol);
            known.is_none_or(|(_, beside)| {
                self.words[self.field..].iter().all(|word| {
                    word == symbol
                        || is_among(word, beside)
                        || is_among(word, COMMON)
                        || word.parse::<u32>().is_ok()
                })
            })
        };
        match set {
            [letter] if letter.len() <= 2 => {
                self.words.first().is_some_and(|word| word == letter) && is_own(letter)
            }
            words => {
                words.iter().all(|word| self.words.iter().any(|other| other == word))
                    && (words.len() > 1 || words.iter().all(|word| is_own(word)))
            }
        }
    }
}

fn is_among(word: &str, words: &str) -> bool {
    words.split(' ').any(|other| other == word)
}

/// A unit in brackets at the end: `speed [m/s]`, `heading (deg)`.
fn in_brackets(column: &str) -> Option<(&str, Option<&'static str>)> {
    let column = column.trim();
    let (open, close) = [('[', ']'), ('(', ')')].into_iter().find(|(_, close)| column.ends_with(*close))?;
    let (name, inside) = column.rsplit_once(open)?;
    let inside = inside.trim_end_matches(close).trim();
    // An element of a list, such as `data[1]`.
    if open == '[' && !name.ends_with(' ') && inside.parse::<u32>().is_ok() {
        return None;
    }
    let foreign = || FOREIGN.split(' ').find(|other| *other == inside);
    Some((name, UNITS.iter().find(|unit| unit.name == inside).map(|unit| unit.name).or_else(foreign)))
}

/// A unit after the last underscore: `u_mps`, `delta_rad`.
fn at_end(column: &str) -> Option<(&str, Option<&'static str>)> {
    ENDINGS.split(", ").find_map(|ending| {
        let (end, unit) = ending.split_once(' ')?;
        let name = column.strip_suffix(end)?.strip_suffix('_')?;
        (!name.is_empty()).then_some((name, Some(unit)))
    })
}
