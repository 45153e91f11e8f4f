use crate::{foreign, nearest};

/// Names that a message lists at most.
const LISTED: usize = 12;

/// `names` for a message; of a long list, those most like `name`.
pub fn some_of(names: &[impl AsRef<str>], name: &str) -> String {
    let mut left: Vec<&str> = names.iter().map(AsRef::as_ref).collect();
    let total = left.len();
    if total <= LISTED {
        return left.iter().map(|own| format!("`{}`", foreign(own))).collect::<Vec<_>>().join(", ");
    }
    let mut listed = Vec::new();
    while let (true, Some(near)) = (listed.len() < LISTED, nearest(name, left.iter().copied())) {
        listed.push(format!("`{}`", foreign(near)));
        left.retain(|own| *own != near);
    }
    format!("{} and {} more", listed.join(", "), left.len())
}
