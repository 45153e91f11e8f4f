//! What ESRI ASCII grids are read and refused.

use chart::{Crs, Grid, GridCell, GridDeclaration, GridKind, Reading};

use crate::support::fixture;

fn read(text: &str, kind: GridKind) -> Result<Grid, String> {
    let declared =
        GridDeclaration { kind, crs: Some(Crs::new("EPSG:32635").unwrap()), unit: None, open_sea: false };
    Grid::from_ascii(text, &declared, &Reading::whole()).map_err(|e| e.to_string())
}

#[test]
fn rows_run_from_south_to_north_and_depths_positive_down() {
    let grid = read(&fixture("depth_5x4.asc"), GridKind::Depth).unwrap();
    assert_eq!((grid.columns, grid.rows, grid.corner, grid.cell), (5, 4, [500_000.0, 6_650_000.0], 100.0));
    let cells: Vec<GridCell> = grid.cells().collect();
    assert_eq!(cells[0], GridCell::Depth(-0.5));
    assert_eq!(cells[15], GridCell::Depth(12.5));
    assert_eq!(cells[19], GridCell::Missing);
}

#[test]
fn elevations_and_cell_centres_say_the_same() {
    let depth = read(&fixture("depth_5x4.asc"), GridKind::Depth).unwrap();
    let elevation = read(&fixture("elevation_5x4.asc"), GridKind::Elevation).unwrap();
    assert!(depth.cells().eq(elevation.cells()));
    assert_eq!(depth.corner, elevation.corner);
}

#[test]
fn wrong_shapes_and_numbers_are_refused() {
    let good = fixture("depth_5x4.asc");
    let cases = [
        (good.replace("cellsize 100", "cellsize 0"), "`cellsize`"),
        (good.replace("cellsize 100", "cellsize -25"), "`cellsize`"),
        (good.replace("cellsize 100\n", ""), "`cellsize`"),
        (good.replace("cellsize 100", "cellsize NaN"), "line 5"),
        (good.replace("ncols 5", "ncols 6"), "6 values"),
        (good.replace("ncols 5", "ncols 5.5"), "`ncols`"),
        (good.replace("ncols 5", "ncols 1e99"), "`ncols`"),
        (good.replace("ncols 5", "ncols 4").replace("nrows 4", "nrows 5"), "4 values"),
        (good.replace("nrows 4", "nrows 5"), "5 rows"),
        (good.replace("nrows 4", "nrows 3"), "3 rows"),
        (good.replace("ncols 5", "ncols 5\nncols 5"), "twice"),
        (good.replace("xllcorner", "xcorner"), "xcorner"),
        (good.replace("12.5", "NaN"), "`NaN`"),
        (good.replace("12.5", "inf"), "`inf`"),
        (good.replace("12.5", "12,5"), "`12,5`"),
        (good[..good.len() - 8].to_owned(), "values"),
        (good[..good.len() - 20].to_owned(), "rows"),
        (String::new(), "cellsize"),
        ("nan nan\n".to_owned(), "cellsize"),
    ];
    for (text, expected) in cases {
        let message = read(&text, GridKind::Depth).unwrap_err();
        assert!(message.contains(expected) && !message.contains('\n'), "{expected}: {message}");
    }
}

#[test]
fn values_that_stand_for_no_data_are_refused_unless_the_header_names_them() {
    let good = fixture("depth_5x4.asc");
    for fill in ["9.97e36", "-32768", "32767", "99999"] {
        for kind in [GridKind::Depth, GridKind::Elevation] {
            let message = read(&good.replace("12.5", fill), kind).unwrap_err();
            assert!(message.contains("of 20 cells") && message.contains("NODATA_value"), "{fill}: {message}");
        }
    }
}

#[test]
fn signs_that_look_wrong_are_refused_naming_the_other() {
    let rows = |values: &str| format!("ncols 3\nnrows 1\nxllcorner 0\nyllcorner 0\ncellsize 1\n{values}\n");
    let cases = [
        ("-5 -7 -9999", GridKind::Depth, "declare it as `elevation`"),
        ("5 7 -9999", GridKind::Elevation, "declare it as `depth`"),
        ("5 7 9", GridKind::Depth, "`elevation`"),
        ("-5 -7 -9", GridKind::Elevation, "`depth`"),
        ("0 1 2", GridKind::LandMask, "`depth`"),
        ("-9999 -9999 -9999", GridKind::Depth, "no cell with data"),
    ];
    for (values, kind, remedy) in cases {
        let message = read(&rows(values), kind).unwrap_err();
        assert!(message.contains(remedy), "{message}");
    }
    assert!(read(&rows("5 7 9"), GridKind::Depth).unwrap_err().contains("5..9"));
    assert!(read(&rows("5 7 -9999"), GridKind::Depth).is_ok());
    assert!(read(&rows("5 7 -1"), GridKind::Depth).is_ok());
    assert!(read(&rows("0 1 -9999"), GridKind::LandMask).is_ok());
    let crs = Crs::new("WGS84").unwrap();
    let sea = GridDeclaration { kind: GridKind::Depth, crs: Some(crs), unit: None, open_sea: true };
    assert!(Grid::from_ascii(&rows("5 7 9"), &sea, &Reading::whole()).is_ok());
    assert!(Grid::from_ascii(&rows("-5 -7 -9"), &sea, &Reading::whole()).is_err());
}
