//! Sites of a model as inputs.

use fd_model::Channel;

use super::splice::Patch;
use crate::{
    equation::Expr,
    model::{Input, Model},
    simulate::Port,
};

/// The model with an input for the force at each of its sites, and the name of that input next to
/// its port.
pub(crate) fn open_ports(model: &Model) -> (Model, Vec<(String, Port)>) {
    let mut patch = Patch::of(model);
    let mut ports = Vec::new();
    for site in &model.sites {
        let name = patch.fresh_name(&format!("{}_force", site.name));
        patch.add_input(Input { name: name.clone(), unit: site.unit.clone(), saturation: None });
        if patch.add_force_term(&site.name, &Expr::name(&name)).is_err() {
            continue; // a site of a checked model is known
        }
        ports.push((name, Port { channel: Channel::new(&site.name, &site.unit) }));
    }
    match patch.finish() {
        Ok(open) => (open, ports),
        // Fresh names and sites of a checked model make a correct one.
        Err(_) => (model.clone(), Vec::new()),
    }
}
