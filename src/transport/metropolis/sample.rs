//! One path of a given length, found in one of the ways that bidirectional path tracing has: a multiplexed sample [Hachisuka, Kaplanyan &
//! Dachsbacher 2014, "Multiplexed Metropolis light transport"].
//!
//! Its numbers are those of the light subpath, those of the camera subpath, and one that picks the way. What it brings to the picture is weighted by
//! multiple importance sampling, times the number of ways; the mean over all numbers is the radiance of all paths of the length.

use crate::math::Rgb;
use crate::math::random::{PassRandom, RecordedNumbers, Stream};
use crate::scene::Scene;
use crate::transport::bidirectional::{
    CameraWalk, LightWalk, Selection, Show, Vertex, Weighting, connect, direct_light, to_camera,
};
use crate::transport::{Counters, Limits};

/// A point of the primary sample space [Kelemen et al. 2002] of paths of one length: all numbers that make one.
#[derive(Clone, Debug, Default)]
pub(crate) struct PrimarySample {
    /// Of the light subpath.
    pub light: Vec<[f32; 4]>,
    /// Of the camera subpath. The first two say where on the picture it starts.
    pub camera: Vec<[f32; 4]>,
    /// Picks the way.
    pub way: f32,
}

/// Numbers of vertices that two subpaths have; of the light subpath 0 where the camera subpath hits the light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Way {
    /// Of the light subpath.
    pub light: u32,
    /// Of the camera subpath, the lens included.
    pub camera: u32,
}

/// What a path brings to a pixel of the picture.
#[derive(Clone, Copy, Debug)]
pub struct Splat {
    /// Its index in the picture.
    pub pixel: u32,
    /// W·sr⁻¹·m⁻².
    pub radiance: Rgb,
}

/// Blocks of numbers that a subpath of so many vertices looks at.
pub(crate) fn blocks(vertices: u32) -> usize {
    2 * vertices as usize + 2
}

impl PrimarySample {
    /// Takes all numbers of paths of `segments` from `next`.
    pub(crate) fn renew(&mut self, segments: u32, mut next: impl FnMut() -> f32) {
        for numbers in [&mut self.light, &mut self.camera] {
            numbers.clear();
            numbers.extend((0..blocks(segments + 1)).map(|_| [0; 4].map(|_| next())));
        }
        self.way = next();
    }

    /// The way that they pick for paths of `segments`.
    pub(crate) fn way(&self, segments: u32) -> Way {
        let light = ((self.way * (segments + 1) as f32) as u32).min(segments);
        Way { light, camera: segments + 1 - light }
    }
}

/// Makes paths from numbers.
pub(crate) struct PathSampler<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// How the ways share a path: with as many light subpaths as there are pixels.
    pub weighting: Weighting,
}

impl PathSampler<'_> {
    /// Appends what the path of `segments` with these numbers brings to `splats`.
    pub(crate) fn trace(
        &self,
        segments: u32,
        numbers: &PrimarySample,
        splats: &mut Vec<Splat>,
        counters: &mut Counters,
    ) {
        let way = numbers.way(segments);
        let first = splats.len();
        let light_end = match way.light {
            0 | 1 => None,
            _ => match self.light_end(way.light, numbers, counters) {
                None => return,
                end => end,
            },
        };
        match (&light_end, way.camera) {
            (Some(end), 1) => self.end_at_camera(segments, way, end, numbers, splats, counters),
            (end, _) => self.end_at_camera_subpath(segments, way, end.as_ref(), numbers, splats, counters),
        }
        let ways = (segments + 1) as f32;
        splats[first..].iter_mut().for_each(|splat| splat.radiance *= ways);
        if !splats[first..].iter().all(|splat| splat.radiance.is_finite()) {
            counters.non_finite += 1;
            splats.truncate(first);
        }
    }

    /// The last vertex of the light subpath.
    fn light_end(&self, vertices: u32, numbers: &PrimarySample, counters: &mut Counters) -> Option<Vertex> {
        // A photon leaves a segment to the camera.
        let limits = Limits { max_depth: Some(vertices), rr_depth: u32::MAX };
        let random = unused();
        let walk = LightWalk { scene: self.scene, limits, weighting: self.weighting, random: &random };
        let mut end = None;
        walk.trace_with(&RecordedNumbers::new(&numbers.light), counters, |vertex, _, _| {
            if vertex.segments + 1 == vertices {
                end = Some(*vertex);
            }
        });
        end
    }

    fn end_at_camera(
        &self,
        segments: u32,
        way: Way,
        end: &Vertex,
        numbers: &PrimarySample,
        splats: &mut Vec<Splat>,
        counters: &mut Counters,
    ) {
        let limits = Limits { max_depth: Some(segments), rr_depth: u32::MAX };
        let random = unused();
        let walk = LightWalk { scene: self.scene, limits, weighting: self.weighting, random: &random };
        let selection = selection(segments, way);
        let light = RecordedNumbers::new(&numbers.light);
        let Some(seen) = to_camera(&walk, &selection, end, &light, counters) else { return };
        seen.for_each_pixel(self.scene, |pixel, filter| {
            let radiance = seen.radiance * (filter * seen.weight(&self.weighting, 0.0));
            splats.push(Splat { pixel, radiance });
        });
    }

    fn end_at_camera_subpath(
        &self,
        segments: u32,
        way: Way,
        end: Option<&Vertex>,
        numbers: &PrimarySample,
        splats: &mut Vec<Splat>,
        counters: &mut Counters,
    ) {
        let scene = self.scene;
        let [x, y, ..] = numbers.camera.first().copied().unwrap_or_default();
        let (column, right) = split(x, scene.width);
        let (row, down) = split(y, scene.height);
        let pixel = row * scene.width + column;
        let camera = RecordedNumbers::new(&numbers.camera).starting_at([right, down]);
        let random = unused();
        let joiner = CameraWalk {
            scene,
            limits: Limits { max_depth: Some(segments), rr_depth: u32::MAX },
            weighting: self.weighting,
            selection: selection(segments, way),
            random: &random,
        };
        // The subpath ends where it is joined.
        let longest = if way.light == 0 { segments } else { way.camera - 1 };
        let walk = CameraWalk { limits: Limits { max_depth: Some(longest), ..joiner.limits }, ..joiner };
        let radiance = walk.trace_with(&camera, pixel, 0.0, counters, |vertex, numbers, counters| {
            if way.light == 0 || vertex.segments != longest {
                return Rgb::ZERO;
            }
            match end {
                None => direct_light(&joiner, vertex, numbers, 0.0, counters),
                Some(end) => connect(&joiner, vertex, end, numbers, 0.0, counters),
            }
        });
        if radiance != Rgb::ZERO {
            splats.push(Splat { pixel, radiance: radiance * scene.pixel_count() as f32 });
        }
    }
}

/// Paths of one length that are found in one way.
fn selection(segments: u32, way: Way) -> Selection {
    Selection { length: Some(segments), strategy: Some([way.light, way.camera]), show: Show::Radiance }
}

/// Walks that are given their numbers look at no others.
fn unused() -> PassRandom {
    PassRandom::independent(0, Stream::Branch, 0)
}

/// The part of `parts` that a number in [0, 1) lies in, and where in it.
fn split(number: f32, parts: u32) -> (u32, f32) {
    let place = number * parts as f32;
    let part = (place as u32).min(parts - 1);
    (part, (place - part as f32).clamp(0.0, crate::math::discrete::ONE_MINUS_EPSILON))
}
