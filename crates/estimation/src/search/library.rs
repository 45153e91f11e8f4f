use refusal::Invalid;
use ship::model::terms::{add, listed};
use ship::model::{ChannelRole, Degree, DegreeOfFreedom, DerivedSpec, Factor, Formula, Model, Term};

use super::roles::Roles;

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
const AHEAD: usize = 4;

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

/// The factors of a term of symbols in channels: several where channels share a role, none where it is free.
fn meant(symbolic: &[Factor], roles: &Roles) -> Vec<Vec<Factor>> {
    let ahead = symbolic.iter().filter(|f| f.variable == AHEAD).count();
    let mut all = vec![Vec::new()];
    let mut rest: Vec<Factor> = symbolic.to_vec();
    let thrusts = roles.of(ChannelRole::Thrust);
    if ahead > 0 && roles.of(ChannelRole::Ahead).is_empty() && !thrusts.is_empty() {
        // Thrust is proportional to the square of the propeller's speed: other powers have no meaning.
        if ahead != 2 {
            return Vec::new();
        }
        let thrust = |variable: &usize| vec![Factor { variable: *variable, modulus: false }];
        all = thrusts.iter().map(thrust).collect();
        rest.retain(|factor| factor.variable != AHEAD);
    }
    let before = all[0].len();
    for factor in &rest {
        let channels = roles.playing(factor.variable);
        let with = |taken: &Vec<Factor>, variable: usize| {
            // All factors of one symbol are one channel.
            let other = |(by, taken): (&Factor, &Factor)| {
                by.variable == factor.variable && taken.variable != variable
            };
            let more = Factor { variable, modulus: factor.modulus };
            let same = !rest.iter().zip(&taken[before..]).any(other);
            same.then(|| taken.iter().copied().chain([more]).collect::<Vec<_>>())
        };
        all = all.iter().flat_map(|factors| channels.iter().filter_map(|v| with(factors, *v))).collect();
    }
    all
}

impl Roles {
    fn playing(&self, symbol: usize) -> Vec<usize> {
        use ChannelRole::{Ahead, Astern, Even, Odd, Propeller, Rudder};
        let roles = [Propeller, Ahead, Astern, Rudder, Even, Odd];
        match symbol.checked_sub(3).map(|i| roles.get(i)) {
            None => vec![symbol],
            Some(Some(role)) => self.of(*role).to_vec(),
            Some(None) => self.differences.clone(),
        }
    }
}

struct Made<'a> {
    pub model: &'a Model,
    specs: Vec<DerivedSpec>,
}

impl<'a> Made<'a> {
    /// No derived channels yet.
    pub fn new(model: &'a Model) -> Self {
        Self { model, specs: Vec::new() }
    }

    /// The model with the derived channels.
    ///
    /// # Errors
    /// A channel that cannot be computed.
    pub fn finish(self) -> Result<Model, Invalid> {
        self.model.with_derived(&self.specs)
    }

    /// The index of the channel that is computed by `formula`: the model's own, or a new one with this name.
    pub fn channel(&mut self, mut name: String, unit: String, formula: String) -> usize {
        let parsed = Formula::parse(&formula).ok();
        if let Some(known) = self.model.derived.iter().find(|known| Some(&known.formula) == parsed.as_ref()) {
            return known.variable;
        }
        while self.model.variables.iter().any(|taken| taken.name == name) {
            name.push_str("_more");
        }
        self.specs.push(DerivedSpec { name, unit, formula, role: None });
        self.model.variables.len() + self.specs.len() - 1
    }

    /// Whether the model computes `formula` up to a factor.
    pub fn computes(&self, formula: &str) -> bool {
        let parsed = Formula::parse(formula);
        parsed
            .is_ok_and(|wanted| self.model.derived.iter().any(|known| known.formula.is_multiple_of(&wanted)))
    }
}

/// Adds the roles of the sums and differences of pairs of thrusters: of thrusts their sum and difference; of
/// propeller speeds n the sum, and the sum and difference of n |n|, to which thrusts are proportional.
fn with_pairs(made: &mut Made, mut roles: Roles) -> Roles {
    let sides = [ChannelRole::Port, ChannelRole::Starboard].map(|side| roles.of(side).to_vec());
    for (&port, &starboard) in sides[0].iter().zip(&sides[1]) {
        let [p, s] = [port, starboard].map(|variable| made.model.variables[variable].name.as_str());
        let unit = made.model.variables[port].unit.as_str();
        let named = |what: &str| format!("{p}_{what}_{s}");
        let sum = made.channel(named("plus"), unit.to_owned(), format!("{p} + {s}"));
        if unit.ends_with('N') {
            let difference = made.channel(named("minus"), unit.to_owned(), format!("{p} - {s}"));
            roles.add(ChannelRole::Thrust, sum);
            roles.differences.push(difference);
        } else {
            let square = format!("({unit})^2");
            let [together, against] = [("pushes_with", "+"), ("pushes_against", "-")].map(|(what, sign)| {
                made.channel(named(what), square.clone(), format!("{p} |{p}| {sign} {s} |{s}|"))
            });
            roles.add(ChannelRole::Propeller, sum);
            roles.add(ChannelRole::Even, together);
            roles.differences.push(against);
        }
    }
    roles.take_speeds_ahead();
    roles
}

/// Channels that the library derives from the relative wind's speed W and the angle γ that it comes from: name, the
/// powers of cos γ and sin γ that multiply the square of W, and whether a reflection between port and starboard
/// leaves it unchanged. They span all harmonics of γ up to the third: cos 2γ is 2 cos² γ − 1, and so on.
const PRODUCTS: [(&str, i32, i32, bool); 7] = [
    ("square", 0, 0, true),
    ("cos", 1, 0, true),
    ("sin", 0, 1, false),
    ("cos_2", 2, 0, true),
    ("cos_sin", 1, 1, false),
    ("cos_3", 3, 0, true),
    ("sin_3", 0, 3, false),
];

/// Adds the roles of channels derived from the wind, if there is one; those of the model are not derived again.
fn with_wind(made: &mut Made, mut roles: Roles) -> Roles {
    let channel = |role| Some(&made.model.variables[*roles.of(role).first()?]);
    let [Some(wind), Some(from)] = [ChannelRole::Wind, ChannelRole::WindFrom].map(channel) else {
        return roles;
    };
    for (called, cosines, sines, even) in PRODUCTS {
        let factor = |function: &str, power: i32| match power {
            0 => String::new(),
            1 => format!(" {function}({})", from.name),
            _ => format!(" {function}({})^{power}", from.name),
        };
        let formula = format!("{}^2{}{}", wind.name, factor("cos", cosines), factor("sin", sines));
        if made.computes(&formula) {
            continue;
        }
        let (name, unit) = (format!("{}_{called}", wind.name), format!("({})^2", wind.unit));
        roles.add(if even { ChannelRole::Even } else { ChannelRole::Odd }, made.channel(name, unit, formula));
    }
    roles
}

/// `model` with a core of terms in place of its own, or of its forces: resistance and drive in surge, `v` and `u r` in sway, `r` and
/// what steers in yaw; with the channels and roles of [`with_channels`]. Propellers of the numbers `reversing` act apart ahead and
/// astern. A model with terms whose channels do not say what steers keeps them.
///
/// # Errors
/// A channel that cannot be computed.
pub fn core(model: &Model, roles: &Roles, reversing: &[usize]) -> Result<(Model, Roles), Invalid> {
    let (model, roles) = with_astern(model, roles.clone(), reversing)?;
    let (model, roles) = with_channels(&model, &roles)?;
    let rudders = roles.of(ChannelRole::Rudder);
    if model.has_regressors() && rudders.is_empty() && roles.differences.is_empty() {
        return Ok((model, roles));
    }
    let name = |variable: &usize| model.variables[*variable].name.as_str();
    let with = |first: &[&str], more: Vec<String>| {
        first.iter().map(|&term| term.to_owned()).chain(more).collect::<Vec<_>>()
    };
    let speeds = roles.of(ChannelRole::Propeller).iter().map(|n| format!("{0} |{0}|", name(n)));
    // Inputs of which nothing is known may drive.
    let inputs = 3..3 + model.inputs;
    let unknown = roles.of(ChannelRole::Even).iter().filter(|channel| inputs.contains(channel));
    let thrusts = roles.of(ChannelRole::Thrust).iter().chain(unknown);
    let thrusts = thrusts.map(|channel| name(channel).to_owned());
    let rudders = rudders.iter().map(|rudder| format!("u^2 {}", name(rudder)));
    let differences = roles.differences.iter().map(|difference| name(difference).to_owned());
    let surge = with(&["u", "u |u|"], speeds.chain(thrusts).collect());
    let (sway, yaw) = (with(&["v", "u r"], Vec::new()), with(&["r"], rudders.chain(differences).collect()));
    let degrees = [0, 1, 2].map(|_| Degree::default());
    let bare = Model { degrees, constant: [0.0; 3], forces: None, ..model.clone() };
    Ok((listed(&bare, [&surge, &sway, &yaw])?, roles))
}

/// The channels of propellers ahead and astern that are derived of those `reversing`, where none has these roles.
fn with_astern(model: &Model, mut roles: Roles, reversing: &[usize]) -> Result<(Model, Roles), Invalid> {
    let [speeds, ahead, astern] =
        [ChannelRole::Propeller, ChannelRole::Ahead, ChannelRole::Astern].map(|role| roles.of(role));
    let single: Vec<usize> = speeds.iter().copied().filter(|p| reversing.contains(p)).collect();
    let apart = ahead.iter().any(|c| !speeds.contains(c)) || !astern.is_empty();
    if single.is_empty() || apart {
        return Ok((model.clone(), roles));
    }
    let mut made = Made::new(model);
    roles.channels[ChannelRole::Ahead as usize].retain(|channel| !single.contains(channel));
    for propeller in single {
        let (name, unit) = (&model.variables[propeller].name, &model.variables[propeller].unit);
        let mut of = |what: &str, part: &str| {
            made.channel(format!("{name}_{what}"), unit.clone(), format!("{part}({name})"))
        };
        roles.add(ChannelRole::Ahead, of("ahead", "positive"));
        roles.add(ChannelRole::Astern, of("reverse", "negative"));
    }
    Ok((made.finish()?, roles))
}
