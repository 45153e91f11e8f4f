//! The model as a Functional Mock-up Unit (FMI 2.0, co-simulation), whose step is the model's.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::io::{Cursor, Write};

use quick_xml::escape::escape;
use refusal::Invalid;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

use crate::export::portable::Portable;
use crate::export::text::{comment, fill, number, quoted};

/// The standard's name of this platform, if it has one.
pub const PLATFORM: Option<&str> = if cfg!(all(target_os = "linux", target_arch = "x86_64")) {
    Some("linux64")
} else if cfg!(target_os = "macos") {
    Some("darwin64")
} else {
    None
};

/// The extension of shared libraries on this platform.
const LIBRARY: &str = if cfg!(target_os = "macos") { "dylib" } else { "so" };

/// Compiler flags besides sources and output. Sums keep their order, so that results have the same bits.
pub const COMPILED_WITH: [&str; 6] =
    ["-std=c99", "-O2", "-ffp-contract=off", "-fPIC", "-shared", "-fvisibility=hidden"];

impl Portable {
    /// The unit's C sources, name and text: the functions of the standard, the model, its header.
    pub fn unit_sources(&self) -> Vec<(String, String)> {
        let [header, source] = self.c_model();
        let starts = |channels: std::ops::Range<usize>| {
            channels.map(|place| number(self.start(place))).collect::<Vec<_>>().join(", ")
        };
        let inputs = starts(3..self.given().len());
        let values = [
            ("base", self.base.clone()),
            ("BASE", self.upper()),
            ("header", self.c_header()),
            ("guid", quoted(&self.guid())),
            ("ranges_are", self.ranges_are().to_owned()),
            ("initial_states", starts(0..3)),
            ("initial_inputs", if inputs.is_empty() { "0.0".to_owned() } else { inputs }),
        ];
        let text = fill(include_str!("templates/fmi2.c"), &values);
        vec![(format!("{}_fmi2.c", self.base), text), source, header]
    }

    /// Identifies a unit: derived from its source and the producing program.
    fn guid(&self) -> String {
        let origin = &self.origin;
        format!("{} {} {}", origin.digest, origin.values, origin.producer)
    }
}

impl Portable {
    /// The unit, with the `library` built from its sources, if there is one.
    pub(crate) fn unit(&self, library: Option<Vec<u8>>) -> Result<Vec<u8>, Invalid> {
        let mut files = vec![("modelDescription.xml".to_owned(), self.description().into_bytes())];
        let built = PLATFORM.zip(library);
        files.extend(built.map(|(platform, b)| (format!("binaries/{platform}/{}.{LIBRARY}", self.base), b)));
        let sources = self.unit_sources().into_iter();
        files.extend(sources.map(|(name, text)| (format!("sources/{name}"), text.into_bytes())));
        packed(&files).map_err(|e| {
            let expected = "contents that fit into an archive";
            Invalid::new("functional mock-up unit", e.to_string(), expected, "export to c instead")
        })
    }
}

/// No clock is read: every file is dated 1980, the earliest date of such archives.
fn packed(files: &[(String, Vec<u8>)]) -> zip::result::ZipResult<Vec<u8>> {
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Stored)
        .last_modified_time(DateTime::default())
        .unix_permissions(0o644);
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in files {
        archive.start_file(name.as_str(), options)?;
        archive.write_all(bytes)?;
    }
    Ok(archive.finish()?.into_inner())
}

/// A variable of the unit.
struct ScalarVariable<'a> {
    name: String,
    description: String,
    /// Attributes of its role in the unit.
    role: &'a str,
    unit: &'a str,
    start: Option<f64>,
    range: Option<[f64; 2]>,
}

impl Portable {
    /// The description of the unit.
    fn description(&self) -> String {
        let outputs: String = (1..=3).map(|i| format!("      <Unknown index=\"{i}\"/>\n")).collect();
        let variables = self.variables();
        let within = variables.len() + 1;
        let unknowns = format!("{outputs}      <Unknown index=\"{within}\"/>\n");
        let reals: String =
            variables.iter().enumerate().map(|(place, variable)| variable.element(place)).collect();
        let (base, rate) = (&self.base, number(1.0 / self.rate_hz));
        let [name, guid, description, tool] =
            [&self.vessel, &self.guid(), &self.header().join(" "), &self.origin.producer]
                .map(|text| attribute(text));
        format!(
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
             <fmiModelDescription fmiVersion=\"2.0\" modelName=\"{name}\" guid=\"{guid}\"\n    \
             description=\"{description}\"\n    \
             generationTool=\"{tool}\" variableNamingConvention=\"flat\" numberOfEventIndicators=\"0\">\n  \
             <CoSimulation modelIdentifier=\"{base}\" canNotUseMemoryManagementFunctions=\"true\">\n    \
             <SourceFiles>\n      <File name=\"{base}_fmi2.c\"/>\n      <File name=\"{base}.c\"/>\n    </SourceFiles>\n  \
             </CoSimulation>\n  \
             <UnitDefinitions>\n{}  </UnitDefinitions>\n  \
             <LogCategories>\n    <Category name=\"logStatusError\"/>\n    <Category name=\"logStatusWarning\"/>\n  \
             </LogCategories>\n  \
             <DefaultExperiment startTime=\"0.0\" stepSize=\"{rate}\"/>\n  \
             <ModelVariables>\n{reals}{}  </ModelVariables>\n  \
             <ModelStructure>\n    <Outputs>\n{unknowns}    </Outputs>\n    \
             <InitialUnknowns>\n{unknowns}    </InitialUnknowns>\n  </ModelStructure>\n\
             </fmiModelDescription>\n",
            self.units(),
            WITHIN,
        )
    }

    fn units(&self) -> String {
        let channels = self.given().iter().map(|channel| &channel.unit);
        let all: BTreeSet<&String> = channels.chain(self.parameters.iter().map(|p| &p.unit)).collect();
        all.into_iter().map(|unit| format!("    <Unit name=\"{}\"/>\n", attribute(unit))).collect()
    }

    /// States, inputs, parameters, initial states: a variable's index is its value reference.
    fn variables(&self) -> Vec<ScalarVariable<'_>> {
        let range = |place: usize| {
            let known = self.ranges.iter().find(|range| range.channel == place);
            known.map(|range| [range.low, range.high])
        };
        let channel = |place: usize, role, start| {
            let channel = &self.channels[place];
            let (name, description) =
                (channel.identifier.clone(), described(&channel.name, &channel.identifier, &channel.meaning));
            ScalarVariable { name, description, role, unit: &channel.unit, start, range: range(place) }
        };
        let states = (0..3).map(|place| channel(place, OUTPUT, None));
        let inputs = (3..self.given().len()).map(|place| channel(place, INPUT, Some(self.start(place))));
        let parameters = self.parameters.iter().map(|parameter| {
            let error = parameter.standard_error.map(|error| format!(", standard error {}", number(error)));
            let meaning = format!("{}{}", parameter.meaning, error.unwrap_or_default());
            ScalarVariable {
                name: parameter.identifier.clone(),
                description: described(&parameter.name, &parameter.identifier, &meaning),
                role: PARAMETER,
                unit: &parameter.unit,
                start: Some(parameter.value),
                range: None,
            }
        });
        let initial = (0..3).map(|place| {
            let variable = channel(place, INITIAL, Some(self.start(place)));
            ScalarVariable {
                name: format!("initial_{}", variable.name),
                description: format!("{} at the start", variable.name),
                range: None,
                ..variable
            }
        });
        states.chain(inputs).chain(parameters).chain(initial).collect()
    }
}

const OUTPUT: &str = "causality=\"output\" variability=\"discrete\" initial=\"calculated\"";
const INPUT: &str = "causality=\"input\" variability=\"discrete\"";
const PARAMETER: &str = "causality=\"parameter\" variability=\"tunable\" initial=\"exact\"";
const INITIAL: &str = "causality=\"parameter\" variability=\"fixed\" initial=\"exact\"";

/// The Boolean variable.
const WITHIN: &str = "    <ScalarVariable name=\"within_ranges\" valueReference=\"0\" description=\"whether states and inputs are \
    within the range of validity\" causality=\"output\" variability=\"discrete\" initial=\"calculated\"><Boolean/>\
    </ScalarVariable>\n";

impl ScalarVariable<'_> {
    /// The XML element, with its value reference.
    fn element(&self, reference: usize) -> String {
        let Self { name, description, role, unit, start, range } = self;
        let mut real = format!(" unit=\"{}\"", attribute(unit));
        // Writing to a string cannot fail.
        if let Some([low, high]) = range {
            let _ = write!(real, " min=\"{}\" max=\"{}\"", number(*low), number(*high));
        }
        if let Some(start) = start {
            let _ = write!(real, " start=\"{}\"", number(*start));
        }
        format!(
            "    <ScalarVariable name=\"{name}\" valueReference=\"{reference}\" description=\"{}\" {role}><Real{real}/>\
             </ScalarVariable>\n",
            attribute(description)
        )
    }
}

fn described(name: &str, identifier: &str, meaning: &str) -> String {
    if name == identifier { meaning.to_owned() } else { format!("{name}: {meaning}") }
}

/// A quoted attribute.
fn attribute(text: &str) -> String {
    escape(comment(text)).into_owned()
}
