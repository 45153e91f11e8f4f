//! What sentences tell: their fields by name, in the units of the standard (NMEA 0183, IEC 61162-1).

use refusal::Invalid;

use super::sentence::Sentence;
use crate::columns::cell_of;

/// A kind of sentence.
pub(super) struct Kind {
    name: &'static str,
    /// Fields that tell sentences of this kind apart, such as the number of the propeller.
    qualifier: &'static [usize],
    fields: &'static [Field],
}

/// What a sentence tells.
pub(super) struct Field {
    name: &'static str,
    pub(super) unit: &'static str,
    read: Read,
    valid: Valid,
}

/// How a value stands in fields.
enum Read {
    /// A number.
    Number(usize),
    /// Degrees and minutes, `4807.038`, and a letter.
    Place(usize),
    /// A speed, and a letter for its unit.
    Speed(usize),
}
use Read::{Number, Place, Speed};

/// When a value counts.
enum Valid {
    Always,
    /// Where a field is `A`.
    A(usize),
    /// Where a field has a character that is none of these.
    Not(usize, &'static str),
    /// Where a field, if there is one, has none of these.
    Unless(usize, &'static str),
}
use Valid::{A, Always, Not, Unless};

const fn field(name: &'static str, unit: &'static str, read: Read, valid: Valid) -> Field {
    Field { name, unit, read, valid }
}

const fn kind(name: &'static str, fields: &'static [Field]) -> Kind {
    Kind { name, qualifier: &[], fields }
}

const KINDS: [Kind; 16] = [
    kind(
        "GGA",
        &[
            field("latitude", "deg", Place(1), Not(5, "0")),
            field("longitude", "deg", Place(3), Not(5, "0")),
            field("altitude", "m", Number(8), Not(5, "0")),
        ],
    ),
    kind(
        "GNS",
        &[
            field("latitude", "deg", Place(1), Not(5, "N")),
            field("longitude", "deg", Place(3), Not(5, "N")),
            field("altitude", "m", Number(8), Not(5, "N")),
        ],
    ),
    kind("GLL", &[field("latitude", "deg", Place(0), A(5)), field("longitude", "deg", Place(2), A(5))]),
    kind(
        "RMC",
        &[
            field("latitude", "deg", Place(2), A(1)),
            field("longitude", "deg", Place(4), A(1)),
            field("speed", "knot", Number(6), A(1)),
            field("course", "deg", Number(7), A(1)),
        ],
    ),
    kind(
        "VTG",
        &[
            field("course", "deg", Number(0), Unless(8, "N")),
            field("speed", "knot", Number(4), Unless(8, "N")),
            field("speed_kmh", "km/h", Number(6), Unless(8, "N")),
        ],
    ),
    kind("HDT", &[field("heading", "deg", Number(0), Always)]),
    kind("THS", &[field("heading", "deg", Number(0), Not(1, "V"))]),
    kind("HDG", &[field("magnetic", "deg", Number(0), Always)]),
    kind("HDM", &[field("magnetic", "deg", Number(0), Always)]),
    kind(
        "VHW",
        &[
            field("heading", "deg", Number(0), Always),
            field("speed", "knot", Number(4), Always),
            field("speed_kmh", "km/h", Number(6), Always),
        ],
    ),
    kind(
        "VBW",
        &[
            field("surge_water", "knot", Number(0), A(2)),
            field("sway_water", "knot", Number(1), A(2)),
            field("surge", "knot", Number(3), A(5)),
            field("sway", "knot", Number(4), A(5)),
        ],
    ),
    kind("ROT", &[field("rate", "deg/min", Number(0), A(1))]),
    kind("RSA", &[field("starboard", "deg", Number(0), A(1)), field("port", "deg", Number(2), A(3))]),
    Kind {
        name: "RPM",
        qualifier: &[0, 1],
        fields: &[field("speed", "rpm", Number(2), A(4)), field("pitch", "%", Number(3), A(4))],
    },
    Kind {
        name: "MWV",
        qualifier: &[1],
        fields: &[field("angle", "deg", Number(0), A(4)), field("speed", "m/s", Speed(2), A(4))],
    },
    kind("DPT", &[field("depth", "m", Number(0), Always)]),
];

/// A field of a kind of sentence, of one talker or of all: `HDT.heading`, `HEHDT.heading`, `RPM-S1.speed`.
pub(super) struct Column {
    pub(super) name: String,
    /// What the address ends with: `HDT`, or `HEHDT`.
    address: String,
    qualifier: String,
    kind: &'static Kind,
    pub(super) field: &'static Field,
}

impl Column {
    /// None where there is no such field.
    pub(super) fn parse(name: &str) -> Option<Self> {
        let (of, field) = name.split_once('.')?;
        let (address, qualifier) = of.split_once('-').unwrap_or((of, ""));
        let is_plain = address.is_ascii() && [3, 5].contains(&address.len());
        let kind = KINDS.iter().find(|kind| is_plain && address.ends_with(kind.name))?;
        // Without it, the wind over ground would stand among that over the deck.
        if kind.qualifier.is_empty() != qualifier.is_empty() {
            return None;
        }
        let field = kind.fields.iter().find(|known| known.name == field)?;
        let [name, address, qualifier] = [name, address, qualifier].map(str::to_owned);
        Some(Self { name, address, qualifier, kind, field })
    }

    /// Whether sentences of this address may have it.
    pub(super) fn fits(&self, address: &str) -> bool {
        address.len() == 5 && address.ends_with(&self.address)
    }

    /// Whether it stands in `sentence`.
    pub(super) fn is_of(&self, sentence: &Sentence) -> bool {
        let own = self.kind.qualifier.iter().map(|place| sentence.field(*place));
        self.fits(sentence.address) && own.collect::<String>() == self.qualifier
    }
}

/// The names of all fields.
pub(super) fn columns() -> impl Iterator<Item = String> {
    let of = |kind: &'static Kind| {
        let qualified: &[&str] = match kind.name {
            "RPM" => &["-S1", "-E1"],
            "MWV" => &["-R", "-T"],
            _ => &[""],
        };
        let name = move |qualifier| {
            kind.fields.iter().map(move |field| format!("{}{qualifier}.{}", kind.name, field.name))
        };
        qualified.iter().flat_map(name)
    };
    KINDS.iter().flat_map(of)
}

impl Field {
    /// Its value in `sentence`, which stands on `line`; NaN where it is empty or does not count.
    pub(super) fn value(&self, sentence: &Sentence, line: usize) -> Result<f64, Invalid> {
        let counts = match self.valid {
            Always => true,
            A(place) => sentence.field(place) == "A",
            Not(place, none) => sentence.field(place).chars().any(|c| !none.contains(c)),
            Unless(place, none) => !sentence.field(place).contains(|c| none.contains(c)),
        };
        if !counts {
            return Ok(f64::NAN);
        }
        match self.read {
            Number(place) => self.number(sentence, place, line),
            Place(place) => {
                let value = self.number(sentence, place, line)?;
                let degrees = (value / 100.0).floor();
                let angle = degrees + (value - 100.0 * degrees) / 60.0;
                self.lettered(
                    sentence,
                    place + 1,
                    line,
                    &[("N", 1.0), ("E", 1.0), ("S", -1.0), ("W", -1.0)],
                    angle,
                )
            }
            Speed(place) => {
                let value = self.number(sentence, place, line)?;
                let units = [("N", 1852.0 / 3600.0), ("K", 1.0 / 3.6), ("M", 1.0), ("S", 1609.344 / 3600.0)];
                self.lettered(sentence, place + 1, line, &units, value)
            }
        }
    }

    fn number(&self, sentence: &Sentence, place: usize, line: usize) -> Result<f64, Invalid> {
        let text = sentence.field(place);
        if text.is_empty() {
            return Ok(f64::NAN);
        }
        let number = text.parse().ok().filter(|number: &f64| number.is_finite());
        number.ok_or_else(|| self.refused(sentence, text, line, "a number"))
    }

    /// `value` times what the letter in field `place` stands for.
    fn lettered(
        &self,
        sentence: &Sentence,
        place: usize,
        line: usize,
        letters: &[(&str, f64)],
        value: f64,
    ) -> Result<f64, Invalid> {
        let text = sentence.field(place);
        match letters.iter().find(|(letter, _)| *letter == text) {
            _ if value.is_nan() => Ok(value),
            Some((_, factor)) => Ok(factor * value),
            None => {
                let known: Vec<&str> = letters.iter().map(|(letter, _)| *letter).collect();
                Err(self.refused(sentence, text, line, &format!("one of {}", known.join(", "))))
            }
        }
    }

    fn refused(&self, sentence: &Sentence, text: &str, line: usize, expected: &str) -> Invalid {
        let column = format!("{}.{}", sentence.address, self.name);
        Invalid::new(cell_of(line, &column), format!("`{text}`"), expected, "correct or leave out the line")
    }
}
