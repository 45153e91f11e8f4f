//! What objects of an electronic chart mean to a trial, class by class: one table.

use enc::class_name;
use serde::{Deserialize, Serialize};

/// What objects of a class do to a trial.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Treatment {
    /// Nothing.
    Ignore,
    /// Informative maneuvers keep out; getting about does not.
    ManeuversAvoid,
    /// The ship keeps out.
    Avoid,
}

/// By what an object is judged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Judged {
    /// It charts water of a least depth (DRVAL1).
    Depth,
    /// It is an obstacle unless the depth over it (VALSOU) is known and enough, and water stands over it (WATLEV).
    Danger,
    /// So is every sounding.
    Sounding,
    /// It is an obstacle where its depth (VALDCO) is too little.
    Contour,
    /// It is land.
    Land,
    /// It is solid or afloat: an obstacle unless it stands on land.
    Body,
    /// It is an obstacle unless it stands on land, or the clearance under it is known and the ship's air draught less.
    Clearance,
    /// By where it is, and what is restricted there (RESTRN).
    Place,
    /// It may be anything: kept out of unless it stands on land.
    Unknown,
    /// It says where there are data (CATCOV).
    Coverage,
}

impl Judged {
    /// Whether it matters if the object stands on land.
    pub(crate) fn stands(self) -> bool {
        matches!(self, Self::Body | Self::Clearance | Self::Unknown)
    }

    /// Whether its points reach as far as dangers do.
    pub(crate) fn reaches(self) -> bool {
        matches!(self, Self::Danger | Self::Sounding | Self::Body | Self::Clearance | Self::Unknown)
    }
}

/// Why an object is without effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Ignored {
    /// It stands on land.
    OnLand,
    /// Nothing solid: names, rules, or what is carried by something else that is charted.
    NoBody,
    /// It lies on the ground, or matters to anchors, nets and others than passing ships.
    ForOthers,
    /// Areas beside it say as much.
    SaidElsewhere,
    /// It tells of data, or of other objects.
    AboutData,
    /// Its restrictions are none for passing ships.
    Restriction,
    /// The ship passes under it.
    PassedUnder,
    /// It is a mark of which nothing is to be seen.
    Unmarked,
    /// `rules` say so.
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

/// What a class means where nothing else is said.
#[derive(Clone, Copy, Debug)]
pub struct Rule {
    /// Acronyms of the classes.
    pub classes: &'static [&'static str],
    /// By what their objects are judged.
    pub judged: Judged,
    /// What they do.
    pub treatment: Treatment,
    /// Why they do nothing, where they do nothing.
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
    avoid(&["UNSARE", "RESARE", "TSEZNE"], Judged::Place),
    avoid(&["NEWOBJ"], Judged::Unknown),
    Rule {
        classes: &[
            "FAIRWY", "TSSLPT", "TSSRON", "TSSCRS", "TSSBND", "TSELNE", "ISTZNE", "PRCARE", "DWRTPT",
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
    // Carried by something solid that is charted as what it is.
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

/// By what a class is judged; one that the standard lacks may be anything.
pub(crate) fn judged(code: u16) -> Judged {
    of_class(code).map_or(Judged::Unknown, |rule| rule.judged)
}

/// The rule of a class; `None` for one that the standard lacks.
pub(crate) fn of_class(code: u16) -> Option<&'static Rule> {
    let name = class_name(code)?;
    RULES.iter().find(|rule| rule.classes.contains(&name))
}

/// Whether a code is that of a class.
pub(crate) fn is(code: u16, acronym: &str) -> bool {
    class_name(code) == Some(acronym)
}
