//! The study in memory beside the programs' files.

use artifact::TableReader;
use seatrial::{CampaignFile, DictionaryFile, Estimator, Study as InMemory, Vessel};
use study::{estimates, scores};

use crate::support::*;

#[test]
fn law_a_study_in_memory_has_the_rows_of_the_programs() {
    let folder = with(&MADE);
    let text = |name: &str| String::from_utf8(bytes(&folder, name)).unwrap();
    let vessel = Vessel::preset("ljungberg-model-ship").unwrap();
    let dictionary: DictionaryFile = toml::from_str(&text("dictionary.toml")).unwrap();
    let campaign: CampaignFile = toml::from_str(&text("campaign.toml")).unwrap();
    let study = InMemory::new(vessel.clone(), &dictionary, campaign).unwrap();
    let moments = study.moments(&study.dictionary().unwrap()).unwrap();
    let runs = study.simulate(&study.design(&moments).unwrap().designed()).unwrap();
    let estimated = study.estimate(&runs, Estimator::Iv).unwrap();
    let scored = study.score(&estimated).unwrap();
    assert_eq!(scored.len() as u64, 2 * RUNS);

    let file = folder.path().join("estimates.parquet");
    let table = TableReader::open(&file, estimates::ID, estimates::VERSION).unwrap();
    let block = |i| estimates::rows(&table, &vessel, &file, i).unwrap();
    let of_programs: Vec<estimates::Row> = (0..table.blocks()).flat_map(block).collect();
    assert_eq!(estimated, of_programs);
    let table = TableReader::open(folder.path().join("scores.parquet"), scores::ID, scores::VERSION).unwrap();
    assert_eq!(scored, scores::rows(&table).unwrap());
}
