//! Parameters that are fixed, tied or bounded, and the constant as a term.

use ship::engine::Compiled;
use ship::model::{Constraint, DegreeOfFreedom, Source, Vessel, Written};

/// A vessel whose sway terms are `sway`.
fn written(sway: &str) -> String {
    format!(
        "name = \"x\"\nsample_rate_hz = 1.0\n\
         input = [{{ name = \"n\", unit = \"rpm\" }}, {{ name = \"d\", unit = \"rad\" }}]\n\
         surge = [{{ parameter = \"a\", term = \"n |n|\", nominal = 0.1 }}]\n\
         sway = [{sway}]\nyaw = [{{ parameter = \"c\", term = \"r\", nominal = -0.3 }}]\n"
    )
}

fn vessel(sway: &str) -> Result<Vessel, String> {
    let file = written(sway).parse().map_err(|e: toml::de::Error| e.message().to_owned())?;
    Vessel::from_file(file).map_err(|e| e.to_string())
}

const FREE: &str = "{ parameter = \"p\", term = \"v |v| d\", nominal = -0.2 }, \
    { parameter = \"q\", term = \"u r\", nominal = 0.4 }, { parameter = \"s\", term = \"|d| v r\", nominal = -0.6 }, \
    { parameter = \"k\", term = \"1\", nominal = 0.01 }";
/// The same with the first fixed and the third tied to the second.
const HELD: &str = "{ parameter = \"p\", term = \"v |v| d\", nominal = -0.2, fixed = true }, \
    { parameter = \"q\", term = \"u r\", nominal = 0.4 }, { parameter = \"s\", term = \"|d| v r\", tied_to = \"q\", factor = -1.5 }, \
    { parameter = \"k\", term = \"1\", nominal = 0.01 }";
const AT: ([f64; 3], [f64; 2]) = ([0.7, -0.4, 0.3], [2.0, -0.5]);

fn at(vessel: &Vessel) -> Compiled<'_, f64> {
    let mut compiled = Compiled::new(&vessel.model, &vessel.nominal);
    compiled.look(AT.0, &AT.1, None);
    compiled
}

fn close(found: f64, expected: f64) {
    assert!((found - expected).abs() <= 1e-14 * expected.abs().max(1e-3), "{found} {expected}");
}

#[test]
fn law_what_is_fixed_or_tied_acts_as_if_it_were_free_and_had_that_value() {
    let (free, held) = (vessel(FREE).unwrap(), vessel(HELD).unwrap());
    assert_eq!(held.model.parameter_names().collect::<Vec<_>>(), ["a", "q", "k", "c"]);
    assert_eq!(held.nominal, [0.1, 0.4, 0.01, -0.3]);
    let (mut free, mut held) = (at(&free), at(&held));
    for (found, expected) in held.increments().into_iter().zip(free.increments()) {
        close(found, expected);
    }
    close(held.term(1), free.term(2) - 1.5 * free.term(3));
    close(held.known()[1], -0.2 * free.term(1));
    for (found, expected) in held.slopes().as_flattened().iter().zip(free.slopes().as_flattened()) {
        close(*found, *expected);
    }
    let (mut found, mut expected) = ([[0.0; 3]; 5], [[0.0; 3]; 5]);
    held.gradients(&mut found);
    free.gradients(&mut expected);
    found.as_flattened().iter().zip(expected.as_flattened()).for_each(|(a, b)| close(*a, *b));
}

#[test]
fn law_transposed_products_take_fixed_and_tied_terms_along() {
    let (free, held) = (vessel(FREE).unwrap(), vessel(HELD).unwrap());
    let slopes = [[0.3, -0.2, 0.5], [0.7, 0.1, -0.4], [0.2, 0.6, -0.1]];
    let (mut found, mut expected) = ([0.0; 5], [0.0; 5]);
    // Of a, p, q, s, k, c; then of a, q, k, c and the known one, p.
    at(&free).pull_back(&[0.5, 0.8, 0.9, -1.5 * 0.9, 0.3, 0.4], &slopes, &mut expected);
    at(&held).pull_back(&[0.5, 0.9, 0.3, 0.4, 0.8], &slopes, &mut found);
    found.into_iter().zip(expected).for_each(|(a, b)| close(a, b));
}

#[test]
fn parameters_are_in_the_order_of_the_file() {
    let held = vessel(HELD).unwrap();
    let name = |written: &Written| match written {
        Written::Estimated(i) => held.model.parameter_names().nth(*i).unwrap().to_owned(),
        Written::Constrained(own) => format!("({})", own.name),
    };
    let sway = held.written(DegreeOfFreedom::Sway);
    assert_eq!(sway.iter().map(name).collect::<Vec<_>>(), ["(p)", "q", "(s)", "k"]);
    assert_eq!(held.constrained[1].constraint, Constraint::Tied { to: 1, factor: -1.5 });
    assert_eq!(held.constrained[1].value(&held.nominal), -1.5 * 0.4);
    let (model, left) = held.model.held_at_bounds(&held.nominal);
    assert_eq!((model, left), (held.model.clone(), held.nominal.clone()));
}

#[test]
fn a_chain_of_ties_ends_at_what_is_estimated_or_fixed() {
    let chain = |q: &str| {
        format!(
            "{{ parameter = \"p\", term = \"v\", tied_to = \"s\", factor = 2.0 }}, \
             {{ parameter = \"s\", term = \"u v\", tied_to = \"q\", factor = 3.0 }}, \
             {{ parameter = \"q\", term = \"u r\", {q} }}, {{ parameter = \"t\", term = \"r\", nominal = 1.0 }}"
        )
    };
    let tied = vessel(&chain("nominal = 0.4")).unwrap();
    assert_eq!(tied.constrained[0].constraint, Constraint::Tied { to: 1, factor: 6.0 });
    let fixed = vessel(&chain("value = 0.5, fixed = true")).unwrap();
    assert_eq!(fixed.constrained[0].constraint, Constraint::Fixed(3.0));
    assert_eq!(fixed.parameters(Source::Nominal).unwrap(), [0.1, 1.0, -0.3]);
}

#[test]
fn the_constant_is_a_term_and_takes_the_intercepts_place() {
    let free = vessel(FREE).unwrap();
    assert_eq!(free.model.parameter_units()[4], "m/s");
    let lifted = free.model.with_intercepts();
    assert_eq!(lifted.layout(), free.model.layout().with_intercepts());
    assert_eq!(
        lifted.layout().woven(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0], [0.1, 0.0, 0.3]),
        [1.0, 0.1, 2.0, 3.0, 4.0, 5.0, 6.0, 0.3]
    );
    assert_eq!(lifted.layout().intercepts(&[1.0, 0.1, 2.0, 3.0, 4.0, 5.0, 6.0, 0.3]), [0.1, 0.0, 0.3]);
}

#[test]
fn constraints_that_mean_nothing_are_refused_in_one_line() {
    let p = |rest: &str| format!("{{ parameter = \"p\", term = \"v\", {rest} }}");
    let and = |rest: &str| format!("{}, {{ parameter = \"q\", term = \"r\", nominal = 0.4 }}", p(rest));
    for (sway, texts) in [
        (and("tied_to = \"qq\""), vec!["`p`", "`qq`", "did you mean `q`?"]),
        (and("tied_to = \"c\""), vec!["`c`", "another degree of freedom"]),
        (and("tied_to = \"p\""), vec!["tied to itself"]),
        (
            format!("{}, {{ parameter = \"q\", term = \"r\", tied_to = \"p\" }}", p("tied_to = \"q\"")),
            vec!["in a circle"],
        ),
        (and("tied_to = \"q\", factor = 0.0"), vec!["`factor` 0"]),
        (and("nominal = 1.0, factor = 2.0"), vec!["`factor` alone"]),
        (and("tied_to = \"q\", nominal = 1.0"), vec!["nominal value of 1", "0.4"]),
        (and("tied_to = \"q\", fixed = true"), vec!["`fixed`", "one of them"]),
        (and("tied_to = \"q\", bounds = [0.0, 1.0]"), vec!["`bounds`", "one of them"]),
        (and("nominal = 1.0, bounds = [2.0, 0.0]"), vec!["[2, 0]", "swap"]),
        (and("nominal = 1.0, bounds = [2.0, 3.0]"), vec!["`nominal` 1", "[2, 3]"]),
        (and("nominal = 1.0, bounds = [nan, 3.0]"), vec!["NaN"]),
        (and("value = 1.0, fixed = true, bounds = [2.0, 3.0]"), vec!["its value 1", "[2, 3]"]),
        (and("fixed = true"), vec!["without a value"]),
        (and("value = 1.0, nominal = 2.0, fixed = true"), vec!["value 1", "nominal value 2"]),
        (and("value = 1.0"), vec!["no `nominal`"]),
        (p("nominal = 1.0, fixed = true"), vec!["[[sway]]", "every parameter fixed"]),
    ] {
        let refused = vessel(&sway).unwrap_err();
        assert!(
            !refused.contains('\n') && texts.iter().all(|text| refused.contains(text)),
            "{refused}: {texts:?}"
        );
    }
    let twice = "{ parameter = \"p\", term = \"1\", nominal = 0.0 }, { parameter = \"q\", term = \"1\", nominal = 0.0 }";
    assert!(vessel(twice).unwrap_err().contains("which `p` has already"));
    let tied = "{ parameter = \"p\", term = \"1\", tied_to = \"q\" }, { parameter = \"q\", term = \"r\", nominal = 0.0 }";
    assert!(vessel(tied).unwrap_err().contains("the term `1`"));
}
