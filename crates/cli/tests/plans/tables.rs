//! Maneuvers with inputs from tables, planned on a chart.

use crate::planned::*;
use crate::support::*;

/// Rows of the steep zig-zag: two and a half of its periods.
const ROWS: usize = 150;

#[test]
fn law_a_table_is_sailed_whole_as_it_is_written() {
    let folder =
        small_with(&[("maneuver = [{ name = \"zig-zag-steep\"", "maneuver = [{ name = \"recorded\"")]);
    let made = craft::read(&folder.path().join("dictionary.parquet"), "trajectories");
    let column = |name: &str| {
        let place = made.schema.columns.iter().position(|c| c.name == name).unwrap();
        made.blocks[0].columns[place].as_f64().unwrap()[..ROWS].to_vec()
    };
    let inputs = ["tau1", "tau2", "tau3"].map(column);
    let rows: Vec<[f64; 3]> = (0..ROWS).map(|k| [0, 1, 2].map(|i| inputs[i][k])).collect();
    let row = |(k, [x, y, n]): (usize, &[f64; 3])| format!("{k},{x},{y},{n}\n");
    let table: String = rows.iter().enumerate().map(row).collect();
    put(&folder, "log.csv", &format!("t,tau1,tau2,tau3\n{table}"));
    let dictionary = String::from_utf8(bytes(&folder, "dictionary.toml")).unwrap();
    let recorded =
        "\n[[maneuver]]\nname = \"recorded\"\nkind = \"inputs\"\nfile = \"log.csv\"\nspeed_m_s = 1.5\n";
    put(&folder, "dictionary.toml", &format!("{dictionary}{recorded}"));
    run(&folder, DICTIONARY).succeeds();
    run(&folder, PLAN).succeeds();
    let planned = Planned::of(&folder);
    let stretches = planned.track.stretches();
    let own: Vec<_> = stretches.iter().filter(|s| planned.track.maneuver[s.start] == "recorded").collect();
    assert_eq!(own.len(), 1);
    // It may be mirrored.
    let side = (planned.track.inputs[own[0].start + 10][2] / rows[10][2]).signum();
    let sailed = planned.track.inputs[own[0].clone()].iter().map(|[x, y, n]| [*x, side * y, side * n]);
    assert_eq!(sailed.collect::<Vec<_>>(), rows);
}
