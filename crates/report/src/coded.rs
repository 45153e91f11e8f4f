use maud::{Markup, html};

/// Words in which names stand between backticks.
pub(super) fn coded(text: &str) -> Markup {
    html! { @for (i, piece) in text.split('`').enumerate() { @if i % 2 == 1 { code { (piece) } } @else { (piece) } } }
}
