use artifact::{Document, Units};
use identification::pooled::{
    Covered, Expansion, NominalModel, NominalSource, Pool, PooledRuns, Products, Recorded, RunSums,
};
use identification::{Estimator, MeanRemoval};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use vessel::{DegreeOfFreedom, Invalid, Vessel};

/// `sums.json`: sums over the sub-experiments of some runs, which add to those of other runs without rounding.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SumsDocument {
    /// The estimator that they are for: `ls` or `iv`.
    pub estimator: Estimator,
    /// How the instruments' mean is removed.
    pub mean_removal: MeanRemoval,
    /// Where the instruments' nominal model comes from.
    pub nominal: NominalSource,
    /// Its parameters: surge, sway, yaw.
    pub nominal_values: Vec<f64>,
    /// The sampling rate.
    pub sample_rate_hz: f64,
    /// Most seconds of a sub-experiment; null where segments were not cut.
    pub part_s: Option<f64>,
    /// Names of the designs, sorted.
    pub designs: Vec<String>,
    /// Which runs of the trajectories were added up, from 0: first and last of those that follow each other.
    pub runs: Vec<[u64; 2]>,
    /// Number of sub-experiments.
    pub parts: u64,
    /// Regression pairs.
    pub samples: u64,
    /// Surge, sway, yaw.
    pub degrees: Vec<DegreeProducts>,
    /// What the data covered.
    pub covered: Vec<Covered>,
}

/// How an entry is told.
type Told = fn(&SumsDocument) -> String;

/// Sums of products of one degree of freedom with p parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DegreeProducts {
    /// `surge`, `sway` or `yaw`.
    pub name: String,
    /// Its parameters.
    pub parameters: Vec<String>,
    /// Their terms.
    pub terms: Vec<String>,
    /// Σ w wᵀ with w = (instruments, regressors, increment, 1): the upper triangle, row by row. Each entry is the sum of numbers that
    /// do not overlap, the largest first: the sum of all sub-experiments' without rounding.
    pub products: Vec<Vec<f64>>,
}

impl SumsDocument {
    /// The `sums` of `runs` for `estimator`; none where one is too large for a number.
    pub fn new<R: Recorded>(
        pool: &Pool,
        (estimator, nominal): (Estimator, NominalSource),
        part_s: Option<f64>,
        runs: &PooledRuns<R>,
        sums: &RunSums,
    ) -> Option<Self> {
        let vessel = pool.vessel;
        let all = || sums.degrees.iter().flat_map(|own| &own.0);
        all().all(|sum| sum.value().is_finite()).then(|| Self {
            estimator,
            mean_removal: pool.removal,
            nominal,
            nominal_values: match &pool.nominal {
                NominalModel::Known(theta) => theta.clone(),
                NominalModel::Fitted => Vec::new(),
            },
            sample_rate_hz: vessel.sample_rate_hz,
            part_s,
            designs: runs.selected_designs(),
            runs: runs.selected(),
            parts: sums.parts,
            samples: sums.samples,
            degrees: DegreeOfFreedom::ALL.map(|d| DegreeProducts::new(vessel, d, sums)).into(),
            covered: sums.covered.clone(),
        })
    }

    /// The sums.
    pub fn sums(&self) -> RunSums {
        let own = |d: usize| {
            let products = self.degrees.get(d).map_or(&[][..], |degree| &degree.products);
            Products(products.iter().map(|numbers| Expansion::of(numbers)).collect())
        };
        RunSums {
            parts: self.parts,
            samples: self.samples,
            degrees: [0, 1, 2].map(own),
            covered: self.covered.clone(),
        }
    }

    /// What makes the sums of `other` such that they must not be added: the name of what differs, its value here and there.
    pub fn difference(&self, other: &Self) -> Option<[String; 3]> {
        let terms = |own: &Self| {
            let degree = |degree: &DegreeProducts| format!("{} of {}", degree.terms.join(", "), degree.name);
            own.degrees.iter().map(degree).collect::<Vec<_>>().join("; ")
        };
        let told: [(&str, Told); 6] = [
            ("`estimator`", |own| own.estimator.to_string()),
            ("`mean_removal`", |own| own.mean_removal.to_string()),
            ("`sample_rate_hz`", |own| own.sample_rate_hz.to_string()),
            ("`part_s`", |own| own.part_s.map_or("none".to_owned(), |s| s.to_string())),
            ("`nominal`", |own| own.nominal.to_string()),
            ("`nominal_values`", |own| format!("{:?}", own.nominal_values)),
        ];
        let all = told.map(|(name, of)| [name.to_owned(), of(self), of(other)]);
        let all = all.into_iter().chain([["terms".to_owned(), terms(self), terms(other)]]);
        all.into_iter().find(|[_, own, other]| own != other)
    }

    /// Refuses sums of other terms, or at another rate, than `vessel` has.
    ///
    /// # Errors
    /// Names what differs.
    pub fn check_vessel(&self, vessel: &Vessel) -> Result<(), Invalid> {
        let remedy = "name the vessel.toml that the sums were made with";
        if self.sample_rate_hz != vessel.sample_rate_hz {
            let (found, expected) = (self.sample_rate_hz.to_string(), vessel.sample_rate_hz.to_string());
            return Err(Invalid::new("`sample_rate_hz`", found, expected, remedy));
        }
        let empty = RunSums::default();
        for (own, d) in self.degrees.iter().zip(DegreeOfFreedom::ALL) {
            let expected = DegreeProducts::new(vessel, d, &empty);
            if own.terms != expected.terms || own.parameters != expected.parameters {
                let (found, expected) = (own.terms.join(", "), expected.terms.join(", "));
                return Err(Invalid::new(format!("terms of {}", d.name()), found, expected, remedy));
            }
        }
        Ok(())
    }
}

impl DegreeProducts {
    fn new(vessel: &Vessel, d: DegreeOfFreedom, sums: &RunSums) -> Self {
        let degree = &vessel.model.degrees[d as usize];
        Self {
            name: d.name().to_owned(),
            parameters: degree.parameters.clone(),
            terms: degree.terms.iter().map(|term| term.text.clone()).collect(),
            products: sums.degrees[d as usize].0.iter().map(Expansion::numbers).collect(),
        }
    }
}

impl Document for SumsDocument {
    const ID: &'static str = "sums";
    const VERSION: u32 = 1;
    const UNITS: Units = &[
        ("Hz", "sample_rate_hz"),
        ("s", "part_s"),
        ("1", "runs parts samples"),
        ("the parameter's unit", "nominal_values"),
        ("product of the units of two of instruments, regressors, increment and 1", "products"),
        ("the unit beside it", "low high"),
    ];

    fn check(&self) -> Result<(), Invalid> {
        let remedy = "add the runs up again";
        if self.degrees.len() != 3 {
            let found = format!("{} degrees of freedom", self.degrees.len());
            return Err(Invalid::new("data.degrees", found, "surge, sway and yaw", remedy));
        }
        for own in &self.degrees {
            let (found, expected) = (own.products.len(), Products::count(own.terms.len()));
            if found != expected || own.parameters.len() != own.terms.len() {
                let (found, expected) = (format!("{found} products"), expected.to_string());
                return Err(Invalid::new(format!("data.degrees of {}", own.name), found, expected, remedy));
            }
        }
        let parameters: usize = self.degrees.iter().map(|own| own.parameters.len()).sum();
        if self.nominal_values.len() != parameters {
            let found = format!("{} values", self.nominal_values.len());
            return Err(Invalid::new("data.nominal_values", found, parameters.to_string(), remedy));
        }
        match self.runs.iter().find(|[first, last]| first > last) {
            None => Ok(()),
            Some([first, last]) => Err(Invalid::new(
                "data.runs",
                format!("{first} to {last}"),
                "the first before the last",
                remedy,
            )),
        }
    }
}
