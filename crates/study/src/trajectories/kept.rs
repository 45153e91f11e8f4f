use std::borrow::Cow;

use files::Error;
use regression::pooled::Recorded;
use ship::engine::Run;

use super::{Layout, TrajectoryReader};

/// The runs of trajectories for several passes: few are held in memory, many are read again.
pub enum KeptRuns {
    /// In memory.
    Held(Vec<Run>),
    /// In their file.
    InFile(Box<TrajectoryReader>),
}

/// Maximum bytes of runs that are held in memory.
const HELD: f64 = 1e8;

impl KeptRuns {
    /// The runs of `reader`, held in memory if they take less than `most` bytes and not more than some 100 MB.
    ///
    /// # Errors
    /// See [`TrajectoryReader::runs`].
    pub fn new(reader: TrajectoryReader, layout: &Layout, most: f64) -> Result<Self, Error> {
        let (rows, _) = reader.rows();
        let few = rows as f64 * layout.run_bytes() <= HELD.min(most);
        if few { reader.all().map(Self::Held) } else { Ok(Self::InFile(Box::new(reader))) }
    }
}

impl Recorded for KeptRuns {
    type Error = Error;

    fn blocks(&self) -> usize {
        match self {
            Self::Held(_) => 1,
            Self::InFile(reader) => reader.blocks(),
        }
    }

    fn block(&self, i: usize) -> Result<Cow<'_, [Run]>, Error> {
        match self {
            Self::Held(runs) => Ok(Cow::Borrowed(runs)),
            Self::InFile(reader) => reader.runs(i).map(Cow::Owned),
        }
    }

    fn held(&self) -> bool {
        matches!(self, Self::Held(_))
    }
}
