//! Attributes that charts are judged by: code and acronym (IHO object catalogue, S-57 appendix A).

/// An attribute: its code and its acronym.
pub type Attribute = (u16, &'static str);

/// Whether an area is covered by data (1) or not (2).
pub const CATCOV: Attribute = (18, "CATCOV");
/// Whether a distance mark is there (2 to 5) or drawn only (1).
pub const CATDIS: Attribute = (21, "CATDIS");
/// Least depth of an area \[m\].
pub const DRVAL1: Attribute = (87, "DRVAL1");
/// Unit of depths in an area: 1 metres, 2 fathoms and feet, 3 feet, 4 fathoms and fractions.
pub const DUNITS: Attribute = (89, "DUNITS");
/// Unit of heights in an area: 1 metres, 2 feet.
pub const HUNITS: Attribute = (96, "HUNITS");
/// Name.
pub const OBJNAM: Attribute = (116, "OBJNAM");
/// Restrictions: 7 entry prohibited, 8 entry restricted, 14 area to be avoided, and others.
pub const RESTRN: Attribute = (131, "RESTRN");
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
/// Water level effect: 1 partly and 2 always dry, 3 always under water, 4 covers and uncovers, 5 awash, 7
/// floating.
pub const WATLEV: Attribute = (187, "WATLEV");
/// Datum of heights or depths in an area, see [`crate::enc::vertical_datum`].
pub const VERDAT: Attribute = (185, "VERDAT");
/// Horizontal datum of an area: 2 is WGS84.
pub const HORDAT: Attribute = (400, "HORDAT");
/// Quality of a position: 1 surveyed, 4 approximate, 5 doubtful, 10 precisely known, and others.
pub const QUAPOS: Attribute = (402, "QUAPOS");

/// All of these.
pub const ALL: [Attribute; 16] = [
    CATCOV, CATDIS, DRVAL1, DUNITS, HUNITS, OBJNAM, RESTRN, VALDCO, VALSOU, VERCLR, VERCCL, VERCSA, VERDAT,
    WATLEV, HORDAT, QUAPOS,
];
