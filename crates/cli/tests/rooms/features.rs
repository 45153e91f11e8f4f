//! Features of dependencies: those of one crate's tests must be those of all, or `cargo test -p` would compile them again.

use std::collections::BTreeSet;
use std::process::Command;

use crate::source;

/// Each package with its features, as the tests of `selected` build it.
fn built(selected: &[&str]) -> BTreeSet<String> {
    let mut tree = Command::new(env!("CARGO"));
    tree.args(["tree", "--offline", "--locked", "--edges", "normal,build,dev"]);
    let out = tree.args(["--prefix", "none", "--format", "{p}|{f}"]).args(selected).output().unwrap();
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    let text = String::from_utf8(out.stdout).unwrap();
    // What stands behind a repeated package and behind macros is not part of either.
    text.lines().map(|line| line.replace(" (*)", "").replace(" (proc-macro)", "")).collect()
}

#[test]
fn law_a_crate_is_tested_with_what_the_workspace_has_built() {
    let all = built(&["--workspace"]);
    for one in source::crates() {
        let own = built(&["--package", &one.package]);
        let anew: Vec<&String> = own.difference(&all).collect();
        assert!(
            anew.is_empty(),
            "{}: add the features that a build of the workspace has to workspace-hack: {anew:?}",
            one.name
        );
    }
}
