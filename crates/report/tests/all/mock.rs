//! A made-up study of the size and character of the paper's.

use std::collections::BTreeMap;
use study::files::Vessel;

use report::{ManeuverTrace, Study};
use study::documents::{
    Bounds, CriterionName, Degree, DegreeMoments, DegreeSummary, DesignDocument, DesignScores, DesignStatus,
    DesignSummary, Efficiency, EstimateDocument, Estimator, InstrumentKind, ManeuverMoments, MeanRemoval,
    Moments, MomentsDocument, ParameterSummary, Published, PublishedShare, Quantiles, Reference, ScoreStatus,
    ScoredEstimates,
};
use study::scores::Row;

/// Name, share, sensitivity, efficiency alone, speed from, speed to, yaw rate, whether it sweeps.
type Maneuver = (&'static str, f64, f64, f64, f64, f64, f64, bool);

const MANEUVERS: [Maneuver; 11] = [
    ("decelerate", 0.193, 13.0, 0.0, 1.0, 0.0, 0.0, false),
    ("accelerate", 0.0, 9.12, 0.0, 0.0, 1.0, 0.0, false),
    ("zig-zag-slow-flat", 0.0, 5.87, 0.021, 0.35, 0.35, 0.2, false),
    ("zig-zag-moderate-flat", 0.0, 11.4, 0.094, 0.8, 0.8, 0.2, false),
    ("zig-zag-fast-flat", 0.043, 13.0, 0.110, 1.15, 1.15, 0.2, false),
    ("zig-zag-slow-steep", 0.229, 13.0, 0.187, 0.35, 0.35, 0.35, false),
    ("zig-zag-moderate-steep", 0.101, 13.0, 0.243, 0.7, 0.7, 0.35, false),
    ("zig-zag-fast-steep", 0.085, 13.0, 0.262, 1.0, 1.0, 0.35, false),
    ("spiral-slow", 0.0, 6.02, 0.158, 0.4, 0.4, -0.6, true),
    ("spiral-moderate", 0.0, 9.93, 0.301, 0.75, 0.75, -0.6, true),
    ("spiral-fast", 0.349, 13.0, 0.377, 1.0, 1.0, -0.6, true),
];

/// Name, unit, truth, nominal, relative spread optimized and random.
type Parameter = (&'static str, &'static str, f64, f64, f64, f64);

const PARAMETERS: [Parameter; 10] = [
    ("X_u", "1", -0.06, -0.08, 0.11, 0.9),
    ("X_uu", "s/m", -0.01, 0.0, 0.72, 6.1),
    ("X_vr", "s/rad", 0.08, 0.0, 0.41, 2.9),
    ("X_tau", "m/(s N)", 1.4e-5, 1e-5, 0.03, 0.16),
    ("Y_v", "1", -0.1, -0.08, 0.15, 0.5),
    ("Y_ur", "1/rad", -0.006, 0.0, 1.9, 7.7),
    ("Y_tau", "m/(s N)", 1.4e-5, 1e-5, 0.09, 0.31),
    ("N_r", "1", -0.35, -0.4, 0.06, 0.13),
    ("N_uv", "rad s/m²", -0.03, 0.0, 1.1, 3.4),
    ("N_tau", "rad/(s N m)", 3e-4, 3.5e-4, 0.05, 0.11),
];

pub fn study() -> Study {
    let scores = [scores("optimized", 1.9, 0.42), scores("random", 3.9, 1.35), scores("practice", 2.9, 0.9)];
    Study {
        merit: None,
        update: None,
        name: "paper".to_owned(),
        experiment_s: Some(125.0),
        vessel: Some(Vessel::preset("ljungberg-model-ship").expect("a preset")),
        dictionary: Some(MANEUVERS.iter().map(trace).collect()),
        moments: Some(moments()),
        design: Some(design()),
        estimate: Some(estimate()),
        validation: Some(validation()),
        counted: None,
        scores: Some(scores.concat()),
        validation_trace: Some(validation_trace()),
        reference: Some(reference()),
        sequential: None,
        scenarios: Vec::new(),
        selection: None,
        mixed: Vec::new(),
        data: None,
        measured: None,
        trajectory: None,
        files: files(),
    }
}

/// First-order responses that look like a ship's.
fn trace(&(name, .., from, to, rate, sweeps): &Maneuver) -> ManeuverTrace {
    let t: Vec<f64> = (0..300).map(|k| f64::from(k) / 8.0).collect();
    let wanted =
        |t: f64| if sweeps { rate * t / 37.5 } else { rate * (0.2 * std::f64::consts::PI * t).sin() };
    let r: Vec<f64> = t.iter().map(|t| wanted((t - 0.4).max(0.0))).collect();
    let u: Vec<f64> = t.iter().map(|t| to + (from - to) * (-t / 2.2).exp()).collect();
    let v: Vec<f64> = r.iter().zip(&u).map(|(r, u)| -0.4 * r * (0.4 + u) / (1.0 + r * r)).collect();
    let (x, y) = track(&u, &v, &r);
    let surge = vec![to * 4300.0; 300];
    let moment: Vec<f64> = t.iter().map(|t| 1200.0 * wanted(*t)).collect();
    let sway = moment.iter().map(|m| -2.5 * m).collect();
    let input = |name: &str, unit: &str, values| (name.to_owned(), unit.to_owned(), values);
    let inputs = vec![input("tau1", "N", surge), input("tau2", "N", sway), input("tau3", "N m", moment)];
    ManeuverTrace {
        name: name.to_owned(),
        reached: String::new(),
        description: "as in the paper".to_owned(),
        t,
        inputs,
        commands: Vec::new(),
        u,
        v,
        r,
        x,
        y,
    }
}

fn track(u: &[f64], v: &[f64], r: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let (mut x, mut y, mut psi) = (0.0, 0.0, 0.0_f64);
    let step = |((u, v), r): ((&f64, &f64), &f64)| {
        x += 0.125 * (u * psi.cos() - v * psi.sin());
        y += 0.125 * (u * psi.sin() + v * psi.cos());
        psi += 0.125 * r;
        (x, y)
    };
    u.iter().zip(v).zip(r).map(step).unzip()
}

fn validation_trace() -> ManeuverTrace {
    let mut trace = trace(&("telegraph", 0.0, 0.0, 0.0, 0.3, 0.9, 0.3, false));
    trace.inputs[0]
        .2
        .iter_mut()
        .enumerate()
        .for_each(|(k, value)| *value = if (k / 80) % 2 == 0 { 1300.0 } else { 4000.0 });
    trace
}

fn by_name(value: impl Fn(&Maneuver) -> f64) -> BTreeMap<String, f64> {
    MANEUVERS.iter().map(|maneuver| (maneuver.0.to_owned(), value(maneuver))).collect()
}

fn design() -> DesignDocument {
    DesignDocument {
        criterion: CriterionName::DHessian,
        mean_removal: Some(MeanRemoval::Complete),
        status: DesignStatus::Stationary,
        statement: "The shares are first-order optimal to a relative gap of 3e-10. The problem is not concave, so this does \
                    not prove a global optimum; all 6 starts reached the same value."
            .to_owned(),
        held: Vec::new(),
        beyond: vec!["u leaves the 0.1000 to 0.4500 m/s that the model was fitted on in 5 samples (1.2 %)".to_owned()],
        unreached: None,
        prior: None,
        promise: None,
        shares: by_name(|m| m.1),
        order: MANEUVERS.iter().map(|m| m.0.to_owned()).collect(),
        candidates: None,
        sensitivities: by_name(|m| m.2),
        dimension: Some(13),
        gap: Some(4.1e-9),
        relative_gap: Some(3.15e-10),
        log_det: Some(-41.273_918_24),
        efficiency: Some(Efficiency { equal_shares: 0.571, single: by_name(|m| m.3) }),
        counts: None,
        counted: None,
        available: None,
        covariance: None,
        figures: None,
        accuracy: None,
        estimator: None,
        restricted: None,
        sequence: None,
        refined: None,
    }
}

fn moments() -> MomentsDocument {
    let degrees = ["surge", "sway", "yaw"];
    let degree = |(index, name): (usize, &&str), seed: usize| DegreeMoments {
        name: (*name).to_owned(),
        shape: [1, 1],
        m: vec![1.0],
        nonstationarity: 0.013 * ((7 * seed + 3 * index) % 70) as f64,
        b: None,
    };
    let maneuver = |(seed, maneuver): (usize, &Maneuver)| ManeuverMoments {
        name: maneuver.0.to_owned(),
        samples: 300,
        degrees: degrees.iter().enumerate().map(|entry| degree(entry, seed)).collect(),
        output_error: None,
    };
    let structure = |name: &&str| Degree {
        name: (*name).to_owned(),
        regressors: vec!["u".to_owned(), "1".to_owned()],
        parameters: vec!["X_u".to_owned()],
    };
    MomentsDocument(Moments {
        vessel: "Ljungberg model ship".to_owned(),
        sample_rate_hz: 8.0,
        instruments: Some(InstrumentKind::Nominal),
        degrees: degrees.iter().map(structure).collect(),
        maneuvers: MANEUVERS.iter().enumerate().map(maneuver).collect(),
        held: Vec::new(),
        beyond: Vec::new(),
        disturbances: None,
        output_error: None,
        prior: None,
        sampled: None,
    })
}

fn estimate() -> EstimateDocument {
    EstimateDocument {
        designs: vec![
            summary("optimized", |p| p.4, 1.0),
            summary("random", |p| p.5, 40.0),
            summary("practice", |p| 0.5 * (p.4 + p.5), 8.0),
        ],
        seed: Some(1),
        trusted_within: Some(0.15),
        ..EstimateDocument::new(Estimator::Iv, MeanRemoval::Complete)
    }
}

fn summary(design: &str, spread: impl Fn(&Parameter) -> f64, condition: f64) -> DesignSummary {
    let parameter = |p: &Parameter| ParameterSummary {
        at_bound: None,
        name: p.0.to_owned(),
        unit: p.1.to_owned(),
        truth: Some(p.2),
        nominal: p.3,
        mean: Some(p.2 * (1.0 + 0.1 * spread(p))),
        spread: Some(spread(p) * p.2.abs()),
        predicted_se: Some(0.97 * spread(p) * p.2.abs()),
        relative_bias: Some(0.1 * spread(p) * p.2.signum()),
        relative_spread: Some(spread(p)),
        se_ratio: Some(0.97),
        se_trusted: Some(true),
    };
    let degree = |(name, weakest): (&str, &str)| DegreeSummary {
        name: name.to_owned(),
        condition_median: Some(23.4 * condition),
        condition_max: Some(61.0 * condition * condition),
        weakest_parameter: weakest.to_owned(),
        weakest_share: 0.87,
        ..DegreeSummary::default()
    };
    DesignSummary {
        design: design.to_owned(),
        runs: 500,
        identified: 500,
        parameters: PARAMETERS.iter().map(parameter).collect(),
        degrees: [("surge", "X_uu"), ("sway", "Y_ur"), ("yaw", "N_uv")].into_iter().map(degree).collect(),
        ..DesignSummary::default()
    }
}

fn validation() -> ScoredEstimates {
    ScoredEstimates {
        bounds: Bounds { parameter_error: 5.0, simulation_error: 0.15 },
        samples: 1000,
        seed: Some(1),
        recommendations: None,
        designs: vec![
            design_scores("optimized", 0.986, 0.971, 1.0),
            design_scores("random", 0.52, 0.604, 2.4),
            design_scores("practice", 0.75, 0.81, 1.5),
        ],
        compared: None,
    }
}

fn design_scores(design: &str, parameter: f64, simulation: f64, factor: f64) -> DesignScores {
    let quantiles = |median: f64| Quantiles {
        q10: Some(0.4 * median),
        median: Some(median),
        median_interval: Some([Some(0.9 * median), Some(1.2 * median)]),
        q90: Some(2.1 * median),
        ..Quantiles::default()
    };
    DesignScores {
        design: design.to_owned(),
        runs: 500,
        diverged: if factor > 1.0 { 31 } else { 0 },
        parameter_error_share: parameter,
        parameter_error_share_interval: Some([parameter - 0.02, parameter + 0.01]),
        simulation_error_share: simulation,
        parameter_error: quantiles(1.98 * factor),
        simulation_error: quantiles(0.0612 * factor),
        rmse_u: quantiles(0.0511 * factor),
        rmse_v: quantiles(0.0204 * factor),
        rmse_r: quantiles(0.0142 * factor),
        ..DesignScores::default()
    }
}

/// Log-normal errors at fixed quantiles; wide designs have runs without a value.
fn scores(design: &str, median: f64, width: f64) -> Vec<Row> {
    let value = |run: usize, scale: f64, widen: f64, stride: usize| {
        let level = (((run * stride) % 500) as f64 + 0.5) / 500.0;
        let normal = (level / (1.0 - level)).ln() / 1.7;
        (width < 1.0 || run % 17 != 3).then(|| scale * (width * widen * normal).exp())
    };
    let row = |run: usize| Row {
        design: design.to_owned(),
        run: run as i32,
        estimator: Estimator::Iv,
        status: ScoreStatus::Scored,
        parameter_error: value(run, median, 1.0, 37),
        simulation_error: value(run, 0.031 * median, 0.8, 41),
        rmse: [
            value(run, 0.025 * median, 0.9, 43),
            value(run, 0.010 * median, 0.9, 47),
            value(run, 0.007 * median, 0.9, 53),
        ],
    };
    (0..500).map(row).collect()
}

fn reference() -> Reference {
    let shares = [
        ("decelerate", 0.16),
        ("accelerate", 0.04),
        ("zig-zag-fast-flat", 0.09),
        ("zig-zag-slow-steep", 0.42),
        ("zig-zag-fast-steep", 0.04),
        ("spiral-fast", 0.25),
    ];
    let optimized = Published {
        parameter_error_share: PublishedShare::Above { above: 0.99 },
        simulation_error_share: PublishedShare::Value(0.99),
    };
    let random = Published {
        parameter_error_share: PublishedShare::Value(0.49),
        simulation_error_share: PublishedShare::Value(0.69),
    };
    Reference {
        derivatives: BTreeMap::new(),
        source: "Ljungberg, Linder, Enqvist, Tervo, simulation study".to_owned(),
        used: None,
        shares: shares.into_iter().map(|(name, share)| (name.to_owned(), share)).collect(),
        designs: BTreeMap::from([("optimized".to_owned(), optimized), ("random".to_owned(), random)]),
        selection: None,
    }
}

fn files() -> Vec<(String, String, String)> {
    let file = |name: &str, what: &str, digit: &str| {
        (name.to_owned(), what.to_owned(), format!("blake3:{}", digit.repeat(64)))
    };
    vec![
        file("dictionary.parquet", "maneuvers simulated without disturbances", "3"),
        file("moments.json", "moment matrices", "a"),
        file("design.json", "optimal shares", "c"),
        file("scores.parquet", "errors of every run", "7"),
    ]
}
