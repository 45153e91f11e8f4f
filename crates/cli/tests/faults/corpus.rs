//! Damage that once caused a bug: it stays refused, in plain words.

use files::Column;
use parquet::file::metadata::{ParquetMetaData, ParquetMetaDataReader, ParquetMetaDataWriter};

use crate::ends::{ends, start, wait};
use crate::grounds::all;
use crate::places::{Place, unsealed};
use crate::readers::READERS;
use crate::support::craft;

/// A damaged input.
struct Case {
    /// The start of the command line.
    line: &'static str,
    file: &'static str,
    from: &'static str,
    to: &'static str,
    code: i32,
    /// What the refusal says.
    says: &'static [&'static str],
}

const CORPUS: [Case; 4] = [
    // It said: expected usize.
    Case {
        line: "plan --problem",
        file: "problem.json",
        from: "\"nx\": 6",
        to: "\"nx\": \"6\"",
        code: 3,
        says: &["found the text \"6\"", "expected a whole number from 0"],
    },
    // It blamed the output, in which no number may be infinite.
    Case {
        line: "validate --vessel vessel.toml --trajectories trajectories.parquet",
        file: "reference.toml",
        from: "limit_u = 2.0",
        to: "limit_u = inf",
        code: 3,
        says: &["reference.toml: `selection.limit_u`: found inf (line ", "), expected above 0 m/s"],
    },
    // It said: expected struct MoveFile.
    Case {
        line: "plan --problem",
        file: "problem.json",
        from: "\"moves\": [",
        to: "\"moves\": [-32768,",
        code: 3,
        says: &["found the number -32768", "expected a table"],
    },
    // It said: expected f64.
    Case {
        line: "plan --vessel",
        file: "land.geojson",
        from: "[24.998, 59.999]",
        to: "[\"FeatureCollection\", 59.999]",
        code: 3,
        says: &["found invalid type: string \"FeatureCollection\" at line"],
    },
];

#[test]
fn what_was_a_fault_once_is_none() {
    for case in &CORPUS {
        let (ground, stage) = all().into_iter().find(|(_, stage)| stage.line.starts_with(case.line)).unwrap();
        let mut place = Place::on(ground);
        let text = String::from_utf8(unsealed(place.original(case.file))).unwrap();
        assert!(text.contains(case.from), "{}: no `{}`", case.file, case.from);
        place.put(case.file, text.replacen(case.from, case.to, 1).as_bytes());
        let line = stage.line_into("out/");
        assert_eq!(ends(&place, &line), Ok(case.code), "{line}: {}", case.to);
        let told = wait(&place, start(&place, &line, "")).told;
        assert!(case.says.iter().all(|piece| told.contains(piece)), "{told}");
    }
}

/// Values of a table whose squares are infinite: the refusal names the table, not the output.
#[test]
fn magnitudes_that_no_ship_has_are_put_down_to_the_table() {
    for (line, file, kind, column, value) in [
        ("estimate --structure own --folds each", "campaign.parquet", "trajectories", "y_u", 1e200),
        ("estimate --vessel vessel.toml --gather", "estimates-2.parquet", "estimates", "X_u_se", -1e300),
        (
            "validate --vessel vessel.toml --campaign campaign.toml --val",
            "scores-2.parquet",
            "scores",
            "rmse_u",
            1e200,
        ),
    ] {
        let (ground, stage) = all().into_iter().find(|(_, stage)| stage.line.starts_with(line)).unwrap();
        let place = Place::on(ground);
        let path = place.path().join(file);
        let mut whole = craft::read(&path, kind);
        let i = whole.schema.columns.iter().position(|c| c.name == column).unwrap();
        let damaged = &mut whole.blocks[0].columns[i];
        *damaged = Column::nullable_f64(vec![value; damaged.len()], vec![true; damaged.len()]);
        std::fs::remove_file(&path).unwrap();
        whole.write(&path);
        let line = stage.line_into("out/");
        assert_eq!(ends(&place, &line), Ok(3), "{line}");
        let told = wait(&place, start(&place, &line, "")).told;
        assert!(told.contains(file) && told.contains("magnitudes up to 1e"), "{told}");
    }
}

/// Squared errors of a model that a prior keeps near divergence overflow; the output was blamed for them.
#[test]
fn errors_beyond_numbers_are_no_criticism() {
    let line = "estimate --structure own --vessel vessel.toml --trajectories campaign.parquet";
    let (ground, stage) = all().into_iter().find(|(_, stage)| stage.line.starts_with(line)).unwrap();
    let place = Place::on(ground);
    for words in ["--runs 1 --prior 1e-9", "--part-s 1"] {
        assert_eq!(ends(&place, &format!("{} {words}", stage.line_into("out/"))), Ok(0), "{words}");
    }
}

/// The library printed a line of its own, with a path of the machine that it was built on.
#[test]
fn a_chart_whose_text_lies_about_its_length_is_refused_in_one_line() {
    let mut place = Place::on(&READERS[0]);
    let stage = READERS[0].stages.iter().find(|stage| stage.reads[0] == "degrees/a.tif").unwrap();
    let mut bytes = place.original("degrees/a.tif").to_vec();
    let entry = bytes.windows(4).position(|part| part == [0x81, 0xA4, 2, 0]).unwrap();
    bytes[entry + 4..entry + 8].fill(0xFF);
    place.put("degrees/a.tif", &bytes);
    let line = stage.line_into("out/");
    assert_eq!(ends(&place, &line), Ok(3), "{line}");
    let told = wait(&place, start(&place, &line, "")).told;
    assert!(told.contains("a.tif: GeoTIFF, tag 42113: found a text of 4294967295 bytes"), "{told}");
}

/// The footer of a table whose first column begins before the file does.
fn with_negative_offset(metadata: ParquetMetaData) -> ParquetMetaData {
    let mut groups = metadata.row_groups().to_vec();
    let mut columns = groups[0].columns().to_vec();
    let first = columns[0].clone().into_builder().set_data_page_offset(-1).set_dictionary_page_offset(None);
    columns[0] = first.build().unwrap();
    groups[0] = groups[0].clone().into_builder().set_column_metadata(columns).build().unwrap();
    metadata.into_builder().set_row_groups(groups).build()
}

/// The decoder panics on it, and its message preceded the refusal.
#[test]
fn bytes_that_the_decoder_panics_on_are_refused_in_one_line() {
    let line = "moments --vessel vessel.toml --trajectories";
    let (ground, stage) = all().into_iter().find(|(_, stage)| stage.line.starts_with(line)).unwrap();
    let mut place = Place::on(ground);
    let bytes = unsealed(place.original("dictionary.parquet"));
    let length = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
    let body = bytes.len() - 8 - length(bytes.len() - 8);
    let metadata = ParquetMetaDataReader::decode_metadata(&bytes[body..bytes.len() - 8]).unwrap();
    let mut damaged = bytes[..body].to_vec();
    ParquetMetaDataWriter::new(&mut damaged, &with_negative_offset(metadata)).finish().unwrap();
    place.put("dictionary.parquet", &damaged);
    let line = stage.line_into("out/");
    assert_eq!(ends(&place, &line), Ok(3), "{line}");
    let told = wait(&place, start(&place, &line, "")).told;
    assert!(told.contains("bytes that cannot be decoded"), "{told}");
}
