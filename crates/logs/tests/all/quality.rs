//! How good channels are.

use logs::{Channels, Samples, Series, consistency, lag, noise_std};

fn wave(t: f64) -> f64 {
    (0.3 * t).sin() + 0.4 * (0.71 * t).cos()
}

#[test]
fn law_a_delayed_wave_lags_by_its_delay() {
    for delay in [-0.83, 0.0, 0.04, 0.5, 2.0] {
        let times: Vec<f64> = (0..1200).map(|k| 0.1 * f64::from(k)).collect();
        let reference: Vec<f64> = times.iter().map(|t| wave(*t)).collect();
        let late: Vec<f64> = times.iter().map(|t| wave(t - delay)).collect();
        let found = lag(&late.into(), &reference.into(), 10.0, 5.0).unwrap();
        assert!((found - delay).abs() < 5e-3, "{found} instead of {delay}");
    }
}

#[test]
fn law_a_rate_in_degrees_has_the_gain_of_degrees() {
    let series = |f: &dyn Fn(f64) -> f64| {
        let t: Vec<f64> = (0..2000).map(|k| 0.1 * f64::from(k)).collect();
        Series::new(&t, &t.iter().map(|t| f(*t)).collect::<Vec<_>>(), 0.5)
    };
    let heading = series(&|t| 0.5 * (0.3 * t).sin());
    let rate = series(&|t| (0.15 * (0.3 * t).cos()).to_degrees());
    let channels = Channels::from([("psi".to_owned(), heading), ("y_r".to_owned(), rate)]);
    let [u, v, r] = consistency(&channels, 1.0);
    assert_eq!((u, v), (None, None));
    let gain = r.unwrap().gain.unwrap();
    assert!((gain / 1f64.to_degrees() - 1.0).abs() < 0.01, "{gain}");
    let still = Channels::from([
        ("psi".to_owned(), series(&|_| 1.0)),
        ("y_r".to_owned(), series(&|t| 1e-3 * (7.0 * t).sin())),
    ]);
    assert_eq!(consistency(&still, 1.0)[2].unwrap().gain, None);
}

#[test]
fn without_motion_there_is_no_lag() {
    let still = Samples::from(vec![1.0; 100]);
    assert_eq!(lag(&still, &still, 10.0, 5.0), None);
    assert_eq!(lag(&Samples::default(), &Samples::default(), 10.0, 5.0), None);
    let line = still.made((0..100).map(f64::from));
    let falling = still.made(line.iter().map(|x| -x));
    assert_eq!(lag(&line, &falling, 10.0, 5.0), None);
}

#[test]
fn law_a_smooth_channel_has_no_noise() {
    let t: Vec<f64> = (0..500).map(|k| 0.1 * f64::from(k)).collect();
    let smooth: Vec<f64> = t.iter().map(|t| 2.0 + t * t).collect();
    assert!(noise_std(&Series::new(&t, &smooth, 0.2)).unwrap() < 1e-9);
    assert_eq!(noise_std(&Series::new(&t[..10], &smooth[..10], 0.2)), None);
}
