//! Writes `moments.json` and its table, as `moments --keep table` does, for random maneuvers: `many_moments 1000000
//! FOLDER`. It serves to measure the time and memory of `design` for a table of a size.

use std::path::PathBuf;

use design::Degree;
use files::{Provenance, TableWriter, commit_with_document};
use regression::InstrumentKind;
use ship::engine::Streams;
use study::documents::MomentsDocument;
use study::moments_table::{BLOCK, columns, table_of};
use trial::moments::{DegreeMoments, ManeuverMoments, Moments};

/// φ̃φ̃ᵀ, averaged over three samples, of regressors that are powers of a few random numbers.
fn maneuver(streams: &Streams, number: u32, degrees: &[Degree]) -> ManeuverMoments {
    let mut normals = [0.0; 27];
    streams.normals(number, 0, &mut normals);
    let of = |(d, degree): (usize, &Degree)| {
        let n = degree.regressors.len();
        let mut m = vec![0.0; n * n];
        for sample in normals[9 * d..9 * d + 9].chunks(3) {
            let phi = |i: usize| if i + 1 == n { 1.0 } else { sample[i % 3].powi(1 + (i / 3) as i32) };
            (0..n * n).for_each(|e| m[e] += phi(e / n) * phi(e % n) / 3.0);
        }
        DegreeMoments { name: degree.name.clone(), shape: [n as u64; 2], m, nonstationarity: 0.0, b: None }
    };
    let degrees = degrees.iter().enumerate().map(of).collect();
    ManeuverMoments { name: format!("maneuver-{number}"), samples: 1000, degrees, output_error: None }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let [count, folder] = [1, 2].map(|i| std::env::args().nth(i).unwrap_or_default());
    let (count, out) = (count.parse::<u32>()?, PathBuf::from(folder).join("moments.json"));
    let of = |(name, parameters): (&str, usize)| Degree {
        name: name.to_owned(),
        regressors: (0..parameters).map(|i| format!("x{i}")).chain(["1".to_owned()]).collect(),
        parameters: (0..parameters).map(|i| format!("{name}_{i}")).collect(),
    };
    let degrees: Vec<Degree> = [("surge", 4), ("sway", 3), ("yaw", 3)].map(of).into();
    let streams = Streams::new(1, "many moments");
    let (columns, provenance) = (columns(&degrees), Provenance::default());
    let mut writer = TableWriter::create(table_of(&out), columns.schema(), &provenance)?.with_document(&out);
    for first in (0..count).step_by(BLOCK) {
        let numbers = first..count.min(first + BLOCK as u32);
        let rows: Vec<ManeuverMoments> = numbers.map(|i| maneuver(&streams, i, &degrees)).collect();
        writer.push(columns.encode(&rows)?)?;
    }
    let head = Moments {
        vessel: "drawn".to_owned(),
        sample_rate_hz: 8.0,
        instruments: Some(InstrumentKind::Nominal),
        degrees,
        maneuvers: Vec::new(),
        held: Vec::new(),
        beyond: Vec::new(),
        disturbances: None,
        output_error: None,
        prior: None,
        sampled: None,
    };
    commit_with_document(writer.finish()?, &out, &provenance, &MomentsDocument(head))?;
    Ok(())
}
