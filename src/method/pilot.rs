//! The pilot of methods that gather photons: first radii, and where photons should start.
//!
//! Photons that are emitted by power come first. What they are to the pixels that gather them teaches a guide; photons that follow
//! it teach a better one, and so on, since few may have come near the picture at first: each round sees many times as many. First
//! radii are those of photons as passes will emit them.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use rayon::prelude::*;

use super::parameter_values::Emission;
use super::photon_pass::{PILOT_PASS, PhotonPasses, PhotonsOf};
use crate::math::Rgb;
use crate::math::color::luminance;
use crate::math::random::{PassRandom, PathRandom, Stream};
use crate::scene::light::emission_guide::EmissionGuide;
use crate::transport::Counters;
use crate::transport::camera_walk::GatherPoint;
use crate::transport::emission_learning::{EmittedPath, GuideParts, Lesson, learn};
use crate::transport::light_path::emission_point;
use crate::transport::occlusion::Sight;
use crate::transport::photon_map::{PathPhoton, PathSegment, PhotonLookup, PhotonMap};
use crate::transport::receiver::Receiver;

/// Photon passes that teach, at most.
const LESSONS: u32 = 3;
/// A lesson from fewer photons than these, were they all worth the same, is always followed by another.
const SURE: f64 = 1000.0;
/// Another lesson that gains less than this times as much is the last, and not worth another guide.
const PROGRESS: f64 = 1.1;
/// Pixels that lessons look at, at most: discs with some tens of photons overlap, so that more pixels would see the same photons again.
const LESSON_PIXELS: usize = 1 << 12;
/// Photons go by power where guided ones would have less than this many times the variance.
const WORTHWHILE_GAIN: f64 = 1.5;
/// What pixels are brighter than counts against their mean square, as in relMSE.
const DARK: f64 = 1e-3;
/// Worths are summed as whole multiples of its inverse: in any order, sums are the same.
const WORTH_UNITS: f64 = (1u64 << 40) as f64;

/// Where the pixels of a method gather.
pub(crate) trait PilotView: Sync {
    /// Whether first radii of all pixels are wanted, else only what lessons need.
    const ALL_RADII: bool = true;

    /// Shows all points where a pixel gathers to `visit`, with numbers for the sampling of lights there; throughput is the share of the pixel. What the
    /// pixel sees besides, radiance.
    fn visit(
        &self,
        pixel: usize,
        counters: &mut Counters,
        visit: &mut dyn FnMut(&GatherPoint, &PathRandom, &mut Counters),
    ) -> Rgb;

    /// The point that a pixel's first radius is for.
    fn radius_point(&self, pixel: usize, counters: &mut Counters) -> Option<GatherPoint>;
}

/// One new camera path per pixel.
pub(crate) struct CameraPaths<'a> {
    passes: &'a PhotonPasses,
    random: PassRandom,
}

impl<'a> CameraPaths<'a> {
    /// Those of the pilot.
    pub(crate) fn new(passes: &'a PhotonPasses) -> Self {
        Self { passes, random: PassRandom::of_pixels(passes.seed, Stream::PilotCamera, PILOT_PASS) }
    }
}

impl PilotView for CameraPaths<'_> {
    fn visit(
        &self,
        pixel: usize,
        counters: &mut Counters,
        visit: &mut dyn FnMut(&GatherPoint, &PathRandom, &mut Counters),
    ) -> Rgb {
        let random = self.random.path(pixel as u32);
        self.passes.camera_path(&random, pixel, counters, |point, _, counters| visit(point, &random, counters))
    }

    fn radius_point(&self, pixel: usize, counters: &mut Counters) -> Option<GatherPoint> {
        let mut last = None;
        self.visit(pixel, counters, &mut |point, _, counters| {
            // Direct light will cost its rays too.
            counters.rays += 2;
            last = Some(*point);
        });
        last
    }
}

/// What the pilot found.
pub(crate) struct PilotFindings {
    /// First radii of all pixels, m².
    pub radius_squared: Vec<f32>,
    /// Where photons should start, as numbers of a guide; `None` for emission by power.
    pub guide: Option<Vec<f32>>,
    /// What a pass costs.
    pub counters: Counters,
}

/// A pixel that lessons look at.
struct LessonPixel {
    pixel: usize,
    /// Where it gathers.
    points: Vec<GatherPoint>,
    /// The luminance that it sees without photons, W·sr⁻¹·m⁻².
    without_photons: f64,
}

/// Photons, and first radii for them.
struct Round {
    map: PhotonMap<PathSegment>,
    radius_squared: Vec<f32>,
    counters: Counters,
}

impl PhotonPasses {
    /// First radii where the pixels of `view` gather, and a guide where it is wanted and worthwhile.
    pub(crate) fn pilot(&self, view: &impl PilotView, cancel: &AtomicBool) -> Option<PilotFindings> {
        let Round { map, radius_squared, counters } = self.round(view, PILOT_PASS, None, None, cancel)?;
        if self.may_guide() {
            let first = Round { map, radius_squared: radius_squared.clone(), counters };
            if let Some(found) = self.guided(view, first, cancel)? {
                return Some(found);
            }
        }
        Some(PilotFindings { radius_squared, guide: None, counters })
    }

    /// Whether a guide is wanted and has anything to choose.
    pub(crate) fn may_guide(&self) -> bool {
        let chooses = self.guide_parts == GuideParts::Cells || self.scene.lights.lights().len() > 1;
        self.emission != Emission::Power && chooses
    }

    /// Goes on from photons that were emitted by power. The inner `None`: no guide helps.
    fn guided(&self, view: &impl PilotView, mut round: Round, cancel: &AtomicBool) -> Option<Option<PilotFindings>> {
        let pixels = self.lesson_pixels(view);
        let mut guide: Option<EmissionGuide> = None;
        let mut last: Option<Lesson> = None;
        for pass in PILOT_PASS..PILOT_PASS + LESSONS {
            let Some(lesson) = self.lesson(&pixels, &round, pass, guide.as_ref()) else { return Some(None) };
            if self.emission == Emission::Auto && lesson.gain < WORTHWHILE_GAIN {
                return Some(None);
            }
            if last.as_ref().is_some_and(|last| last.photons >= SURE && lesson.gain < PROGRESS * last.gain) {
                break;
            }
            // A scene may have more lights than a guide has cells.
            let Ok(next) = EmissionGuide::new(&lesson.values, &self.scene.lights) else { return Some(None) };
            round = self.round(view, pass + 1, Some(&next), Some(median(&round.radius_squared)), cancel)?;
            (guide, last) = (Some(next), Some(lesson));
        }
        let Round { radius_squared, counters, .. } = round;
        let guide = last.map(|lesson| lesson.values);
        Some(Some(PilotFindings { radius_squared, guide, counters }))
    }

    /// Traces photons and finds radii for them, of about the size that is expected, R², m².
    fn round<V: PilotView>(
        &self,
        view: &V,
        pass: u32,
        guide: Option<&EmissionGuide>,
        expected: Option<f32>,
        cancel: &AtomicBool,
    ) -> Option<Round> {
        let photons = PhotonsOf { stream: Stream::PilotPhoton, pass, guide };
        let cells = expected.unwrap_or_else(|| self.pilot_radius_squared());
        let (map, mut total) = self.trace_photons::<PathPhoton>(&photons, cells, cancel)?;
        let guess = expected.unwrap_or_else(|| self.radius_bounds(map.len()).guess);
        let radius_of = |pixel: usize| {
            let mut counters = Counters::default();
            let point = view.radius_point(pixel, &mut counters);
            (point.map(|point| self.first_radius_squared(&map, &point, guess)), counters)
        };
        let step = if V::ALL_RADII { 1 } else { self.lesson_step() };
        let pixels = (0..self.scene.pixel_count()).into_par_iter().step_by(step);
        let found: Vec<(Option<f32>, Counters)> = pixels.with_min_len(1024).map(radius_of).collect();
        let mut radii: Vec<Option<f32>> = vec![None; self.scene.pixel_count()];
        for (pixel, (radius, counters)) in found.into_iter().enumerate() {
            radii[pixel * step] = radius;
            total += counters;
        }
        let radius_squared = self.complete_first_radii(&mut radii);
        (!cancel.load(Ordering::Relaxed)).then_some(Round { map, radius_squared, counters: total })
    }

    /// Lessons look at one pixel of so many.
    fn lesson_step(&self) -> usize {
        self.scene.pixel_count().div_ceil(LESSON_PIXELS).max(1)
    }

    /// The pixels of all lessons. They see the same in each of them but for its photons.
    fn lesson_pixels(&self, view: &impl PilotView) -> Vec<LessonPixel> {
        let count = self.scene.pixel_count();
        let pixels: Vec<usize> = (0..count).step_by(self.lesson_step()).collect();
        let look = |pixel: &usize| {
            let (mut points, mut sampled) = (Vec::new(), Rgb::ZERO);
            let seen = view.visit(*pixel, &mut Counters::default(), &mut |point, random, counters| {
                sampled += point.throughput * self.direct_light(point, random, counters);
                points.push(*point);
            });
            let without_photons = f64::from(luminance(seen + sampled));
            let without_photons = if without_photons.is_finite() { without_photons } else { 0.0 };
            LessonPixel { pixel: *pixel, points, without_photons }
        };
        pixels.par_iter().map(look).collect()
    }

    /// What the photons of a round teach; `None` where none came to the picture.
    fn lesson(
        &self,
        pixels: &[LessonPixel],
        round: &Round,
        pass: u32,
        guide: Option<&EmissionGuide>,
    ) -> Option<Lesson> {
        let worths = self.worths(pixels, round);
        let random = PassRandom::independent(self.seed, Stream::PilotPhoton, pass);
        let paths: Vec<EmittedPath> = (0..self.photons_per_pass)
            .zip(worths)
            .map(|(path, worth)| EmittedPath {
                start: emission_point(&self.scene, guide, &random.path(path)),
                worth: worth.into_inner() as f64 / WORTH_UNITS,
            })
            .collect();
        let lights = &self.scene.lights;
        learn(&paths, self.guide_parts, lights.lights().len(), |light| lights.emission_pick(light))
    }

    /// What each photon path is to the pixels, see [`EmittedPath::worth`], in units.
    fn worths(&self, pixels: &[LessonPixel], round: &Round) -> Vec<AtomicU64> {
        let brightness: Vec<f64> = pixels.par_iter().map(|pixel| self.brightness(pixel, round)).collect();
        let mean = brightness.iter().sum::<f64>() / brightness.len() as f64;
        let worths: Vec<AtomicU64> = (0..self.photons_per_pass).map(|_| AtomicU64::new(0)).collect();
        pixels.par_iter().zip(&brightness).for_each(|(pixel, brightness)| {
            let square = brightness * brightness + DARK * mean * mean;
            self.visit_photons(pixel, round, |path, brought| {
                // A pixel is at least as bright as what one photon brings it.
                let share = (brought * brought / square).min(1.0);
                worths[path as usize].fetch_add((share * WORTH_UNITS) as u64, Ordering::Relaxed);
            });
        });
        worths
    }

    /// The luminance of a pixel by a single pass, W·sr⁻¹·m⁻².
    fn brightness(&self, pixel: &LessonPixel, round: &Round) -> f64 {
        let mut by_photons = 0.0;
        self.visit_photons(pixel, round, |_, brought| by_photons += brought);
        pixel.without_photons + by_photons
    }

    /// Shows every photon that a pixel gathers: its path, and the luminance that it brings, W·sr⁻¹·m⁻².
    fn visit_photons(&self, pixel: &LessonPixel, round: &Round, mut visit: impl FnMut(u32, f64)) {
        let radius_squared = round.radius_squared[pixel.pixel];
        let disc = std::f64::consts::PI * f64::from(radius_squared) * f64::from(self.photons_per_pass);
        for point in &pixel.points {
            let receiver = Receiver::new(&self.scene, &point.hit, point.view());
            let counting = self.counting(point, radius_squared);
            let sight = Sight::new(&self.scene, &point.hit, &receiver.query(counting), self.occlusion);
            let counts = |index: usize, segment: &PathSegment| {
                let photon = || round.map.photon(index);
                sight.as_ref().is_none_or(|sight| sight.accepts(&photon(), segment.length, &mut Counters::default()))
            };
            receiver.visit(&round.map, counting, |index, reflected| {
                let segment = &round.map.extras()[index];
                let brought = f64::from(luminance(point.throughput * reflected)) / disc;
                if brought.is_finite() && counts(index, segment) {
                    visit(segment.path, brought);
                }
            });
        }
    }

    /// The R² that a search for first radii starts with, m².
    fn pilot_radius_squared(&self) -> f32 {
        // Two or three photons are stored per emitted one in a closed room.
        self.radius_bounds(2 * self.photons_per_pass as usize).guess
    }
}

/// The middle one of values that are not NaN.
fn median(values: &[f32]) -> f32 {
    let mut values = values.to_vec();
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f32::total_cmp).1
}
