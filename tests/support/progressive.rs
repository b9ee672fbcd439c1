//! Jobs run on this machine, as a farm with one worker would run them: pilot, epochs of passes, merge.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use photonfarm::estimate::{Estimate, Region, Shard};
use photonfarm::import::load_file;
use photonfarm::method::{CheckedMethod, MethodChoice, check, declaration};
use photonfarm::render::Renderer;
use photonfarm::scene::Scene;

/// A scene with a method, ready to be traced.
pub(crate) struct Job {
    pub(crate) scene: Arc<Scene>,
    pub(crate) method: CheckedMethod,
    pub(crate) renderer: Renderer,
    pub(crate) never: AtomicBool,
}

/// A job whose pilot is done.
pub(crate) struct Begun {
    pub(crate) estimate: Estimate,
    /// It traces the passes: photons start where the pilot found that they should.
    pub(crate) renderer: Renderer,
}

/// The folder of a reference picture.
pub(crate) fn reference_folder(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/references").join(name)
}

/// The scene of a reference picture.
pub(crate) fn reference_scene(name: &str) -> Arc<Scene> {
    let description = load_file(&reference_folder(name).join("scene.xml"), &[]).expect("a reference scene loads");
    Arc::new(Scene::prepare(&description).expect("a reference scene is good"))
}

impl Job {
    /// A job with seed 1; `parameters` is a JSON object.
    pub(crate) fn new(scene: &Arc<Scene>, method: &str, parameters: &str) -> Self {
        Self::with_seed(scene, method, parameters, 1)
    }

    /// The same with any seed.
    pub(crate) fn with_seed(scene: &Arc<Scene>, method: &str, parameters: &str, seed: u64) -> Self {
        let parameters = serde_json::from_str(parameters).expect("parameters are a JSON object");
        let choice = MethodChoice { name: method.to_owned(), parameters };
        let method = check(&choice, scene.pixel_count() as u64).expect("the parameters are good");
        let renderer = Renderer::new(scene.clone(), &method, seed).expect("the method can be prepared");
        Self { scene: scene.clone(), method, renderer, never: AtomicBool::new(false) }
    }

    /// The whole picture.
    pub(crate) fn region(&self) -> Region {
        Region { row_start: 0, row_end: self.scene.height }
    }

    /// The estimate after the pilot and before the first pass.
    pub(crate) fn begin(&self) -> Begun {
        let pilot = self.renderer.pilot(&self.never).expect("nobody cancels");
        let renderer = self.renderer.guided(&pilot.guides()).expect("the pilot fits the lights");
        let (width, height) = (self.scene.width, self.scene.height);
        let declaration = declaration(&self.method);
        let estimate = Estimate::new(width, height, &[self.region()], declaration, pilot.radius_squared());
        Begun { estimate: estimate.expect("the pilot fits"), renderer }
    }

    /// Traces `passes` passes and merges them. The passes of an epoch are shards of one pass with the same radius field.
    pub(crate) fn run(&self, passes: u32, epoch: u32) -> Estimate {
        let Begun { mut estimate, renderer } = self.begin();
        for start in (0..passes).step_by(epoch as usize) {
            let field = estimate.radius_field(self.region());
            for first_pass in start..passes.min(start + epoch) {
                let shard = Shard { first_pass, passes: 1, region: self.region() };
                let tally = renderer.trace(shard, &field, &self.never).expect("nobody cancels");
                estimate.merge(&tally, &field).expect("tallies come in order");
            }
        }
        estimate
    }
}
