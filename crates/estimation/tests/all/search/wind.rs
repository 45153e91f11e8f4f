//! A measured wind in libraries of terms.

use estimation::search::{Roles, with_channels};
use ship::model::{ChannelRole, Model, Vessel, VesselFile};

/// A ship with one rudder in a measured wind, with further tables.
fn ship(further: &str) -> Model {
    let text = format!(
        "name = \"ship\"\nsample_rate_hz = 1.0\n[[input]]\nname = \"delta\"\nunit = \"rad\"\n\
         [[measured]]\nname = \"wind\"\nunit = \"m/s\"\n[[measured]]\nname = \"wind_from\"\nunit = \"rad\"\n{further}\
         [[surge]]\nparameter = \"a\"\nterm = \"u\"\nnominal = 0.0\n[[sway]]\nparameter = \"b\"\nterm = \"v\"\n\
         nominal = 0.0\n[[yaw]]\nparameter = \"c\"\nterm = \"r\"\nnominal = 0.0\n"
    );
    Vessel::from_file(text.parse::<VesselFile>().unwrap()).unwrap().model
}

fn library_of(model: &Model) -> (Model, Roles) {
    let roles = Roles::new(model).unwrap();
    assert_eq!(roles.of(ChannelRole::Rudder), [3], "an angle of the wind steers nothing");
    with_channels(model, &roles).unwrap()
}

fn values(model: &Model, [speed, from]: [f64; 2]) -> impl Fn(&str) -> f64 {
    let mut row = vec![0.0; model.exogenous()];
    (row[1], row[2]) = (speed, from);
    model.derive(&mut row);
    let names: Vec<String> = model.variables[3..].iter().map(|own| own.name.clone()).collect();
    move |name| row[names.iter().position(|own| own == name).unwrap()]
}

#[test]
fn law_the_products_of_the_wind_are_its_harmonics_and_odd_where_a_reflection_turns_them() {
    let model = ship("");
    let (model, roles) = library_of(&model);
    assert_eq!(model.derived.len(), 7);
    for (speed, from) in [(3.0, 0.4), (1.5, -2.2), (7.0, 3.0), (0.0, 1.0)] {
        let of = values(&model, [speed, from]);
        let harmonic = |k: f64| [(k * from).cos(), (k * from).sin()].map(|x| speed * speed * x);
        let close = |found: f64, [expected]: [f64; 1]| {
            assert!((found - expected).abs() < 1e-12 * (1.0 + speed * speed), "{found} {expected}");
        };
        close(of("wind_square"), [speed * speed]);
        let [second, third] = [harmonic(2.0), harmonic(3.0)];
        close(2.0 * of("wind_cos_2") - of("wind_square"), [second[0]]);
        close(2.0 * of("wind_cos_sin"), [second[1]]);
        close(4.0 * of("wind_cos_3") - 3.0 * of("wind_cos"), [third[0]]);
        close(3.0 * of("wind_sin") - 4.0 * of("wind_sin_3"), [third[1]]);
        let other = values(&model, [speed, -from]);
        for (side, sign) in [(ChannelRole::Even, 1.0), (ChannelRole::Odd, -1.0)] {
            let names = roles.of(side).iter().map(|place| model.variables[*place].name.as_str());
            names.for_each(|name| close(other(name), [sign * of(name)]));
        }
    }
    assert_eq!([ChannelRole::Even, ChannelRole::Odd].map(|side| roles.of(side).len()), [4, 3]);
}

#[test]
fn what_the_vessel_makes_of_the_wind_is_not_made_again_and_half_a_wind_is_refused() {
    let own = "[[derived]]\nname = \"push_x\"\nunit = \"1\"\nformula = \"-1 cos(wind_from) wind^2\"\n";
    let (model, _) = library_of(&ship(own));
    let names: Vec<&str> = model.variables.iter().skip(6).map(|own| own.name.as_str()).collect();
    let beyond = ["wind_square", "wind_sin", "wind_cos_2", "wind_cos_sin", "wind_cos_3", "wind_sin_3"];
    assert_eq!(names, [&["push_x"], &beyond[..]].concat());
    let mut alone = ship("");
    alone.variables.truncate(5);
    alone.roles.insert(4, ChannelRole::Wind);
    let said = Roles::new(&alone).unwrap_err().to_string();
    assert!(said.contains("measured `wind`, `role`") && said.contains("`role = \"wind-from\"`"), "{said}");
}
