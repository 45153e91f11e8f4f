//! `modelDescription.xml`.

use std::collections::BTreeSet;
use std::fmt::Write;

use quick_xml::escape::escape;

use crate::export::portable::Portable;
use crate::export::text::{comment, number};

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
    pub(super) fn description(&self) -> String {
        let outputs: String = (1..=3).map(|i| format!("      <Unknown index=\"{i}\"/>\n")).collect();
        let variables = self.variables();
        let within = variables.len() + 1;
        let unknowns = format!("{outputs}      <Unknown index=\"{within}\"/>\n");
        let reals: String = variables.iter().enumerate().map(|(place, own)| own.element(place)).collect();
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
        let channels = self.given().iter().map(|own| &own.unit);
        let all: BTreeSet<&String> =
            channels.chain(self.parameters.iter().map(|parameter| &parameter.unit)).collect();
        all.into_iter().map(|unit| format!("    <Unit name=\"{}\"/>\n", attribute(unit))).collect()
    }

    /// States, inputs, parameters, initial states: a variable's index is its value reference.
    fn variables(&self) -> Vec<ScalarVariable<'_>> {
        let range = |place: usize| {
            let own = self.ranges.iter().find(|range| range.channel == place);
            own.map(|range| [range.low, range.high])
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
            let own = channel(place, INITIAL, Some(self.start(place)));
            ScalarVariable {
                name: format!("initial_{}", own.name),
                description: format!("{} at the start", own.name),
                range: None,
                ..own
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
