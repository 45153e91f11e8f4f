//! Names in files are those on the command line.

use regression::pooled::NominalSource;
use regression::{InstrumentKind, MeanRemoval};
use serde::Serialize;

fn check<T: Copy + Serialize>(all: &[T], name: fn(T) -> &'static str) {
    for one in all {
        assert_eq!(serde_json::to_value(one).unwrap(), name(*one));
    }
}

#[test]
fn choices_are_called_in_files_what_their_names_say() {
    check(&MeanRemoval::ALL, MeanRemoval::name);
    check(&InstrumentKind::ALL, InstrumentKind::name);
    check(&NominalSource::ALL, NominalSource::name);
}
