//! Camera subpaths up to their first surface that is not a mirror: from where a final gather looks at what photons brought.

use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use super::mutation::Source;
use super::path_space::absorption::passing;
use super::path_space::extension::Tracer;
use super::path_space::lobe_choice::Lobe;
use super::path_space::path::PathVertex;
use super::path_space::window::FilmWindow;
use crate::math::color::luminance;
use crate::math::random::PassRandom;
use crate::math::{Rgb, Vec3};
use crate::scene::geometry::Ray;
use crate::scene::geometry::surface::NO_LIGHT;
use crate::scene::material::TransportMode;
use crate::scene::{MediumIndex, Scene};
use crate::transport::Counters;
use crate::transport::visibility::SHADOW_END;

/// A camera subpath whose vertices are mirrors and glass but for the last.
#[derive(Clone, Copy, Debug)]
pub struct EyeSubpath {
    /// The last vertex.
    end: PathVertex,
    /// Unit direction from there to the vertex before.
    back: Vec3,
    /// The medium that it came through.
    medium: MediumIndex,
    /// What its picture is multiplied with, over the density of the subpath, times the number of pixels.
    throughput: Rgb,
}

/// Independent camera subpaths of a pass, which chains look up in turn.
pub struct EyeSubpaths {
    subpaths: Vec<Option<EyeSubpath>>,
    usual: f32,
}

/// One of so many subpaths only tells what is usual.
const FOR_USUAL: usize = 16;

impl EyeSubpaths {
    /// Traces `count` of them; `None` when cancelled.
    pub fn trace(
        scene: &Scene,
        window: &FilmWindow,
        count: u32,
        random: &PassRandom,
        cancel: &AtomicBool,
    ) -> Option<(Self, Counters)> {
        let trace = |chain: &mut Vec<PathVertex>, index: u32| {
            let mut counters = Counters::default();
            let mut source = Source::new(random.path(index));
            let mut tracer = Tracer { scene, counters: &mut counters, chain };
            (EyeSubpath::trace(window, &mut source, &mut tracer), counters)
        };
        let traced: Vec<_> = (0..count).into_par_iter().map_init(Vec::new, trace).collect();
        let mut total = Counters::default();
        let mut subpaths: Vec<Option<EyeSubpath>> = Vec::with_capacity(traced.len());
        for (subpath, counters) in traced {
            total += counters;
            subpaths.push(subpath);
        }
        let others = subpaths.split_off(subpaths.len() / FOR_USUAL);
        let usual = usual_importance(scene, &subpaths, &mut total);
        (!cancel.load(Ordering::Relaxed)).then_some((Self { subpaths: others, usual }, total))
    }

    /// The usual importance of a photon where the camera looks; what chains are told before they begin.
    pub fn usual(&self) -> f32 {
        self.usual
    }

    /// One of them, by a number in [0, 1); `None` of one that ended nowhere.
    pub fn pick(&self, u: f32) -> Option<&EyeSubpath> {
        let count = self.subpaths.len();
        self.subpaths.get(((u * count as f32) as usize).min(count.checked_sub(1)?))?.as_ref()
    }
}

/// The median importance that the ends of some subpaths have for others that they see, as places of photons that come from the eye; 0 where none sees any.
fn usual_importance(scene: &Scene, subpaths: &[Option<EyeSubpath>], counters: &mut Counters) -> f32 {
    let (places, ways) = subpaths.split_at(subpaths.len() / 2);
    let pairs = places.iter().zip(ways).filter_map(|(place, way)| place.as_ref().zip(way.as_ref()));
    let of =
        |(place, way): (&EyeSubpath, &EyeSubpath)| luminance(way.importance(scene, &place.end, place.back, counters));
    let mut found: Vec<f32> = pairs.map(of).filter(|importance| *importance > 0.0).collect();
    found.sort_by(f32::total_cmp);
    found.get(found.len() / 2).copied().unwrap_or(0.0)
}

impl EyeSubpath {
    fn trace(window: &FilmWindow, source: &mut Source, tracer: &mut Tracer<'_>) -> Option<Self> {
        let scene = tracer.scene;
        let film = window.place([source.number(), source.number()]);
        let lens = [source.number(), source.number()];
        let first = tracer.seen(film, lens)?;
        tracer.follow_specular_from(first, TransportMode::Radiance, source)?;
        let chain = &*tracer.chain;
        let end = *chain.last()?;
        let seen = scene.camera.look_at(chain[0].hit.position, lens).filter(|seen| scene.film.reaches(seen.film))?;
        let mut throughput = Rgb::splat((f64::from(scene.film.whole_pixel_count()) / window.density()) as f32);
        let (mut back, mut medium) = (seen.direction, scene.camera_medium);
        throughput *= passing(scene, medium, first.position, back, first.distance);
        for pair in chain.windows(2) {
            let on = (pair[1].hit.position - pair[0].hit.position).normalize();
            let (terms, value) = pair[0].terms(scene, on, back)?;
            throughput *= value / terms.to_light as f32;
            medium = scene.medium_beyond(&pair[0].hit, on, medium);
            let length = pair[1].hit.position.distance(pair[0].hit.position);
            throughput *= passing(scene, medium, pair[0].hit.position, on, length);
            back = -on;
        }
        let is_hidden = scene.hides_lights && chain[0].hit.shape.light != NO_LIGHT;
        (!is_hidden && throughput.is_finite()).then_some(Self { end, back, medium, throughput })
    }

    /// What the picture gets, on average over these subpaths, of a photon that brings 1 W from the direction `incident` to `at`: radiance of a pixel over
    /// the density of the subpath. 0 where the end of the subpath does not see it.
    pub fn importance(&self, scene: &Scene, at: &PathVertex, incident: Vec3, counters: &mut Counters) -> Rgb {
        self.open_importance(scene, at, incident, counters).unwrap_or(Rgb::ZERO)
    }

    fn open_importance(&self, scene: &Scene, at: &PathVertex, incident: Vec3, counters: &mut Counters) -> Option<Rgb> {
        let offset = self.end.hit.position - at.hit.position;
        let distance_squared = offset.length_squared();
        let direction = offset / distance_squared.sqrt();
        let at = PathVertex { lobe: Lobe::Smooth, ..*at };
        let (photon, at_photon) = at.terms(scene, incident, direction)?;
        let (seen, at_end) = self.end.terms(scene, -direction, self.back)?;
        let geometry = photon.camera_cosine * seen.light_cosine / f64::from(distance_squared);
        let medium = scene.medium_beyond(&self.end.hit, -direction, self.medium);
        let absorbed = passing(scene, medium, at.hit.position, direction, distance_squared.sqrt());
        let importance = self.throughput * absorbed * at_end * at_photon * (geometry / seen.camera_lobe) as f32;
        if importance == Rgb::ZERO || !importance.is_finite() {
            return None;
        }
        counters.rays += 1;
        let origin = at.hit.offset_towards(direction);
        let between = self.end.hit.offset_towards(-direction) - origin;
        let length = between.length();
        let ray = Ray { origin, direction: between / length, length: length * SHADOW_END };
        (!scene.geometry.is_blocked(&ray)).then_some(importance)
    }
}
