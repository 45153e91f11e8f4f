//! Text of others, shortened.

use refusal::{fitted, foreign, with_remedy};

#[test]
fn foreign_text_is_short_and_turns_nothing_around() {
    assert_eq!(foreign("a\u{202e}b\nc"), "a b c");
    let long = foreign(&"x".repeat(1_000_000));
    assert_eq!((long.chars().count(), long.ends_with('…')), (80, true));
    assert_eq!(foreign(&"é".repeat(80)), "é".repeat(80));
}

#[test]
fn the_longest_parts_give_way() {
    let long = "y".repeat(1000);
    let [short, cut] = fitted(["abc", &long], 100);
    assert_eq!((short.as_str(), cut.chars().count()), ("abc", 97));
    let all = fitted([&long, &long, &long, "z"], 300);
    assert!(all.iter().map(|part| part.chars().count()).sum::<usize>() <= 300 && all[3] == "z");
    assert_eq!(fitted(["a", "b"], 10), ["a", "b"]);
}

#[test]
fn a_message_that_is_too_long_keeps_its_remedy() {
    let end = ", expected one; add runs";
    let message = with_remedy(&format!("a: found {}{end}", "no, expected y ".repeat(100)), 100);
    assert!(message.starts_with("a: found no") && message.ends_with(end), "{message}");
    assert!(message.chars().count() <= 100, "{message}");
    assert!(with_remedy(&"é".repeat(1000), 100).chars().count() <= 100);
    assert_eq!(with_remedy("a, expected b", 100), "a, expected b");
}
