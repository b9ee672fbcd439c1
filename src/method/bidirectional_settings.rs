//! What the parameters of the methods that make paths from two ends come to, and what follows from it for all of them.

use std::sync::Arc;

use super::bidirectional_pass::BidirectionalPasses;
use super::parameter_values::{
    All, Auto, Depth, Emission, LightPicks, PathLength, RouletteDepth, Subpaths, Switch, limits,
};
use super::visibility_pilot::LightSampling;
use super::{Contradiction, PreparedMethod, SceneTraits, Strategy};
use crate::scene::Scene;
use crate::transport::Limits;
use crate::transport::bidirectional::{Heuristic, Measure, Selection, Show, Techniques, Weighting};
use crate::transport::kernel::Kernel;
use crate::transport::light_trials::SamplingVertices;
use crate::transport::occlusion::Occlusion;

/// The longest path that a strategy may be given of, in segments.
const LONGEST: u32 = 65_535;

/// What passes of these methods do.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PassSettings {
    /// Ways of finding paths.
    pub techniques: Techniques,
    /// How techniques share a path.
    pub heuristic: Heuristic,
    /// In which measure their densities are compared.
    pub measure: Measure,
    /// Limits on whole paths.
    pub limits: Limits,
    /// Which paths count.
    pub selection: Selection,
    /// How vertices are merged, where they are.
    pub merging: MergeSettings,
    /// How lights are picked for light subpaths.
    pub emission: Emission,
    /// Whether as many photons again, which are only merged, are states of chains that stay where camera subpaths look.
    pub chains: bool,
}

/// How vertices are merged.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MergeSettings {
    /// First radius, m.
    pub first_radius: Auto<f32>,
    /// How photons count by their distance.
    pub kernel: Kernel,
    /// Only so many photons are merged with a vertex; 0 for all within the radius.
    pub neighbors: u32,
    /// Which photons count only where their origin is seen.
    pub occlusion: Occlusion,
}

impl MergeSettings {
    /// All photons within the radius count alike.
    pub(crate) fn discs(first_radius: Auto<f32>, occlusion: Occlusion) -> Self {
        Self { first_radius, kernel: Kernel::Disc, neighbors: 0, occlusion }
    }
}

/// Which paths are made and counted.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Paths {
    /// Longest path.
    pub max_depth: Depth,
    /// Where roulette begins.
    pub rr_depth: RouletteDepth,
    /// Their length.
    pub length: All<PathLength>,
    /// Their strategy.
    pub strategy: All<Subpaths>,
    /// What is seen of them.
    pub show: Show,
}

impl PassSettings {
    /// `techniques` on `paths`, by the balance heuristic and without merging.
    pub(crate) fn new(techniques: Techniques, paths: &Paths) -> Self {
        let length = paths.length.only().map(PathLength::get);
        let limits = limits(paths.max_depth, paths.rr_depth);
        // Longer paths than those that are looked at need not be traced.
        let limits = Limits { max_depth: limits.max_depth.into_iter().chain(length).min(), ..limits };
        let strategy = paths.strategy.only().map(|Subpaths { light, camera }| [light, camera]);
        let selection = Selection { length, strategy, show: paths.show };
        let (heuristic, measure) = (Heuristic::Balance, Measure::Area);
        let merging = MergeSettings::discs(Auto::Auto, Occlusion::Off);
        let (emission, chains) = (Emission::Power, false);
        Self { techniques, heuristic, measure, limits, selection, merging, emission, chains }
    }

    /// Whether any of `techniques` is in use.
    pub(crate) fn uses(&self, techniques: Techniques) -> bool {
        self.techniques.any(techniques)
    }

    /// How the techniques share paths when there are `light_paths` a pass.
    pub(crate) fn weighting(&self, light_paths: u32) -> Weighting {
        let Self { techniques, heuristic, measure, .. } = *self;
        Weighting { techniques, heuristic, measure, light_paths: light_paths as f32 }
    }

    /// Makes passes of a scene ready.
    pub(crate) fn prepare(self, scene: Arc<Scene>, light_paths: u32, seed: u64) -> Box<dyn PreparedMethod> {
        Box::new(BidirectionalPasses::new(scene, self, light_paths, seed))
    }

    /// How lights are sampled: at all vertices of camera subpaths.
    pub(crate) fn light_sampling(&self, picks: LightPicks) -> LightSampling {
        LightSampling { picks, vertices: SamplingVertices::All, limits: self.limits }
    }

    /// The strategies of the paths that count, else of all from 2 to `longest` segments.
    pub(crate) fn strategies(&self, longest: u32) -> Vec<Strategy> {
        let Self { techniques, limits, selection, .. } = *self;
        let lengths = selection.length.map_or(2..=longest, |length| length..=length);
        let of_length = |segments: u32| {
            let pairs = techniques
                .strategies(segments)
                .filter(move |[light, camera]| selection.takes(segments, *light, *camera));
            pairs.map(move |[light, camera]| Strategy { segments, light, camera })
        };
        lengths.filter(|segments| limits.allows(*segments)).flat_map(of_length).collect()
    }

    /// Why no path counts, if `length` and `strategy` leave none.
    pub(crate) fn contradiction(&self) -> Option<Contradiction> {
        let Self { limits, selection, .. } = *self;
        if let (Some(length), Some(limit)) = (selection.length, limits.max_depth)
            && length > limit
        {
            let problem = format!("\"length\" is {length}, and \"max_depth\" allows {limit} segments");
            return Some(Contradiction { problem, remedy: format!("give a length of at most {limit}") });
        }
        match (selection.strategy, selection.length) {
            (None, None) => None,
            (None, Some(length)) => {
                let found = length == 1 || self.techniques.strategies(length).next().is_some();
                let problem = format!("no paths of {length} segments are found");
                let remedy = "switch a way of finding them on".to_owned();
                (!found).then_some(Contradiction { problem, remedy })
            }
            (Some(strategy), _) => (!self.finds(strategy)).then(|| self.no_such_strategy(strategy)),
        }
    }

    /// Whether any path has the strategy, of the length and within the limit.
    fn finds(&self, [light, camera]: [u32; 2]) -> bool {
        let vertices = u64::from(light) + u64::from(camera);
        // Connected vertices make one segment fewer, merged ones as many.
        let lengths =
            [vertices.saturating_sub(1), vertices].map(|segments| u32::try_from(segments).unwrap_or(u32::MAX));
        lengths.into_iter().any(|segments| {
            let counts = self.limits.allows(segments) && self.selection.takes(segments, light, camera);
            counts && segments <= LONGEST && self.techniques.strategies(segments).any(|pair| pair == [light, camera])
        })
    }

    fn no_such_strategy(&self, [light, camera]: [u32; 2]) -> Contradiction {
        let Self { techniques, limits, selection, .. } = *self;
        let vertices = u64::from(light) + u64::from(camera);
        let nearest = vertices.clamp(3, 6) as u32 - 1;
        let segments = selection.length.unwrap_or(limits.max_depth.map_or(nearest, |limit| nearest.min(limit)));
        let known: Vec<String> =
            techniques.strategies(segments).take(8).map(|[light, camera]| format!("{light},{camera}")).collect();
        let of_length = selection.length.map_or(String::new(), |length| format!(" of {length} segments"));
        Contradiction {
            problem: format!("no path{of_length} is found with the strategy {light},{camera}"),
            remedy: format!("those of {segments} segments are {}", known.join(" ")),
        }
    }
}

/// The techniques of `bdpm` and `pbdpm`: merging, and what `light_hits` and `camera_hits` add to it.
pub(crate) fn photon_techniques(light_hits: Switch, camera_hits: Switch) -> Techniques {
    Techniques::MERGE.with(Techniques::HIT, light_hits.is_on()).with(Techniques::CAMERA, camera_hits.is_on())
}

/// Light that no connection finds.
pub(crate) fn blind_without_merging(traits: SceneTraits) -> Option<&'static str> {
    (traits.point_lights && traits.specular).then_some(
        "light that mirrors and glass throw from point, spot and directional lights, where it is seen in mirrors or through \
         glass; sppm and vcm do",
    )
}
