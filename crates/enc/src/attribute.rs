//! Attributes of objects that charts are judged by: code and acronym (IHO object catalogue, S-57 appendix A).

/// An attribute: its code and its acronym.
pub type Attribute = (u16, &'static str);

/// Whether an area is covered by data (1) or not (2).
pub const CATCOV: Attribute = (18, "CATCOV");
/// Least depth of an area \[m\].
pub const DRVAL1: Attribute = (87, "DRVAL1");
/// Name.
pub const OBJNAM: Attribute = (116, "OBJNAM");
/// What is not allowed: 7 entry prohibited, 8 entry restricted, 14 area to be avoided, and others.
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
/// How water stands over it: 1 partly and 2 always dry, 3 always under water, 4 covers and uncovers, 5 awash, 7 floating.
pub const WATLEV: Attribute = (187, "WATLEV");
/// Quality of a position: 1 surveyed, 4 approximate, 5 doubtful, 10 precisely known, and others.
pub const QUAPOS: Attribute = (402, "QUAPOS");

/// All of these.
pub const ALL: [Attribute; 11] =
    [CATCOV, DRVAL1, OBJNAM, RESTRN, VALDCO, VALSOU, VERCLR, VERCCL, VERCSA, WATLEV, QUAPOS];
