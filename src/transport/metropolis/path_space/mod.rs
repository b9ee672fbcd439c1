//! Paths as states of chains: changed by their vertices, as in Metropolis light transport [Veach 1997, chapter 11] and Metropolis photon sampling
//! [Fan et al. 2005, "Metropolis photon sampling with optional user guidance"].
//!
//! | file | what |
//! |---|---|
//! | [`path`] | a path and all its factors |
//! | [`light_end`], [`lobe_choice`], [`window`] | its first vertex, its directions, its last vertex |
//! | [`absorption`] | what media let pass |
//! | [`extension`] | new vertices |
//! | [`proposals`] | changes, one file each |
//! | [`user_path`] | paths that a user gives |
//!
//! A change of a path x into y is taken with probability a = min(1, f*(y) T(y → x) / f*(x) T(x → y)) [V97, eq. 11.4], where T is the density with which a
//! proposal of one kind makes the one of the other. Each kind keeps f* by itself.

pub(crate) mod absorption;
pub(crate) mod extension;
pub(crate) mod light_end;
pub(crate) mod lobe_choice;
pub(crate) mod path;
pub mod proposals;
pub mod user_path;
pub mod window;

use std::ops::Range;

use self::extension::{Arrival, Tracer};
use self::light_end::LightEnd;
use self::lobe_choice::Lobe;
use self::path::{Path, PathVertex, Terms};
use self::proposals::{Kept, Shares};
use self::user_path::UserPath;
use self::window::FilmWindow;
use super::chains::{Change, Lengths, Space};
use super::mutation::Source;
use super::primary_space::show;
use super::sample::Splat;
use crate::scene::Scene;
use crate::scene::material::Lobes;
use crate::transport::Counters;
use crate::transport::bidirectional::for_each_pixel;

/// Paths from a light to the camera.
pub struct PathSpace<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// How long paths are.
    pub lengths: Lengths,
    /// Where on the film they end.
    pub window: FilmWindow,
    /// How often each kind of change is proposed.
    pub shares: Shares,
    /// Paths that a user gave.
    pub user_paths: &'a [UserPath],
    /// What of its importance to the picture a photon has at least: paths that leave one where light is worth less are sought as if it were worth so much.
    /// 0 where paths leave none.
    pub least_importance: f32,
    /// Pixels of which anything is wanted.
    pub pixels: Range<u32>,
}

/// A path and what is known of it.
#[derive(Default)]
pub struct PathState {
    /// The path.
    pub path: Path,
    /// Whether it brings anything, and its factors and its density are known.
    pub is_known: bool,
    /// Its factors.
    pub terms: Terms,
    /// The density with which it is sampled independently.
    pub density: f64,
    splats: Vec<Splat>,
    /// Vertices that are being made, from the eye on or from where a change begins.
    chain: Vec<PathVertex>,
}

impl Space for PathSpace<'_> {
    type State = PathState;
    type Brought = Splat;

    fn renew(&self, state: &mut PathState, source: &mut Source, counters: &mut Counters) {
        state.is_known = false;
        let segments = self.lengths.pick(source) as usize;
        let light_vertices = (source.number() * (segments + 1) as f32) as usize;
        let gap = proposals::Gap {
            kept: Kept { light: 0, camera: 1 },
            light: light_vertices,
            camera: segments - light_vertices,
        };
        let empty = Path::default();
        if let Some(connection) = self.fill(&empty, &gap, state, source, counters) {
            self.finish(state, connection, counters);
        }
    }

    fn change(&self, from: &PathState, to: &mut PathState, source: &mut Source, counters: &mut Counters) -> Change {
        let kind = self.shares.pick(source.number());
        to.is_known = false;
        let acceptance = self.propose(kind, from, to, source, counters).unwrap_or(0.0);
        to.is_known &= acceptance > 0.0;
        Change { step: kind.step(), acceptance }
    }

    fn target(&self, state: &PathState) -> f32 {
        if state.is_known { (self.sought(&state.path, &state.terms) / state.density) as f32 } else { 0.0 }
    }

    fn show(&self, state: &PathState, weight: f32, splats: &mut Vec<Splat>) {
        if state.is_known {
            show(&state.splats, weight, &self.pixels, splats);
        }
    }
}

impl PathSpace<'_> {
    /// What chains visit paths in proportion to: f*, where no importance is too small.
    fn sought(&self, path: &Path, terms: &Terms) -> f64 {
        if self.least_importance == 0.0 {
            return terms.target();
        }
        match path.photon_place() {
            Some(place) if !place.is_caustic => {
                let importance = terms.importance(place.index, self.scene, &self.window);
                terms.target() * f64::from(1.0 + self.least_importance / importance)
            }
            _ => terms.target(),
        }
    }

    /// Fills a gap of `from` by two subpaths: the path in `to`, and the index of its first vertex behind the segment that joins them, 0 where the
    /// camera subpath hit a light.
    fn fill(
        &self,
        from: &Path,
        gap: &proposals::Gap,
        to: &mut PathState,
        source: &mut Source,
        counters: &mut Counters,
    ) -> Option<usize> {
        let mut tracer = Tracer { scene: self.scene, counters, chain: &mut to.chain };
        let proposals::Gap { kept, light, camera } = *gap;
        let segments = kept.light + light + camera + kept.camera - 1;
        let (path, connection) = (&mut to.path, kept.light + light);
        path.lens = if kept.camera == 1 { [source.number(), source.number()] } else { from.lens };
        path.vertices.clear();
        path.vertices.extend_from_slice(&from.vertices[..kept.light.saturating_sub(1)]);
        path.light = if kept.light > 0 { from.light } else { None };
        match (kept.light, light) {
            (_, 0) => {}
            (0, 1) => path.light = Some(LightEnd::sample(self.scene, source)?),
            (0, _) => {
                let (light_end, vertex) = self.emit(&mut tracer, source)?;
                path.light = Some(light_end);
                path.vertices.push(vertex);
                tracer.extend_from_light(&mut path.vertices, &light_end, light - 2, source)?;
            }
            (1, _) => return None,
            _ => tracer.extend_from_light(&mut path.vertices, &from.light?, light, source)?,
        }
        tracer.chain.clear();
        tracer.chain.extend(from.vertices[from.vertices.len() + 1 - kept.camera..].iter().rev());
        for index in 0..camera {
            match self.next_from_camera(&mut tracer, path.lens, source)? {
                Arrival::Surface(hit) if connection == 0 && index + 1 == camera => {
                    let is_seen = tracer.chain.iter().all(|vertex| vertex.lobe == Lobe::Specular);
                    path.light = Some(LightEnd::of_hit(self.scene, &hit, is_seen)?);
                }
                Arrival::Surface(hit) => tracer.chain.push(PathVertex { hit, lobe: Lobe::Smooth }),
                Arrival::Outside(direction) if connection == 0 && index + 1 == camera => {
                    path.light = Some(LightEnd::outside(self.scene, direction)?);
                }
                Arrival::Outside(_) => return None,
            }
        }
        path.vertices.extend(tracer.chain.iter().rev());
        if connection > 0 {
            for index in [connection - 1, connection].into_iter().filter(|index| *index > 0 && *index < segments) {
                let vertex = &mut path.vertices[index - 1];
                if !self.scene.lobes_at(vertex.hit.shape).any(Lobes::SMOOTH) {
                    return None;
                }
                vertex.lobe = Lobe::Smooth;
            }
        }
        Some(connection)
    }

    /// A photon and the surface that it meets.
    fn emit(&self, tracer: &mut Tracer<'_>, source: &mut Source) -> Option<(LightEnd, PathVertex)> {
        let numbers = [0; 5].map(|_| source.number());
        let lights = &self.scene.lights;
        let photon =
            lights.emit(&self.scene.geometry, [numbers[0], numbers[1], numbers[2]], [numbers[3], numbers[4]])?;
        let hit = tracer.surface(&crate::scene::geometry::Ray::new(photon.origin, photon.direction))?;
        Some((LightEnd::of_photon(self.scene, &photon), PathVertex { hit, lobe: Lobe::Smooth }))
    }

    /// Where a camera subpath with the vertices of the tracer's chain, from the eye on, goes on to.
    fn next_from_camera(&self, tracer: &mut Tracer<'_>, lens: [f32; 2], source: &mut Source) -> Option<Arrival> {
        let back = match tracer.chain[..] {
            [] => {
                let film = self.window.place([source.number(), source.number()]);
                let ray = self.scene.camera.ray(film, lens);
                return Some(tracer.seen(film, lens).map_or(Arrival::Outside(ray.direction), Arrival::Surface));
            }
            [first] => self.scene.camera.look_at(first.hit.position, lens)?.direction,
            [.., before, last] => (before.hit.position - last.hit.position).normalize(),
        };
        tracer.extend_from_camera(back, source)
    }

    /// Looks whether the segment that joins its subpaths is open, and computes all else that is to be known of a path.
    fn finish(&self, state: &mut PathState, connection: usize, counters: &mut Counters) -> Option<()> {
        let PathState { path, terms, chain, .. } = state;
        path.compute(self.scene, terms)?;
        let mut tracer = Tracer { scene: self.scene, counters, chain };
        if connection > 0 && !tracer.is_open(path, terms, connection - 1) {
            return None;
        }
        state.density = self.independent_density(path, terms);
        if !(state.density > 0.0 && state.density.is_finite()) {
            return None;
        }
        // A photon of no importance would be sought without end.
        if !((self.sought(path, terms) / state.density) as f32).is_finite() {
            return None;
        }
        let radiance = terms.over(state.density);
        state.splats.clear();
        for_each_pixel(self.scene, terms.film, |pixel, filter| {
            state.splats.push(Splat { pixel, radiance: radiance * filter });
        });
        state.is_known = true;
        Some(())
    }

    /// The density with which a path is sampled without any other.
    fn independent_density(&self, path: &Path, terms: &Terms) -> f64 {
        let segments = path.segments();
        let length = f64::from(self.lengths.probability(segments as u32));
        length * self.two_subpaths(path, terms, Kept { light: 0, camera: 1 })
    }

    /// The density with which the gap between what is kept is filled by two subpaths, over all places where they may meet.
    fn two_subpaths(&self, path: &Path, terms: &Terms, kept: Kept) -> f64 {
        let (first, last) = (kept.light, path.segments() + 1 - kept.camera);
        let joins = |connection: &usize| path.is_joined_at(*connection);
        let of = |connection: usize| {
            terms.light_subpath(first, connection) * terms.camera_subpath(connection, last, &self.window)
        };
        (first..=last).filter(joins).map(of).sum::<f64>() / (last - first + 1) as f64
    }
}

impl Path {
    /// Whether a light subpath may end before vertex x_i and a camera subpath at it.
    fn is_joined_at(&self, index: usize) -> bool {
        let is_smooth = |index: usize| index == 0 || index >= self.segments() || !self.is_specular(index);
        match index {
            0 => self.light.is_some_and(|light| light.can_be_hit()),
            _ => is_smooth(index - 1) && is_smooth(index),
        }
    }
}
