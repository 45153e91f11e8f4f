//! Fields of sentences by name, in the units of the standard (NMEA 0183, IEC 61162-1).

use refusal::{Invalid, foreign};

use super::sentence::{Accepted, Sentence, Valid};
use crate::Reason;
use crate::columns::cell_of;

/// A kind of sentence.
pub(super) struct FieldKind {
    name: &'static str,
    /// Fields that distinguish sentences of this kind, such as the number of the propeller.
    qualifier: &'static [usize],
    fields: &'static [Field],
}

/// A quantity in a sentence.
pub(crate) struct Field {
    pub(crate) name: &'static str,
    pub(super) unit: &'static str,
    read: Read,
    valid: Valid,
}

/// How a value is written in fields.
enum Read {
    /// A number.
    Number(usize),
    /// Degrees and minutes, `4807.038`, and a letter.
    Place(usize),
    /// A speed, and a letter for its unit.
    Speed(usize),
    /// A compass heading, then its deviation and the variation, each with a letter: the sum.
    True(usize),
}
use Read::{Number, Place, Speed, True};
use Valid::{A, Always, AnyMode, Fix, Letter, Mode, OwnMode};

/// A value in a sentence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Value {
    Known(f64),
    /// A heading without a stated deviation, which is taken as 0.
    Undeviated(f64),
    Empty,
    /// There is a number, but it is left out.
    Left(Reason),
}

const fn field(name: &'static str, unit: &'static str, read: Read, valid: Valid) -> Field {
    Field { name, unit, read, valid }
}

const fn kind(name: &'static str, fields: &'static [Field]) -> FieldKind {
    FieldKind { name, qualifier: &[], fields }
}

const RMC: Valid = Mode { status: Some(1), mode: 11 };
const GLL: Valid = Mode { status: Some(5), mode: 6 };
const VTG: Valid = Mode { status: None, mode: 8 };

const KINDS: [FieldKind; 16] = [
    kind(
        "GGA",
        &[
            field("latitude", "deg", Place(1), Fix(5)),
            field("longitude", "deg", Place(3), Fix(5)),
            field("altitude", "m", Number(8), Fix(5)),
        ],
    ),
    kind(
        "GNS",
        &[
            field("latitude", "deg", Place(1), AnyMode(5)),
            field("longitude", "deg", Place(3), AnyMode(5)),
            field("altitude", "m", Number(8), AnyMode(5)),
        ],
    ),
    kind("GLL", &[field("latitude", "deg", Place(0), GLL), field("longitude", "deg", Place(2), GLL)]),
    kind(
        "RMC",
        &[
            field("latitude", "deg", Place(2), RMC),
            field("longitude", "deg", Place(4), RMC),
            field("speed", "knot", Number(6), RMC),
            field("course", "deg", Number(7), RMC),
        ],
    ),
    kind(
        "VTG",
        &[
            field("course", "deg", Number(0), VTG),
            field("speed", "knot", Number(4), VTG),
            field("speed_kmh", "km/h", Number(6), VTG),
        ],
    ),
    kind("HDT", &[field("heading", "deg", Number(0), Letter(1, "T"))]),
    kind("THS", &[field("heading", "deg", Number(0), OwnMode(1))]),
    kind("HDG", &[field("heading", "deg", True(0), Always), field("magnetic", "deg", Number(0), Always)]),
    kind("HDM", &[field("magnetic", "deg", Number(0), Always)]),
    kind(
        "VHW",
        &[
            field("heading", "deg", Number(0), Letter(1, "T")),
            field("magnetic", "deg", Number(2), Letter(3, "M")),
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
    FieldKind {
        name: "RPM",
        qualifier: &[0, 1],
        fields: &[field("speed", "rpm", Number(2), A(4)), field("pitch", "%", Number(3), A(4))],
    },
    FieldKind {
        name: "MWV",
        qualifier: &[1],
        fields: &[field("angle", "deg", Number(0), A(4)), field("speed", "m/s", Speed(2), A(4))],
    },
    kind("DPT", &[field("depth", "m", Number(0), Always)]),
];

/// A field of a kind of sentence, of one talker or of all: `HDT.heading`, `HEHDT.heading`, `RPM-S1.speed`.
pub(crate) struct FieldColumn {
    pub(crate) name: String,
    /// The ending of the address: `HDT`, or `HEHDT`.
    pub(crate) address: String,
    qualifier: String,
    kind: &'static FieldKind,
    pub(crate) field: &'static Field,
}

impl FieldColumn {
    /// `None` where there is no such field.
    pub(crate) fn parse(name: &str) -> Option<Self> {
        let (of, field) = name.split_once('.')?;
        let (address, qualifier) = of.split_once('-').unwrap_or((of, ""));
        let is_plain = address.is_ascii() && [3, 5].contains(&address.len());
        let kind = KINDS.iter().find(|kind| is_plain && address.ends_with(kind.name))?;
        // Without this check, wind over ground would be mixed with that over the deck.
        if kind.qualifier.is_empty() != qualifier.is_empty() {
            return None;
        }
        let field = kind.fields.iter().find(|known| known.name == field)?;
        let [name, address, qualifier] = [name, address, qualifier].map(str::to_owned);
        Some(Self { name, address, qualifier, kind, field })
    }

    /// Whether sentences with this address may have it.
    pub(super) fn fits(&self, address: &str) -> bool {
        address.len() == 5
            && address.is_ascii()
            && address.ends_with(&self.address)
            && !address.starts_with('P')
    }

    /// Whether `sentence` has it.
    pub(super) fn is_of(&self, sentence: &Sentence) -> bool {
        let qualifier = || self.kind.qualifier.iter().flat_map(|place| sentence.field(*place).chars());
        self.fits(sentence.address) && qualifier().eq(self.qualifier.chars())
    }

    /// Its value in `sentence`, which stands on `line`, if its quality is `accepted`.
    pub(crate) fn value(
        &self,
        sentence: &Sentence,
        line: usize,
        accepted: &Accepted,
    ) -> Result<Value, Invalid> {
        self.field.value(sentence, line, accepted)
    }
}

/// The fields of `sentence`, which stands on `line`: their names as columns of any talker, units and values of quality `accepted`.
/// Values that cannot be read are none.
pub(super) fn fields_of(
    sentence: &Sentence,
    line: usize,
    accepted: &Accepted,
) -> Vec<(String, &'static str, Value)> {
    let Some(kind) = KINDS.iter().find(|kind| sentence.is_a(kind.name)) else { return Vec::new() };
    let qualifier: String = kind.qualifier.iter().flat_map(|place| sentence.field(*place).chars()).collect();
    let dash = if kind.qualifier.is_empty() { "" } else { "-" };
    let field = |field: &'static Field| {
        let value = field.value(sentence, line, accepted).unwrap_or(Value::Empty);
        (format!("{}{dash}{qualifier}.{}", kind.name, field.name), field.unit, value)
    };
    kind.fields.iter().map(field).collect()
}

/// The columns of the kind of sentence in `name`, if that is known; otherwise those of all kinds.
pub(super) fn columns_like(name: &str) -> Vec<String> {
    let of = name.split(['.', '-']).next().unwrap_or_default();
    let same: Vec<String> = columns().filter(|column| of.ends_with(&column[..3])).collect();
    if same.is_empty() { columns().collect() } else { same }
}

/// The names of all fields.
fn columns() -> impl Iterator<Item = String> {
    let of = |kind: &'static FieldKind| {
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
    fn value(&self, sentence: &Sentence, line: usize, accepted: &Accepted) -> Result<Value, Invalid> {
        let (Number(place) | Place(place) | Speed(place) | True(place)) = self.read;
        if sentence.field(place).is_empty() {
            return Ok(Value::Empty);
        }
        if !accepted.counts(self.valid, sentence) {
            return Ok(Value::Left(Reason::Quality));
        }
        let value = self.number(sentence, place, line)?;
        match self.read {
            Number(_) => Ok(Value::Known(value)),
            True(_) => self.true_heading(sentence, place, line, value),
            Place(_) => {
                let degrees = (value / 100.0).floor();
                let minutes = value - 100.0 * degrees;
                let angle = degrees + minutes / 60.0;
                let letters = [("N", 1.0), ("E", 1.0), ("S", -1.0), ("W", -1.0)];
                let angle = self.lettered(sentence, place + 1, line, &letters, angle)?;
                let fits = minutes < 60.0 && degrees >= 0.0 && angle.abs() <= 180.0;
                Ok(if fits { Value::Known(angle) } else { Value::Left(Reason::Range) })
            }
            Speed(_) => {
                let units = [("N", 1852.0 / 3600.0), ("K", 1.0 / 3.6), ("M", 1.0), ("S", 1609.344 / 3600.0)];
                self.lettered(sentence, place + 1, line, &units, value).map(Value::Known)
            }
        }
    }

    /// The true heading where a compass shows `shown`: east is positive.
    fn true_heading(
        &self,
        sentence: &Sentence,
        place: usize,
        line: usize,
        shown: f64,
    ) -> Result<Value, Invalid> {
        let correction = |place: usize| match [place, place + 1].map(|place| sentence.field(place)) {
            ["", _] => Ok(None),
            // A number without its direction, east or west.
            [_, ""] => Ok(Some(f64::NAN)),
            _ => {
                let value = self.number(sentence, place, line)?;
                self.lettered(sentence, place + 1, line, &[("E", 1.0), ("W", -1.0)], value).map(Some)
            }
        };
        let (deviation, variation) = (correction(place + 1)?, correction(place + 3)?);
        let heading = shown + deviation.unwrap_or(0.0) + variation.unwrap_or(f64::NAN);
        Ok(match deviation {
            _ if heading.is_nan() => Value::Left(Reason::Incomplete),
            Some(_) => Value::Known(heading.rem_euclid(360.0)),
            None => Value::Undeviated(heading.rem_euclid(360.0)),
        })
    }

    fn number(&self, sentence: &Sentence, place: usize, line: usize) -> Result<f64, Invalid> {
        let text = sentence.field(place);
        let number = text.parse().ok().filter(|number: &f64| number.is_finite());
        number.ok_or_else(|| self.refused(sentence, text, line, "a number"))
    }

    /// `value` times the factor of the letter in field `place`.
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
            Some((_, factor)) => Ok(factor * value),
            None => {
                let known: Vec<&str> = letters.iter().map(|(letter, _)| *letter).collect();
                Err(self.refused(sentence, text, line, &format!("one of {}", known.join(", "))))
            }
        }
    }

    fn refused(&self, sentence: &Sentence, text: &str, line: usize, expected: &str) -> Invalid {
        let column = format!("{}.{}", sentence.address, self.name);
        Invalid::new(
            cell_of(line, &column),
            format!("`{}`", foreign(text)),
            expected,
            "correct or leave out the line",
        )
    }
}
