//! Where `photon_map` looks for photons, as its pilot sees it: caustics where the camera looks, all others where gather rays end.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use super::parameter_values::{Auto, DirectLight, Emission};
use super::photon_pass::PhotonPasses;
use super::pilot::PilotView;
use crate::math::Rgb;
use crate::math::random::{PassRandom, PathRandom, dimension};
use crate::scene::Scene;
use crate::transport::camera_walk::{CameraWalk, GatherPoint, trace_camera_path};
use crate::transport::direct_light::direct_light;
use crate::transport::emission_learning::GuideParts;
use crate::transport::occlusion::Occlusion;
use crate::transport::{Counters, Limits, shading};

/// One new camera path per pixel, with one gather ray.
pub(crate) struct GatherEnds<'a> {
    /// The scene.
    pub scene: &'a Arc<Scene>,
    /// Limits on path length.
    pub limits: Limits,
    /// Whether photons are looked for where rays end; else where the camera path does.
    pub gathers: bool,
    /// Numbers of the paths.
    pub random: PassRandom,
}

impl GatherEnds<'_> {
    /// Where photons should start for these places, as numbers of a guide; the inner `None`: by power. The outer: cancelled.
    pub(crate) fn learn(
        &self,
        seed: u64,
        photons_per_pass: u32,
        (emission, occlusion): (Emission, Occlusion),
        cancel: &AtomicBool,
    ) -> Option<Option<Vec<f32>>> {
        if emission == Emission::Power {
            return Some(None);
        }
        let passes = PhotonPasses {
            scene: self.scene.clone(),
            seed,
            limits: self.limits,
            direct: DirectLight::Photons,
            follows_narrow: true,
            photons_per_pass,
            first_radius: Auto::Auto,
            chains: false,
            emission,
            guide_parts: GuideParts::Cells,
            occlusion,
        };
        Some(passes.pilot(self, cancel)?.guide)
    }

    /// Shows where a ray from `from` finds photons.
    fn gather(
        &self,
        from: &GatherPoint,
        random: &PathRandom,
        counters: &mut Counters,
        visit: &mut dyn FnMut(&GatherPoint, &PathRandom, &mut Counters),
    ) {
        let random = random.branch(0);
        let u = random.block(dimension::scattering(from.segments));
        let material = self.scene.material(from.hit.shape);
        let Some(scattering) = shading::scatter(&from.hit, material, &from.view(), [u[0], u[1], u[2]]) else { return };
        let mut walk = CameraWalk::gathering(self.scene, from, &scattering);
        if !walk.walk.survives(&self.limits, u[3]) {
            return;
        }
        // What the ray sees is direct light or a caustic where it began.
        let mut unused = Rgb::ZERO;
        trace_camera_path(self.scene, walk, &random, &self.limits, &mut unused, counters, |at, _, counters| {
            if !at.goes_on {
                visit(at, &random, counters);
            }
        });
    }
}

impl PilotView for GatherEnds<'_> {
    // The method looks for the nearest photons.
    const ALL_RADII: bool = false;

    fn visit(
        &self,
        pixel: usize,
        counters: &mut Counters,
        visit: &mut dyn FnMut(&GatherPoint, &PathRandom, &mut Counters),
    ) -> Rgb {
        let Self { scene, limits, gathers, .. } = self;
        let random = self.random.path(pixel as u32);
        let place = [pixel as u32 % scene.width, pixel as u32 / scene.width];
        let walk = CameraWalk::new(scene, scene.camera_ray(place, random.block(dimension::CAMERA)), true);
        let mut seen = Rgb::ZERO;
        trace_camera_path(scene, walk, &random, limits, &mut seen, counters, |at, seen, counters| {
            if limits.allows(at.segments + 1) {
                *seen += at.throughput * direct_light(scene, at, &random, counters);
            }
            if at.goes_on || *gathers {
                visit(&GatherPoint { goes_on: true, ..*at }, &random, counters);
            }
            match (at.goes_on, *gathers) {
                (true, _) => {}
                (false, true) => self.gather(at, &random, counters, visit),
                (false, false) => visit(at, &random, counters),
            }
        });
        seen
    }

    fn radius_point(&self, pixel: usize, counters: &mut Counters) -> Option<GatherPoint> {
        let mut last = None;
        self.visit(pixel, counters, &mut |point, _, _| last = Some(*point));
        last
    }
}
