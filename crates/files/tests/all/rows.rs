//! Rows as tables and back.

use files::{Columns, Provenance, TableReader, TableWriter, commit};
use serde::{Deserialize, Serialize};

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
enum Sky {
    #[serde(rename = "half cloudy")]
    Half,
    Clear,
}

#[derive(Clone, Debug, PartialEq)]
struct Row {
    place: String,
    sky: Sky,
    run: i32,
    depth: f64,
    speeds: Vec<Option<f64>>,
}

fn columns(speeds: usize) -> Columns<Row> {
    let fixed = Columns::<Row>::new("places", 1)
        .text("place", |row| &row.place, |row, place| row.place = place.to_owned())
        .choice("sky", |row| row.sky, |row, sky| row.sky = sky)
        .integer("run", "1", |row| row.run, |row, run| row.run = run)
        .number("depth", "m", |row| row.depth, |row, depth| row.depth = depth);
    (0..speeds).fold(fixed, |columns, i| {
        columns.optional(format!("u{i}"), "m/s", move |row| row.speeds[i], move |row, u| row.speeds[i] = u)
    })
}

fn row(place: &str, sky: Sky, run: i32, depth: f64, speeds: [Option<f64>; 2]) -> Row {
    Row { place: place.to_owned(), sky, run, depth, speeds: speeds.into() }
}

/// Writes `blocks` with the columns of `columns` and opens the file.
fn written<R: 'static>(columns: &Columns<R>, blocks: &[&[R]]) -> (tempfile::TempDir, TableReader) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("places.parquet");
    let mut writer = TableWriter::create(&path, columns.schema(), &Provenance::default()).unwrap();
    blocks.iter().for_each(|rows| writer.push(columns.encode(rows).unwrap()).unwrap());
    commit(vec![writer.finish().unwrap()]).unwrap();
    let reader = TableReader::open(&path, "places", 1).unwrap();
    (folder, reader)
}

#[test]
fn law_rows_come_back_as_they_were_written() {
    let first = [
        row("Utö", Sky::Half, 0, 4.5, [Some(1.0), None]),
        row("", Sky::Clear, -7, 0.0, [None, Some(-2.5)]),
        row("Utö", Sky::Clear, 1, 1e-9, [None, None]),
    ];
    let second = [row("Hanko", Sky::Half, i32::MAX, -3.0, [Some(0.0), Some(1.0)])];
    let columns = columns(2);
    let (_folder, reader) = written(&columns, &[&first, &second]);
    let blank = row("blank", Sky::Half, 99, 99.0, [Some(99.0); 2]);
    assert_eq!(columns.read(&reader, &blank).unwrap(), [&first[..], &second[..]].concat());
    assert_eq!(columns.read_block(&reader, 1, &blank).unwrap(), second);
}

#[test]
fn an_unknown_name_is_refused_with_its_row_in_the_file_and_the_known_ones() {
    let sky = || Columns::<String>::new("places", 1).text("sky", |sky| sky, |row, sky| *row = sky.to_owned());
    let text = |sky: &str| sky.to_owned();
    let (_folder, reader) = written(&sky(), &[&[text("Clear")], &[text("half cloudy"), text("dark")]]);
    let read = Columns::<Sky>::new("places", 1).choice("sky", |sky| *sky, |row, sky| *row = sky);
    let line = read.read(&reader, &Sky::Half).unwrap_err().to_string();
    let expected = "column `sky`, row 2: found `dark`, expected one of `half cloudy`, `Clear`";
    assert!(line.contains(expected), "{line}");
}
