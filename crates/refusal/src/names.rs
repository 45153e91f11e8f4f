use crate::{Invalid, foreign, one_line};

/// Most characters of a name: it stands in figures and routes.
const LONGEST: usize = 200;

/// Refuses a name that figures, routes and pages cannot hold: an empty one, one of more than 200 characters,
/// or one with line breaks, invisible marks, or characters that XML does not allow.
///
/// # Errors
/// Names `thing`, the owner of the name.
pub fn check_name(thing: impl Into<String>, name: &str) -> Result<(), Invalid> {
    let count = name.chars().count();
    let refuse = |found: String| {
        let expected = format!("1 to {LONGEST} visible characters in one line");
        Err(Invalid::new(thing, found, expected, "rename it"))
    };
    let unheld = |c: &char| matches!(c, '\u{fffe}' | '\u{ffff}') || one_line(&c.to_string()) != c.to_string();
    match name.chars().find(unheld) {
        Some(c) => refuse(format!("`{}` with the character U+{:04X}", foreign(name), u32::from(c))),
        None if name.trim().is_empty() => refuse("no name".to_owned()),
        None if count > LONGEST => refuse(format!("`{}`, {count} characters", foreign(name))),
        None => Ok(()),
    }
}
