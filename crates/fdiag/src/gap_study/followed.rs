//! Columns of the logs that the model does not use, and that its parameters may follow.

use fd_sim::model::{Input, Model, ModelError};

use super::request::Request;

/// The model with an input, which no equation uses, for every input of the column map that it does not have: a temperature, a
/// fan, a voltage that a parameter may follow.
///
/// # Errors
///
/// Returns an error when such a column has no name that can stand in an expression.
pub(super) fn with_followed(request: &Request, model: &Model) -> Result<Model, ModelError> {
    let channels = [model.external_inputs(), model.output_channels()].concat();
    let is_known =
        |name: &str| channels.iter().any(|channel| channel.name == name) || model.is_driven(name);
    let named = request.columns.iter().flat_map(|map| &map.inputs);
    let followed = named.filter(|column| !is_known(&column.name)).map(|column| Input {
        name: column.name.clone(),
        unit: column.unit.clone().or(column.column_unit.clone()).unwrap_or_else(|| "1".to_owned()),
        saturation: None,
    });
    let mut draft = model.clone().into_draft();
    draft.inputs.extend(followed);
    Model::try_from(draft)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_column_that_the_model_does_not_have_is_an_input_that_nothing_uses() {
        let model: Model = r#"
        version = 1
        kind = "equations"
        name = "lag"
        sample_time = 0.1
        inputs = { u = { unit = "1" } }
        states = { x = { unit = "1", initial = 0.0, derivative = "u - x" } }
        outputs = { y = { unit = "1", value = "x" } }
        "#
        .parse()
        .unwrap();
        let map = "inputs = [{ name = \"u\", column = \"U\" }, { name = \"T_amb\", unit = \"K\" }]\noutputs = [{ name = \"y\" }]";
        let mut request = Request::new("lag.toml", ["monday.csv"]);
        request.columns = Some(toml::from_str(map).unwrap());
        let followed = with_followed(&request, &model).unwrap();
        let inputs: Vec<(&str, &str)> =
            followed.inputs.iter().map(|i| (i.name.as_str(), i.unit.as_str())).collect();
        assert_eq!(inputs, [("u", "1"), ("T_amb", "K")]);
        assert_eq!(
            with_followed(&Request::new("lag.toml", ["monday.csv"]), &model).unwrap(),
            model
        );
    }
}
