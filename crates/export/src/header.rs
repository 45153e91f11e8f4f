//! The comment at the top of the code, in every language.

use crate::portable::Portable;
use crate::text::{comment, number, wrapped};

/// Characters in a line of a comment.
const WIDTH: usize = 110;

impl Portable {
    /// The lines of the comment at the top of a file.
    pub(crate) fn header(&self) -> Vec<String> {
        let origin = &self.origin;
        let mut said = vec![
            format!("Manoeuvring model of {}, written by {}.", self.vessel, origin.producer),
            format!("Made from {}, {}; the values are its {}.", origin.file, origin.digest, origin.values),
            format!(
                "Discrete in time: it holds for steps of {} s ({} Hz) and for no others. In a step the states gain the sums below.",
                number(1.0 / self.rate_hz),
                self.rate_hz
            ),
            "States: u, v [m/s] along x (forward) and y (starboard), r [rad/s] about z (down), in body axes. In a current c, in \
             body axes too, the next state is c plus the step from (state - c)."
                .to_owned(),
        ];
        said.push(match self.ranges.is_empty() {
            true => "Its range of validity is not known: within_ranges is true everywhere.".to_owned(),
            false => "Its range of validity is what the data covered that it was fitted to.".to_owned(),
        });
        said.extend(self.tied.iter().map(|own| {
            format!("{} is {} times {}, and part of the term of that.", own.name, number(own.factor), own.to)
        }));
        let renamed = self.renamed();
        said.extend(renamed.iter().map(|(own, name)| format!("{name} is called {own} here.")));
        said.extend(self.notes.iter().map(|note| format!("Note: {note}.")));
        said.iter().flat_map(|line| wrapped(&comment(line), WIDTH)).collect()
    }

    /// [`Portable::header`] with `mark` in front of every line.
    pub(crate) fn marked_header(&self, mark: &str) -> String {
        self.header().iter().map(|line| format!("{mark}{line}\n")).collect()
    }
}
