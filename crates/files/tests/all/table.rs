//! Writing and reading tables.

use files::{
    Column, ColumnSpec, Digest, Kind, PIECE_ROWS, Provenance, Table, TableReader, TableSchema, TableWriter,
    encode_block,
};
use proptest::prelude::*;

use crate::sample::{self, ROWS, block, folder, provenance, refusal, schema, spec, write};

fn bits(column: &Column) -> Vec<Option<u64>> {
    let values = column.as_f64().unwrap();
    (0..values.len()).map(|row| (!column.is_null(row)).then(|| values[row].to_bits())).collect()
}

fn texts(column: &Column) -> Vec<&str> {
    (0..column.len()).map(|row| column.text_at(row).unwrap()).collect()
}

#[test]
fn what_is_written_is_read_back() {
    let folder = folder();
    let path = write(&folder, "t.parquet", &provenance(), 0..3);
    let reader = TableReader::open(&path, "trajectories", 2).unwrap();
    assert_eq!(reader.columns(), schema().columns);
    assert_eq!(reader.provenance(), &provenance());
    assert_eq!(reader.digest(), Digest::of_file(&path).unwrap());
    assert_eq!(
        (reader.rows(), reader.blocks(), reader.block_rows(2), reader.block_rows(3)),
        (3 * ROWS, 3, ROWS, 0)
    );
    for i in 0..3 {
        let read = reader.read_block(i, &["tau1", "maneuver", "u", "run"]).unwrap().columns;
        let written = block(i).columns;
        assert_eq!(texts(&read[1]), texts(&written[0]));
        assert_eq!(read[3].as_i32(), written[1].as_i32());
        assert_eq!(bits(&read[2]), bits(&written[2]));
        assert_eq!(bits(&read[0]), bits(&written[3]));
        assert_eq!(read[0].nulls(), 1);
        assert!(read[0].as_f64().unwrap()[ROWS - 1].is_nan());
    }
}

#[test]
fn readers_of_arrow_find_a_schema_in_the_footer() {
    let folder = folder();
    let found = |name: &str, rows| {
        let bytes = std::fs::read(write(&folder, name, &provenance(), rows)).unwrap();
        let text = String::from_utf8_lossy(&bytes).into_owned();
        // Followed by the value's mark, its length in two bytes, and the first bytes of every schema message in base 64
        text.split_once("ARROW:schema").unwrap().1.split_once("/////").unwrap().1[..500].to_owned()
    };
    assert_eq!(found("some.parquet", 0..3), found("none.parquet", 0..0));
}

#[test]
fn a_table_without_rows_keeps_its_columns() {
    let folder = folder();
    let path = write(&folder, "t.parquet", &provenance(), 0..0);
    let reader = TableReader::open(&path, "trajectories", 2).unwrap();
    assert_eq!((reader.rows(), reader.blocks(), reader.columns().len()), (0, 0, 4));
    assert!(refusal(reader.read_block(0, &["u"])).contains("found block 0"));
}

#[test]
fn a_block_without_rows_leaves_no_trace() {
    let folder = folder();
    let empty =
        vec![Column::text(vec![], vec![]), Column::i32(vec![]), Column::f64(vec![]), Column::f64(vec![])];
    let mut blocks = sample::encode(0..2);
    blocks.insert(1, encode_block(&schema(), &Table { columns: empty }).unwrap());
    let path = folder.path().join("with");
    files::commit(vec![sample::stage(&path, &provenance(), blocks).unwrap()]).unwrap();
    let without = write(&folder, "without", &provenance(), 0..2);
    assert_eq!(std::fs::read(path).unwrap(), std::fs::read(without).unwrap());
}

#[test]
fn a_block_that_is_written_by_columns_has_the_same_bytes() {
    let folder = folder();
    let whole = write(&folder, "whole", &provenance(), 0..3);
    let path = folder.path().join("by columns");
    // The inputs may be set at the end.
    let unknown = Provenance { inputs: Default::default(), ..provenance() };
    let mut writer = TableWriter::create(&path, &schema(), &unknown).unwrap();
    for i in 0..3 {
        let Table { columns } = sample::block(i);
        let column =
            |i: usize| Box::new(std::iter::once(columns[i].clone())) as Box<dyn Iterator<Item = Column>>;
        writer.write(&schema(), columns[0].len(), column).unwrap();
    }
    writer.set_inputs(&provenance());
    files::commit(vec![writer.finish().unwrap()]).unwrap();
    assert_eq!(std::fs::read(path).unwrap(), std::fs::read(whole).unwrap());
}

#[test]
fn a_long_block_that_is_written_in_pieces_has_the_same_bytes() {
    let spec =
        |name: &str, kind, nullable| ColumnSpec { name: name.into(), unit: "1".into(), kind, nullable };
    let columns =
        vec![spec("x", Kind::F64, true), spec("k", Kind::I32, false), spec("name", Kind::Text, false)];
    let schema = TableSchema { id: "long", version: 1, columns };
    let rows = 3 * PIECE_ROWS + 1000;
    let part = |rows: std::ops::Range<usize>| {
        let x = rows.clone().map(|i| (i as f64).sqrt()).collect();
        let codes = rows.clone().map(|i| (i / 50_000) as u32).collect();
        let labels = (0..5).map(|i| format!("label {i}")).collect();
        let present = rows.clone().map(|i| i % 7 > 0).collect();
        let k = rows.map(|i| i as i32).collect();
        vec![Column::nullable_f64(x, present), Column::i32(k), Column::text(labels, codes)]
    };
    let folder = folder();
    let [whole, pieces] = ["whole", "pieces"].map(|name| folder.path().join(name));
    let mut writer = TableWriter::create(&whole, &schema, &provenance()).unwrap();
    writer.push(encode_block(&schema, &Table { columns: part(0..rows) }).unwrap()).unwrap();
    files::commit(vec![writer.finish().unwrap()]).unwrap();
    let parts = |end: usize, i: usize| {
        let part = move |start: usize| part(start..(start + PIECE_ROWS).min(end)).swap_remove(i);
        Box::new((0..end).step_by(PIECE_ROWS).map(part)) as Box<dyn Iterator<Item = Column>>
    };
    let mut writer = TableWriter::create(&pieces, &schema, &provenance()).unwrap();
    writer.write(&schema, rows, |i| parts(rows, i)).unwrap();
    files::commit(vec![writer.finish().unwrap()]).unwrap();
    assert!(std::fs::read(&pieces).unwrap() == std::fs::read(whole).unwrap());
    // A refused block leaves no file.
    let mut writer = TableWriter::create(&pieces, &schema, &provenance()).unwrap();
    let refused = refusal(writer.write(&schema, rows, |i| parts(rows - i, i)));
    assert!(
        refused.contains(&format!("column `k`: found {} rows, expected {rows} rows", rows - 1)),
        "{refused}"
    );
    assert!(writer.finish().is_err());
    let mut writer = TableWriter::create(&pieces, &schema, &provenance()).unwrap();
    let damaged = |i: usize| {
        let late = parts(rows, i)
            .enumerate()
            .map(|(n, piece)| if n < 2 { piece } else { Column::f64(vec![f64::NAN]) });
        Box::new(late) as Box<dyn Iterator<Item = Column>>
    };
    let refused = refusal(writer.write(&schema, rows, damaged));
    assert!(refused.contains(&format!("column `x`, row {}", 2 * PIECE_ROWS)), "{refused}");
}

#[test]
fn bytes_do_not_depend_on_who_encodes_when() {
    let folder = folder();
    let alone = write(&folder, "alone", &provenance(), 0..4);
    let mut blocks: Vec<_> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..4).rev().map(|i| scope.spawn(move || sample::encode(i..i + 1))).collect();
        threads.into_iter().flat_map(|thread| thread.join().unwrap()).collect()
    });
    blocks.reverse();
    let path = folder.path().join("threads");
    files::commit(vec![sample::stage(&path, &provenance(), blocks).unwrap()]).unwrap();
    assert_eq!(std::fs::read(path).unwrap(), std::fs::read(alone).unwrap());
}

#[test]
fn many_threads_read_one_reader() {
    let folder = folder();
    let path = write(&folder, "t.parquet", &provenance(), 0..8);
    let reader = &TableReader::open(&path, "trajectories", 2).unwrap();
    std::thread::scope(|scope| {
        for i in (0..8).cycle().take(64) {
            scope.spawn(move || {
                let read = reader.read_block(i, &["u"]).unwrap();
                assert_eq!(read.columns[0].as_f64(), block(i).columns[2].as_f64());
            });
        }
    });
}

#[test]
fn a_file_that_is_replaced_is_still_read_as_checked() {
    let folder = folder();
    let path = write(&folder, "t.parquet", &provenance(), 0..2);
    let reader = TableReader::open(&path, "trajectories", 2).unwrap();
    write(&folder, "t.parquet", &provenance(), 5..6);
    let read = reader.read_block(1, &["run"]).unwrap();
    assert_eq!(read.columns[0].as_i32(), block(1).columns[1].as_i32());
}

#[test]
fn all_missing_columns_are_named_at_once() {
    let folder = folder();
    let reader =
        TableReader::open(write(&folder, "t.parquet", &provenance(), 0..1), "trajectories", 2).unwrap();
    reader.require(&schema().columns).unwrap();
    let wanted = [
        spec("tau2", "N", Kind::F64, true),
        spec("u", "m/s", Kind::F64, false),
        spec("v", "m/s", Kind::F64, false),
    ];
    let line = refusal(reader.require(&wanted));
    assert!(
        line.contains("expected also `tau2`, `v`") && line.contains("nearest in the file: `tau1`"),
        "{line}"
    );
    let line = refusal(reader.read_block(0, &["tau2", "v"]));
    assert!(line.contains("`tau2`, `v`"), "{line}");
}

#[test]
fn another_unit_or_type_is_refused() {
    let folder = folder();
    let reader =
        TableReader::open(write(&folder, "t.parquet", &provenance(), 0..1), "trajectories", 2).unwrap();
    let line =
        refusal(reader.require(&[spec("u", "km/h", Kind::F64, false), spec("run", "1", Kind::F64, false)]));
    assert!(line.contains("t.parquet: column `u`, `run`: found f64 in unit m/s, i32 in unit 1, "), "{line}");
    assert!(line.contains("expected f64 in unit km/h, f64 in unit 1; convert"), "{line}");
}

#[test]
fn another_kind_or_version_is_refused() {
    let folder = folder();
    let path = write(&folder, "t.parquet", &provenance(), 0..1);
    let later = refusal(TableReader::open(&path, "trajectories", 1));
    assert!(later.contains("found trajectories/2, expected trajectories/1; upgrade seatrial or"), "{later}");
    let earlier = refusal(TableReader::open(&path, "trajectories", 3));
    assert!(
        earlier.contains("found trajectories/2, expected trajectories/3; write the file again"),
        "{earlier}"
    );
    let other = refusal(TableReader::open(&path, "scores", 2));
    assert!(other.contains("found trajectories/2, expected scores/2; name a file of kind scores"), "{other}");
}

#[test]
fn files_of_other_formats_are_refused() {
    let folder = folder();
    for (name, bytes) in [
        ("empty", &b""[..]),
        ("text", b"u,v\n1,2\n"),
        ("magic", b"PAR1PAR1PAR1"),
        ("only", b"PAR1\0\0\0\0PAR1"),
    ] {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        refusal(TableReader::open(&path, "trajectories", 2));
    }
    let missing = TableReader::open(folder.path().join("none"), "trajectories", 2).unwrap_err();
    assert!(matches!(missing, files::Error::Io { action: "read", .. }));
}

#[test]
fn numbers_that_are_not_finite_are_refused() {
    for wrong in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let mut table = block(0);
        let mut values = vec![1.0; ROWS];
        values[7] = wrong;
        table.columns[2] = Column::f64(values);
        let line = refusal(encode_block(&schema(), &table));
        assert!(line.starts_with("trajectories: column `u`, row 7 of the block: found"), "{line}");
    }
    let mut table = block(0);
    table.columns[3] = Column::nullable_f64(vec![f64::NAN; ROWS], (0..ROWS).map(|row| row == 9).collect());
    assert!(refusal(encode_block(&schema(), &table)).contains("column `tau1`, row 9"));
}

#[test]
fn blocks_that_do_not_fit_their_schema_are_refused() {
    let with = |i: usize, column: Column| {
        let mut table = block(0);
        table.columns[i] = column;
        refusal(encode_block(&schema(), &table))
    };
    assert!(with(1, Column::f64(vec![1.0; ROWS])).contains("found f64, expected i32"));
    assert!(with(1, Column::i32(vec![1; 3])).contains("found 3 rows, expected 50 rows"));
    assert!(
        with(0, Column::text(vec!["a".into()], vec![1; ROWS]))
            .contains("row 0 of the block: found label number 1")
    );
    let absent = Column::nullable_f64(vec![1.0; ROWS], vec![true; 20]);
    assert!(with(2, absent).contains("column `u`, row 20 of the block: found no value"));
    assert!(
        refusal(encode_block(&schema(), &Table::default())).contains("found 0 columns, expected 4 columns")
    );
}

#[test]
fn a_block_of_another_schema_is_refused() {
    let folder = folder();
    let mut other = schema();
    other.columns[2].unit = "km/h".to_owned();
    let mut writer = TableWriter::create(folder.path().join("t"), &other, &provenance()).unwrap();
    assert!(refusal(writer.push(sample::encode(0..1).remove(0))).contains("a block with other columns"));
}

#[test]
fn schemas_that_no_reader_could_trust_are_refused() {
    let folder = folder();
    let create = |columns| {
        let schema = TableSchema { columns, ..schema() };
        refusal(TableWriter::create(folder.path().join("t"), &schema, &provenance()))
    };
    let u = || spec("u", "m/s", Kind::F64, false);
    assert!(create(vec![u(), u()]).contains("two columns of this name"));
    assert!(create(vec![spec("", "1", Kind::F64, false)]).contains("an invalid name"));
    assert!(create(vec![spec("a\"b", "1", Kind::F64, false)]).contains("an invalid name"));
    assert!(create(vec![spec("a", "", Kind::F64, false)]).contains("found no unit"));
    assert!(create(vec![spec("a", "1", Kind::I32, true)]).contains("f64 columns only"));
}

#[test]
fn column_accessors_know_their_kind() {
    let text = Column::text(vec!["a".into(), "b".into()], vec![1, 0, 2]);
    assert_eq!((text.text_at(0), text.text_at(2), text.text_at(3)), (Some("b"), None, None));
    assert_eq!(text.text_codes().unwrap().1, [1, 0, 2]);
    assert!(text.as_f64().is_none() && text.as_i32().is_none() && !text.is_null(0));
    let column = Column::nullable_f64(vec![1.0, 2.0, 3.0], vec![true, false]);
    assert_eq!((column.len(), column.nulls(), column.is_null(1), column.is_null(2)), (3, 2, true, true));
    assert!(Column::f64(vec![]).is_empty());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn law_every_finite_number_survives(
        values in prop::collection::vec((any::<f64>(), any::<bool>()), 1..300),
        labels in prop::collection::vec("\\PC{0,8}", 1..5),
        numbers in any::<[i32; 7]>(),
    ) {
        let columns = vec![spec("x", "1", Kind::F64, true), spec("n", "1", Kind::I32, false), spec("t", "1", Kind::Text, false)];
        let schema = TableSchema { id: "any", version: 1, columns };
        let finite: Vec<f64> = values.iter().map(|(x, _)| if x.is_finite() { *x } else { 0.5 }).collect();
        let rows = finite.len();
        let written = vec![
            Column::nullable_f64(finite, values.iter().map(|(_, valid)| *valid).collect()),
            Column::i32((0..rows).map(|row| numbers[row % 7]).collect()),
            Column::text(labels.clone(), (0..rows).map(|row| (row % labels.len()) as u32).collect()),
        ];
        let folder = folder();
        let path = folder.path().join("t");
        let mut writer = TableWriter::create(&path, &schema, &provenance()).unwrap();
        writer.push(encode_block(&schema, &Table { columns: written.clone() }).unwrap()).unwrap();
        files::commit(vec![writer.finish().unwrap()]).unwrap();
        let reader = TableReader::open(&path, "any", 1).unwrap();
        let read = reader.read_block(0, &["x", "n", "t"]).unwrap().columns;
        prop_assert_eq!(bits(&read[0]), bits(&written[0]));
        prop_assert_eq!(read[1].as_i32(), written[1].as_i32());
        prop_assert_eq!(texts(&read[2]), texts(&written[2]));
    }
}
