//! What `modelDescription.xml` says (FMI 2.0.4, section 2.2).

use roxmltree::{Document, Node};

/// What is needed of a description.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Description {
    pub(super) name: String,
    pub(super) guid: String,
    /// Name of the library.
    pub(super) identifier: String,
    /// Whether a process may have one instance only.
    pub(super) is_single: bool,
    pub(super) variables: Vec<Variable>,
}

/// A variable of type `Real`.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Variable {
    pub(super) name: String,
    pub(super) reference: u32,
    pub(super) causality: String,
    pub(super) unit: Option<String>,
    pub(super) start: Option<f64>,
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
        if root.tag_name().name() != "fmiModelDescription" || !version.starts_with("2.") {
            return Err(wrong("fmiVersion", "2.0", version));
        }
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
        let scalars = child("ModelVariables").into_iter().flat_map(|node| node.children());
        let scalars = scalars.filter(|node| node.has_tag_name("ScalarVariable"));
        let variables = scalars.filter_map(|node| variable(node, types)).collect();
        Ok(Self {
            name: of_root("modelName")?,
            guid: of_root("guid")?,
            identifier: identifier.to_owned(),
            is_single: is_true("canBeInstantiatedOnlyOncePerProcess"),
            variables,
        })
    }
}

/// A variable, if it is real.
fn variable(node: Node<'_, '_>, types: Option<Node<'_, '_>>) -> Option<Variable> {
    let real = node.children().find(|child| child.has_tag_name("Real"))?;
    let declared = real.attribute("declaredType");
    let unit_of_type = || {
        let simple =
            types?.children().find(|t| declared.is_some() && t.attribute("name") == declared);
        simple?.children().find(|child| child.has_tag_name("Real"))?.attribute("unit")
    };
    Some(Variable {
        name: node.attribute("name")?.to_owned(),
        reference: node.attribute("valueReference")?.parse().ok()?,
        causality: node.attribute("causality").unwrap_or("local").to_owned(),
        unit: real.attribute("unit").or_else(unit_of_type).map(str::to_owned),
        start: real.attribute("start").and_then(|start| start.parse().ok()),
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
    fn what_cannot_be_run_is_refused_with_its_reason() {
        for (text, found) in [
            ("<other/>".to_owned(), "none"),
            (HEAD.replace("2.0", "3.0") + "</fmiModelDescription>", "3.0"),
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
