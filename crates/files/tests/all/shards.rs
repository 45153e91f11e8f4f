//! Merging shards.

use std::path::PathBuf;

use files::{Digest, Shard, TableReader, TableWriter, commit, encode_block, gather};
use serde_json::json;
use tempfile::TempDir;

use crate::sample::{block, folder, names, provenance, refusal, schema, shard, write};

const BLOCKS: usize = 10;

fn write_shards(folder: &TempDir, count: u32) -> Vec<PathBuf> {
    let part = |index| {
        let range = Shard { index, count }.range(BLOCKS);
        write(folder, &format!("part-{index}-{count}"), &shard(index, count), range)
    };
    (1..=count).map(part).collect()
}

fn try_gather(folder: &TempDir, shards: &[PathBuf]) -> files::Result<files::Staged> {
    gather(shards, &folder.path().join("whole"), None, "trajectories", 2)
}

#[test]
fn law_gathered_shards_are_the_unsharded_file() {
    for count in [1, 3, 4, 13] {
        let folder = folder();
        let unsharded = write(&folder, "unsharded", &provenance(), 0..BLOCKS);
        let mut shards = write_shards(&folder, count);
        shards.reverse();
        commit(vec![try_gather(&folder, &shards).unwrap()]).unwrap();
        let whole = std::fs::read(folder.path().join("whole")).unwrap();
        assert!(whole == std::fs::read(unsharded).unwrap(), "{count} shards");
    }
}

#[test]
fn a_gathered_file_is_whole_and_sealed() {
    let folder = folder();
    commit(vec![try_gather(&folder, &write_shards(&folder, 4)).unwrap()]).unwrap();
    let reader = TableReader::open(folder.path().join("whole"), "trajectories", 2).unwrap();
    assert_eq!(reader.provenance(), &provenance());
    let read = reader.read_block(BLOCKS - 1, &["run"]).unwrap();
    assert_eq!(read.columns[0].as_i32(), block(BLOCKS - 1).columns[1].as_i32());
}

#[test]
fn all_missing_shards_are_named() {
    let folder = folder();
    let shards = write_shards(&folder, 4);
    let line = refusal(try_gather(&folder, &shards[1..3]));
    assert!(line.contains("found no shard 1/4, 4/4, expected each of the 4 shards once"), "{line}");
    assert!(refusal(try_gather(&folder, &[])).contains("found none"));
}

#[test]
fn a_huge_number_of_shards_is_told_in_short() {
    let folder = folder();
    let line = refusal(try_gather(&folder, &[write(&folder, "a", &shard(2, u32::MAX), 0..1)]));
    assert!(
        line.contains("no shard 1/4294967295, 3/4294967295") && line.contains(" and 4294967286 more"),
        "{line}"
    );
}

#[test]
fn a_shard_that_occurs_twice_is_refused() {
    let folder = folder();
    let mut shards = write_shards(&folder, 4);
    shards.push(write(&folder, "again", &shard(2, 4), 2..5));
    let line = refusal(try_gather(&folder, &shards));
    assert!(line.contains("shard 2/4 in ") && line.contains("again"), "{line}");
}

#[test]
fn a_shard_of_another_computation_is_refused() {
    let folder = folder();
    let mut shards = write_shards(&folder, 4);
    let mut foreign = |change: &dyn Fn(&mut files::Provenance)| {
        let mut other = shard(4, 4);
        change(&mut other);
        shards[3] = write(&folder, "foreign", &other, 7..10);
        refusal(try_gather(&folder, &shards))
    };
    let line = foreign(&|p| _ = p.settings.insert("seed".into(), json!(2)));
    assert!(line.contains("foreign: settings.seed: found 2, expected 1 as in "), "{line}");
    let line = foreign(&|p| _ = p.inputs.insert("vessel".into(), Digest::of_bytes(b"other")));
    assert!(line.contains("foreign: inputs.vessel: found blake3:"), "{line}");
    let line = foreign(&|p| _ = p.inputs.insert("chart".into(), Digest::of_bytes(b"other")));
    assert!(line.contains("expected nothing as in"), "{line}");
    assert!(foreign(&|p| p.producer = "simulate 0.2.0".into()).contains("producer"));
    assert!(
        foreign(&|p| p.shard = Some(Shard { index: 4, count: 5 }))
            .contains("number of shards: found 5, expected 4")
    );
    assert!(foreign(&|p| p.shard = None).contains("shard: found a whole file, expected a shard K/N"));
}

#[test]
fn a_shard_with_other_columns_is_refused() {
    let folder = folder();
    let mut shards = write_shards(&folder, 2);
    let mut other = schema();
    other.columns[2].unit = "km/h".to_owned();
    let path = folder.path().join("other");
    let mut writer = TableWriter::create(&path, &other, &shard(2, 2)).unwrap();
    writer.push(encode_block(&other, &block(0)).unwrap()).unwrap();
    commit(vec![writer.finish().unwrap()]).unwrap();
    shards[1] = path;
    assert!(refusal(try_gather(&folder, &shards)).contains("other: columns: found"));
}

#[test]
fn a_damaged_shard_is_refused_and_nothing_is_left() {
    let folder = folder();
    let shards = write_shards(&folder, 2);
    let mut bytes = std::fs::read(&shards[1]).unwrap();
    bytes[100] ^= 1;
    std::fs::write(&shards[1], bytes).unwrap();
    assert!(refusal(try_gather(&folder, &shards)).contains("part-2-2: seal: "));
    assert_eq!(names(&folder), ["part-1-2", "part-2-2"]);
}
