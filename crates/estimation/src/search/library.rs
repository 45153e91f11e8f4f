use refusal::Invalid;
use ship::model::terms::add;
use ship::model::{DegreeOfFreedom, Factor, Model, Term};

use crate::search::made::Made;
use crate::search::pairs::with_pairs;
use crate::search::roles::Roles;
use crate::search::wind::with_wind;

/// Terms of surge: even under reflection between port and starboard.
const SURGE: &str = "u; u |u|; u^3; v r; v^2; r^2; |v|; |r|; u |v|; u |r|; u v^2; u r^2; u v r; |u| v r; |v| |r|; |v|^3; \
    |r|^3; n |n|; nr |nr|; na; nr; na u; nr u; na |u|; na u^2; na^2; na^2 u; na |v|; na |r|; na v r; na^2 de^2; \
    na^2 |de|; na^2 de^4; u |u| de^2; u |u| |de|; na u de^2; u v de; u r de; na v de; na r de; nr^2 |de|; nr^2 de^2; \
    v de; r de; nr |v|; nr |r|; de^2; u de^2; v df; r df; de df; even";
/// Terms of sway and yaw: odd, and those for the side force of a single propeller.
const SIDEWAYS: &str = "v; r; u v; u r; |u| v; |u| r; v |v|; r |r|; v |r|; |v| r; v^3; r^3; v^2 r; v r^2; u^2 v; u^2 r; \
    u v |v|; u r |r|; u v |r|; u |v| r; na v; na r; nr v; nr r; na^2 v; na^2 r; nr^2 v; nr^2 r; na u v; na u r; na; na^2; \
    na u; nr; nr |nr|; nr u; nr u^2; u |u| de; na^2 de; na u de; u de; na de; de; nr^2 de; nr de; nr u de; na^2 de |de|; \
    na^2 de^3; u |u| de^3; u |u| de |de|; na u de^3; na |v| de; na |r| de; na^2 |de| v; na^2 |de| r; u |de| v; u |de| r; \
    v de^2; r de^2; na v de^2; na r de^2; na^2 |de|; na^2 de^2; de |de|; de^3; df; u df; df |df|; odd; even";

/// The symbols in the lists above for channels by role.
const SYMBOLS: [&str; 10] = ["u", "v", "r", "n", "na", "nr", "de", "even", "odd", "df"];
const PROPELLER: usize = 3;
const AHEAD: usize = 4;
const ASTERN: usize = 5;
const RUDDER: usize = 6;
const EVEN: usize = 7;
const ODD: usize = 8;
const DIFFERENCE: usize = 9;

/// Adds to `model` the channels that the library derives from pairs of thrusters and from the wind, and their roles
/// to `roles`.
///
/// # Errors
/// A channel that cannot be computed.
pub fn with_channels(model: &Model, roles: &Roles) -> Result<(Model, Roles), Invalid> {
    let mut made = Made::new(model);
    let roles = with_pairs(&mut made, roles.clone());
    let roles = with_wind(&mut made, roles);
    Ok((made.finish()?, roles))
}

/// `base` with every term of the library that its channels allow, after its own terms.
///
/// The library holds products of velocities, rudder and propeller to third order by their parity under reflection. If
/// thrust is logged instead of the propeller's speed, it stands for the square of the speed.
pub fn library(base: &Model, roles: &Roles) -> Model {
    let mut model = base.clone();
    for (d, degree) in model.degrees.iter_mut().enumerate() {
        let list = if d == DegreeOfFreedom::Surge as usize { SURGE } else { SIDEWAYS };
        for text in list.split(';') {
            let Ok(symbolic) = Term::parse(text, &SYMBOLS) else { continue };
            for factors in meant(&symbolic.factors, roles) {
                add(degree, d, base, factors);
            }
        }
    }
    model
}

/// The factors of a term of symbols in the vessel's channels; several if several channels have one role, none if no
/// channel has it.
fn meant(symbolic: &[Factor], roles: &Roles) -> Vec<Vec<Factor>> {
    let ahead = symbolic.iter().filter(|f| f.variable == AHEAD).count();
    let mut all = vec![Vec::new()];
    let mut rest: Vec<Factor> = symbolic.to_vec();
    if ahead > 0 && roles.ahead.is_empty() && !roles.thrusts.is_empty() {
        // Thrust is proportional to the square of the propeller's speed: other powers have no meaning.
        if ahead != 2 {
            return Vec::new();
        }
        let thrust = |variable: &usize| vec![Factor { variable: *variable, modulus: false }];
        all = roles.thrusts.iter().map(thrust).collect();
        rest.retain(|factor| factor.variable != AHEAD);
    }
    let before = all[0].len();
    for factor in &rest {
        let channels = roles.playing(factor.variable);
        let with = |own: &Vec<Factor>, variable: usize| {
            // All factors of one symbol are one channel.
            let other =
                |(by, own): (&Factor, &Factor)| by.variable == factor.variable && own.variable != variable;
            let more = Factor { variable, modulus: factor.modulus };
            let same = !rest.iter().zip(&own[before..]).any(other);
            same.then(|| own.iter().copied().chain([more]).collect::<Vec<_>>())
        };
        all = all.iter().flat_map(|own| channels.iter().filter_map(|v| with(own, *v))).collect();
    }
    all
}

impl Roles {
    /// The channels that a symbol stands for.
    fn playing(&self, symbol: usize) -> Vec<usize> {
        match symbol {
            PROPELLER => self.propellers.clone(),
            AHEAD => self.ahead.clone(),
            ASTERN => self.astern.clone(),
            RUDDER => self.rudders.clone(),
            EVEN => self.even.clone(),
            ODD => self.odd.clone(),
            DIFFERENCE => self.differences.clone(),
            state => vec![state],
        }
    }
}
