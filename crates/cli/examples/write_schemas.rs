//! Writes the JSON Schema of every document and of every hand-written file into a folder, and the page of the keys of
//! `ingest.toml` into `docs` next to it: `cargo run -p study --example write_schemas -- schemas`.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use study::documents::schemas;
use study::files;
use study::ingest_file::page;

fn main() -> ExitCode {
    let Some(folder) = std::env::args_os().nth(1).map(PathBuf::from) else {
        eprintln!("error: folder: found none, expected the folder for the schemas; name it");
        return ExitCode::from(2);
    };
    match write(&folder) {
        Ok(()) => ExitCode::SUCCESS,
        Err(e) => {
            eprintln!(
                "error: {}: write: found {e}, expected a writable folder; write elsewhere",
                folder.display()
            );
            ExitCode::from(1)
        }
    }
}

fn write(folder: &Path) -> std::io::Result<()> {
    std::fs::create_dir_all(folder)?;
    let documents = schemas().into_iter().map(|(id, schema)| (format!("{id}.schema.json"), schema));
    let written = files::schemas().map(|(kind, schema)| (files::file_name(kind), schema));
    for (name, schema) in documents.chain(written) {
        std::fs::write(folder.join(name), format!("{schema:#}\n"))?;
    }
    let docs = folder.join("../docs");
    if docs.is_dir() {
        std::fs::write(docs.join("ingest-keys.md"), page())?;
    }
    Ok(())
}
