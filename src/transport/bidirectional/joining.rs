//! Making one path of two subpaths.

use super::camera_walk::CameraWalk;
use super::light_walk::LightWalk;
use super::selection::{Selection, Show};
use super::stored_vertex::MergeRecord;
use super::vertex::{Vertex, densities};
use super::weights::{Sums, Weighting};
use crate::math::random::{Numbers, dimension};
use crate::math::{Rgb, Vec2, Vec3};
use crate::scene::Scene;
use crate::scene::geometry::Ray;
use crate::scene::geometry::surface::NO_LIGHT;
use crate::scene::material::TransportMode;
use crate::transport::kernel::Kernel;
use crate::transport::occlusion::{Occlusion, Sight};
use crate::transport::photon_map::{GatherQuery, Gathered, Nearest, PhotonLookup};
use crate::transport::receiver::{Counting, Receiver};
use crate::transport::visibility::{Blockers, Joint, SHADOW_END, transmittance};
use crate::transport::{Counters, shading};

/// The line along `ray` that leaves `vertex`.
#[inline]
fn joint<'a, N>(scene: &Scene, vertex: &Vertex, ray: Ray, blockers: Blockers, random: &'a N) -> Joint<'a, N> {
    let medium = scene.medium_beyond(&vertex.hit, ray.direction, vertex.medium);
    Joint { ray, medium, blockers, random, step: vertex.steps }
}

/// The line between two vertices in `direction`. Both ends are moved off their surfaces: short connections in corners carry much.
#[inline]
fn ray_between(from: &Vertex, to: &Vertex, direction: Vec3) -> Ray {
    let origin = from.hit.offset_towards(direction);
    let between = to.hit.offset_towards(-direction) - origin;
    let length = between.length();
    Ray { origin, direction: between / length, length: length * SHADOW_END }
}

/// Radiance by a sampled point of a light at a camera vertex [Veach 1997, 10.3: one light vertex].
#[inline]
pub fn direct_light(
    walk: &CameraWalk<'_>,
    camera: &Vertex,
    random: &impl Numbers,
    acceptance: f32,
    counters: &mut Counters,
) -> Rgb {
    let scene = walk.scene;
    let segments = camera.segments + 1;
    if !walk.limits.allows(segments) || !walk.selection.takes(segments, 1, camera.segments + 1) {
        return Rgb::ZERO;
    }
    let u = random.block(dimension::light(camera.steps));
    let place = scene.place(&camera.hit);
    let Some(light) = scene.lights.sample_direct(&scene.geometry, &place, [u[0], u[1], u[2]]) else { return Rgb::ZERO };
    let Some(reflected) = camera.reflect(scene, TransportMode::Radiance, light.direction) else { return Rgb::ZERO };
    let carried = camera.throughput * reflected.value * light.weighted_radiance;
    if carried == Rgb::ZERO {
        return Rgb::ZERO;
    }
    let origin = camera.hit.offset_towards(light.direction);
    let ray = Ray { origin, direction: light.direction, length: light.distance * SHADOW_END };
    let passing = transmittance(scene, &joint(scene, camera, ray, walk.blockers(), random), counters);
    if passing == Rgb::ZERO {
        return Rgb::ZERO;
    }
    let pdf = match walk.weighting.is_one_ended() {
        true => camera.forward_pdf(scene, &reflected),
        false => camera.pdf(scene, &reflected),
    };
    let weight = walk.weighting.direct(&camera.sums, pdf, reflected.cosine, &light, acceptance);
    walk.selection.shown(carried * passing, weight)
}

/// Radiance by connecting a camera vertex with the vertex of a light subpath [Veach 1997, 10.3: two light vertices or more].
#[inline]
pub fn connect(
    walk: &CameraWalk<'_>,
    camera: &Vertex,
    light: &Vertex,
    random: &impl Numbers,
    acceptance: f32,
    counters: &mut Counters,
) -> Rgb {
    let segments = camera.segments + light.segments + 1;
    let takes = walk.selection.takes(segments, light.segments + 1, camera.segments + 1);
    if !walk.limits.allows(segments) || !takes {
        return Rgb::ZERO;
    }
    let between = light.hit.position - camera.hit.position;
    let distance_squared = between.length_squared();
    let direction = between / distance_squared.sqrt();
    let Some(at_camera) = camera.reflect(walk.scene, TransportMode::Radiance, direction) else { return Rgb::ZERO };
    let Some(at_light) = light.reflect(walk.scene, TransportMode::Flux, -direction) else { return Rgb::ZERO };
    // Of the geometry factor one cosine is in each of the values.
    let carried = camera.throughput * at_camera.value * at_light.value * light.throughput / distance_squared;
    if !carried.is_finite() {
        return Rgb::ZERO;
    }
    let joint = joint(walk.scene, camera, ray_between(camera, light, direction), Blockers::All, random);
    let passing = transmittance(walk.scene, &joint, counters);
    if passing == Rgb::ZERO {
        return Rgb::ZERO;
    }
    let weight = walk.weighting.connection(
        [&camera.sums, &light.sums],
        [camera.pdf(walk.scene, &at_camera), light.pdf(walk.scene, &at_light)],
        [at_camera.cosine, at_light.cosine],
        distance_squared,
        acceptance,
    );
    walk.selection.shown(carried * passing, weight)
}

/// A vertex of a light subpath as the camera sees it.
#[derive(Clone, Copy, Debug)]
pub struct SeenVertex {
    /// Place in the whole film, (0, 0) top left to (1, 1) bottom right.
    pub film: Vec2,
    /// Radiance of a pixel that the place lies in, times the number of light subpaths; without the weight.
    pub radiance: Rgb,
    /// The density by solid angle with which a camera subpath of that pixel finds the vertex, and what makes it one by area.
    density: [f32; 2],
    reverse: f32,
    sums: Sums,
}

/// Shows `add` the pixels that a place of the whole film counts in, by index in the picture and filter weight.
#[inline]
pub fn for_each_pixel(scene: &Scene, film: Vec2, mut add: impl FnMut(u32, f32)) {
    // Without a border nothing that lies beyond an edge counts within.
    let repeats = if scene.film.samples_border { scene.camera.repeats() } else { &[0.0] };
    for repeat in repeats {
        scene.film.for_each_pixel(film + Vec2::new(*repeat, 0.0), &mut add);
    }
}

impl SeenVertex {
    /// Shows `add` the pixels that it counts in, by index in the picture and filter weight.
    #[inline]
    pub fn for_each_pixel(&self, scene: &Scene, add: impl FnMut(u32, f32)) {
        for_each_pixel(scene, self.film, add);
    }

    /// The weight for a pixel with ηᵝ = `acceptance`.
    #[inline]
    pub fn weight(&self, weighting: &Weighting, acceptance: f32) -> f32 {
        weighting.to_camera(&self.sums, self.density, self.reverse, acceptance)
    }
}

/// Connects the vertex of a light subpath with the camera [Veach 1997, 10.3: one camera vertex]; `None` where the camera does
/// not see it. `random` are the numbers of the light subpath.
#[inline]
pub fn to_camera(
    walk: &LightWalk<'_>,
    selection: &Selection,
    light: &Vertex,
    random: &impl Numbers,
    counters: &mut Counters,
) -> Option<SeenVertex> {
    let scene = walk.scene;
    let segments = light.segments + 1;
    if !walk.limits.allows(segments) || !selection.takes(segments, light.segments + 1, 1) {
        return None;
    }
    if scene.hides_lights && light.hit.shape.light != NO_LIGHT {
        return None;
    }
    let [lens_x, lens_y, ..] = random.block(dimension::light(light.steps));
    let seen =
        scene.camera.look_at(light.hit.position, [lens_x, lens_y]).filter(|seen| scene.film.reaches(seen.film))?;
    let reflected = light.reflect(scene, TransportMode::Flux, seen.direction)?;
    let per_pixel = seen.pdf * scene.film.whole_pixel_count();
    // The cosine is in the value.
    let radiance = light.throughput * reflected.value * (per_pixel / seen.spread);
    if radiance == Rgb::ZERO {
        return None;
    }
    let origin = light.hit.offset_towards(seen.direction);
    let ray = Ray { origin, direction: seen.direction, length: seen.visible_distance * SHADOW_END };
    let passing = transmittance(scene, &joint(scene, light, ray, Blockers::Seen, random), counters);
    if passing == Rgb::ZERO {
        return None;
    }
    let density = [per_pixel, reflected.cosine / seen.spread];
    Some(SeenVertex {
        film: seen.film,
        radiance: radiance * passing,
        density,
        reverse: light.pdf(scene, &reflected).reverse,
        sums: light.sums,
    })
}

/// Where the photons of a pass are found, and how they count.
pub struct Merging<'a, L> {
    /// All light vertices, as photons.
    pub photons: &'a L,
    /// What else is known of them.
    pub records: &'a [MergeRecord],
    /// How they count by their distance.
    pub kernel: Kernel,
    /// Only the nearest of them, at least 2; 0 for all within the radius.
    pub neighbors: u32,
    /// Which count only where their origin is seen.
    pub occlusion: Occlusion,
}

/// Un-normalised flux and photons that merge with a camera vertex within √`radius_squared`. Where only the nearest count, the
/// flux is scaled to that radius; weights keep the pixel's `acceptance`, since all techniques must share one to add up to one.
#[inline]
pub fn merge<L: PhotonLookup>(
    walk: &CameraWalk<'_>,
    camera: &Vertex,
    merging: &Merging<'_, L>,
    (radius_squared, acceptance): (f32, f32),
    nearest: &mut Nearest,
    counters: &mut Counters,
) -> Gathered {
    let hit = &camera.hit;
    let receiver = Receiver::new(walk.scene, hit, shading::view(hit, TransportMode::Radiance));
    let most_segments = walk.limits.most_photon_segments(camera.segments);
    let query = receiver.query(Counting { radius_squared, most_segments, caustics_only: false });
    let mut sum = MergeSum { walk, camera, merging, receiver, acceptance, gathered: Gathered::default() };
    sum.add_disc(&query, nearest, |_| true);
    if sum.gathered.photons == 0.0 {
        return sum.gathered;
    }
    if let Some(sight) = Sight::new(walk.scene, hit, &query, merging.occlusion) {
        sum.gathered = Gathered::default();
        let accepts = |index: usize| {
            sight.accepts(&merging.photons.photon(index), merging.records[index].origin_distance, counters)
        };
        sum.add_disc(&query, nearest, accepts);
    }
    sum.gathered
}

/// The sums of a merge.
struct MergeSum<'a, L> {
    walk: &'a CameraWalk<'a>,
    camera: &'a Vertex,
    merging: &'a Merging<'a, L>,
    receiver: Receiver<'a>,
    acceptance: f32,
    gathered: Gathered,
}

impl<L: PhotonLookup> MergeSum<'_, L> {
    /// Adds the photons of a disc that `counts` wants, by their indices.
    #[inline]
    fn add_disc(&mut self, query: &GatherQuery, nearest: &mut Nearest, mut counts: impl FnMut(usize) -> bool) {
        let Merging { photons, kernel, neighbors, .. } = *self.merging;
        let radius_squared = query.radius_squared;
        if neighbors > 0 {
            photons.nearest(query, neighbors as usize, nearest);
            let nearer = nearest.radius_squared();
            for (distance_squared, index) in nearest.photons().filter(|(_, index)| counts(*index)) {
                let weights = kernel.weights(distance_squared / nearer);
                self.add(index, weights.map(|weight| weight * (radius_squared / nearer)));
            }
        } else if kernel == Kernel::Disc {
            photons.visit_disc(query, |index, is_inner| {
                if counts(index) {
                    self.add(index, [1.0, f32::from(is_inner)]);
                }
            });
        } else {
            photons.visit_disc(query, |index, _| {
                if counts(index) {
                    let offset = Vec3::from_array(photons.photon(index).position) - query.position;
                    self.add(index, kernel.weights(offset.length_squared() / radius_squared));
                }
            });
        }
    }

    /// Adds the photon with an index: its shares of the flux and of the inner flux.
    #[inline(always)]
    fn add(&mut self, index: usize, [share, inner_share]: [f32; 2]) {
        let Self { walk, camera, merging, receiver, .. } = self;
        let light = &merging.records[index];
        if !walk.selection.takes(camera.segments + light.segments, light.segments, camera.segments) {
            return;
        }
        self.gathered.photons += 1.0;
        let incident = receiver.incident(merging.photons.direction(index));
        let value = receiver.value(incident);
        if value == Rgb::ZERO {
            return;
        }
        let weight = match walk.selection.show {
            Show::Unweighted => 1.0,
            _ => {
                let pdf = densities(walk.scene, &camera.hit, receiver.view(), incident);
                walk.weighting.merged([&camera.sums, &light.sums], pdf, self.acceptance)
            }
        };
        let carried = camera.throughput * value * merging.photons.flux(index);
        let shown = walk.selection.shown(carried, weight);
        self.gathered.flux += shown * share;
        self.gathered.inner_flux += shown * inner_share;
    }
}
