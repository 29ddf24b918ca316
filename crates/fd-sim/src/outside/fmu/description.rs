//! What `modelDescription.xml` says (FMI 2.0.4, section 2.2; FMI 3.0.2, section 2.4).

use std::fmt;

use roxmltree::{Document, Node};

/// A version of the standard.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Version {
    Two,
    Three,
}

impl fmt::Display for Version {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Two => "2.0",
            Self::Three => "3.0",
        })
    }
}

/// What is needed of a description.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Description {
    pub version: Version,
    pub name: String,
    /// What an FMU of version 2 calls `guid`.
    pub token: String,
    /// Name of the library.
    pub identifier: String,
    /// Whether a process may have one instance only.
    pub is_single: bool,
    pub variables: Vec<Variable>,
}

/// A variable of type `Real`, in version 3 a single one of type `Float64`.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Variable {
    pub name: String,
    pub reference: u32,
    pub causality: String,
    pub unit: Option<String>,
    pub start: Option<f64>,
}

/// What is wrong: where, what was expected, and what was found.
pub(super) type Wrong = (String, String, String);

impl Description {
    /// Reads a description.
    pub(super) fn read(text: &str) -> Result<Self, Wrong> {
        let wrong = |what: &str, expected: &str, found: &str| {
            (what.to_owned(), expected.to_owned(), found.to_owned())
        };
        let xml = Document::parse(text)
            .map_err(|error| wrong("modelDescription.xml", "XML", &error.to_string()))?;
        let root = xml.root_element();
        let version = root.attribute("fmiVersion").unwrap_or("none");
        let is_description = root.tag_name().name() == "fmiModelDescription";
        let version = match version {
            two if is_description && two.starts_with("2.") => Version::Two,
            three if is_description && three.starts_with("3.") => Version::Three,
            other => return Err(wrong("fmiVersion", "2.0 or 3.0", other)),
        };
        let of_root = |name: &str| {
            let value = root.attribute(name).map(str::to_owned);
            value.ok_or_else(|| wrong("fmiModelDescription", &format!("`{name}`"), "none"))
        };
        let child = |name: &str| root.children().find(|node| node.has_tag_name(name));
        let kind = child("CoSimulation").ok_or_else(|| {
            wrong("modelDescription.xml", "`CoSimulation`", "an FMU for model exchange only")
        })?;
        let identifier = kind.attribute("modelIdentifier").unwrap_or_default();
        let is_name = |c: char| c.is_ascii_alphanumeric() || c == '_';
        if identifier.is_empty() || !identifier.chars().all(is_name) {
            return Err(wrong("modelIdentifier", "the name of a library", identifier));
        }
        let is_true = |name: &str| kind.attribute(name) == Some("true");
        if is_true("needsExecutionTool") {
            return Err(wrong("needsExecutionTool", "an FMU that runs by itself", "true"));
        }
        let types = child("TypeDefinitions");
        let variables = child("ModelVariables").into_iter().flat_map(|node| node.children());
        let variables = variables.filter_map(|node| match version {
            Version::Two => real(node, types),
            Version::Three => float(node, types),
        });
        Ok(Self {
            version,
            name: of_root("modelName")?,
            token: of_root(match version {
                Version::Two => "guid",
                Version::Three => "instantiationToken",
            })?,
            identifier: identifier.to_owned(),
            is_single: is_true("canBeInstantiatedOnlyOncePerProcess"),
            variables: variables.collect(),
        })
    }
}

/// A variable of version 3, if it is one of floating point, and no array.
fn float(node: Node<'_, '_>, types: Option<Node<'_, '_>>) -> Option<Variable> {
    let is_array = node.children().any(|child| child.has_tag_name("Dimension"));
    if !node.has_tag_name("Float64") || is_array {
        return None;
    }
    let declared = node.attribute("declaredType");
    let is_its =
        |t: &Node<'_, '_>| t.has_tag_name("Float64Type") && t.attribute("name") == declared;
    let unit_of_type = || types?.children().find(is_its)?.attribute("unit");
    variable(node, node, declared.and_then(|_| unit_of_type()))
}

/// A variable of version 2, if it is real.
fn real(node: Node<'_, '_>, types: Option<Node<'_, '_>>) -> Option<Variable> {
    if !node.has_tag_name("ScalarVariable") {
        return None;
    }
    let real = node.children().find(|child| child.has_tag_name("Real"))?;
    let declared = real.attribute("declaredType");
    let unit_of_type = || {
        let simple =
            types?.children().find(|t| declared.is_some() && t.attribute("name") == declared);
        simple?.children().find(|child| child.has_tag_name("Real"))?.attribute("unit")
    };
    variable(node, real, unit_of_type())
}

/// A variable, with the node that its unit and its value are attributes of, and the unit of its type.
fn variable(
    node: Node<'_, '_>,
    value: Node<'_, '_>,
    unit_of_type: Option<&str>,
) -> Option<Variable> {
    Some(Variable {
        name: node.attribute("name")?.to_owned(),
        reference: node.attribute("valueReference")?.parse().ok()?,
        causality: node.attribute("causality").unwrap_or("local").to_owned(),
        unit: value.attribute("unit").or(unit_of_type).map(str::to_owned),
        start: value.attribute("start").and_then(|start| start.parse().ok()),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEAD: &str = "<fmiModelDescription fmiVersion=\"2.0\" modelName=\"m\" guid=\"{1}\">";

    #[test]
    fn units_come_from_variables_or_their_types() {
        let text = format!(
            "{HEAD}<CoSimulation modelIdentifier=\"m\"/><TypeDefinitions><SimpleType name=\"Mass\">\
             <Real unit=\"kg\"/></SimpleType></TypeDefinitions><ModelVariables>\
             <ScalarVariable name=\"a\" valueReference=\"7\" causality=\"input\"><Real unit=\"N\"/>\
             </ScalarVariable><ScalarVariable name=\"b\" valueReference=\"8\">\
             <Real declaredType=\"Mass\" start=\"1.5\"/></ScalarVariable>\
             <ScalarVariable name=\"c\" valueReference=\"9\"><Integer/></ScalarVariable>\
             </ModelVariables></fmiModelDescription>"
        );
        let read = Description::read(&text).unwrap();
        let [a, b] = &read.variables[..] else { panic!("{read:?}") };
        assert_eq!((a.reference, a.causality.as_str(), a.unit.as_deref()), (7, "input", Some("N")));
        assert_eq!((b.causality.as_str(), b.unit.as_deref()), ("local", Some("kg")));
        assert_eq!(b.start, Some(1.5));
    }

    #[test]
    fn variables_of_version_3_are_elements_of_their_type_and_no_arrays() {
        let text = "<fmiModelDescription fmiVersion=\"3.0\" modelName=\"m\" instantiationToken=\"{1}\">\
             <CoSimulation modelIdentifier=\"m\"/><TypeDefinitions><Float64Type name=\"Mass\" unit=\"kg\"/>\
             </TypeDefinitions><ModelVariables>\
             <Float64 name=\"a\" valueReference=\"7\" causality=\"input\" unit=\"N\"/>\
             <Float64 name=\"b\" valueReference=\"8\" declaredType=\"Mass\" start=\"1.5\"/>\
             <Float64 name=\"c\" valueReference=\"9\"><Dimension start=\"3\"/></Float64>\
             <Int32 name=\"d\" valueReference=\"10\"/></ModelVariables></fmiModelDescription>";
        let read = Description::read(text).unwrap();
        assert_eq!((read.version, read.token.as_str()), (Version::Three, "{1}"));
        let [a, b] = &read.variables[..] else { panic!("{read:?}") };
        assert_eq!((a.reference, a.causality.as_str(), a.unit.as_deref()), (7, "input", Some("N")));
        assert_eq!((b.unit.as_deref(), b.start), (Some("kg"), Some(1.5)));
    }

    #[test]
    fn what_cannot_be_run_is_refused_with_its_reason() {
        for (text, found) in [
            ("<other/>".to_owned(), "none"),
            (HEAD.replace("2.0", "1.0") + "</fmiModelDescription>", "1.0"),
            (HEAD.replace("2.0", "3.0") + "</fmiModelDescription>", "for model exchange only"),
            (format!("{HEAD}</fmiModelDescription>"), "an FMU for model exchange only"),
            (
                format!("{HEAD}<CoSimulation modelIdentifier=\"../m\"/></fmiModelDescription>"),
                "../m",
            ),
        ] {
            let (_, _, wrong) = Description::read(&text).unwrap_err();
            assert!(wrong.contains(found), "{wrong}");
        }
    }
}
