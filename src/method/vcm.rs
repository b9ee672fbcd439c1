//! `vcm`: vertex connection and merging. Everything that `bdpt` and `pbdpm` do, with weights that know all of it. With `merge: off` it
//! is `bdpt`, with `connect: off` it is `pbdpm` without photons that the camera sees.
//!
//! References: \[G+12\] Georgiev, Křivánek, Davidovič & Slusallek 2012, "Light transport simulation with vertex connection and
//! merging"; \[G12\] Georgiev 2012, "Implementing vertex connection and merging".
//!
//! | symbol | here | unit |
//! |---|---|---|
//! | s, t | vertices of the light and of the camera subpath | – |
//! | η | `Weighting::acceptance`, π r² n | – |
//! | d | `Sums` [G12, eqs. 31–36] | – |
//!
//! Limits: it does the work of both methods in every pass, which pays where neither alone finds all light well.

use std::sync::Arc;

use super::bidirectional_settings::{MergeSettings, PassSettings, Paths};
use super::parameter_values::{
    All, Auto, Depth, Emission, LightPicks, MergingRadiusRule, OpenUnit, Passes, PathLength, PhotonCount,
    PhotonEmission, Radius, RouletteDepth, Subpaths, Switch,
};
use super::parameters::{ParameterSet, parameter, parameters, read_method};
use super::shared_parameters::{
    ALPHA, HEURISTIC, LENGTH, LIGHT_PICKS, LIGHT_SUBPATHS, MAX_DEPTH, MERGING_RADIUS, MERGING_RADIUS_RULE, OCCLUSION,
    PASSES, SHOW, STRATEGY, SUBPATH_RR_DEPTH,
};
use super::visibility_pilot::LightSampling;
use super::{Bias, Contradiction, Gathering, MethodEntry, ParameterizedMethod, PreparedMethod, SceneTraits, Strategy};
use crate::scene::Scene;
use crate::transport::bidirectional::{Heuristic, Show, Techniques};
use crate::transport::counters::Step;
use crate::transport::occlusion::Occlusion;

/// The row of the table.
pub(crate) const ENTRY: MethodEntry = MethodEntry {
    name: "vcm",
    also_called: &["upm", "vertex_merging", "vertex_connection_and_merging"],
    summary: "vertex connection and merging: bdpt and pbdpm in one",
    cannot_sample: "nothing but light of point, spot and directional lights that only mirrors and glass reflect to the camera",
    reference: "Georgiev et al. 2012",
    bias: Bias::TakenOver,
    parameters: Parameters::HELP,
    negative_lobes: true,
    media: false,
    read: read_method::<Parameters>,
};

parameters! {
    /// Parameters of `vcm`.
    struct Parameters {
        connect: Switch = parameter("whether vertices are connected", Switch::On, "on"),
        merge: Switch = parameter("whether vertices are merged", Switch::On, "on"),
        alpha: OpenUnit = ALPHA,
        radius_rule: MergingRadiusRule = MERGING_RADIUS_RULE,
        photons_per_pass: Auto<PhotonCount> = LIGHT_SUBPATHS,
        initial_radius: Auto<Radius> = MERGING_RADIUS,
        occlusion: Occlusion = OCCLUSION,
        heuristic: Heuristic = HEURISTIC,
        strategy: All<Subpaths> = STRATEGY,
        show: Show = SHOW,
        light_picks: LightPicks = LIGHT_PICKS,
        emission: PhotonEmission = parameter(
            "how a light is picked for light subpaths and photons: by power; guided, mostly where they reach what pixels see, weighted \
             for it; auto: guided where the pilot finds that it helps; metropolis: as auto, and as many photons again to merge with, in \
             chains of whole paths that stay where the picture looks, weighted for it",
            PhotonEmission::Auto,
            "auto",
        ),
        max_depth: Depth = MAX_DEPTH,
        rr_depth: RouletteDepth = SUBPATH_RR_DEPTH,
        length: All<PathLength> = LENGTH,
        passes: Passes = PASSES,
    }
}

impl Parameters {
    /// What passes do.
    fn settings(&self) -> PassSettings {
        let techniques = match self.connect.is_on() {
            true => Techniques::ALL_CONNECTIONS,
            false => Techniques::HIT,
        };
        let techniques = techniques.with(Techniques::MERGE, self.merge.is_on());
        let Self { max_depth, rr_depth, length, strategy, show, .. } = *self;
        let paths = Paths { max_depth, rr_depth, length, strategy, show };
        let merging = MergeSettings::discs(self.initial_radius.meters(), self.occlusion);
        PassSettings {
            heuristic: self.heuristic,
            merging,
            emission: self.emission.of_paths(),
            chains: self.emission == PhotonEmission::Metropolis,
            ..PassSettings::new(techniques, &paths)
        }
    }
}

impl ParameterizedMethod for Parameters {
    fn settle_photons(&mut self, pixels: u64) -> u32 {
        match self.merge.is_on() {
            true => self.photons_per_pass.settle(pixels),
            false => self.photons_per_pass.settle_to_pixels(pixels),
        }
    }

    fn passes(&self) -> u32 {
        self.passes.get()
    }

    fn gathering(&self) -> Gathering {
        match self.merge.is_on() {
            true => Gathering::ShrinkingDiscs { rule: self.radius_rule.into(), alpha: self.alpha.get() },
            false => Gathering::Nothing,
        }
    }

    fn bias(&self, usual: Bias) -> Bias {
        match (self.connect.is_on(), self.merge.is_on()) {
            (true, true) => usual,
            // Nothing takes over from what is merged.
            (false, true) => Bias::Shrinks,
            (_, false) => Bias::None,
        }
    }

    fn blind_to(&self, traits: SceneTraits) -> Option<&'static str> {
        (!self.merge.is_on() && traits.point_lights && traits.specular).then_some(
            "light that mirrors and glass throw from point, spot and directional lights, where it is seen in mirrors or through \
             glass; merge: on does",
        )
    }

    fn strategies(&self, longest: u32) -> Option<Vec<Strategy>> {
        Some(self.settings().strategies(longest))
    }

    fn light_sampling(&self) -> Option<LightSampling> {
        self.connect.is_on().then(|| self.settings().light_sampling(self.light_picks))
    }

    fn may_guide_photons(&self) -> bool {
        self.emission.of_paths() != Emission::Power
    }

    fn proposals(&self) -> &'static [Step] {
        self.emission.proposals()
    }

    fn contradiction(&self) -> Option<Contradiction> {
        if self.emission == PhotonEmission::Metropolis && !self.merge.is_on() {
            let problem = "\"emission\" is \"metropolis\", which makes photons to merge with, and \"merge\" is \"off\""
                .to_owned();
            return Some(Contradiction { problem, remedy: "switch merge on, or give another emission".to_owned() });
        }
        self.settings().contradiction()
    }

    fn prepare(&self, scene: Arc<Scene>, photons_per_pass: u32, seed: u64) -> Box<dyn PreparedMethod> {
        self.settings().prepare(scene, photons_per_pass, seed)
    }
}
