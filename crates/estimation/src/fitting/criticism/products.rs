//! Products of motion and inputs that an equation may lack.

use refusal::Invalid;
use ship::forces::{Channel, Factor, Forces, MOTION, TermSpec};

use crate::fitting::Unfit;

/// A factor: its place among the motion and the channels, and whether it is the modulus.
type Plain = (usize, bool);

/// A product that an equation may lack.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Product {
    /// 0 surge, 1 sway, 2 yaw.
    pub degree: usize,
    /// As a term is written.
    pub text: String,
    /// Whether the prime system scales its number: it has no channels but angles and pure numbers.
    pub scaled: bool,
}

/// Places of u, v, r, U and U_s among the motion.
const STATES: [usize; 3] = [0, 1, 2];
const SPEED: usize = 3;
const SIGNED_SPEED: usize = 4;

/// Products that `forces` lacks, of u, v, r, |u|, |v|, |r| and U in pairs, of u, v, r in threes, of the first `inputs`
/// channels with motion and with each other, and each of the other channels by itself.
pub(crate) fn products(forces: &Forces, channels: &[Channel], inputs: usize) -> Vec<Product> {
    let all = library(channels, inputs);
    let lacking = |degree: usize| {
        let own = terms(forces, degree);
        let absent = all.iter().filter(move |factors| !own.contains(factors));
        let product = |factors: &Vec<Plain>| Product {
            degree,
            text: text(factors, channels),
            scaled: factors.iter().all(|(variable, _)| is_scaled(*variable, channels)),
        };
        absent.map(product).collect::<Vec<_>>()
    };
    (0..3).flat_map(lacking).collect()
}

/// Whether the prime system scales a number that multiplies this variable.
fn is_scaled(variable: usize, channels: &[Channel]) -> bool {
    let channel = variable.checked_sub(MOTION.len()).map(|variable| channels[variable].unit.as_str());
    channel.is_none_or(|unit| ["rad", "1", ""].contains(&unit))
}

/// The products of `lists` for surge, sway and yaw that `forces` lacks, each once.
///
/// # Errors
/// A text that is no term of these channels.
pub(crate) fn listed(
    forces: &Forces,
    channels: &[Channel],
    lists: &[Vec<String>; 3],
) -> Result<Vec<Product>, Unfit> {
    let mut all = Vec::new();
    for (degree, list) in lists.iter().enumerate() {
        let count = own_terms(forces, degree);
        let mut known: Vec<Vec<Factor>> =
            (0..count).map(|i| in_order(forces.factors(degree, i).to_vec())).collect();
        for text in list {
            let factors = parsed(forces, channels, (degree, text)).map_err(|e| Unfit::Listed(Box::new(e)))?;
            if known.contains(&factors) {
                continue;
            }
            let scaled = factors.iter().all(|factor| is_scaled(factor.variable, channels));
            all.push(Product { degree, text: text.trim().to_owned(), scaled });
            known.push(factors);
        }
    }
    Ok(all)
}

/// The factors of a term in this equation, in order.
fn parsed(
    forces: &Forces,
    channels: &[Channel],
    (degree, text): (usize, &str),
) -> Result<Vec<Factor>, Invalid> {
    let mut description = forces.description().clone();
    let name = ["surge", "sway", "yaw"][degree];
    let parameter = "candidate to be tried".to_owned();
    let spec = TermSpec { parameter, term: text.to_owned(), nominal: Some(0.0), ..TermSpec::default() };
    description.terms_mut()[degree].push(spec);
    let with = Forces::new(&description, channels)
        .map_err(|e| Invalid { thing: format!("`{name}`: term `{text}`"), ..e })?;
    Ok(in_order(with.factors(degree, own_terms(forces, degree)).to_vec()))
}

/// Number of terms of an equation.
fn own_terms(forces: &Forces, degree: usize) -> usize {
    forces.description().terms()[degree].len()
}

fn in_order(mut factors: Vec<Factor>) -> Vec<Factor> {
    factors.sort_unstable_by_key(|own| (own.variable, own.modulus, own.divides));
    factors
}

/// The factors of the terms of an equation, in order; those with a division count as none.
fn terms(forces: &Forces, degree: usize) -> Vec<Vec<Plain>> {
    let count = own_terms(forces, degree);
    let plain = |factors: &[Factor]| {
        let whole = factors.iter().all(|factor| !factor.divides);
        whole.then(|| sorted(factors.iter().map(|factor| (factor.variable, factor.modulus)).collect()))
    };
    (0..count).filter_map(|i| plain(forces.factors(degree, i))).collect()
}

/// Factors in order; two moduli of the same are its square.
fn sorted(mut factors: Vec<Plain>) -> Vec<Plain> {
    factors.sort_unstable();
    for i in 1..factors.len() {
        if factors[i - 1] == factors[i] && factors[i].1 {
            (factors[i - 1].1, factors[i].1) = (false, false);
        }
    }
    factors
}

fn library(channels: &[Channel], inputs: usize) -> Vec<Vec<Plain>> {
    let plain = STATES.map(|own| (own, false));
    let motion: Vec<Plain> =
        plain.into_iter().chain(STATES.map(|own| (own, true))).chain([(SPEED, false)]).collect();
    let mut all: Vec<Vec<Plain>> = vec![Vec::new()];
    all.extend(motion.iter().map(|own| vec![*own]));
    all.extend(pairs(&motion));
    all.extend([1, 2].map(|own| vec![(own, false), (SIGNED_SPEED, false)]));
    let squares: Vec<Vec<Plain>> = pairs(&plain);
    let cubes = squares.iter().flat_map(|square| plain.map(|plain| [square.as_slice(), &[plain]].concat()));
    all.extend(cubes);
    // A term can have no other names.
    let named =
        |own: &usize| channels[own - MOTION.len()].name.chars().all(|c| c.is_alphanumeric() || c == '_');
    let places = (MOTION.len()..MOTION.len() + inputs.min(channels.len())).filter(named);
    let signed =
        |own: &usize| channels[own - MOTION.len()].range.is_none_or(|[low, high]| low < 0.0 && high > 0.0);
    let driven: Vec<Plain> =
        places.flat_map(|own| [Some((own, false)), signed(&own).then_some((own, true))]).flatten().collect();
    for own in &driven {
        all.push(vec![*own]);
        let beside = plain.into_iter().chain([(SPEED, false)]);
        all.extend(beside.map(|other| vec![other, *own]));
        if !own.1 {
            all.extend(squares.iter().map(|square| [square.as_slice(), &[*own]].concat()));
            all.extend(plain.map(|other| vec![other, *own, *own]));
        }
    }
    all.extend(pairs(&driven));
    let others = (MOTION.len() + inputs..MOTION.len() + channels.len()).filter(named);
    all.extend(others.map(|own| vec![(own, false)]));
    let mut unique: Vec<Vec<Plain>> = Vec::new();
    for own in all.into_iter().map(sorted) {
        if !unique.contains(&own) {
            unique.push(own);
        }
    }
    unique
}

/// Products of two, each pair once and squares.
fn pairs(of: &[Plain]) -> Vec<Vec<Plain>> {
    let with = |i: usize| of[i..].iter().map(move |other| vec![of[i], *other]);
    (0..of.len()).flat_map(with).collect()
}

/// As a term is written: `v^2 |r|`, 1 without a factor.
fn text(factors: &[Plain], channels: &[Channel]) -> String {
    if factors.is_empty() {
        return "1".to_owned();
    }
    let mut parts: Vec<(Plain, usize)> = Vec::new();
    for factor in factors {
        match parts.iter_mut().find(|(known, _)| known == factor) {
            Some((_, power)) => *power += 1,
            None => parts.push((*factor, 1)),
        }
    }
    let part = |((variable, modulus), power): ((usize, bool), usize)| {
        let channel = |own: usize| channels[own - MOTION.len()].name.clone();
        let name = MOTION.get(variable).map_or_else(|| channel(variable), |own| (*own).to_owned());
        let name = if modulus { format!("|{name}|") } else { name };
        if power > 1 { format!("{name}^{power}") } else { name }
    };
    parts.into_iter().map(part).collect::<Vec<_>>().join(" ")
}
