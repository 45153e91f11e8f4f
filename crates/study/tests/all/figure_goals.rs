//! Figures of merit and accuracies as they are stated on the command line.

use study::figure_goals::{FigureWeight, StatedAccuracy};

#[test]
fn a_name_stands_for_a_figure_or_for_all_of_its_numbers() {
    let of = |name: &str| format!("{name}=1").parse::<FigureWeight>().unwrap().name;
    assert!(of("tactical-diameter").matches("turn", "tactical_diameter"));
    assert!(of("overshoot").matches("a", "overshoot_1") && of("overshoot").matches("b", "overshoot_2"));
    assert!(of("overshoot-2").matches("a", "overshoot_2") && !of("overshoot_2").matches("a", "overshoot_1"));
    assert!(of("zig-zag/overshoot").matches("zig-zag", "overshoot_1"));
    assert!(!of("zig-zag/overshoot").matches("other", "overshoot_1"));
    assert!(of("all").matches("a", "advance") && !of("time").matches("a", "time_to_stop"));
}

#[test]
fn accuracies_are_shares_or_figures_with_units() {
    let of = |text: &str| text.parse::<StatedAccuracy>();
    assert_eq!(of("0.1"), Ok(StatedAccuracy::Share(0.1)));
    for (text, error, unit) in
        [("advance=2 m", 2.0, "m"), ("advance=1e-1L", 0.1, "L"), ("advance=2", 2.0, "")]
    {
        let Ok(StatedAccuracy::Figure(found)) = of(text) else { panic!("{text}") };
        assert_eq!((found.error, found.unit.as_str(), found.name.text()), (error, unit, "advance"));
    }
    for text in ["x", "0", "advance=m", "advance=-2 m", "advance=nan m"] {
        assert!(of(text).is_err_and(|e| e.contains("expected")), "{text}");
    }
    for text in ["advance", "advance=-1", "advance=x", "advance=inf"] {
        assert!(text.parse::<FigureWeight>().is_err_and(|e| e.contains("expected")), "{text}");
    }
}
