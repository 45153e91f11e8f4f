//! Writes the JSON Schema of every document and of every hand-written file into a folder, and the page of the keys of
//! `ingest.toml` into `docs` next to it: `cargo run -p seatrial-cli --example write_schemas -- schemas`.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use cli::pipeline::starting;
use study::documents::schemas;
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
    let documents = documents.map(|(name, schema)| (name, format!("{schema:#}\n")));
    for (name, text) in documents.chain(starting::schemas()) {
        std::fs::write(folder.join(name.trim_start_matches("schemas/")), text)?;
    }
    let docs = folder.join("../docs");
    if docs.is_dir() {
        std::fs::write(docs.join("ingest-keys.md"), page())?;
    }
    Ok(())
}
