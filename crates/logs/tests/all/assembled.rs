//! Channels on one clock.

use logs::{
    Assembled, Channels, Conventions, Lever, Method, Samples, Section, Series, Unassembled, assemble,
};

use crate::declared;

fn conventions(method: Method) -> Conventions {
    declared::conventions(method, 10.0)
}

fn with_n(channels: Channels, conventions: &Conventions) -> Result<Assembled, Unassembled> {
    assemble(channels, conventions, &["n"], &[])
}

/// A steady turn with surge 2, sway −0.3 and yaw rate 0.05, at 10 Hz.
fn turn() -> Channels {
    let (u, v, r) = (2.0, -0.3, 0.05);
    let t: Vec<f64> = (0..600).map(|k| 0.1 * f64::from(k)).collect();
    let series = |f: &dyn Fn(f64) -> f64| Series::new(&t, &t.iter().map(|t| f(*t)).collect::<Vec<_>>(), 0.5);
    let psi = |t: f64| r * t;
    let channels: [(&str, &dyn Fn(f64) -> f64); 4] = [
        ("x", &|t| (u * psi(t).sin() + v * psi(t).cos()) / r),
        ("y", &|t| (-u * psi(t).cos() + v * psi(t).sin()) / r),
        ("psi", &psi),
        ("n", &|_| 5.0),
    ];
    channels.into_iter().map(|(name, f)| (name.to_owned(), series(f))).collect()
}

#[test]
fn law_a_steady_turn_gives_the_same_velocities_by_both_methods() {
    // Euler's chord lies half a step of turning ahead of the tangent: v is off by u r dt/2, u by −v r dt/2.
    let (r_dt, [u, v]) = (0.05 * 0.1, [2.0, -0.3]);
    let euler = with_n(turn(), &conventions(Method::Euler)).unwrap();
    let smooth = with_n(turn(), &conventions(Method::Smoother)).unwrap();
    let [by_euler, by_smoother] = [&euler, &smooth].map(|made| made.measured.each_ref().map(Samples::to_vec));
    for k in 0..599 {
        approx::assert_abs_diff_eq!(by_euler[0][k], u - v * r_dt / 2.0, epsilon = 1e-4);
        approx::assert_abs_diff_eq!(by_euler[1][k], v + u * r_dt / 2.0, epsilon = 1e-4);
        approx::assert_abs_diff_eq!(by_smoother[0][k], u, epsilon = 1e-3);
        approx::assert_abs_diff_eq!(by_smoother[1][k], v, epsilon = 1e-3);
        for made in [&by_euler, &by_smoother] {
            approx::assert_abs_diff_eq!(made[2][k], 0.05, epsilon = 1e-9);
        }
    }
    assert_eq!((euler.grid.rows, smooth.grid.rows), (599, 600));
    assert_eq!(euler.sections, [Section { start: 0, samples: 598 }]);
    assert_eq!(smooth.sections, [Section { start: 0, samples: 599 }]);
}

#[test]
fn law_the_velocities_are_those_of_the_reference_point() {
    let moved = Conventions { lever: Lever([4.0, 1.0]), ..conventions(Method::Smoother) };
    let moved = with_n(turn(), &moved).unwrap().measured.map(|channel| channel.to_vec());
    approx::assert_abs_diff_eq!(moved[0][300], 2.0 + 0.05 * 1.0, epsilon = 1e-3);
    approx::assert_abs_diff_eq!(moved[1][300], -0.3 - 0.05 * 4.0, epsilon = 1e-3);
}

#[test]
fn a_measured_velocity_goes_before_one_made_from_positions() {
    let mut channels = turn();
    let gyro = channels["psi"].clone().map(|_| 0.06);
    channels.insert("y_r".into(), gyro);
    let made =
        with_n(channels, &conventions(Method::Euler)).unwrap().measured.map(|channel| channel.to_vec());
    assert_eq!(made[2][10], 0.06);
    assert!((made[0][10] - 2.0).abs() < 0.01);
}

#[test]
fn channels_that_never_overlap_are_refused() {
    let mut channels = turn();
    let late = channels["n"].t.iter().map(|t| t + 1000.0).collect::<Vec<f64>>();
    channels.insert("n".into(), Series::new(&late, &vec![1.0; late.len()], 0.5));
    assert_eq!(with_n(channels, &conventions(Method::Euler)), Err(Unassembled::NoOverlap));
    let mut channels = turn();
    channels.insert("n".into(), Series::new(&[], &[], 0.5));
    assert_eq!(with_n(channels, &conventions(Method::Euler)), Err(Unassembled::Empty("n".into())));
    let mut channels = turn();
    channels.remove("psi");
    assert_eq!(with_n(channels, &conventions(Method::Euler)), Err(Unassembled::NoChannel("psi".into())));
}
