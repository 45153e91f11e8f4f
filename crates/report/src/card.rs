use maud::{Markup, Render, html};

/// A key figure with its caption, and lines below it.
pub(super) fn card(what: &str, figure: impl Render, of: impl Render, others: &[String]) -> Markup {
    html! {
        div.card {
            p.what { (what) }
            p.figure-line { span.big { (figure) } " " span.who { (of) } }
            @for other in others { p.other { (other) } }
        }
    }
}
