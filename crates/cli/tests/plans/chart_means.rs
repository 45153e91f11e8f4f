//! The memory of charts is bounded: grids are read in the window of the area, and refused before allocation.

use std::io::{Seek, SeekFrom, Write};

use crate::grid_files::*;
use crate::planned::*;
use crate::support::*;
use crate::units::{METRES, SHOAL, over_a_shoal, scaled};

/// A tile of 10,000 × 10,000 cells, of which the area has some thousands: the file has 200 MB of zeros except for the
/// shoal.
#[cfg(target_os = "linux")]
#[test]
fn law_of_a_vast_tile_the_window_is_read() {
    const SIDE: usize = 10_000;
    let packed = Packed { numbers: Numbers::I16, offset: 20.0, missing: -32768.0, ..METRES };
    let tile = Basin { west_deg: 20.0, south_deg: 55.0, ..Basin::with_a_shoal() };
    let scale = scaled(1.0, 20.0, "m");
    let [start, end] = tiff_around(&tile, [SIDE; 2], &packed, Some("-32768"), Some(&scale), &[]);
    let folder = over_a_shoal("own.tif", "kind = \"depth\"", &start);
    let mut file = std::fs::OpenOptions::new().write(true).open(folder.path().join("own.tif")).unwrap();
    let at = |row: usize, column: usize| {
        SeekFrom::Start((start.len() + 2 * ((SIDE - 1 - row) * SIDE + column)) as u64)
    };
    file.set_len((start.len() + 2 * SIDE * SIDE) as u64).unwrap();
    file.seek(SeekFrom::End(0)).unwrap();
    file.write_all(&end).unwrap();
    // Where the small basin has its shoal: 24.90 to 24.92 E, 60.10 to 60.12 N. A cell without data stands beside it.
    for row in 5100..5120 {
        file.seek(at(row, 4900)).unwrap();
        file.write_all(&(-17_i16).to_le_bytes().repeat(20)).unwrap();
    }
    file.seek(at(5095, 4895)).unwrap();
    file.write_all(&i16::MIN.to_le_bytes()).unwrap();
    drop(file);
    let (code, peak) = crate::budget::peak_mib(&folder, &format!("{PLAN} --memory-mib 512"));
    assert!(code == Some(4) && peak > 1.0 && peak < 160.0, "{code:?} {peak} MiB");
    run(&folder, PLAN).refuses(4, &SHOAL);
}

/// 16,000 × 16,000 cells within the area: refused before any is read; the file does not contain them.
#[test]
fn a_grid_of_more_cells_than_fit_is_refused_before_it_is_read() {
    let cell_deg = 2.5e-6;
    let row = Basin {
        columns: 16_000,
        west_deg: 24.89,
        south_deg: 60.13 - cell_deg,
        cell_deg,
        depths_m: vec![None; 16_000],
    };
    let mut chart = tiff(&row, &METRES, None, None, &[]);
    for (tag, from) in [(257_u16, 1_u32), (278, 7)] {
        let entry = |value: u32| [&tag.to_le_bytes()[..], &[4, 0, 1, 0, 0, 0], &value.to_le_bytes()].concat();
        let at = chart.windows(12).position(|window| window == entry(from)).unwrap();
        chart.splice(at..at + 12, entry(16_000));
    }
    let folder = over_a_shoal("own.tif", "kind = \"depth\"", &chart);
    let pieces = ["own.tif", "grid", "16000 × 16000 cells around the area", "256 MiB of --memory-mib"];
    refused(&folder, 3, &format!("{PLAN} --memory-mib 256"), &pieces);
    let vast = "ncols 900000\nnrows 900000\nxllcorner 0\nyllcorner 0\ncellsize 0.0001\n1 2 3\n";
    let folder = over_a_shoal("own.asc", "kind = \"depth\"\ncrs = \"WGS84\"", vast.as_bytes());
    refused(&folder, 3, PLAN, &["own.asc", "900000 × 900000 values"]);
}

#[test]
fn a_time_that_is_over_ends_the_reading_of_charts() {
    let line = format!("{PLAN} --time-limit-s 0.000001");
    refused(
        &small(),
        4,
        &line,
        &["plan.toml", "none in time", "the reading of its charts", "--time-limit-s"],
    );
}

#[cfg(unix)]
#[test]
fn pipes_are_no_charts() {
    for name in ["own.geojson", "own.tif", "own.asc"] {
        let folder = over_a_shoal(name, "kind = \"depth\"\ncrs = \"WGS84\"", b"");
        let path = folder.path().join(name);
        std::fs::remove_file(&path).unwrap();
        assert!(std::process::Command::new("mkfifo").arg(&path).status().unwrap().success());
        run(&folder, PLAN).refuses(3, &[name, "a pipe"]);
    }
}
