//! Channels in the axes and about the point of the trajectories.

use std::f64::consts::FRAC_PI_2;

use logs::{
    Body, Channels, Conventions, Derived, Formula, Frame, Heading, Law, Method, Propulsor, Series, Thruster,
    Unassembled, prepare,
};

use crate::declared;

fn conventions() -> Conventions {
    declared::conventions(Method::Smoother, 1.0)
}

fn channels(pairs: &[(&str, &[f64])]) -> Channels {
    let series = |values: &[f64]| {
        let t: Vec<f64> = (0..values.len()).map(|i| i as f64).collect();
        Series::new(&t, values, 1.5)
    };
    pairs.iter().map(|(name, values)| ((*name).to_owned(), series(values))).collect()
}

#[test]
fn east_north_up_becomes_north_east_down() {
    let enu = Conventions {
        frame: Frame::Enu,
        heading: Heading::EastCounterclockwise,
        body: Body::Flu,
        ..conventions()
    };
    let measured =
        channels(&[("x", &[1.0]), ("y", &[2.0]), ("psi", &[0.0]), ("y_v", &[0.1]), ("y_u", &[3.0])]);
    let found = prepare(measured, &enu).unwrap();
    let value = |name: &str| found[name].values.first().unwrap();
    assert_eq!((value("x"), value("y"), value("psi")), (2.0, 1.0, FRAC_PI_2));
    assert_eq!((value("y_u"), value("y_v")), (3.0, -0.1));
}

#[test]
fn geographic_positions_are_north_and_east_in_any_frame() {
    let enu = Conventions { frame: Frame::Enu, ..conventions() };
    let measured = channels(&[("latitude_deg", &[1.0, 1.0 + 1e-5]), ("longitude_deg", &[0.3, 0.3])]);
    let found = prepare(measured, &enu).unwrap();
    let [x, y] = ["x", "y"].map(|name| found[name].values.last().unwrap());
    assert!((x - 63.5).abs() < 0.5 && y.abs() < 1e-6, "{found:?}");
    assert_eq!(found.len(), 2);
}

fn computed(name: &str, text: &str) -> Derived {
    Derived { channel: name.into(), formula: Formula::parse(text).unwrap(), unit: "1".into() }
}

#[test]
fn computed_channels_may_use_those_before_them() {
    let formulas = [("back", "negative(n)"), ("square", "back^2")];
    let derived = formulas.map(|(name, text)| computed(name, text)).into();
    let found = prepare(channels(&[("n", &[-3.0, 2.0])]), &Conventions { derived, ..conventions() }).unwrap();
    assert_eq!(found["square"].values.to_vec(), [9.0, 0.0]);
    let lacking = prepare(channels(&[]), &Conventions { derived: vec![computed("a", "b")], ..conventions() });
    assert_eq!(lacking, Err(Unassembled::NoChannel("b".to_owned())));
}

#[test]
fn thrusters_add_up() {
    let aft = |y: f64| Thruster { law: Law::Linear, coefficient: 1.0, position_m: [-0.4, y] };
    let of = |thruster, speed: &str, angle: Option<&str>| Propulsor {
        thruster,
        speed: speed.to_owned(),
        angle: angle.map(str::to_owned),
        table: None,
    };
    let named = |y: f64| of(aft(y), "n", Some("alpha"));
    let bow = Thruster { position_m: [0.4, 0.0], ..aft(0.0) };
    let thrusters = vec![named(-0.1), named(0.1), of(bow, "bow", None)];
    let measured = channels(&[("n", &[2.0]), ("alpha", &[FRAC_PI_2]), ("bow", &[1.0])]);
    let found = prepare(measured, &Conventions { thrusters, ..conventions() }).unwrap();
    approx::assert_abs_diff_eq!(found["tau1"].values.first().unwrap(), 0.0, epsilon = 1e-15);
    approx::assert_abs_diff_eq!(found["tau2"].values.first().unwrap(), 5.0, epsilon = 1e-15);
    approx::assert_abs_diff_eq!(found["tau3"].values.first().unwrap(), -0.4 * 4.0 + 0.4, epsilon = 1e-15);
}
