//! Pairs of thrusters in libraries of terms.

use estimation::search::{Roles, library, with_channels};
use ship::model::{ChannelRole, Model, Vessel, VesselFile};

/// A ship with two thrusters and a third one with the terms `further`.
fn ship(names: [&str; 2], unit: &str, further: &str) -> Model {
    let input = |name: &str, unit: &str| format!("[[input]]\nname = \"{name}\"\nunit = \"{unit}\"\n");
    let text = format!(
        "name = \"ship\"\nsample_rate_hz = 1.0\n{}{}{}[[surge]]\nparameter = \"a\"\nterm = \"u\"\nnominal = 0.0\n\
         [[sway]]\nparameter = \"b\"\nterm = \"v\"\nnominal = 0.0\n[[yaw]]\nparameter = \"c\"\nterm = \"r\"\nnominal = 0.0\n\
         {further}",
        input("bow", "N"),
        input(names[0], unit),
        input(names[1], unit),
    );
    Vessel::from_file(text.parse::<VesselFile>().unwrap()).unwrap().model
}

/// Thrusters on port and on starboard.
fn pairs(roles: &Roles) -> [&[usize]; 2] {
    [ChannelRole::Port, ChannelRole::Starboard].map(|side| roles.of(side))
}

fn formulas(model: &Model) -> Vec<&str> {
    model.derived.iter().map(|own| own.text.as_str()).collect()
}

#[test]
fn thrusters_that_differ_by_their_side_are_pairs_and_none_of_several_is_the_thrust() {
    let model = ship(["main_stbd", "main_port"], "N", "");
    let roles = Roles::new(&model).unwrap();
    assert_eq!((pairs(&roles), roles.of(ChannelRole::Thrust)), ([&[5][..], &[4]], &[3][..]));
    let (made, roles) = with_channels(&model, &roles).unwrap();
    assert_eq!(formulas(&made), ["main_port + main_stbd", "main_port - main_stbd"]);
    assert_eq!([roles.of(ChannelRole::Thrust), &roles.differences], [&[3, 6][..], &[7]]);
    let others = ship(["fore", "aft"], "kN", "");
    let roles = Roles::new(&others).unwrap();
    assert!(pairs(&roles) == [[0; 0]; 2] && roles.of(ChannelRole::Thrust) == [3, 4, 5], "{roles:?}");
}

#[test]
fn law_what_a_reflection_turns_stands_in_sway_and_yaw_alone() {
    let model = ship(["n_p", "n_s"], "1/s", "");
    let roles = Roles::new(&model).unwrap();
    let (made, roles) = with_channels(&model, &roles).unwrap();
    assert_eq!(roles.differences.len(), 1);
    // A reflection swaps the two: sums stay, the difference changes its sign.
    let values = |port: f64, starboard: f64| {
        let mut row = [vec![0.0, port, starboard], vec![0.0; made.derived.len()]].concat();
        made.derive(&mut row);
        row
    };
    let (one, other) = (values(3.0, -2.0), values(-2.0, 3.0));
    for own in &made.derived {
        let sign = if roles.differences.contains(&own.variable) { -1.0 } else { 1.0 };
        assert_eq!(one[own.variable - 3], sign * other[own.variable - 3], "{}", own.text);
    }
    let all = library(&made, &roles);
    let alone = |d: usize| {
        let terms = all.degrees[d].terms.iter();
        terms
            .filter(|term| term.factors.iter().map(|f| f.variable).eq(roles.differences.iter().copied()))
            .count()
    };
    assert_eq!([0, 1, 2].map(alone), [0, 1, 1]);
}

#[test]
fn pairs_are_found_where_the_model_ties_them_or_the_file_states_them() {
    let tied = "[[surge]]\nparameter = \"d\"\nterm = \"one\"\nnominal = 1.0\n\
         [[surge]]\nparameter = \"e\"\nterm = \"two\"\ntied_to = \"d\"\n\
         [[yaw]]\nparameter = \"f\"\nterm = \"one\"\nnominal = 1.0\n\
         [[yaw]]\nparameter = \"g\"\nterm = \"two\"\ntied_to = \"f\"\nfactor = -1.0\n";
    let model = ship(["one", "two"], "N", tied);
    assert_eq!(pairs(&Roles::new(&model).unwrap()), [[4], [5]]);
    let mut free = ship(["one", "two"], "N", "");
    free.roles = [(4, ChannelRole::Starboard), (5, ChannelRole::Port)].into();
    assert_eq!(pairs(&Roles::new(&free).unwrap()), [[5], [4]]);
}

#[test]
fn law_channels_are_what_the_file_says_and_what_is_guessed_may_be_stated() {
    let input =
        |role: ChannelRole| format!("[[input]]\nname = \"{role:?}\"\nunit = \"rad\"\nrole = \"{role}\"\n");
    let model = ship(["one", "two"], "N", &ChannelRole::ALL.map(input).concat());
    let roles = Roles::new(&model).unwrap();
    for (i, role) in (6..).zip(ChannelRole::ALL) {
        let guessed = if role == ChannelRole::Thrust { &[3, 4, 5][..] } else { &[] };
        assert_eq!(roles.of(role), [&[i], guessed].concat(), "{role}");
    }
    let mut model = ship(["n_p", "n_s"], "1/s", "");
    let guessed = Roles::new(&model);
    model.roles = [(3, ChannelRole::Thrust), (4, ChannelRole::Port), (5, ChannelRole::Starboard)].into();
    assert_eq!(Roles::new(&model), guessed);
}
