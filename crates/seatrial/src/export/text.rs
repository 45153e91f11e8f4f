//! Numbers, texts and comments in the syntax of the languages. Text from users cannot terminate a string or a
//! comment.

/// A number that reads back to the same bits in every language.
pub fn number(value: f64) -> String {
    format!("{value:?}")
}

/// `text` in one line.
fn one_line(text: &str) -> String {
    text.chars()
        .map(|c| if c.is_control() || matches!(c, '\u{2028}' | '\u{2029}') { ' ' } else { c })
        .collect()
}

/// `text` within a comment of any language.
pub fn comment(text: &str) -> String {
    one_line(text).replace("*/", "* /").replace("/*", "/ *").replace('\\', "/").replace("??", "? ?")
}

/// A string in double quotes, for Python and C. In C, two question marks and another character could be a
/// trigraph.
pub fn quoted(text: &str) -> String {
    let escaped = one_line(text).replace('\\', "\\\\").replace('"', "\\\"").replace("??", "?\\077");
    format!("\"{escaped}\"")
}

/// A string in single quotes, for MATLAB.
pub fn single(text: &str) -> String {
    format!("'{}'", one_line(text).replace('\'', "''"))
}

/// `text` in lines of at most `width` characters, broken between words.
pub fn wrapped(text: &str, width: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in one_line(text).split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.chars().count() + word.chars().count() < width => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}
