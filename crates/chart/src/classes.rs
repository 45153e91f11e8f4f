//! What the object classes of an electronic chart mean for a trial: one table.

use std::fmt;
use std::sync::Arc;

use geojson::JsonObject;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::enc::{Feature, OBJNAM, class_name};

/// The effect of a class of objects on a trial.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Treatment {
    /// Nothing.
    Ignore,
    /// Informative maneuvers keep out; transit does not.
    ManeuversAvoid,
    /// The ship keeps out.
    Avoid,
}

/// How an object is judged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Judged {
    /// It charts water of a least depth (DRVAL1).
    Depth,
    /// It is an obstacle unless the depth over it (VALSOU) is known and sufficient, and it is under water (WATLEV).
    Danger,
    /// So is every sounding.
    Sounding,
    /// It is an obstacle where its depth (VALDCO) is insufficient.
    Contour,
    /// It is land.
    Land,
    /// It is solid or afloat: an obstacle unless it stands on land.
    Body,
    /// It is an obstacle unless it stands on land, or its clearance is known and exceeds the ship's air draught.
    Clearance,
    /// By its area and the restrictions there (RESTRN).
    Place,
    /// It may be anything: the ship keeps out unless it stands on land.
    Unknown,
    /// It shows where there are data (CATCOV).
    Coverage,
}

impl Judged {
    /// Whether standing on land makes a difference.
    pub(crate) fn stands(self) -> bool {
        matches!(self, Self::Body | Self::Clearance | Self::Unknown)
    }

    /// Whether its points have the radius of dangers.
    pub(crate) fn reaches(self) -> bool {
        matches!(self, Self::Danger | Self::Sounding | Self::Body | Self::Clearance | Self::Unknown)
    }
}

/// Why an object has no effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Ignored {
    /// It stands on land.
    OnLand,
    /// Nothing solid: names, rules, or objects that are carried by another charted one.
    NoBody,
    /// It lies on the seabed, or concerns anchors, nets and the like, but not passing ships.
    ForOthers,
    /// Areas beside it contain the same information.
    SaidElsewhere,
    /// It is about data, or other objects.
    AboutData,
    /// Its restrictions do not concern passing ships.
    Restriction,
    /// The ship passes under it.
    PassedUnder,
    /// A mark that is not physically there.
    Unmarked,
    /// `rules` in plan.toml.
    Rule,
}

impl Ignored {
    /// In words.
    pub fn reason(self) -> &'static str {
        match self {
            Self::OnLand => "on land",
            Self::NoBody => "no body",
            Self::ForOthers => "on the ground or for others",
            Self::SaidElsewhere => "areas say as much",
            Self::AboutData => "about the data",
            Self::Restriction => "restricts no passing ship",
            Self::PassedUnder => "passed under",
            Self::Unmarked => "not physically there",
            Self::Rule => "rule of plan.toml",
        }
    }
}

/// The default meaning of classes.
#[derive(Clone, Copy, Debug)]
pub struct Rule {
    /// Acronyms of the classes.
    pub classes: &'static [&'static str],
    /// How their objects are judged.
    pub judged: Judged,
    /// Their effect.
    pub treatment: Treatment,
    /// Why they have no effect, if they have none.
    pub ignored: Ignored,
}

const fn avoid(classes: &'static [&'static str], judged: Judged) -> Rule {
    Rule { classes, judged, treatment: Treatment::Avoid, ignored: Ignored::Restriction }
}

const fn ignore(classes: &'static [&'static str], judged: Judged, ignored: Ignored) -> Rule {
    Rule { classes, judged, treatment: Treatment::Ignore, ignored }
}

/// The rules, for every class of the standard.
pub const RULES: [Rule; 20] = [
    avoid(&["DEPARE", "DRGARE"], Judged::Depth),
    avoid(&["OBSTRN", "WRECKS", "UWTROC"], Judged::Danger),
    avoid(&["SOUNDG"], Judged::Sounding),
    ignore(&["DEPCNT"], Judged::Contour, Ignored::SaidElsewhere),
    avoid(&["LNDARE"], Judged::Land),
    avoid(
        &[
            "PONTON", "HULKES", "FLODOC", "SLCONS", "DRYDOC", "CAUSWY", "DAMCON", "DYKCON", "GATCON",
            "PYLONS", "OFSPLF", "PILPNT", "MORFAC", "OILBAR",
        ],
        Judged::Body,
    ),
    avoid(
        &["FSHFAC", "MARCUL", "LOGPON", "ICEARE", "OSPARE", "PRDARE", "LITFLT", "LITVES", "RAPIDS", "WATFAL"],
        Judged::Body,
    ),
    avoid(
        &[
            "LNDMRK", "BUISGL", "SILTNK", "CRANES", "DAYMAR", "DISMAR", "FORSTC", "FNCLNE", "CTRPNT",
            "RUNWAY", "VEGATN",
        ],
        Judged::Body,
    ),
    avoid(&["BOYCAR", "BOYINB", "BOYISD", "BOYLAT", "BOYSAW", "BOYSPP"], Judged::Body),
    avoid(&["BCNCAR", "BCNISD", "BCNLAT", "BCNSAW", "BCNSPP"], Judged::Body),
    ignore(&["COALNE", "RIVBNK", "CANBNK", "LAKSHR"], Judged::Land, Ignored::SaidElsewhere),
    avoid(&["BRIDGE", "CBLOHD", "PIPOHD", "CONVYR"], Judged::Clearance),
    avoid(&["UNSARE", "RESARE", "TSSRON"], Judged::Place),
    avoid(&["NEWOBJ"], Judged::Unknown),
    Rule {
        classes: &[
            "FAIRWY", "TSSLPT", "TSSCRS", "TSSBND", "TSELNE", "TSEZNE", "ISTZNE", "PRCARE", "DWRTPT",
            "TWRTPT", "ACHARE", "ACHBRT", "PILBOP", "MIPARE", "SUBTLN", "SPLARE", "CTNARE",
        ],
        judged: Judged::Place,
        treatment: Treatment::ManeuversAvoid,
        ignored: Ignored::Restriction,
    },
    ignore(
        &[
            "CBLARE", "CBLSUB", "PIPARE", "PIPSOL", "DMPGRD", "FSHGRD", "FERYRT", "ICNARE", "TESARE",
            "EXEZNE", "FSHZNE", "CTSARE", "TUNNEL", "SBDARE", "SNDWAV", "WEDKLP", "SPRING", "WATTUR",
        ],
        Judged::Place,
        Ignored::ForOthers,
    ),
    // Carried by something solid that is charted itself.
    ignore(
        &[
            "LIGHTS", "TOPMAR", "FOGSIG", "RADRFL", "RETRFL", "RTPBCN", "RADSTA", "RDOSTA", "SISTAT",
            "SISTAW", "CGUSTA", "RSCSTA", "ROADWY", "RAILWY",
        ],
        Judged::Place,
        Ignored::NoBody,
    ),
    // Names, waters, lines and zones.
    ignore(
        &[
            "ADMARE", "AIRARE", "BERTHS", "BUAARE", "CANALS", "CHKPNT", "CONZNE", "COSARE", "CURENT",
            "CUSZNE", "DOCARE", "DWRTCL", "FRPARE", "GRIDRN", "HRBARE", "HRBFAC", "LAKARE", "LNDELV",
            "LNDRGN", "LOCMAG", "LOKBSN", "MAGVAR", "NAVLNE", "RADLNE", "RADRNG", "RCRTCL", "RCTLPT",
            "RDOCAL", "RECTRC", "RIVERS", "SEAARE", "SLOGRD", "SLOTOP", "SMCFAC", "SQUARE", "STSLNE",
            "SWPARE", "TIDEWY", "TS_FEB", "TS_PAD", "TS_PNH", "TS_PRH", "TS_TIS", "T_HMON", "T_NHMN",
            "T_TIMS", "ARCSLN", "ASLXIS",
        ],
        Judged::Place,
        Ignored::NoBody,
    ),
    ignore(
        &[
            "M_ACCY", "M_CSCL", "M_HDAT", "M_HOPA", "M_NPUB", "M_NSYS", "M_PROD", "M_QUAL", "M_SDAT",
            "M_SREL", "M_UNIT", "M_VDAT", "C_AGGR", "C_ASSO", "C_STAC",
        ],
        Judged::Place,
        Ignored::AboutData,
    ),
    ignore(&["M_COVR"], Judged::Coverage, Ignored::AboutData),
];

/// How a class is judged; one that is not in the standard may be anything.
pub(crate) fn judged(code: u16) -> Judged {
    of_class(code).map_or(Judged::Unknown, |rule| rule.judged)
}

/// The rule of a class; `None` if the standard lacks it.
pub(crate) fn of_class(code: u16) -> Option<&'static Rule> {
    let name = class_name(code)?;
    RULES.iter().find(|rule| rule.classes.contains(&name))
}

/// Whether a code is that of a class.
pub(crate) fn is(code: u16, acronym: &str) -> bool {
    class_name(code) == Some(acronym)
}

/// Properties that hold a feature's name.
const NAMES: [&str; 3] = ["OBJNAM", "name", "NAME"];

/// Class, name and depth of a charted thing, printed as `WRECKS Träholm 4.2 m`.
#[derive(Clone, Debug, PartialEq)]
pub struct Called {
    /// Its kind: the acronym of its class, or a word.
    pub what: &'static str,
    /// Its own name.
    pub name: Option<Arc<str>>,
    /// The charted depth of it or over it \[m\].
    pub depth_m: Option<f64>,
}

impl Called {
    /// Something without a name.
    pub(crate) fn plain(what: &'static str) -> Self {
        Self { what, name: None, depth_m: None }
    }

    pub(crate) fn object(object: &Feature, depth_m: Option<f64>) -> Self {
        let name = object.attributes.get(&OBJNAM.0).map(|name| name.trim());
        let name = name.filter(|name| !name.is_empty()).map(Arc::from);
        Self { what: class_name(object.class).unwrap_or("object"), name, depth_m }
    }

    /// The name of a GeoJSON feature of kind `what`.
    pub(crate) fn feature(what: &'static str, properties: Option<&JsonObject>, depth_m: Option<f64>) -> Self {
        let name = |key: &&str| Some(properties?.get(*key)?.as_str()?.trim()).filter(|name| !name.is_empty());
        Self { what, name: NAMES.iter().find_map(name).map(Arc::from), depth_m }
    }
}

impl fmt::Display for Called {
    fn fmt(&self, out: &mut fmt::Formatter) -> fmt::Result {
        out.write_str(self.what)?;
        self.name.iter().try_for_each(|name| write!(out, " {name}"))?;
        self.depth_m.iter().try_for_each(|depth| write!(out, " {depth} m"))
    }
}
