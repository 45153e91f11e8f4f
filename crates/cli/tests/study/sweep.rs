//! `sweep` and `report --sweep`: a grid over a study's values, per cell and in comparison.

use serde_json::{Value, json};
use study::documents::{CellsDocument, SweepDocument, TallyDocument};
use tempfile::TempDir;

use crate::support::*;

const CELLS: &str = "sweep cells --config sweep.toml --out cells.json";
const COLLECT: &str = "sweep collect --cells cells.json --tallies cells --out sweep.json";
const GRID: &str = "study = \".\"\nrealizations = 16\nestimators = [\"iv\", \"ls\"]\n\
                    baseline = { design = \"optimized\", estimator = \"ls\" }\n\n[grid]\n";

/// A study with a grid of these lines.
fn swept(lines: &str) -> TempDir {
    let folder = with(&["dictionary.parquet", "moments.json", "design.json"]);
    put(&folder, "sweep.toml", &format!("{GRID}{lines}\n"));
    folder
}

fn grid(folder: &TempDir) -> CellsDocument {
    run(folder, CELLS).succeeds();
    document::<CellsDocument>(folder, "cells.json").data
}

/// Makes the tally of every cell that is not refused, as the pipeline does.
fn made(folder: &TempDir, grid: &CellsDocument) {
    for cell in grid.cells.iter().filter(|cell| cell.refused.is_none()) {
        let out = format!("cells/{}", cell.name);
        std::fs::create_dir_all(folder.path().join(&out)).unwrap();
        let line = "monte-carlo --vessel vessel.toml --dictionary dictionary.toml --campaign campaign.toml --design design.json";
        let (own, set) = (grid.monte_carlo.join(" "), cell.set.join(" "));
        run(folder, &format!("{line} {own} {set} --out {out}/tally.json")).succeeds();
    }
}

#[test]
fn cells_are_all_of_the_grid_and_share_designs() {
    let folder = swept(
        "\"campaign.current.std_m_s\" = [0.1, -0.2, 0.3]\nvessel.value.X_u = [-0.05, -0.06]\n\
         dictionary = { duration_s = [30.0] }",
    );
    let grid = grid(&folder);
    let keys: Vec<&str> = grid.axes.iter().map(|axis| axis.key.as_str()).collect();
    assert_eq!(keys, ["campaign.current.std_m_s", "dictionary.duration_s", "vessel.value.X_u"]);
    assert_eq!((grid.cells.len(), grid.designs.len()), (6, 2));
    let at: Vec<&[usize]> = grid.cells.iter().map(|cell| &cell.at[..]).collect();
    assert_eq!(at, [[0, 0, 0], [0, 0, 1], [1, 0, 0], [1, 0, 1], [2, 0, 0], [2, 0, 1]]);
    let set = ["--set", "campaign.current.std_m_s=0.3", "--set", "dictionary.duration_s=30.0", "--set"];
    assert_eq!(grid.cells[4].set, [&set[..], &["vessel.value.X_u=-0.05"]].concat());
    assert_eq!(grid.cells[4].design, grid.designs[0].name);
    assert_eq!(grid.designs[0].vessel, ["--set", "vessel.value.X_u=-0.05"]);
    let refused: Vec<usize> = (0..6).filter(|i| grid.cells[*i].refused.is_some()).collect();
    assert_eq!(refused, [2, 3]);
    let said = grid.cells[2].refused.as_deref().unwrap();
    assert!(said.contains("campaign.toml: `current.std_m_s`: found -0.2"), "{said}");
    assert_eq!(grid.monte_carlo, ["--estimator", "iv,ls", "--realizations", "16"]);
}

#[test]
fn a_grid_that_the_study_has_no_place_for_is_refused_before_any_work() {
    let refused = |lines: &str, says: &[&str]| refused(&swept(lines), 3, CELLS, says);
    let says = ["campaign.toml", "`realisations`", "did you mean `realizations`?"];
    refused("campaign.realisations = [1, 2]", &says);
    refused("vessel.value.X_v = [0.1]", &["vessel.toml", "`X_v`", "did you mean `X_vr`?"]);
    refused("campain.seed = [1]", &["sweep.toml", "`campain`", "did you mean `campaign`?"]);
    refused("campaign.seed = 1", &["sweep.toml", "`grid.campaign.seed`", "found 1", "a list of values"]);
    refused("campaign.seed = [1, 1]", &["`grid.campaign.seed`", "1 twice"]);
    refused("campaign.seed = []", &["`grid.campaign.seed`", "no value"]);
    refused("", &["sweep.toml", "`grid`", "no key"]);
    let many = (0..400).map(|i| i.to_string()).collect::<Vec<_>>().join(",");
    let many = format!("campaign.seed = [{many}]\ncampaign.duration_s = [{many}]");
    refused(&many, &["sweep.toml", "`grid`", "more cells", "100000"]);
    let folder = swept("campaign.seed = [1]");
    edit(&folder, "sweep.toml", "realizations = 16", "realizations = 16\nhalf_width = 0.1");
    crate::support::refused(&folder, 3, CELLS, &["sweep.toml", "`half_width`", "beside"]);
    edit(&folder, "sweep.toml", "realizations = 16\nhalf_width = 0.1", "shards = 0");
    crate::support::refused(&folder, 3, CELLS, &["sweep.toml", "`shards`", "found 0"]);
    edit(&folder, "sweep.toml", "shards = 0", "relizations = 3");
    crate::support::refused(&folder, 3, CELLS, &["`relizations`", "did you mean `realizations`?"]);
    edit(&folder, "sweep.toml", "relizations = 3", "");
    edit(&folder, "sweep.toml", "estimator = \"ls\" }", "estimator = \"refined-iv\" }");
    crate::support::refused(&folder, 3, CELLS, &["`refined-iv`", "it is gone: take `output-error`"]);
}

#[test]
fn law_a_sweep_says_of_each_cell_what_its_tally_says() {
    let folder =
        swept("campaign.measurement.std_u_m_s = [0.05, 0.3, 0.6]\ncampaign.duration_s = [60.0, -1.0]");
    let grid = grid(&folder);
    made(&folder, &grid);
    // One cell was refused by a stage: its --json output replaces the tally.
    let refusal = json!({"exit_code": 3, "error": "campaign.toml: `x`: found y, expected z; correct it"});
    put(&folder, &format!("cells/{}/tally.json", grid.cells[2].name), &format!("{refusal}\n"));
    run(&folder, COLLECT).succeeds();
    let sweep = document::<SweepDocument>(&folder, "sweep.json").data;
    assert_eq!((sweep.cells.len(), sweep.refused.len()), (2, 4));
    assert!(sweep.refused.iter().any(|cell| cell.refusal.contains("`x`: found y")));
    assert!(sweep.refused.iter().any(|cell| cell.refusal.contains("`duration_s`: found -1")));
    for cell in &sweep.cells {
        let tally = document::<TallyDocument>(&folder, &format!("cells/{}/tally.json", cell.cell)).data;
        for line in &cell.lines {
            let by = tally.scores.iter().find(|by| by.estimator == line.estimator).unwrap();
            let own = by.designs.iter().find(|design| design.design == line.design).unwrap();
            assert_eq!(line.parameter_error_share.share, own.parameter_error_share);
            assert_eq!(line.parameter_error_share.interval, own.parameter_error_share_interval);
            assert_eq!(line.simulation_error_share.interval, own.simulation_error_share_interval);
            assert_eq!(line.parameter_error_median, own.parameter_error.median);
            let baseline = &cell.lines[1];
            let Some(difference) = line.difference else {
                assert_eq!((line.design.as_str(), line.estimator.name()), ("optimized", "ls"));
                continue;
            };
            let apart = line.parameter_error_share.share - baseline.parameter_error_share.share;
            assert!((difference.share - apart).abs() < 1e-12);
            assert!(difference.interval[0] <= apart && apart <= difference.interval[1]);
            assert_eq!(difference.paired, line.design == "optimized");
        }
    }
    let ran = run(&folder, "report --sweep sweep.json --out page/sweep.html").refuses(1, &["page"]);
    assert!(ran.stderr.contains("create the folder"), "{ran}");
    run(&folder, "report --sweep sweep.json --out sweep.html").succeeds();
    let page = String::from_utf8(bytes(&folder, "sweep.html")).unwrap();
    for piece in
        ["download=\"sweep.csv\"", "`x`: found y", "run by run", "as samples", "2 cells counted, 4 refused"]
    {
        assert!(page.contains(piece), "the page lacks {piece}");
    }
    let link = page.split("href=\"data:application/json;charset=utf-8,").nth(1).unwrap();
    let told: Value = serde_json::from_str(&decoded(link.split('"').next().unwrap())).unwrap();
    assert_eq!(told, json(&folder, "sweep.json")["data"]);
}

/// The contents of a data URI.
fn decoded(address: &str) -> String {
    let mut pieces = address.split('%');
    let mut bytes = pieces.next().unwrap().as_bytes().to_vec();
    for piece in pieces {
        bytes.push(u8::from_str_radix(&piece[..2], 16).unwrap());
        bytes.extend(piece[2..].bytes());
    }
    String::from_utf8(bytes).unwrap()
}

#[test]
fn tallies_of_other_cells_and_studies_are_not_collected() {
    let folder = swept("campaign.measurement.std_u_m_s = [0.05, 0.3]");
    let grid = grid(&folder);
    made(&folder, &grid);
    let [first, second] = [0, 1].map(|i| format!("cells/{}/tally.json", grid.cells[i].name));
    let whole = bytes(&folder, &first);
    std::fs::write(folder.path().join(&first), bytes(&folder, &second)).unwrap();
    refused(&folder, 3, COLLECT, &[&first, "inputs.campaign", "another campaign"]);
    std::fs::write(folder.path().join(&first), &whole[..whole.len() / 2]).unwrap();
    refused(&folder, 3, COLLECT, &[&first]);
    std::fs::remove_file(folder.path().join(&first)).unwrap();
    refused(&folder, 1, COLLECT, &[&first, "an existing file"]);
    std::fs::write(folder.path().join(&first), whole).unwrap();
    let mut other = json(&folder, "cells.json");
    other["data"]["baseline"]["design"] = "optimised".into();
    other["seal"] = Value::Null;
    put(&folder, "cells.json", &other.to_string());
    refused(&folder, 3, COLLECT, &[&first, "`baseline.design`", "did you mean `optimized`?"]);
    edit(&folder, "vessel.toml", "preset", "name = \"other\"\npreset");
    run(&folder, CELLS).succeeds();
    refused(&folder, 3, COLLECT, &[&first, "inputs.vessel", "another vessel"]);
}
