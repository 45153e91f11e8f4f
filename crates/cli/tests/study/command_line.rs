//! The shape of the command line: help, versions, flags before and after subcommands, completions, manual pages.

use clap::Command;

use crate::support::*;

/// Every command line of `command`, without flags: the stages and their subcommands.
fn all(command: &Command, before: &str) -> Vec<(String, Command)> {
    let own = command.get_subcommands().flat_map(|own| {
        let line = format!("{before}{} ", own.get_name());
        let below = all(own, &line);
        [(line.trim_end().to_owned(), own.clone())].into_iter().chain(below)
    });
    own.collect()
}

#[test]
fn every_help_has_an_example_that_parses_and_the_exit_codes() {
    let folder = tempfile::tempdir().unwrap();
    let commands = all(&cli::umbrella::command(), "");
    assert!(commands.iter().any(|(line, _)| line == "simulate plan"));
    assert!(commands.iter().any(|(line, _)| line == "estimate"));
    for (line, _) in &commands {
        let ran = run(&folder, &format!("{line} --help")).succeeds();
        assert!(ran.stderr.is_empty() && ran.stdout.contains("Exit codes: 0 written, 1 failed"), "{ran}");
        let examples = ran.stdout.split_once("Example:").unwrap_or_else(|| panic!("no example{ran}")).1;
        assert!(examples.trim_start().starts_with(&format!("seatrial {line}")), "{ran}");
    }
    for (line, command) in &commands {
        let about = command.get_about().unwrap().to_string();
        assert!(!about.contains("besides"), "{line}: {about}");
        let help = command.get_after_help().unwrap().to_string();
        // What the short help hides is named at its end.
        for flag in command.get_arguments().filter(|flag| flag.is_hide_short_help_set()) {
            let name = format!("--{}", flag.get_long().unwrap());
            let shared = help.lines().find(|own| own.starts_with("Also ")).unwrap();
            assert!(shared.split([' ', ',']).any(|word| word == name), "{line}: {name}");
        }
        for example in help.lines().filter(|line| line.trim_start().starts_with("seatrial ")) {
            let words = example.split_whitespace().take_while(|word| *word != ">");
            let parsed = cli::umbrella::command().try_get_matches_from(words);
            assert!(parsed.is_ok(), "{example}: {}", parsed.unwrap_err());
        }
    }
}

#[test]
fn every_command_tells_its_version() {
    let folder = tempfile::tempdir().unwrap();
    for (line, _) in all(&cli::umbrella::command(), "") {
        for flag in ["-V", "--version"] {
            let ran = run(&folder, &format!("{line} {flag}")).succeeds();
            let name = format!("seatrial-{}", line.replace(' ', "-"));
            assert_eq!(ran.stdout.trim(), format!("{name} {}", env!("CARGO_PKG_VERSION")), "{ran}");
        }
    }
}

#[test]
fn common_flags_may_stand_before_a_subcommand() {
    let folder = with(&["moments.json"]);
    let line = DICTIONARY.replace("simulate ", "--quiet simulate --threads 1 --json ");
    let ran = run(&folder, &line).succeeds();
    let said: serde_json::Value = serde_json::from_str(&ran.stdout).unwrap();
    assert_eq!((said["out"].as_str(), ran.stderr.as_str()), (Some("dictionary.parquet"), ""), "{ran}");
    for line in ["design --quiet", "validate --quiet merit"] {
        refused(&folder, 2, line, &["required arguments", "--"]);
    }
    let one = run(&folder, &format!("--seed 7 {DESIGN}")).succeeds();
    let seed = json(&folder, "design.json")["settings"]["seed"].clone();
    assert_eq!(seed, 7, "{one}");
}

#[test]
fn a_flag_of_the_stage_before_its_subcommand_is_refused() {
    let folder = with(&["moments.json"]);
    let merit = "merit --vessel vessel.toml --dictionary dictionary.toml --out merit.json";
    refused(
        &folder,
        2,
        &format!("validate --window-s 5 {merit}"),
        &["--window-s", "before `merit`", "validate merit --window-s"],
    );
}

#[test]
fn shells_and_manuals_know_every_command() {
    let folder = tempfile::tempdir().unwrap();
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let ran = run(&folder, &format!("completions {shell}")).succeeds();
        for word in ["simulate", "refine", "--mean-removal"] {
            let word = if shell == "fish" { word.trim_start_matches("--") } else { word };
            assert!(ran.stdout.contains(word), "{word}{ran}");
        }
    }
    run(&folder, "completions cshell").refuses(2, &["cshell", "bash"]);
    run(&folder, "completions man man/").succeeds();
    for page in std::fs::read_dir(folder.path().join("man")).unwrap() {
        let name = page.unwrap().file_name().into_string().unwrap();
        assert!(!name.contains("help"), "{name}");
    }
    for (line, _) in all(&cli::umbrella::command(), "") {
        let page =
            std::fs::read_to_string(folder.path().join(format!("man/seatrial-{}.1", line.replace(' ', "-"))));
        assert!(page.unwrap_or_else(|e| panic!("{line}: {e}")).contains("Exit codes"), "{line}");
    }
}

/// A remedy that is refused in turn is none: what stands behind `--` is no flag's value.
#[test]
fn numbers_below_zero_are_refused_by_what_the_flag_takes() {
    const WHOLE: &str = "expected a whole number from 0 on";
    let folder = with(&[]);
    let simulate = "simulate dictionary --vessel vessel.toml --dictionary dictionary.toml --out d.parquet";
    for (flags, found) in [("--threads -1", "1..=1024"), ("--seed -1", WHOLE), ("--memory-mib -5", WHOLE)] {
        run(&folder, &format!("{simulate} {flags}")).refuses(2, &["invalid value '-", found]);
    }
    let said = run(&folder, &format!("{simulate} --treads 2"));
    assert!(said.stderr.contains("'--threads'") && !said.stderr.contains("use '-- "), "{said}");
    assert!(!run(&folder, "design -x").stderr.contains("use '-- "));
}

#[test]
fn what_is_gone_names_what_takes_its_place() {
    let folder = tempfile::tempdir().unwrap();
    let sweep = "it is gone: `make sweep` runs every cell of a grid by `seatrial run --set`, into sweep.csv";
    for (line, found) in [
        ("sweep cells --config sweep.toml --out cells.json", "unrecognized subcommand 'sweep'"),
        ("report --sweep sweep.json --out sweep.html", "unexpected argument '--sweep'"),
    ] {
        refused(&folder, 2, line, &[found, sweep]);
    }
}
