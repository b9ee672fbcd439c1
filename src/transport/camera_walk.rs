//! Camera paths: from the lens through specular surfaces to the first one where photons are stored.

use crate::math::random::{PathRandom, dimension};
use crate::math::{Rgb, Vec3};
use crate::scene::Scene;
use crate::scene::geometry::{Interaction, Ray};
use crate::scene::material::TransportMode;

use super::counters::Counters;
use super::limits::Limits;
use super::shading::{self, Scattering};

/// Where a camera path meets the first surface with a smooth lobe.
#[derive(Clone, Copy, Debug)]
pub struct GatherPoint {
    /// The surface.
    pub hit: Interaction,
    /// What radiance from here is multiplied with on its way to the camera.
    pub throughput: Rgb,
    /// Segments from the camera to here.
    pub segments: u32,
    /// Length of the path from the camera to here, m.
    pub path_length: f32,
}

impl GatherPoint {
    /// The true normal on the side from which the camera sees the surface.
    #[inline]
    pub fn facing_normal(&self) -> Vec3 {
        let normal = self.hit.geometric_normal;
        if self.hit.outgoing.dot(normal) < 0.0 { -normal } else { normal }
    }
}

/// A camera path on its way.
#[derive(Clone, Copy, Debug)]
pub struct CameraWalk {
    /// The next segment.
    pub ray: Ray,
    /// What radiance from the next vertex is multiplied with.
    pub throughput: Rgb,
    /// Segments before the next one.
    pub segments: u32,
    /// Length so far, m.
    pub path_length: f32,
    /// Product of squared relative indices: undoes refraction's scaling of radiance when roulette judges a path.
    index_squared: f32,
}

/// What the next vertex of a camera path is.
pub enum CameraVertex {
    /// The path left the scene or was absorbed.
    End,
    /// A surface with a smooth lobe: gather here.
    Gather(GatherPoint),
    /// A purely specular surface: go on.
    Specular(Interaction),
}

impl CameraWalk {
    /// A path that starts with a camera ray.
    pub fn new(ray: Ray) -> Self {
        Self { ray, throughput: Rgb::ONE, segments: 0, path_length: 0.0, index_squared: 1.0 }
    }

    /// Traces the next segment; emission that it sees is added to `radiance`.
    #[inline]
    pub fn advance(
        &mut self,
        scene: &Scene,
        limits: &Limits,
        radiance: &mut Rgb,
        counters: &mut Counters,
    ) -> CameraVertex {
        if !limits.allows(self.segments + 1) {
            return CameraVertex::End;
        }
        self.segments += 1;
        counters.rays += 1;
        let Some(hit) = scene.geometry.intersect(&self.ray) else {
            if let Some((environment, _)) = scene.lights.environment() {
                *radiance += self.throughput * environment;
            }
            return CameraVertex::End;
        };
        if let Some((emitted, _)) = scene.lights.emitted(&scene.geometry, self.ray.origin, &hit) {
            *radiance += self.throughput * emitted;
        }
        self.path_length += hit.distance;
        if !scene.material(hit.shape).lobes().smooth {
            return CameraVertex::Specular(hit);
        }
        let Self { throughput, segments, path_length, .. } = *self;
        CameraVertex::Gather(GatherPoint { hit, throughput, segments, path_length })
    }

    /// Goes on after a scattering.
    #[inline]
    pub fn follow(&mut self, hit: &Interaction, scattering: &Scattering) {
        self.throughput *= scattering.weight;
        let index = scattering.sample.relative_index;
        self.index_squared *= index * index;
        self.ray = hit.ray_to(scattering.direction);
    }

    /// Plays roulette with `u`; false ends the path.
    #[inline]
    pub fn survives(&mut self, limits: &Limits, u: f32) -> bool {
        let kept = self.throughput.max_element() * self.index_squared;
        let survival = limits.survival(self.segments, kept);
        if u >= survival {
            return false;
        }
        self.throughput /= survival;
        true
    }
}

/// Walks to the first surface with a smooth lobe, one random lobe at each specular one; adds emission seen on the way.
#[inline]
pub fn walk_to_gather_point(
    scene: &Scene,
    mut walk: CameraWalk,
    random: &PathRandom,
    limits: &Limits,
    radiance: &mut Rgb,
    counters: &mut Counters,
) -> Option<GatherPoint> {
    loop {
        let hit = match walk.advance(scene, limits, radiance, counters) {
            CameraVertex::End => return None,
            CameraVertex::Gather(point) => return Some(point),
            CameraVertex::Specular(hit) => hit,
        };
        let u = random.block(dimension::scattering(walk.segments));
        let scattering =
            shading::scatter(&hit, scene.material(hit.shape), TransportMode::Radiance, [u[0], u[1], u[2]])?;
        walk.follow(&hit, &scattering);
        if !walk.survives(limits, u[3]) {
            return None;
        }
    }
}
