//! The comment at the top of the code, in every language.

use ship::model::RateChange;

use crate::export::portable::Portable;
use crate::export::text::{comment, number, wrapped};

/// Characters in a line of a comment.
const WIDTH: usize = 110;

impl Portable {
    /// The lines of the comment at the top of a file.
    pub(crate) fn header(&self) -> Vec<String> {
        let origin = &self.origin;
        let mut said = vec![
            format!("Manoeuvring model of {}, written by {}.", self.vessel, origin.producer),
            format!("Made from {}, {}; the values are its {}.", origin.file, origin.digest, origin.values),
            self.time(),
            format!(
                "States: u, v [m/s] along x (forward) and y (starboard), r [rad/s] about z (down), in body axes. {}",
                self.current()
            ),
        ];
        said.extend(self.late.iter().map(|own| format!("Inputs are as they act: {own}.")));
        said.push(match self.ranges.is_empty() {
            true => "Its range of validity is not known: within_ranges is true everywhere.".to_owned(),
            false => format!("Its range of validity is {}.", self.ranges_are()),
        });
        said.extend(self.tied.iter().map(|own| {
            format!("{} is {} times {}, and part of the term of that.", own.name, number(own.factor), own.to)
        }));
        if self.ship.is_some() {
            said.push("A number `key` of `component` is called component_key here.".to_owned());
        }
        let renamed = self.unlike();
        said.extend(renamed.iter().map(|(own, name)| format!("{name} is called {own} here.")));
        said.extend(self.parts.iter().map(|part| format!("{part}.")));
        said.extend(self.notes.iter().map(|note| format!("Note: {note}.")));
        said.iter().flat_map(|line| wrapped(&comment(line), WIDTH)).collect()
    }

    /// The length of its steps, in words.
    fn time(&self) -> String {
        let (seconds, rate) = (number(1.0 / self.rate_hz), self.rate_hz);
        let own = number(1.0 / self.own_rate_hz());
        let sums = "Discrete in time: in a step the states gain the sums below. They hold for steps of";
        match (&self.ship, self.pace) {
            (None, RateChange::Repeated(count)) => {
                format!("{sums} {own} s; here, a step of {seconds} s ({rate} Hz) is {count} of them.")
            }
            (None, RateChange::Divided { by, order }) => format!(
                "{sums} {own} s; here, a step of {seconds} s ({rate} Hz) is a part of them, by Newton's forward formula of order {order} for \
                 1/{by} of a step."
            ),
            (Some(ship), _) => format!(
                "Forces in continuous time: a step of {seconds} s ({rate} Hz) is {} of Runge and Kutta's method of order 4.",
                if ship.steps == 1 { "one".to_owned() } else { ship.steps.to_string() }
            ),
            (None, RateChange::Own) => format!(
                "Discrete in time: it holds for steps of {seconds} s ({rate} Hz) and for no others. In a step the states gain the \
                 sums below."
            ),
        }
    }

    /// How it is stepped in a current.
    fn current(&self) -> &'static str {
        match self.ship {
            Some(_) => {
                "In a current, step from (state - c), where c is the current in body axes; then add it in the body axes at the end of \
                 the step: it keeps its course over the earth."
            }
            None => "In a current c, in body axes too, the next state is c plus the step from (state - c).",
        }
    }

    /// [`Portable::header`] with `mark` in front of every line.
    pub(crate) fn marked_header(&self, mark: &str) -> String {
        self.header().iter().map(|line| format!("{mark}{line}\n")).collect()
    }
}
