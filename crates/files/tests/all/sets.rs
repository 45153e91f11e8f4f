//! Files of one set are read; a mixture of two sets is refused.

use std::path::Path;

use files::{
    Loaded, Result, TableReader, TableWriter, commit, read_document, stage_document, stage_set_document,
};

use crate::sample::{Design, design, encode, folder, names, provenance, refusal, schema};

/// Writes a table of `blocks` blocks and the document that vouches for it.
fn write(folder: &Path, blocks: usize) {
    let (table, document) = (folder.join("t.parquet"), folder.join("t.json"));
    let mut writer = TableWriter::create(&table, &schema(), &provenance()).unwrap().with_document(&document);
    encode(0..blocks).into_iter().for_each(|block| writer.push(block).unwrap());
    let mut files = vec![writer.finish().unwrap()];
    files.push(stage_set_document(&document, &provenance(), &design(), &files).unwrap());
    commit(files).unwrap();
}

fn table(folder: &Path) -> Result<TableReader> {
    TableReader::open(folder.join("t.parquet"), "trajectories", 2)
}

fn document(folder: &Path) -> Result<Loaded<Design>> {
    read_document(folder.join("t.json"))
}

#[test]
fn both_files_of_a_mixed_set_are_refused() {
    let (one, two) = (folder(), folder());
    write(one.path(), 1);
    write(two.path(), 2);
    assert_eq!((table(one.path()).unwrap().blocks(), table(two.path()).unwrap().blocks()), (1, 2));
    std::fs::copy(two.path().join("t.parquet"), one.path().join("t.parquet")).unwrap();
    for line in [refusal(table(one.path())), refusal(document(one.path()))] {
        assert!(line.contains("t.parquet: digest: found another file than the one written with"), "{line}");
    }
}

#[test]
fn a_file_without_the_others_of_its_set_is_read() {
    let (one, two) = (folder(), folder());
    write(one.path(), 1);
    std::fs::copy(one.path().join("t.parquet"), two.path().join("t.parquet")).unwrap();
    table(two.path()).unwrap();
    std::fs::remove_file(one.path().join("t.parquet")).unwrap();
    document(one.path()).unwrap();
}

#[test]
fn what_only_the_earlier_document_vouched_for_is_removed() {
    let folder = folder();
    write(folder.path(), 1);
    let path = folder.path().join("t.json");
    let alone = || commit(vec![stage_document(&path, &provenance(), &design()).unwrap()]).unwrap();
    alone();
    assert_eq!(names(&folder), ["t.json"]);
    // But not what somebody else has written since.
    write(folder.path(), 1);
    std::fs::write(folder.path().join("t.parquet"), b"other").unwrap();
    alone();
    assert_eq!(names(&folder), ["t.json", "t.parquet"]);
}

#[test]
fn a_table_that_its_document_does_not_vouch_for_is_refused() {
    let (one, two) = (folder(), folder());
    write(one.path(), 1);
    commit(vec![stage_document(two.path().join("t.json"), &provenance(), &design()).unwrap()]).unwrap();
    std::fs::copy(one.path().join("t.parquet"), two.path().join("t.parquet")).unwrap();
    assert!(refusal(table(two.path())).contains("t.parquet: digest: found another file than"));
}
