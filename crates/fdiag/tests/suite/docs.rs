//! The documentation is true: its examples are read as they are printed.

use fdiag::spec::{
    DetectorSpec, GeneratorSpec, IsolationSpec, LearningSpec, PipelineSpec, StructureSpec,
    testing::kinds,
};

#[test]
fn the_example_of_the_spec_page_is_a_spec() {
    let page = include_str!("../../../../docs/spec.md");
    let blocks: Vec<&str> =
        page.split("```toml\n").skip(1).filter_map(|rest| rest.split("```").next()).collect();
    assert!(!blocks.is_empty(), "the page has an example");
    for block in blocks {
        let spec: PipelineSpec = block.parse().unwrap();
        let again: PipelineSpec = toml::to_string(&spec).unwrap().parse().unwrap();
        assert_eq!(again, spec);
    }
}

/// Whatever a spec may say is on the page of specs.
#[test]
fn the_spec_page_names_every_kind() {
    let page = include_str!("../../../../docs/spec.md");
    let all = [
        kinds::<GeneratorSpec>(),
        kinds::<LearningSpec>(),
        kinds::<StructureSpec>(),
        kinds::<DetectorSpec>(),
        kinds::<IsolationSpec>(),
    ];
    assert!(all.iter().all(|kinds| kinds.len() > 2), "{all:?}");
    for kind in all.concat() {
        assert!(page.contains(&format!("`{kind}`")), "docs/spec.md does not name `{kind}`");
    }
}

#[test]
fn the_spec_of_the_gas_turbine_is_a_spec() {
    let text = include_str!("../../../../examples/micro-gas-turbine/spec.toml");
    assert!(text.parse::<PipelineSpec>().is_ok());
}
