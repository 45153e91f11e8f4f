//! The stages from the design to the chart are programs of their own, too.

use assert_cmd::Command;

#[test]
fn every_program_is_its_stage() {
    let programs = [
        ("simulate", env!("CARGO_BIN_EXE_simulate")),
        ("moments", env!("CARGO_BIN_EXE_moments")),
        ("design", env!("CARGO_BIN_EXE_design")),
        ("estimate", env!("CARGO_BIN_EXE_estimate")),
        ("validate", env!("CARGO_BIN_EXE_validate")),
        ("plan", env!("CARGO_BIN_EXE_plan")),
    ];
    for (name, path) in programs {
        let output = Command::new(path).arg("-V").output().unwrap();
        let said = String::from_utf8(output.stdout).unwrap();
        assert_eq!(said.trim(), format!("{name} {}", env!("CARGO_PKG_VERSION")));
        let output = Command::new(path).arg("--help").output().unwrap();
        let help = String::from_utf8(output.stdout).unwrap();
        assert!(help.contains(&format!("Usage: {name} ")) && help.contains("Exit codes"), "{name}: {help}");
    }
}
