//! Files are written whole or not at all.

use files::{Error, Staged, TableWriter, commit};

use crate::sample::{encode, folder, names, provenance, refusal, schema, stage};

#[test]
fn dropped_files_leave_nothing() {
    let folder = folder();
    let path = folder.path().join("t.parquet");
    let mut writer = TableWriter::create(&path, &schema(), &provenance()).unwrap();
    writer.push(encode(0..1).remove(0)).unwrap();
    assert_eq!(names(&folder).len(), 1);
    drop(writer);
    assert!(names(&folder).is_empty());
    let staged = stage(&path, &provenance(), encode(0..2)).unwrap();
    assert_eq!(staged.path(), path);
    assert!(!path.exists());
    drop(staged);
    assert!(names(&folder).is_empty());
}

#[test]
fn a_committed_file_replaces_the_one_before() {
    let folder = folder();
    let path = folder.path().join("a.txt");
    for text in ["one", "two"] {
        commit(vec![Staged::bytes(&path, text.as_bytes()).unwrap()]).unwrap();
        assert_eq!(std::fs::read_to_string(&path).unwrap(), text);
    }
    assert_eq!(names(&folder), ["a.txt"]);
}

#[test]
fn a_missing_folder_is_told_with_its_remedy() {
    let folder = folder();
    let path = folder.path().join("none/t.parquet");
    let error = TableWriter::create(&path, &schema(), &provenance()).unwrap_err();
    assert!(matches!(&error, Error::Io { path: p, action: "create", .. } if *p == path));
    let line = error.to_string();
    assert!(line.contains("t.parquet: create: found no folder `"), "{line}");
    assert!(line.ends_with("expected an existing folder; create the folder first"), "{line}");
    assert!(names(&folder).is_empty());
}

#[test]
fn a_folder_as_target_is_refused_before_anything_is_written() {
    let folder = folder();
    assert!(matches!(Staged::bytes(folder.path(), b"x"), Err(Error::Io { action: "create", .. })));
    assert!(matches!(Staged::bytes("", b"x"), Err(Error::Io { action: "create", .. })));
    assert!(names(&folder).is_empty());
}

#[cfg(unix)]
#[test]
fn a_link_or_a_device_is_refused_and_stays() {
    let folder = folder();
    let (target, link) = (folder.path().join("target"), folder.path().join("link"));
    std::fs::write(&target, b"old").unwrap();
    std::os::unix::fs::symlink(&target, &link).unwrap();
    let line = refusal(Staged::bytes(&link, b"x"));
    assert!(
        line.contains("link: output: found a link to ") && line.ends_with("or remove the link"),
        "{line}"
    );
    assert!(refusal(Staged::bytes("/dev/null", b"x")).contains("/dev/null: output: found a device or pipe"));
    assert!(link.is_symlink());
    assert_eq!(std::fs::read(&target).unwrap(), b"old");
}

#[test]
fn two_files_of_one_name_are_refused() {
    let folder = folder();
    let path = folder.path().join("a");
    let staged = vec![Staged::bytes(&path, b"1").unwrap(), Staged::bytes(&path, b"2").unwrap()];
    assert!(refusal(commit(staged)).contains("a: output: found two files of this name"));
    assert!(names(&folder).is_empty());
}

#[cfg(unix)]
#[test]
fn a_file_has_ordinary_permissions() {
    use std::os::unix::fs::PermissionsExt;
    let folder = folder();
    let (path, plain) = (folder.path().join("a"), folder.path().join("b"));
    commit(vec![Staged::bytes(&path, b"x").unwrap()]).unwrap();
    std::fs::write(&plain, b"x").unwrap();
    let mode = |path| std::fs::metadata(path).unwrap().permissions().mode();
    assert_eq!(mode(path), mode(plain));
}

#[test]
fn names_of_devices_are_seen_in_any_part_and_with_any_ending() {
    for (path, device) in [("out/nul", "nul"), ("Con.parquet", "Con.parquet"), ("lpt1/x.json", "lpt1")] {
        assert_eq!(files::device_in(path.as_ref()).as_deref(), Some(device), "{path}");
    }
    for path in ["out/null.json", "com/x.parquet", "a.con", "com10.json"] {
        assert_eq!(files::device_in(path.as_ref()), None, "{path}");
    }
}
