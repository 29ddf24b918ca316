//! The documentation is true: its examples are read as they are printed.

use fdiag::spec::PipelineSpec;

#[test]
fn the_example_of_the_spec_page_is_a_spec() {
    let page = include_str!("../../../docs/spec.md");
    let blocks: Vec<&str> =
        page.split("```toml\n").skip(1).filter_map(|rest| rest.split("```").next()).collect();
    assert!(!blocks.is_empty(), "the page has an example");
    for block in blocks {
        let spec: PipelineSpec = toml::from_str(block).unwrap();
        let again: PipelineSpec = toml::from_str(&toml::to_string(&spec).unwrap()).unwrap();
        assert_eq!(again, spec);
    }
}

#[test]
fn the_spec_of_the_gas_turbine_is_a_spec() {
    let text = include_str!("../../../examples/micro-gas-turbine/spec.toml");
    assert!(toml::from_str::<PipelineSpec>(text).is_ok());
}
