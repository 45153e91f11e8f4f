//! Whether numbers of grids are positive up or down.

use chart::{Direction, GridKind};

#[test]
fn what_a_file_says_must_be_what_is_declared() {
    for (positive, name, fits) in [
        (None, None, [true, true]),
        (Some("Down"), None, [true, false]),
        (Some("up"), Some("land_ice_mask"), [false, true]),
        (Some("sideways"), None, [false, false]),
        (None, Some("sea_floor_depth_below_geoid"), [true, false]),
        (None, Some("height_above_mean_sea_level"), [false, true]),
    ] {
        let accepted =
            [GridKind::Depth, GridKind::Elevation].map(|kind| Direction::check(kind, positive, name).is_ok());
        assert_eq!(accepted, fits, "{positive:?} {name:?}");
        assert_eq!(Direction::check(GridKind::LandMask, positive, name), Ok(()));
    }
}
