/// `a`, `a and b`, `a, b and c`.
pub fn listed(items: &[String]) -> String {
    match items {
        [] => String::new(),
        [one] => one.clone(),
        [most @ .., last] => format!("{} and {last}", most.join(", ")),
    }
}

/// The names in `text`, which has commas between them: of pieces that are `known` only together one name, the longest.
pub fn names_in(text: &str, known: impl Fn(&str) -> bool) -> Vec<String> {
    let pieces: Vec<&str> = text.split(',').collect();
    let (mut names, mut rest) = (Vec::new(), pieces.as_slice());
    while let [first, ..] = rest {
        let joined = |n: usize| (n, rest[..n].join(",").trim().to_owned());
        let whole = (1..=rest.len()).rev().map(joined).find(|(_, name)| known(name));
        let (used, name) = whole.unwrap_or_else(|| (1, first.trim().to_owned()));
        names.push(name);
        rest = &rest[used..];
    }
    names
}
