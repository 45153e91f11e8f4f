//! Candidates by generation: a table `[generate]` in `dictionary.toml` instead of maneuvers written by hand.

use refusal::Invalid;
use ship::engine::Streams;

use super::draw::Draw;
use super::generate_spec::GenerateSpec;
use super::kept::Kept;
use super::spec::ManeuverSpec;

impl GenerateSpec {
    /// All candidates, whether or not they keep the limits.
    ///
    /// # Errors
    /// A meaningless number.
    pub fn candidates(&self) -> Result<Vec<ManeuverSpec>, Invalid> {
        self.check()?;
        let kinds = self.kinds();
        let streams = Streams::new(self.seed, "candidates");
        let one = |index: u32| {
            let kind = kinds[index as usize % kinds.len()];
            let mut draw = Draw { rng: streams.channel(index, 0), spec: self };
            ManeuverSpec {
                name: format!("{kind}-{index:05}"),
                description: "generated".into(),
                duration_s: self.duration_s,
                keeps: Kept::default(),
                executed: self.executed,
                feedback: None,
                approach: None,
                kind: draw.kind(kind, index),
            }
        };
        Ok((0..self.candidates).map(one).collect())
    }
}
