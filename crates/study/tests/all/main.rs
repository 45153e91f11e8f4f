//! The files of a study as its users see them.

mod chart_text;
mod figure_goals;
mod hand_written;
mod sequential;
