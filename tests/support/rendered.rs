//! Pictures of a few passes on this machine.

use std::sync::Arc;

use photonfarm::estimate::Picture;
use photonfarm::evaluation::Run;
use photonfarm::method::{self, MethodChoice};
use photonfarm::scene::Scene;
use serde_json::{Map, Value};

/// The picture of `scene` after `passes` passes of the method `name`, with parameters and a seed.
pub(crate) fn rendered(
    scene: &Arc<Scene>,
    name: &str,
    parameters: Map<String, Value>,
    passes: u32,
    seed: u64,
) -> Picture {
    let choice = MethodChoice { name: name.to_owned(), parameters };
    let checked = method::check(&choice, scene.pixel_count() as u64).expect("the parameters are good");
    let mut run = Run::start(scene, &checked, seed).expect("the method can be prepared");
    while run.passes() < passes {
        run.pass().expect("a pass is traced");
    }
    run.picture()
}

/// The parameters that keep passes of the method `name` short: 8192 photons, where it takes them.
pub(crate) fn few_photons(name: &str) -> Map<String, Value> {
    let known = method::entry(name).expect("in the table").parameters;
    let takes = known.iter().any(|parameter| parameter.name == "photons_per_pass");
    takes.then(|| ("photons_per_pass".to_owned(), 8192.into())).into_iter().collect()
}
