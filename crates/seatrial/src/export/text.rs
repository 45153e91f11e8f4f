//! Numbers, texts and comments in the syntax of the languages. Text from users cannot terminate a string or a
//! comment.

use std::collections::BTreeSet;

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

/// `template` with every `{{key}}` replaced by its value. Inserted values are not expanded again.
pub fn fill(template: &str, values: &[(&str, String)]) -> String {
    let mut parts = template.split("{{");
    let mut out = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let (key, rest) = part.split_once("}}").unwrap_or((part, ""));
        let value = values.iter().find(|(name, _)| *name == key);
        debug_assert!(value.is_some(), "no value for {key}");
        out.push_str(value.map_or("", |(_, value)| value));
        out.push_str(rest);
    }
    out
}

// Names that are identifiers in every target language.

/// Words with a meaning in one of the languages, or in the generated code.
const RESERVED: &str = "\
    auto break case char const continue default do double else enum extern float for goto if inline int long register \
    restrict return short signed sizeof static struct switch typedef union unsigned void volatile while asm NULL NAN \
    INFINITY HUGE_VAL EOF errno main fabs size_t \
    linux unix i386 mips sparc sun vax arm hpux near far huge pascal cdecl interface small hyper min max IN OUT \
    I complex imaginary bool nullptr constexpr thread_local alignas alignof static_assert typeof typeof_unqual \
    HUGE HUGE_VALF HUGE_VALL MAXFLOAT DOMAIN SING OVERFLOW UNDERFLOW PLOSS TLOSS X_TLOSS BUFSIZ RAND_MAX EXIT_SUCCESS \
    EXIT_FAILURE TMP_MAX FILENAME_MAX FOPEN_MAX L_tmpnam P_tmpdir SEEK_SET SEEK_CUR SEEK_END stdin stdout stderr \
    math_errhandling MATH_ERRNO MATH_ERREXCEPT FP_NAN FP_INFINITE FP_ZERO FP_SUBNORMAL FP_NORMAL FP_ILOGB0 FP_ILOGBNAN \
    M_E M_LOG2E M_LOG10E M_LN2 M_LN10 M_PI M_PI_2 M_PI_4 M_1_PI M_2_PI M_2_SQRTPI M_SQRT2 M_SQRT1_2 \
    class new delete this template typename namespace using public private protected operator friend virtual explicit \
    export mutable throw reinterpret_cast dynamic_cast const_cast static_cast decltype noexcept consteval constinit \
    concept requires co_await co_return co_yield wchar_t char8_t char16_t char32_t typeid \
    and_eq bitand bitor compl not_eq or_eq xor xor_eq \
    False None True and as assert async await class def del elif except finally from global import in is lambda nonlocal \
    not or pass raise try with yield abs print sin cos \
    catch classdef end elseif function otherwise parfor persistent spmd ans eps inf Inf nan NaN pi i j true false size \
    zeros numel \
    p du dv dr state states input inputs next parameters ranges model step simulate outside within_ranges \
    initial_u initial_v initial_r time own_step";

/// Most characters of an identifier, without its distinguishing suffix: MATLAB allows 63 in total.
const LONGEST: usize = 57;

/// The Greek letters from alpha on, which are spelled out.
const GREEK: [&str; 25] = [
    "alpha", "beta", "gamma", "delta", "epsilon", "zeta", "eta", "theta", "iota", "kappa", "lambda", "mu",
    "nu", "xi", "omicron", "pi", "rho", "sigma", "sigma", "tau", "upsilon", "phi", "chi", "psi", "omega",
];

/// Identifiers in use.
pub struct Identifiers(BTreeSet<String>);

impl Identifiers {
    /// The reserved words.
    pub fn reserved() -> Self {
        Self(RESERVED.split_whitespace().map(str::to_owned).collect())
    }

    /// Reserves further words.
    pub fn reserve(&mut self, words: &str) {
        self.0.extend(words.split_whitespace().map(str::to_owned));
    }

    /// The identifier for `name` from now on: the name itself if it is a valid identifier that is not in use.
    pub fn take(&mut self, name: &str) -> String {
        let plain = identifier(name);
        let numbered = (2..).map(|number| format!("{plain}_{number}"));
        let free = [plain.clone()].into_iter().chain(numbered).find(|candidate| !self.0.contains(candidate));
        let free = free.unwrap_or(plain);
        self.0.insert(free.clone());
        free
    }
}

/// `name` if it is an identifier already, else the nearest one.
fn identifier(name: &str) -> String {
    let letters = |c: char| c.is_ascii_alphanumeric() || c == '_';
    if name.starts_with(|c: char| c.is_ascii_alphabetic())
        && name.chars().all(letters)
        && name.len() <= LONGEST
    {
        return name.to_owned();
    }
    let written: String = name.chars().map(spelled).collect();
    let words: Vec<&str> = written.split('_').filter(|word| !word.is_empty()).collect();
    let joined = words.join("_");
    let begun =
        if joined.starts_with(|c: char| c.is_ascii_alphabetic()) { joined } else { format!("x_{joined}") };
    begun.trim_end_matches('_').chars().take(LONGEST).collect()
}

/// A character as it may occur in an identifier.
fn spelled(c: char) -> String {
    let greek = |first: char| GREEK.get((u32::from(c).wrapping_sub(u32::from(first))) as usize);
    match c {
        c if c.is_ascii_alphanumeric() => c.to_string(),
        'Α'..='Ω' => greek('Α').map_or("_".to_owned(), |name| name[..1].to_uppercase() + &name[1..]),
        'α'..='ω' => greek('α').map_or("_".to_owned(), |name| (*name).to_owned()),
        _ => "_".to_owned(),
    }
}

/// The base name of files and functions: the vessel's name in lower case.
pub fn file_name(name: &str) -> String {
    let mut taken = Identifiers::reserved();
    taken.reserve(files::DEVICES);
    match name.chars().any(|c| c.is_ascii_alphabetic()) {
        true => taken.take(&identifier(&name.to_lowercase()).chars().take(40).collect::<String>()),
        false => "vessel".to_owned(),
    }
}
