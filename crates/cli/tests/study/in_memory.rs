//! The library in memory compared with the programs' files.

use files::{Document, TableReader, read_document};
use seatrial::{CampaignFile, DictionaryFile, Estimator, Logs, Pooling, Study as InMemory, Vessel};
use serde_json::{Value, to_value};
use study::documents::{IngestDocument, ModelDocument};
use study::trajectories::{Layout, TrajectoryReader};
use study::{estimates, scores};
use tempfile::TempDir;

use crate::support::*;

#[test]
fn law_a_study_in_memory_has_the_rows_of_the_programs() {
    let folder = with(&MADE);
    let text = |name: &str| String::from_utf8(bytes(&folder, name)).unwrap();
    let vessel = Vessel::preset("ljungberg-model-ship").unwrap();
    let dictionary: DictionaryFile = text("dictionary.toml").parse().unwrap();
    let campaign: CampaignFile = toml::from_str(&text("campaign.toml")).unwrap();
    let study = InMemory::new(vessel.clone(), &dictionary, campaign).unwrap();
    let moments = study.moments(&study.dictionary().unwrap()).unwrap();
    let runs = study.simulate(&study.design(&moments).unwrap().designed()).unwrap();
    let estimated = study.estimate(&runs, Estimator::Iv).unwrap();
    let scored = study.score(&estimated).unwrap();
    assert_eq!(scored.len() as u64, 3 * RUNS);

    let file = folder.path().join("estimates.parquet");
    let table = TableReader::open(&file, estimates::ID, estimates::VERSION).unwrap();
    let block = |i| estimates::rows(&table, &vessel, &file, i).unwrap();
    let of_programs: Vec<estimates::Row> = (0..table.blocks()).flat_map(block).collect();
    assert_eq!(estimated, of_programs);
    let table = TableReader::open(folder.path().join("scores.parquet"), scores::ID, scores::VERSION).unwrap();
    assert_eq!(scored, scores::rows(&table).unwrap());
}

/// The document in a file.
fn written<D: Document>(folder: &TempDir, name: &str) -> Value {
    to_value(read_document::<D>(folder.path().join(name)).unwrap().data).unwrap()
}

#[test]
fn law_logs_in_memory_have_the_runs_and_the_model_of_the_programs() {
    let logs = repository().join("fixtures/logs");
    let [config, ship] = ["ingest.toml", "vessel.toml"].map(|name| logs.join(name));
    let folder = tempfile::tempdir().unwrap();
    let (vessel, table) = (ship.display(), "trajectories.parquet");
    let line = format!("ingest --config {} --vessel {vessel} --out {table}", config.display());
    run(&folder, &line).succeeds();
    let line = format!(
        "estimate --structure own --vessel {vessel} --trajectories {table} --nominal least-squares --out pool/"
    );
    std::fs::create_dir(folder.path().join("pool")).unwrap();
    run(&folder, &line).succeeds();

    let vessel = std::fs::read_to_string(&ship).unwrap();
    let vessel = Vessel::from_file(vessel.parse().unwrap()).unwrap();
    let ingested = Logs::read(&config, &vessel).unwrap().ingested().unwrap();
    let path = folder.path().join(table);
    let reader = TrajectoryReader::open(&path, &Layout::new(&vessel.model), vessel.sample_rate_hz).unwrap();
    assert_eq!(ingested.runs, reader.all().unwrap());
    assert_eq!(to_value(&ingested.document).unwrap(), written::<IngestDocument>(&folder, "ingest.json"));

    let mut pooling = Pooling::new(&vessel).by_least_squares();
    pooling.pool.constant = ingested.document.constant_channels();
    let set = pooling.model(&ingested.pooled().unwrap(), None).unwrap();
    assert_eq!(to_value(set.model.unwrap()).unwrap(), written::<ModelDocument>(&folder, "pool/model.json"));
}
