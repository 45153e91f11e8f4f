//! Vertical datums of S-57 (attribute VERDAT; VDAT and SDAT of a cell).

/// The datums of a cell's heights and depths, by the codes of VERDAT.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Datums {
    /// Of heights and clearances (VDAT).
    pub heights: u8,
    /// Of depths (SDAT).
    pub depths: u8,
}

/// In the order of their codes, from 1.
const NAMES: [&str; 30] = [
    "mean low water springs",
    "mean lower low water springs",
    "mean sea level",
    "lowest low water",
    "mean low water",
    "lowest low water springs",
    "approximate mean low water springs",
    "Indian spring low water",
    "low water springs",
    "approximate lowest astronomical tide",
    "nearly lowest low water",
    "mean lower low water",
    "low water",
    "approximate mean low water",
    "approximate mean lower low water",
    "mean high water",
    "mean high water springs",
    "high water",
    "approximate mean sea level",
    "high water springs",
    "mean higher high water",
    "equinoctial spring low water",
    "lowest astronomical tide",
    "local datum",
    "International Great Lakes datum 1985",
    "mean water level",
    "lower low water large tide",
    "higher high water large tide",
    "nearly highest high water",
    "highest astronomical tide",
];

/// The name of a code of VERDAT; `None` if the standard lacks it.
pub fn vertical_datum(code: u8) -> Option<&'static str> {
    match code {
        44 => Some("Baltic Sea chart datum 2000"),
        _ => NAMES.get(usize::from(code).checked_sub(1)?).copied(),
    }
}
