//! Each stage's program is that stage.

use assert_cmd::Command;

#[test]
fn every_program_is_its_stage() {
    let programs = [
        ("simulate", env!("CARGO_BIN_EXE_simulate")),
        ("ingest", env!("CARGO_BIN_EXE_ingest")),
        ("moments", env!("CARGO_BIN_EXE_moments")),
        ("design", env!("CARGO_BIN_EXE_design")),
        ("estimate", env!("CARGO_BIN_EXE_estimate")),
        ("validate", env!("CARGO_BIN_EXE_validate")),
        ("monte-carlo", env!("CARGO_BIN_EXE_monte-carlo")),
        ("plan", env!("CARGO_BIN_EXE_plan")),
        ("sequential", env!("CARGO_BIN_EXE_sequential")),
        ("export", env!("CARGO_BIN_EXE_export")),
        ("report", env!("CARGO_BIN_EXE_report")),
    ];
    let stages = cli::commands::STAGES.map(|stage| stage.command());
    assert_eq!(programs.map(|(name, _)| name), stages.each_ref().map(|stage| stage.get_name()));
    for (name, path) in programs {
        let output = Command::new(path).arg("-V").output().unwrap();
        let said = String::from_utf8(output.stdout).unwrap();
        assert_eq!(said.trim(), format!("{name} {}", env!("CARGO_PKG_VERSION")));
        let output = Command::new(path).arg("--help").output().unwrap();
        let help = String::from_utf8(output.stdout).unwrap();
        assert!(help.contains(&format!("Usage: {name} ")) && help.contains("Exit codes"), "{name}: {help}");
    }
}
