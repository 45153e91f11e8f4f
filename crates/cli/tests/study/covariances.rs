//! `estimate --keep covariance`: the covariances of every run's parameters, in a table beside the estimates.

use files::{Provenance, TableReader};
use ship::model::Vessel;
use study::estimates::{self, covariances};
use study::files::read_vessel;
use tempfile::TempDir;

use crate::support::*;

fn vessel(folder: &TempDir) -> Vessel {
    read_vessel(&folder.path().join("vessel.toml"), &mut Provenance::default()).unwrap()
}

/// The rows of both tables.
fn tables(folder: &TempDir) -> Vec<(estimates::Row, covariances::CovarianceRow)> {
    let (vessel, file) = (vessel(folder), folder.path().join("estimates.parquet"));
    let reader = TableReader::open(&file, estimates::ID, estimates::VERSION).unwrap();
    let second = folder.path().join(covariances::FILE);
    let second = TableReader::open(second, covariances::ID, covariances::VERSION).unwrap();
    assert_eq!(reader.rows(), second.rows());
    let first = (0..reader.blocks()).flat_map(|i| estimates::rows(&reader, &vessel, &file, i).unwrap());
    let second: Vec<_> =
        (0..second.blocks()).flat_map(|i| covariances::rows(&second, &vessel, i).unwrap()).collect();
    first.zip(second).collect()
}

/// Refuses a covariance that is not symmetric, has other variances than the squares of standard errors, or correlations
/// beyond 1.
fn check(covariance: &[f64], errors: &[f64]) {
    let p = errors.len();
    for i in 0..p {
        let (variance, square) = (covariance[i * p + i], errors[i] * errors[i]);
        assert!((variance - square).abs() <= 1e-9 * square, "{i}: {variance}, {square}");
        for j in 0..p {
            assert_eq!(covariance[i * p + j].to_bits(), covariance[j * p + i].to_bits());
            let most = (1.0 + 1e-9) * errors[i] * errors[j];
            assert!(covariance[i * p + j].abs() <= most, "{i}, {j}: {} {most}", covariance[i * p + j]);
        }
    }
}

#[test]
fn law_covariances_have_the_squares_of_standard_errors_on_their_diagonal() {
    for flags in [
        "--estimator ls,iv,output-error,prediction-error --campaign campaign.toml",
        "--estimator output-error --unknown-current earth --campaign campaign.toml",
    ] {
        let folder = with(&["campaign.parquet"]);
        run(&folder, &format!("{ESTIMATE} {flags} --keep covariance")).succeeds();
        let rows = tables(&folder);
        for (estimate, own) in &rows {
            assert_eq!((&estimate.design, estimate.run), (&own.design, own.run));
            assert_eq!(estimate.estimator, own.estimator);
            assert_eq!(estimate.estimate.is_some(), own.covariance.is_some(), "{estimate:?}");
            let Some((_, errors)) = &estimate.estimate else { continue };
            check(own.covariance.as_ref().unwrap(), errors);
        }
        assert!(rows.iter().filter(|(_, own)| own.covariance.is_some()).count() > rows.len() / 2);
    }
}

/// Of both designs the parameters of a term and its input are strongly correlated: over all runs as much as predicted.
#[test]
fn law_estimates_of_many_runs_correlate_as_their_covariances_say() {
    let folder = with(&["campaign.parquet"]);
    run(&folder, &format!("{ESTIMATE} --keep covariance")).succeeds();
    let rows = tables(&folder);
    let names: Vec<String> = vessel(&folder).model.parameter_names().map(str::to_owned).collect();
    let place = |name: &str| names.iter().position(|own| own == name).unwrap();
    let (i, j, p) = (place("N_r"), place("N_tau"), names.len());
    let own: Vec<_> = rows.iter().filter(|(estimate, _)| estimate.design == "optimized").collect();
    let predicted = |(_, row): &&(estimates::Row, covariances::CovarianceRow)| {
        let own = row.covariance.as_ref().unwrap();
        own[i * p + j] / (own[i * p + i] * own[j * p + j]).sqrt()
    };
    let predicted = own.iter().map(predicted).sum::<f64>() / own.len() as f64;
    let theta = |k: usize| own.iter().map(move |(row, _)| row.estimate.as_ref().unwrap().0[k]);
    let mean = |k: usize| theta(k).sum::<f64>() / own.len() as f64;
    let product =
        |a: usize, b: usize| theta(a).zip(theta(b)).map(|(x, y)| (x - mean(a)) * (y - mean(b))).sum::<f64>();
    let found = product(i, j) / (product(i, i) * product(j, j)).sqrt();
    assert!(predicted < -0.7, "{predicted}");
    assert!((found - predicted).abs() < 0.15, "{found} {predicted}");
}

/// Without stated noise standard errors are the largest under several kinds of it, or by blocks.
#[test]
fn law_found_noise_gives_a_covariance_that_fits_the_errors_or_none() {
    let folder = with(&["campaign.parquet"]);
    let few = "--runs optimized/0,optimized/1,random/0,random/1,practice/0,practice/1";
    run(&folder, &format!("{ESTIMATE} --estimator prediction-error --keep covariance {few}")).succeeds();
    let rows = tables(&folder);
    for (estimate, own) in &rows {
        if let (Some((_, errors)), Some(covariance)) = (&estimate.estimate, &own.covariance) {
            check(covariance, errors);
        }
    }
}

#[test]
fn covariances_belong_to_the_set_and_go_with_the_next_estimate() {
    let folder = with(&["campaign.parquet"]);
    let has = || folder.path().join(covariances::FILE).exists();
    run(&folder, &format!("{ESTIMATE} --keep covariance")).succeeds();
    assert!(has() && json(&folder, "estimate.json")["members"].get(covariances::FILE).is_some());
    let before = bytes(&folder, covariances::FILE);
    run(&folder, &format!("{ESTIMATE} --keep covariance --threads 1")).succeeds();
    assert_eq!(bytes(&folder, covariances::FILE), before);
    let estimates = bytes(&folder, "estimates.parquet");
    run(&folder, ESTIMATE).succeeds();
    assert!(!has());
    assert_eq!(bytes(&folder, "estimates.parquet"), estimates);
    refused(&folder, 2, &format!("{ESTIMATE} --keep covariance --shard 1/2"), &["--keep", "--shard"]);
}
