//! Parquet that other programs wrote.

use std::fs::File;
use std::path::Path;
use std::sync::Arc;

use files::{ForeignTable, Result};
use parquet::basic::{LogicalType, Repetition, Type as Physical};
use parquet::data_type::{BoolType, ByteArrayType, DoubleType, FloatType, Int32Type, Int64Type};
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::types::Type;

fn field(name: &str, physical: Physical, optional: bool) -> Arc<Type> {
    let repetition = if optional { Repetition::OPTIONAL } else { Repetition::REQUIRED };
    let text = (physical == Physical::BYTE_ARRAY).then_some(LogicalType::String);
    let builder = Type::primitive_type_builder(name, physical).with_repetition(repetition);
    Arc::new(builder.with_logical_type(text).build().unwrap())
}

fn write(path: &Path) {
    let fields = vec![
        field("time", Physical::INT64, false),
        field("u", Physical::DOUBLE, true),
        field("n", Physical::FLOAT, false),
        field("k", Physical::INT32, false),
        field("on", Physical::BOOLEAN, false),
        field("label", Physical::BYTE_ARRAY, true),
        field("raw", Physical::INT96, true),
    ];
    let root = Arc::new(Type::group_type_builder("schema").with_fields(fields).build().unwrap());
    let mut writer =
        SerializedFileWriter::new(File::create(path).unwrap(), root, Default::default()).unwrap();
    for block in 0..2_i64 {
        let mut group = writer.next_row_group().unwrap();
        let mut column = |f: &dyn Fn(&mut SerializedColumnWriter)| {
            let mut column = group.next_column().unwrap().unwrap();
            f(&mut column);
            column.close().unwrap();
        };
        column(&|c| drop(c.typed::<Int64Type>().write_batch(&[10 * block, 10 * block + 5], None, None)));
        column(&|c| drop(c.typed::<DoubleType>().write_batch(&[0.5], Some(&[0, 1]), None)));
        column(&|c| drop(c.typed::<FloatType>().write_batch(&[1.5, 2.5], None, None)));
        column(&|c| drop(c.typed::<Int32Type>().write_batch(&[-1, 7], None, None)));
        column(&|c| drop(c.typed::<BoolType>().write_batch(&[true, false], None, None)));
        column(&|c| drop(c.typed::<ByteArrayType>().write_batch(&["turn".into()], Some(&[1, 0]), None)));
        column(&|c| drop(c.typed::<parquet::data_type::Int96Type>().write_batch(&[], Some(&[0, 0]), None)));
        group.close().unwrap();
    }
    writer.close().unwrap();
}

fn numbers(table: &ForeignTable, column: &str) -> Result<Vec<f64>> {
    let mut all = Vec::new();
    table.numbers(column, |number| all.push(number)).map(|()| all)
}

fn texts(table: &ForeignTable, column: &str) -> Result<Vec<String>> {
    let mut all = Vec::new();
    table.texts(column, |text| all.push(text.to_owned())).map(|()| all)
}

#[test]
fn simple_columns_of_any_type_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.parquet");
    write(&path);
    let table = ForeignTable::open(&path).unwrap();
    assert_eq!(table.rows(), 4);
    assert_eq!(table.columns()[..2], ["time", "u"]);
    assert_eq!(numbers(&table, "time").unwrap(), [0.0, 5.0, 10.0, 15.0]);
    let u = numbers(&table, "u").unwrap();
    assert!(u[0].is_nan() && u[1] == 0.5 && u[2].is_nan() && u[3] == 0.5, "{u:?}");
    assert_eq!(numbers(&table, "n").unwrap(), [1.5, 2.5, 1.5, 2.5]);
    assert_eq!(numbers(&table, "k").unwrap(), [-1.0, 7.0, -1.0, 7.0]);
    assert_eq!(numbers(&table, "on").unwrap(), [1.0, 0.0, 1.0, 0.0]);
    assert_eq!(texts(&table, "label").unwrap(), ["turn", "", "turn", ""]);
}

#[test]
fn other_columns_are_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.parquet");
    write(&path);
    let table = ForeignTable::open(&path).unwrap();
    for (name, piece) in [("label", "type BYTE_ARRAY"), ("raw", "type INT96"), ("w", "no such column")] {
        let line = numbers(&table, name).unwrap_err().to_string();
        assert!(line.contains(&format!("column `{name}`")) && line.contains(piece), "{line}");
    }
    assert!(texts(&table, "u").unwrap_err().to_string().contains("type DOUBLE"));
}

#[test]
fn damaged_files_are_refused_and_never_panic() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.parquet");
    write(&path);
    let whole = std::fs::read(&path).unwrap();
    for length in [0, 4, 11, whole.len() / 2, whole.len() - 1] {
        std::fs::write(&path, &whole[..length]).unwrap();
        let line = ForeignTable::open(&path).map(drop).unwrap_err().to_string();
        assert!(line.contains("expected a whole Parquet file"), "{line}");
    }
    for at in (0..whole.len()).step_by(5) {
        let mut bytes = whole.clone();
        bytes[at] ^= 0xff;
        std::fs::write(&path, &bytes).unwrap();
        let Ok(table) = ForeignTable::open(&path) else { continue };
        for name in table.columns().to_vec() {
            drop((numbers(&table, &name), texts(&table, &name)));
        }
    }
}
