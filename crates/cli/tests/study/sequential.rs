//! Trials in rounds, through the binary.

use files::TableReader;
use ship::model::Source;
use study::documents::{TrialsInRounds, ValidationDocument};
use study::scores::{ID, VERSION};
use tempfile::TempDir;
use trial::rounds::Arm;

use crate::support::*;

const SEQUENTIAL: &str = "monte-carlo --vessel vessel.toml --dictionary dictionary.toml --campaign campaign.toml \
     --out scores.parquet";
const CONFIG: &str =
    "realizations = 16\nduration_s = 90.0\nrounds = 3\nnominal_spread = 0.4\naccuracy = 0.5\n";

/// The paper's study with a sixth of its noise, so that few realizations suffice, and rounds.
fn folder(config: &str) -> TempDir {
    let folder = written(2);
    for _ in 0..4 {
        edit(&folder, "campaign.toml", "0.15811388300841897", "0.025");
    }
    in_rounds(&folder, config);
    folder
}

/// Arm, realization, round, status, parameter error of every row.
fn rows(folder: &TempDir) -> Vec<(String, i32, i32, String, Option<f64>)> {
    let table = TableReader::open(folder.path().join("scores.parquet"), ID, VERSION).unwrap();
    (0..table.blocks()).flat_map(|block| rows_of(&table, block)).collect()
}

fn rows_of(table: &TableReader, number: usize) -> Vec<(String, i32, i32, String, Option<f64>)> {
    let names = ["arm", "run", "round", "status", "parameter_error"];
    let block = table.read_block(number, &names).unwrap();
    let [arm, realization, round, status, error] = [0, 1, 2, 3, 4].map(|i| &block.columns[i]);
    let row = |i: usize| {
        let text = |column: &files::Column| column.text_at(i).unwrap().to_owned();
        (
            text(arm),
            realization.as_i32().unwrap()[i],
            round.as_i32().unwrap()[i],
            text(status),
            error.value_at(i),
        )
    };
    (0..table.block_rows(number)).map(row).collect()
}

fn found(folder: &TempDir) -> TrialsInRounds {
    document::<ValidationDocument>(folder, "validation.json").data.rounds.unwrap()
}

#[test]
fn law_motions_are_held_by_feedback_in_rounds_too() {
    let folder = folder(CONFIG);
    let text = std::fs::read_to_string(folder.path().join("dictionary.toml")).unwrap();
    let of = |executed: &str| {
        let maneuver = format!("[[maneuver]]\nexecuted = \"{executed}\"\n");
        let own = text.replace("[[maneuver]]\n", &maneuver);
        put(&folder, "dictionary.toml", &own.replace("inputs_from = \"value\"", "inputs_from = \"nominal\""));
        run(&folder, SEQUENTIAL).succeeds();
        let random = rows(&folder).into_iter().filter(|row| row.0 == "random");
        random.collect::<Vec<_>>()
    };
    let (inputs, feedback) = (of("inputs"), of("feedback"));
    assert_eq!(inputs.len(), 16 * 3);
    // The same maneuvers in the same sea: only what the ship does of them is another.
    assert!(inputs.iter().zip(&feedback).all(|(one, other)| one.4 != other.4), "{inputs:?} {feedback:?}");
}

#[test]
fn law_more_time_and_a_design_leave_less_error_and_every_outcome_is_counted() {
    let folder = folder(CONFIG);
    let ran = run(&folder, SEQUENTIAL).succeeds();
    assert!(ran.stdout.contains("at equal time") && ran.stdout.contains("sizes beforehand"), "{ran}");
    let found = found(&folder);
    let names: Vec<&str> = found.arms.iter().map(|arm| arm.name.name()).collect();
    assert_eq!(names, ["sequential", "one-shot", "informed", "random"]);
    let median = |arm: usize, round: usize| found.arms[arm].points[round].median.unwrap_or(f64::INFINITY);
    (0..4).for_each(|arm| assert!(median(arm, 2) < median(arm, 0), "{:?}", found.arms[arm]));
    (0..3).for_each(|arm| assert!(median(arm, 2) < median(3, 2), "{:?} beats chance", found.arms[arm]));
    let rows = rows(&folder);
    assert_eq!(rows.len(), 16 * 4 * 3);
    for (arm, round) in found.arms.iter().flat_map(|arm| (0..3).map(move |round| (arm, round))) {
        let own = rows.iter().filter(|row| row.0 == arm.name.name() && row.2 == round);
        let lost = own.filter(|row| row.4.is_none()).count() as u64;
        let point = &arm.points[round as usize];
        assert_eq!(point.not_converged + point.not_identifiable + point.diverged, lost, "{point:?}");
    }
    assert!(rows.iter().all(|row| row.4.is_some() == (row.3 == "identified")));
    let [rounds, one_shot] = [&found.stopping[0], &found.stopping[1]];
    assert_eq!((rounds.arm, one_shot.arm), (Arm::Sequential, Arm::OneShot));
    assert!(rounds.stopped > 0 && rounds.mean_time_s < 90.0, "{rounds:?}");
}

#[test]
fn law_shards_gather_to_the_bytes_of_the_whole_and_to_no_others() {
    let folder = folder(&CONFIG.replace("= 16", "= 20"));
    run(&folder, &format!("{SEQUENTIAL} --threads 1")).succeeds();
    let all = |name: &str| (bytes(&folder, name), bytes(&folder, "validation.json"));
    let whole = all("scores.parquet");
    let parts: Vec<String> = (1..=3).map(|k| format!("part-{k}.parquet")).collect();
    for (k, part) in parts.iter().enumerate() {
        let shard = format!("--shard {}/3 --threads 3", k + 1);
        run(&folder, &SEQUENTIAL.replace("scores.parquet", part).replace("--out", &format!("{shard} --out")))
            .succeeds();
    }
    let gather = format!("{SEQUENTIAL} --gather {}", parts.join(" "));
    run(&folder, &gather).succeeds();
    assert_eq!(all("scores.parquet"), whole);
    run(&folder, &format!("{SEQUENTIAL} --gather {} {}", parts[0], parts[2])).refuses(3, &["no shard 2/3"]);
    run(&folder, &format!("{gather} --seed 9")).refuses(3, &["part-1.parquet", "`seed`", "as requested now"]);
    edit(&folder, "campaign.toml", "accuracy = 0.5", "accuracy = 0.25");
    run(&folder, &gather).refuses(3, &["campaign.toml", "another campaign", "part-1.parquet"]);
}

#[test]
fn law_the_first_round_is_the_one_shot_trial_and_without_spread_the_informed_one() {
    let folder = folder(&CONFIG.replace("= 16", "= 8").replace("= 0.4", "= 0.0"));
    run(&folder, SEQUENTIAL).succeeds();
    let rows = rows(&folder);
    let first = |arm: &str| {
        let own = rows.iter().filter(|row| row.0 == arm && row.2 == 0);
        own.map(|row| (row.1, row.4.map(f64::to_bits))).collect::<Vec<_>>()
    };
    assert_eq!(first("sequential").len(), 8);
    assert_eq!(first("sequential"), first("one-shot"));
    assert_eq!(first("sequential"), first("informed"));
    assert_ne!(first("sequential"), first("random"));
    assert_eq!(found(&folder).gains[0].ratio, Some(1.0));
}

#[test]
fn law_the_same_bytes_for_any_number_of_threads() {
    let made = |threads: &str| {
        let folder = folder(&CONFIG.replace("rounds = 3", "rounds = 2"));
        run(&folder, &format!("{SEQUENTIAL} --threads {threads}")).succeeds();
        ["scores.parquet", "validation.json"].map(|name| bytes(&folder, name))
    };
    assert!(made("1") == made("2"));
}

#[test]
fn generated_maneuvers_beyond_their_limits_are_in_no_trial_and_the_report_shows_the_rounds() {
    let folder = folder(&CONFIG.replace("= 16", "= 8").replace("rounds = 3", "rounds = 2"));
    let generate = "duration_s = 10.0\n[generate]\ncandidates = 40\n[generate.limits]\nu_m_s = 1.2\nv_m_s = 0.25\nr_rad_s = 0.6\ninputs = { tau2 = 1000.0 }\n";
    put(&folder, "dictionary.toml", generate);
    run(&folder, SEQUENTIAL).succeeds();
    let maneuvers = found(&folder).maneuvers;
    assert!((10..40).contains(&maneuvers), "{maneuvers}");
    run(&folder, REPORT).succeeds();
    let page = String::from_utf8(bytes(&folder, "report.html")).unwrap();
    for piece in ["At equal time", "When to stop", "from the truth", "Not converged"] {
        assert!(page.contains(piece), "{piece}");
    }
}

#[test]
fn configurations_without_meaning_are_refused() {
    let folder = folder(CONFIG);
    let nominal = "accuracy = 0.5\ncrude_about = \"nominal\"";
    for (from, to, pieces) in [
        ("rounds = 3", "rounds = 0", vec!["`rounds.rounds`", "found 0", "a whole number from 1"]),
        (
            "rounds = 3",
            "rounds = 50",
            vec!["`rounds.rounds`", "50 rounds of 720 samples", "26 samples per round"],
        ),
        ("rounds = 3", "rouns = 3", vec!["`rouns`", "did you mean `rounds`?"]),
        ("accuracy = 0.5", "accuracy = nan", vec!["`rounds.accuracy`", "NaN"]),
        ("nominal_spread = 0.4", "nominal_spread = -1.0", vec!["`rounds.nominal_spread`", "0 to 2"]),
        (
            "accuracy = 0.5",
            "accuracy = 0.5\ncrude_about = \"truth\"",
            vec!["`truth`", "`value`", "`nominal`"],
        ),
        ("accuracy = 0.5", nominal, vec!["`rounds.floor.X_uu`", "`nominal` of `X_uu` is zero", "state it"]),
        (
            "accuracy = 0.5",
            "accuracy = 0.5\n[rounds.floor]\nX_u = 0.0",
            vec!["`rounds.floor.X_u`", "found 0"],
        ),
        ("accuracy = 0.5", "accuracy = 0.5\n[rounds.floor]\nX_vv = 1.0", vec!["`X_vv`", "did you mean `X_"]),
    ] {
        assert!(CONFIG.contains(from));
        in_rounds(&folder, &CONFIG.replace(from, to));
        refused(&folder, 3, SEQUENTIAL, &[&["campaign.toml"], pieces.as_slice()].concat());
    }
}

#[test]
fn what_rounds_do_not_take_is_refused() {
    let folder = folder(CONFIG);
    for flag in ["--estimator ls", "--until 0.1", "--keep scores", "--mean-removal none"] {
        let name = flag.split(' ').next().unwrap();
        refused(&folder, 2, &format!("{SEQUENTIAL} {flag}"), &[name, "trials in rounds", "leave it out"]);
    }
    refused(
        &folder,
        2,
        &SEQUENTIAL.replace("monte-carlo", "sequential"),
        &["it is gone", "[rounds] of campaign.toml"],
    );
    let plain = written(2);
    refused(&plain, 2, &SEQUENTIAL.replace("scores.parquet", "validation.json"), &["--design: found none"]);
}

#[test]
fn vessels_and_disturbances_that_the_study_is_not_for_are_refused() {
    let folder = folder(&CONFIG.replace("= 16", "= 2"));
    let paper = std::fs::read_to_string(folder.path().join("campaign.toml")).unwrap();
    for (from, to, pieces) in [
        ("kind = \"white\"", "kind = \"constant\"", vec!["campaign.toml", "a lasting current"]),
        ("std_v_m_s = 0.025", "std_v_m_s = 0.0", vec!["campaign.toml", "`measurement`"]),
        ("realizations = 2", "realization = 2", vec!["campaign.toml", "`realizations`"]),
    ] {
        assert!(paper.contains(from));
        put(&folder, "campaign.toml", &paper.replacen(from, to, 1));
        refused(&folder, 3, SEQUENTIAL, &pieces);
    }
    put(&folder, "campaign.toml", &paper);
    let vessel = std::fs::read_to_string(repository().join("pipelines/paper/vessel.toml")).unwrap();
    for (from, to, code, pieces) in [
        ("value = -0.01\n", "", 3, vec!["vessel.toml", "X_uu", "`value`"]),
        ("value = -0.01\n", "value = 0.0\n", 3, vec!["vessel.toml", "X_uu", "relative"]),
        ("nominal = -0.08", "nominal = 0.08", 4, vec!["no estimate in any of 2", "`rounds.duration_s`"]),
    ] {
        assert!(vessel.contains(from));
        put(&folder, "vessel.toml", &vessel.replacen(from, to, 1));
        refused(&folder, code, SEQUENTIAL, &pieces);
    }
}

#[test]
fn crude_models_about_the_nominal_one_take_floors_for_what_is_zero() {
    let floors =
        "crude_about = \"nominal\"\n[rounds.floor]\nX_uu = 0.01\nX_vr = 0.05\nY_ur = 0.01\nN_uv = 0.03\n";
    let folder =
        folder(&format!("{}{floors}", CONFIG.replace("= 16", "= 8").replace("rounds = 3", "rounds = 2")));
    run(&folder, SEQUENTIAL).succeeds();
    let found = found(&folder);
    assert_eq!(found.crude_about, Source::Nominal);
    assert!(found.arms.iter().all(|arm| arm.points.iter().all(|point| point.undesigned == 0)));
}

#[test]
fn crude_models_that_diverge_share_the_time_evenly_and_are_counted() {
    let wild = CONFIG.replace("rounds = 3", "rounds = 2").replace("= 0.4", "= 1.5");
    let folder = folder(&wild);
    run(&folder, SEQUENTIAL).succeeds();
    let undesigned = |arm: usize, round: usize| found(&folder).arms[arm].points[round].undesigned;
    assert!((1..16).contains(&undesigned(1, 0)), "{}", undesigned(1, 0));
    assert_eq!((undesigned(0, 0), undesigned(1, 1)), (undesigned(1, 0), undesigned(1, 0)));
    assert!(undesigned(0, 1) < undesigned(0, 0), "what was sailed evenly makes a design");
    assert_eq!((undesigned(2, 1), undesigned(3, 1)), (0, 0), "the truth designs, chance draws");
}
