//! Electronic navigational charts: a cell of IHO S-57 (edition 3.1) and its updates, from bytes to features.
//!
//! A cell is a file of ISO 8211 records (`US4MD81M.000`). Its vector records are nodes and edges, its feature records are
//! objects of a class (`DEPARE`, `WRECKS`) that point to them. Updates (`.001`, `.002`, …) insert, delete and modify
//! records, in order. Only cells of the ENC product are read: binary, chain-node topology, WGS84, metres.
//!
//! Longitude comes before latitude, in degrees of WGS84; depths are positive down \[m\], below the sounding datum.
//!
//! ```no_run
//! let [base, first] = [Vec::new(), Vec::new()];
//! let mut cell = chart::enc::Cell::read(&base)?;
//! cell.update(&first)?;
//! let wrecks = cell.features()?.into_iter().filter(|f| f.class == chart::enc::class("WRECKS").unwrap_or(0));
//! # Ok::<(), chart::enc::Invalid>(())
//! ```

mod cell;
mod dataset;
mod iso8211;
mod record;
mod topology;

use std::collections::BTreeMap;

pub use cell::{Cell, identify};
pub use dataset::{Identity, Listed, Purpose, crc, listed};
pub use refusal::Invalid;

// Attributes that charts are judged by: code and acronym (IHO object catalogue, S-57 appendix A).

/// An attribute: its code and its acronym.
pub type Attribute = (u16, &'static str);

/// Whether an area is covered by data (1) or not (2).
pub const CATCOV: Attribute = (18, "CATCOV");
/// Whether a distance mark is there (2 to 5) or drawn only (1).
pub const CATDIS: Attribute = (21, "CATDIS");
/// Category of the zone of confidence: 1 A1, 2 A2, 3 B, 4 C, 5 D, 6 not assessed.
pub const CATZOC: Attribute = (72, "CATZOC");
/// Least depth of an area \[m\].
pub const DRVAL1: Attribute = (87, "DRVAL1");
/// Unit of depths in an area: 1 metres, 2 fathoms and feet, 3 feet, 4 fathoms and fractions.
pub const DUNITS: Attribute = (89, "DUNITS");
/// Unit of heights in an area: 1 metres, 2 feet.
pub const HUNITS: Attribute = (96, "HUNITS");
/// Name.
pub const OBJNAM: Attribute = (116, "OBJNAM");
/// Direction: of a lane's traffic, of a light \[deg, true\].
pub const ORIENT: Attribute = (117, "ORIENT");
/// Restrictions: 7 entry prohibited, 8 entry restricted, 14 area to be avoided, and others.
pub const RESTRN: Attribute = (131, "RESTRN");
/// Traffic: 1 inbound, 2 outbound, 3 one-way, 4 two-way.
pub const TRAFIC: Attribute = (172, "TRAFIC");
/// Depth of a contour \[m\].
pub const VALDCO: Attribute = (174, "VALDCO");
/// Depth over a danger \[m\].
pub const VALSOU: Attribute = (179, "VALSOU");
/// Vertical clearance \[m\]: of a fixed span, of one that opens when closed, and the safe one under a cable.
pub const VERCLR: Attribute = (181, "VERCLR");
/// See [`VERCLR`].
pub const VERCCL: Attribute = (182, "VERCCL");
/// See [`VERCLR`].
pub const VERCSA: Attribute = (184, "VERCSA");
/// Water level effect: 1 partly and 2 always dry, 3 always under water, 4 covers and uncovers, 5 awash, 7 floating.
pub const WATLEV: Attribute = (187, "WATLEV");
/// Datum of heights or depths in an area, see [`vertical_datum`].
pub const VERDAT: Attribute = (185, "VERDAT");
/// Horizontal datum of an area: 2 is WGS84.
pub const HORDAT: Attribute = (400, "HORDAT");
/// Quality of a position: 1 surveyed, 4 approximate, 5 doubtful, 10 precisely known, and others.
pub const QUAPOS: Attribute = (402, "QUAPOS");

/// All of these.
pub const ALL: [Attribute; 19] = [
    CATCOV, CATDIS, CATZOC, DRVAL1, DUNITS, HUNITS, OBJNAM, ORIENT, RESTRN, TRAFIC, VALDCO, VALSOU, VERCLR,
    VERCCL, VERCSA, VERDAT, WATLEV, HORDAT, QUAPOS,
];

// Object classes of S-57 (edition 3.1, appendix A): code and acronym.

/// In the order of the codes.
#[rustfmt::skip]
const CLASSES: [(u16, &str); 179] = [
    (1, "ADMARE"), (2, "AIRARE"), (3, "ACHBRT"), (4, "ACHARE"), (5, "BCNCAR"), (6, "BCNISD"), (7, "BCNLAT"),
    (8, "BCNSAW"), (9, "BCNSPP"), (10, "BERTHS"), (11, "BRIDGE"), (12, "BUISGL"), (13, "BUAARE"),
    (14, "BOYCAR"), (15, "BOYINB"), (16, "BOYISD"), (17, "BOYLAT"), (18, "BOYSAW"), (19, "BOYSPP"),
    (20, "CBLARE"), (21, "CBLOHD"), (22, "CBLSUB"), (23, "CANALS"), (24, "CANBNK"), (25, "CTSARE"),
    (26, "CAUSWY"), (27, "CTNARE"), (28, "CHKPNT"), (29, "CGUSTA"), (30, "COALNE"), (31, "CONZNE"),
    (32, "COSARE"), (33, "CTRPNT"), (34, "CONVYR"), (35, "CRANES"), (36, "CURENT"), (37, "CUSZNE"),
    (38, "DAMCON"), (39, "DAYMAR"), (40, "DWRTCL"), (41, "DWRTPT"), (42, "DEPARE"), (43, "DEPCNT"),
    (44, "DISMAR"), (45, "DOCARE"), (46, "DRGARE"), (47, "DRYDOC"), (48, "DMPGRD"), (49, "DYKCON"),
    (50, "EXEZNE"), (51, "FAIRWY"), (52, "FNCLNE"), (53, "FERYRT"), (54, "FSHZNE"), (55, "FSHFAC"),
    (56, "FSHGRD"), (57, "FLODOC"), (58, "FOGSIG"), (59, "FORSTC"), (60, "FRPARE"), (61, "GATCON"),
    (62, "GRIDRN"), (63, "HRBARE"), (64, "HRBFAC"), (65, "HULKES"), (66, "ICEARE"), (67, "ICNARE"),
    (68, "ISTZNE"), (69, "LAKARE"), (70, "LAKSHR"), (71, "LNDARE"), (72, "LNDELV"), (73, "LNDRGN"),
    (74, "LNDMRK"), (75, "LIGHTS"), (76, "LITFLT"), (77, "LITVES"), (78, "LOCMAG"), (79, "LOKBSN"),
    (80, "LOGPON"), (81, "MAGVAR"), (82, "MARCUL"), (83, "MIPARE"), (84, "MORFAC"), (85, "NAVLNE"),
    (86, "OBSTRN"), (87, "OFSPLF"), (88, "OSPARE"), (89, "OILBAR"), (90, "PILPNT"), (91, "PILBOP"),
    (92, "PIPARE"), (93, "PIPOHD"), (94, "PIPSOL"), (95, "PONTON"), (96, "PRCARE"), (97, "PRDARE"),
    (98, "PYLONS"), (99, "RADLNE"), (100, "RADRNG"), (101, "RADRFL"), (102, "RADSTA"), (103, "RTPBCN"),
    (104, "RDOCAL"), (105, "RDOSTA"), (106, "RAILWY"), (107, "RAPIDS"), (108, "RCRTCL"), (109, "RECTRC"),
    (110, "RCTLPT"), (111, "RSCSTA"), (112, "RESARE"), (113, "RETRFL"), (114, "RIVERS"), (115, "RIVBNK"),
    (116, "ROADWY"), (117, "RUNWAY"), (118, "SNDWAV"), (119, "SEAARE"), (120, "SPLARE"), (121, "SBDARE"),
    (122, "SLCONS"), (123, "SISTAT"), (124, "SISTAW"), (125, "SILTNK"), (126, "SLOTOP"), (127, "SLOGRD"),
    (128, "SMCFAC"), (129, "SOUNDG"), (130, "SPRING"), (131, "SQUARE"), (132, "STSLNE"), (133, "SUBTLN"),
    (134, "SWPARE"), (135, "TESARE"), (136, "TS_PRH"), (137, "TS_PNH"), (138, "TS_PAD"), (139, "TS_TIS"),
    (140, "T_HMON"), (141, "T_NHMN"), (142, "T_TIMS"), (143, "TIDEWY"), (144, "TOPMAR"), (145, "TSELNE"),
    (146, "TSSBND"), (147, "TSSCRS"), (148, "TSSLPT"), (149, "TSSRON"), (150, "TSEZNE"), (151, "TUNNEL"),
    (152, "TWRTPT"), (153, "UWTROC"), (154, "UNSARE"), (155, "VEGATN"), (156, "WATTUR"), (157, "WATFAL"),
    (158, "WEDKLP"), (159, "WRECKS"), (160, "TS_FEB"), (161, "ARCSLN"), (162, "ASLXIS"), (163, "NEWOBJ"),
    (300, "M_ACCY"), (301, "M_CSCL"), (302, "M_COVR"), (303, "M_HDAT"), (304, "M_HOPA"), (305, "M_NPUB"),
    (306, "M_NSYS"), (307, "M_PROD"), (308, "M_QUAL"), (309, "M_SDAT"), (310, "M_SREL"), (311, "M_UNIT"),
    (312, "M_VDAT"), (400, "C_AGGR"), (401, "C_ASSO"), (402, "C_STAC"),
];

/// The acronym of a class; `None` for a code that the standard lacks.
pub fn class_name(code: u16) -> Option<&'static str> {
    CLASSES.binary_search_by_key(&code, |(known, _)| *known).ok().map(|k| CLASSES[k].1)
}

/// The code of a class; `None` for an acronym that the standard lacks.
pub fn class(acronym: &str) -> Option<u16> {
    CLASSES.iter().find(|(_, name)| *name == acronym).map(|(code, _)| *code)
}

/// An object: its class, position and attributes.
#[derive(Clone, Debug, PartialEq)]
pub struct Feature {
    /// Code of its class, see [`class_name`].
    pub class: u16,
    /// Its unique id in all editions: producer, number, subdivision.
    pub id: String,
    /// Its attributes, by code, see [`super`]; as text, empty where unknown.
    pub attributes: BTreeMap<u16, String>,
    /// Its position.
    pub geometry: Geometry,
    /// The stated quality of its positions (QUAPOS), if any.
    pub position_quality: Vec<u8>,
}

/// The position of an object: longitude and latitude \[deg\].
#[derive(Clone, Debug, PartialEq)]
pub enum Geometry {
    /// None: a statement about other objects.
    None,
    /// At points.
    Points(Vec<[f64; 2]>),
    /// Longitude, latitude, and depth \[m, positive down\].
    Soundings(Vec<[f64; 3]>),
    /// Along lines.
    Lines(Vec<Vec<[f64; 2]>>),
    /// Within polygons.
    Area(Vec<Polygon>),
}

impl Geometry {
    /// Number of places in it.
    pub fn places(&self) -> u64 {
        let all = match self {
            Self::None => 0,
            Self::Points(points) => points.len(),
            Self::Soundings(points) => points.len(),
            Self::Lines(lines) => lines.iter().map(Vec::len).sum(),
            Self::Area(polygons) => polygons.iter().flatten().map(Vec::len).sum(),
        };
        all as u64
    }
}

/// Closed rings: the outer one, then its holes.
pub type Polygon = Vec<Vec<[f64; 2]>>;

impl Feature {
    /// Its class and id, for messages.
    pub fn named(&self) -> String {
        match class_name(self.class) {
            Some(name) => format!("{name} {}", self.id),
            None => format!("class {} {}", self.class, self.id),
        }
    }

    /// An attribute that is a number; `None` where it is unknown.
    ///
    /// # Errors
    /// An attribute that is not a finite number.
    pub fn number(&self, (code, name): (u16, &str)) -> Result<Option<f64>, Invalid> {
        let Some(text) = self.attributes.get(&code).map(|text| text.trim()).filter(|text| !text.is_empty())
        else {
            return Ok(None);
        };
        match text.parse::<f64>().ok().filter(|v| v.is_finite()) {
            Some(value) => Ok(Some(value)),
            None => Err(Invalid::new(
                format!("{}, `{name}`", self.named()),
                format!("`{text}`"),
                "a number",
                "report it to the chart's producer",
            )),
        }
    }

    /// The numbers of an attribute that is a list, such as `7,14`; empty if it is unknown.
    pub fn list(&self, (code, _): (u16, &str)) -> Vec<u16> {
        let text = self.attributes.get(&code).map_or("", String::as_str);
        text.split(',').filter_map(|part| part.trim().parse().ok()).collect()
    }
}

/// The datums of a cell's heights and depths, by the codes of VERDAT.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Datums {
    /// Of heights and clearances (VDAT).
    pub heights: u8,
    /// Of depths (SDAT).
    pub depths: u8,
}

/// In the order of their codes, from 1, with `, ` between them.
const NAMES: &str = "\
    mean low water springs, mean lower low water springs, mean sea level, lowest low water, mean low \
    water, lowest low water springs, approximate mean low water springs, Indian spring low water, low \
    water springs, approximate lowest astronomical tide, nearly lowest low water, mean lower low water, \
    low water, approximate mean low water, approximate mean lower low water, mean high water, mean high \
    water springs, high water, approximate mean sea level, high water springs, mean higher high water, \
    equinoctial spring low water, lowest astronomical tide, local datum, International Great Lakes datum \
    1985, mean water level, lower low water large tide, higher high water large tide, nearly highest high \
    water, highest astronomical tide";

/// The name of a code of VERDAT; `None` if the standard lacks it.
pub fn vertical_datum(code: u8) -> Option<&'static str> {
    match code {
        44 => Some("Baltic Sea chart datum 2000"),
        _ => NAMES.split(", ").nth(usize::from(code).checked_sub(1)?),
    }
}
