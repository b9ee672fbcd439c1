//! Tracing new vertices of a path.

use super::light_end::LightEnd;
use super::lobe_choice::{Lobe, LobeChoice};
use super::path::{Path, PathVertex, Terms};
use crate::math::{Vec2, Vec3};
use crate::scene::Scene;
use crate::scene::geometry::{Interaction, Ray};
use crate::scene::material::{Lobes, TransportMode, View};
use crate::transport::Counters;
use crate::transport::metropolis::mutation::Source;
use crate::transport::shading;
use crate::transport::visibility::SHADOW_END;

/// Makes new vertices.
pub(crate) struct Tracer<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// What it took.
    pub counters: &'a mut Counters,
    /// Vertices that it makes one after the other.
    pub chain: &'a mut Vec<PathVertex>,
}

/// Where a camera subpath came to.
pub(crate) enum Arrival {
    /// A surface.
    Surface(Interaction),
    /// Outside of the scene, in this direction.
    Outside(Vec3),
}

impl Tracer<'_> {
    /// Where a ray meets a surface.
    pub(crate) fn surface(&mut self, ray: &Ray) -> Option<Interaction> {
        self.counters.rays += 1;
        self.scene.intersect(ray)
    }

    /// Where the camera's ray through a place of the film meets a surface.
    pub(crate) fn seen(&mut self, film: Vec2, lens: [f32; 2]) -> Option<Interaction> {
        self.counters.rays += 1;
        self.scene.intersect_from_camera(&self.scene.camera.ray(film, lens))
    }

    /// Whether nothing lies between x_{index} and x_{index+1} of a path whose vertices are surfaces, the light or the camera.
    pub(crate) fn is_open(&mut self, path: &Path, terms: &Terms, index: usize) -> bool {
        self.counters.rays += 1;
        let from = |vertex: usize| &path.vertices[vertex - 1].hit;
        if index == 0 {
            let (hit, first) = (from(1), &terms.first);
            let origin = hit.offset_towards(first.direction);
            let ray = Ray { origin, direction: first.direction, length: first.distance * SHADOW_END };
            return !self.scene.geometry.is_blocked(&ray);
        }
        let (hit, direction) = (from(index), terms.vertices[index - 1].camera_direction);
        let origin = hit.offset_towards(direction);
        if index + 1 == path.segments() {
            let ray = Ray { origin, direction, length: terms.visible_distance * SHADOW_END };
            return !self.scene.is_hidden_from_camera(&ray);
        }
        // Both ends are moved off their surfaces: short connections in corners carry much.
        let between = from(index + 1).offset_towards(-direction) - origin;
        let length = between.length();
        !self.scene.geometry.is_blocked(&Ray { origin, direction: between / length, length: length * SHADOW_END })
    }

    /// Picks how a path goes on from `vertex`, to which it came from the direction `back`; says so there. The new direction.
    pub(crate) fn scatter(
        &mut self,
        vertex: &mut PathVertex,
        back: Vec3,
        mode: TransportMode,
        source: &mut Source,
    ) -> Option<Vec3> {
        let u = [0; 4].map(|_| source.number());
        let hit = &vertex.hit;
        let view = View { point: hit.texture_point(), outgoing: hit.frame.to_local(back), mode, lobes: Lobes::ALL };
        if let Some(specular) = LobeChoice::new(self.scene, hit.shape, &view).pick(u[3]) {
            vertex.lobe = Lobe::Specular;
            return Some(hit.frame.to_world(specular.direction));
        }
        vertex.lobe = Lobe::Smooth;
        let sample = self.scene.material(hit.shape).sample(&view.of(Lobes::SMOOTH), [u[0], u[1], u[2]])?;
        let arrived = Interaction { outgoing: back, ..*hit };
        Some(shading::finish(&arrived, &view, sample)?.direction)
    }

    /// Appends `count` vertices that a light subpath goes on to behind x_{l−1}, the last of `path`; l is at least 2.
    pub(crate) fn extend_from_light(
        &mut self,
        path: &mut Vec<PathVertex>,
        light: &LightEnd,
        count: usize,
        source: &mut Source,
    ) -> Option<()> {
        for _ in 0..count {
            let before = match path.len() {
                1 => None,
                length => Some(path[length - 2].hit.position),
            };
            let last = path.last_mut()?;
            let back = match before {
                Some(before) => (before - last.hit.position).normalize(),
                None => light.segment(self.scene, last.hit.position)?.direction,
            };
            let direction = self.scatter(last, back, TransportMode::Flux, source)?;
            let ray = last.hit.ray_to(direction);
            let hit = self.surface(&ray)?;
            path.push(PathVertex { hit, lobe: Lobe::Smooth });
        }
        Some(())
    }

    /// Where a camera subpath goes on to from the last vertex of its chain, to which it came from the direction `back`.
    pub(crate) fn extend_from_camera(&mut self, back: Vec3, source: &mut Source) -> Option<Arrival> {
        let mut last = *self.chain.last()?;
        let direction = self.scatter(&mut last, back, TransportMode::Radiance, source)?;
        *self.chain.last_mut()? = last;
        let ray = last.hit.ray_to(direction);
        Some(self.surface(&ray).map_or(Arrival::Outside(direction), Arrival::Surface))
    }

    /// Follows `ray` by specular lobes alone to a surface where the path does not follow one, and makes all vertices its chain. The path carries light
    /// in this direction in [`TransportMode::Flux`], else importance.
    pub(crate) fn follow_specular(&mut self, ray: &Ray, mode: TransportMode, source: &mut Source) -> Option<()> {
        let hit = self.surface(ray)?;
        self.follow_specular_from(hit, mode, source)
    }

    /// The same from where the ray met a surface.
    pub(crate) fn follow_specular_from(
        &mut self,
        mut hit: Interaction,
        mode: TransportMode,
        source: &mut Source,
    ) -> Option<()> {
        self.chain.clear();
        for _ in 0..MOST_SPECULAR {
            let choice = LobeChoice::new(self.scene, hit.shape, &View::at(&hit, mode)).pick(source.number());
            let Some(specular) = choice else {
                self.chain.push(PathVertex { hit, lobe: Lobe::Smooth });
                return Some(());
            };
            self.chain.push(PathVertex { hit, lobe: Lobe::Specular });
            let ray = hit.ray_to(hit.frame.to_world(specular.direction));
            hit = self.surface(&ray)?;
        }
        None
    }
}

/// Chains of mirrors and glass that are longer end without a path.
const MOST_SPECULAR: usize = 64;
