//! Grids in the form that agencies publish: GeoTIFF.

use std::io::Cursor;
use std::path::{Path, PathBuf};

use chart::{Crs, Grid, GridCell, GridDeclaration, GridKind, Reading, Unread};
use serde_json::Value;

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn bytes(name: &str) -> Vec<u8> {
    std::fs::read(repository().join("fixtures/charts/grids").join(name)).unwrap()
}

fn declared(name: &str) -> GridDeclaration {
    let kind = if name.starts_with("depth") { GridKind::Depth } else { GridKind::Elevation };
    GridDeclaration { kind, crs: None, unit: None, open_sea: false }
}

fn read(bytes: Vec<u8>, declared: &GridDeclaration) -> Result<Grid, Unread> {
    Grid::from_tiff(Cursor::new(bytes), declared, &Reading::whole())
}

#[test]
fn oracle_grids_are_read_as_gdal_reads_them() {
    let text = std::fs::read_to_string(repository().join("fixtures/oracle/grids.json")).unwrap();
    let expected: Vec<Value> = serde_json::from_str(&text).unwrap();
    assert_eq!(expected.len(), 2);
    for own in &expected {
        let name = own["file"].as_str().unwrap();
        let declared = declared(name);
        let grid = read(bytes(name), &declared).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_eq!(grid.crs.name(), own["crs"].as_str().unwrap(), "{name}");
        let corner: [f64; 2] = serde_json::from_value(own["corner"].clone()).unwrap();
        let near = |a: f64, b: f64| (a - b).abs() <= 1e-9 * b.abs().max(1.0);
        assert!(
            near(grid.corner[0], corner[0]) && near(grid.corner[1], corner[1]),
            "{name}: {:?}",
            grid.corner
        );
        assert!(near(grid.cell, own["cell"].as_f64().unwrap()), "{name}: {}", grid.cell);
        let rows: Vec<Vec<Option<f64>>> = serde_json::from_value(own["values"].clone()).unwrap();
        assert_eq!([grid.rows, grid.columns], [rows.len(), rows[0].len()]);
        let sign = if declared.kind == GridKind::Depth { 1.0 } else { -1.0 };
        for (cell, value) in grid.cells().zip(rows.iter().rev().flatten()) {
            let same = match (cell, value) {
                (GridCell::Missing, None) => true,
                (GridCell::Depth(depth), Some(value)) => depth as f32 == (sign * value) as f32,
                _ => false,
            };
            assert!(same, "{name}: {cell:?} {value:?}");
        }
    }
}

#[test]
fn what_a_file_does_not_say_or_says_otherwise_is_refused() {
    let said = |bytes, declared| read(bytes, &declared).map(|_| ()).unwrap_err().to_string();
    let crs = Some(Crs::new("EPSG:32634").unwrap());
    let other = said(bytes("depth_utm.tif"), GridDeclaration { crs, ..declared("depth") });
    assert!(other.contains("`crs`") && other.contains("EPSG:32635, as the file says"), "{other}");
    let foreign = said(b"CDF\x01 and so on".to_vec(), declared("depth"));
    assert!(foreign.contains("GeoTIFF") && foreign.contains("a whole GeoTIFF"), "{foreign}");
}

#[test]
fn damaged_files_are_refused_or_read_and_never_panic() {
    for name in ["depth_utm.tif", "elevation_point.tif"] {
        let (whole, declared) = (bytes(name), declared(name));
        for cut in (0..whole.len()).step_by(53) {
            let _ = read(whole[..cut].to_vec(), &declared);
        }
        let mut state = 1_u64;
        for _ in 0..300 {
            let mut damaged = whole.clone();
            for _ in 0..3 {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                let at = (state >> 33) as usize % damaged.len();
                damaged[at] = (state >> 20) as u8;
            }
            let _ = read(damaged, &declared);
        }
    }
}

/// Deflated blocks have a checksum each; here they are all that stands behind the tags.
#[test]
fn law_flipped_bits_of_deflated_blocks_are_refused_or_change_nothing() {
    let (whole, own) = (bytes("depth_utm.tif"), declared("depth_utm.tif"));
    let cells = |grid: &Grid| format!("{:?}", grid.cells().collect::<Vec<_>>());
    let healthy = cells(&read(whole.clone(), &own).unwrap());
    for at in 430..whole.len() {
        let mut damaged = whole.clone();
        damaged[at] ^= 1 << (at % 8);
        let found = read(damaged, &own);
        assert!(found.is_err() || found.is_ok_and(|grid| cells(&grid) == healthy), "silent: byte {at}");
    }
}

/// The library printed a line of its own for a text that says it is longer than the file.
#[test]
fn texts_of_tags_that_lie_about_their_length_are_refused_by_the_tag() {
    let mut lying = bytes("elevation_point.tif");
    let entry = lying.windows(4).position(|part| part == [0x81, 0xA4, 2, 0]).unwrap();
    lying[entry + 4..entry + 8].fill(0xFF);
    let said = read(lying, &declared("elevation")).map(drop).unwrap_err().to_string();
    assert!(said.contains("tag 42113: found a text of 4294967295 bytes"), "{said}");
}
