use refusal::Invalid;
use thiserror::Error;

/// Why there is no fit.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum Unfit {
    /// Every number is known, fixed or tied.
    #[error("no number of the model is free")]
    NoParameter,
    /// No recording has two samples.
    #[error("no recording has two samples")]
    NoSample,
    /// A state is constant, so that its errors have no scale.
    #[error("`{0}` does not vary in the recordings")]
    Constant(&'static str),
    /// With the numbers before the fit a simulation leaves every bound.
    #[error("with the numbers before the fit, the simulation of `{recording}` from {first_s} s on diverges")]
    Diverged {
        /// The recording.
        recording: String,
        /// Where the window begins in it \[s\].
        first_s: f64,
    },
    /// The cost of the numbers that a search begins with is not finite, though every window's is.
    #[error("the cost of the numbers that the search begins with is not finite")]
    Boundless,
    /// The state that a window starts from cannot be found: how motion depends on it grows beyond every number.
    #[error(
        "in `{recording}`, the state at {first_s} s cannot be found: the motion of its window depends on it beyond all numbers"
    )]
    Start {
        /// The recording.
        recording: String,
        /// Where the window begins in it \[s\].
        first_s: f64,
    },
    /// Neither the recordings nor a prior determine a parameter.
    #[error("nothing in the recordings determines `{0}`, and it has no prior")]
    Undetermined(String),
    /// A term cannot be tried.
    #[error("a term to be tried is refused: {0}")]
    Candidate(String),
    /// A listed term is refused.
    #[error("{0}")]
    Listed(Box<Invalid>),
    /// The search did not end, and recordings fit better with something turned over.
    #[error("no minimum after {0} steps; the recordings fit better with {1}")]
    WrongSign(usize, String),
    /// The search did not end.
    #[error("no minimum after {0} steps")]
    Unfinished(usize),
}

impl Unfit {
    /// What is invalid, and the remedy.
    pub fn invalid(&self) -> Invalid {
        let (thing, expected, remedy) = match self {
            Self::Listed(own) => return (**own).clone(),
            Self::NoParameter => {
                ("the model", "at least one free number", "write some as tables with `nominal` and `prior`")
            }
            Self::NoSample => ("the recordings", "two samples or more", "give longer runs"),
            Self::Constant(_) => ("the recordings", "u, v and r that vary", "give runs with maneuvers"),
            Self::Diverged { .. } => {
                ("the model", "numbers that the ship can be simulated with", "correct `nominal` or `prime`")
            }
            Self::Boundless => ("the model", "a finite one", "begin from numbers nearer to their priors"),
            Self::Start { .. } => {
                let expected = "windows over which motion stays finite";
                (
                    "the recordings",
                    expected,
                    "take shorter windows (`--window-s`), or correct the model's numbers",
                )
            }
            Self::Undetermined(_) => ("the model", "information about each", "add a `prior`, or fix it"),
            Self::Candidate(_) => {
                ("the model", "channels that terms can name", "rename the channel in vessel.toml")
            }
            Self::WrongSign(..) => {
                ("the fit", "signs as the ship has them", "check these columns and places, and correct them")
            }
            Self::Unfinished(_) => (
                "the fit",
                "a minimum",
                "give each number a prior, or a narrower one, or begin from better numbers",
            ),
        };
        Invalid::new(thing, self.to_string(), expected, remedy)
    }
}
