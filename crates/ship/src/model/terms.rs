//! Terms that are added to a model.

use refusal::Invalid;

use crate::model::{Degree, Factor, Model, Term};

/// `base` with the terms of `lists` for surge, sway and yaw after its own terms, each as text, such as `u |u|`; those that it has
/// already and the constant are left out.
///
/// # Errors
/// A term that cannot be read.
pub fn listed(base: &Model, lists: [&[String]; 3]) -> Result<Model, Invalid> {
    let names: Vec<&str> = base.variables.iter().map(|v| v.name.as_str()).collect();
    let mut model = base.clone();
    for (d, list) in lists.into_iter().enumerate() {
        // The constant is there already.
        for text in list.iter().filter(|text| text.trim() != "1") {
            add(&mut model.degrees[d], d, base, Term::parse(text, &names)?.factors);
        }
    }
    Ok(model)
}

/// Adds the term of `factors`, places among the variables of `base`, to `degree` unless there is one like it. `degree` is that of
/// number `d`, 0 to 2 for surge, sway and yaw; the parameter is named after it and the channels, and as none of `base` is.
pub fn add(degree: &mut Degree, d: usize, base: &Model, factors: Vec<Factor>) {
    let names: Vec<&str> = base.variables.iter().map(|v| v.name.as_str()).collect();
    let form = form(&factors);
    let known = degree.known.iter().map(|known| known.factors.as_slice());
    if form.is_empty()
        || degree.terms.iter().flat_map(Term::products).chain(known).any(|own| self::form(own) == form)
    {
        return;
    }
    let letter = ["X", "Y", "N"][d];
    let mut name = format!(
        "{letter}_{}",
        text(&factors, "_", |factor, power| {
            let (abs, name) = (if factor.modulus { "abs_" } else { "" }, names[factor.variable]);
            if power > 1 { format!("{abs}{name}_{power}") } else { format!("{abs}{name}") }
        })
    );
    while base.parameter_names().any(|taken| taken == name) {
        name.push_str("_more");
    }
    let text = text(&factors, " ", |factor, power| {
        let name = names[factor.variable];
        let name = if factor.modulus { format!("|{name}|") } else { name.to_owned() };
        if power > 1 { format!("{name}^{power}") } else { name }
    });
    degree.parameters.push(name);
    degree.terms.push(Term::of(text, factors));
}

fn text(factors: &[Factor], between: &str, one: impl Fn(&Factor, usize) -> String) -> String {
    let runs = factors.chunk_by(|a, b| a == b);
    runs.map(|run| one(&run[0], run.len())).collect::<Vec<_>>().join(between)
}

/// By variable its power and whether its sign counts: `|v| v^2` and `|v|^3` are the same.
fn form(factors: &[Factor]) -> Vec<(usize, usize, bool)> {
    let mut variables: Vec<usize> = factors.iter().map(|f| f.variable).collect();
    variables.sort_unstable();
    variables.dedup();
    let of = |variable: usize| {
        let own = || factors.iter().filter(move |f| f.variable == variable);
        (variable, own().count(), own().filter(|f| !f.modulus).count() % 2 == 1)
    };
    variables.into_iter().map(of).collect()
}
