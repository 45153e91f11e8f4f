use files::Provenance;

use crate::documents::{Bounds, ValidationDocument};
use crate::recommendation::recommendations;
use crate::scores::{Row, compare, summarize};
use crate::seed::seed;

/// `validation.json` of `rows`, scored over `samples` samples of validation runs with `provenance`.
pub fn validated(rows: &[Row], bounds: Bounds, samples: u64, provenance: &Provenance) -> ValidationDocument {
    ValidationDocument {
        bounds,
        samples,
        seed: seed(provenance),
        designs: summarize(rows, bounds),
        recommendations: recommendations(rows),
        compared: compare(rows, bounds),
    }
}
