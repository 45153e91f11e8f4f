use maud::{Markup, html};

/// Says which file is missing and which stage writes it.
pub(super) fn missing(what: &str, file: &str, stage: &str) -> Markup {
    html! {
        p.missing {
            (what) " not shown: there is no " code { (file) } "; the stage " code { (stage) } " writes it."
        }
    }
}
