//! Patterns and templates of file names.

use logs::{Pattern, Template};

#[test]
fn stars_stop_at_folders() {
    assert!(Pattern::new("zig*_*.csv").fits("zigzag_1.csv"));
    assert!(Pattern::new("*").fits("a{b}"));
    assert!(!Pattern::new("*.csv").fits("a/b.csv"));
    assert!(!Pattern::new("*.csv").fits("b.csv.gz"));
}

#[test]
fn named_parts_are_found() {
    let template = Template::new("{kind}_*.csv", "kind").unwrap();
    assert_eq!(template.part("turn_14-Oct_2.csv"), Some("turn"));
    assert_eq!(template.part("_x.csv"), None);
    let path = "{kind}/*_{run}.csv.gz";
    let part = |name: &str, text| Template::new(path, name).unwrap().part(text);
    assert_eq!(part("run", "zigzag/port_7.csv.gz"), Some("7"));
    assert_eq!(part("kind", "zigzag/port_7.csv.gz"), Some("zigzag"));
    assert_eq!(part("kind", "zigzag/7.csv.gz"), None);
    assert!(Template::new("{kind", "kind").is_none() && Template::new("{}x{kind}", "kind").is_none());
    assert!(Template::new(path, "kinds").is_none());
}
