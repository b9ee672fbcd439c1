//! The irradiance cache of a pass.
//!
//! The camera paths of the whole picture, each with the random numbers that it has anyway, are visited in rounds: those of every
//! 16th pixel along both axes first, all in the end. Where a path ends on a matte surface that no record covers, a new one is
//! made of rays that gather as all others do. Rows of a round know the records of earlier rounds and their own, so they can be
//! visited at once; then their records are inserted row by row. So the cache belongs to the pass: threads and regions change
//! nothing. Each region of a pass makes it anew, as it does photon maps.

use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use super::TwoPasses;
use super::local_pass::LocalPass;
use super::parameters::Parameters;
use super::second_pass::Seen;
use crate::math::random::{PassRandom, PathRandom, dimension};
use crate::math::{Frame, Rgb, Vec3, warp};
use crate::method::parameter_values::Auto;
use crate::scene::Scene;
use crate::scene::material::MaterialSample;
use crate::transport::camera_walk::{CameraWalk, GatherPoint, trace_camera_path};
use crate::transport::irradiance::{
    Arrival, HemisphereCells, IrradianceCache, IrradianceQuery, IrradianceRecord, RadiusRange,
};
use crate::transport::photon_map::{LightLookup, OriginLookup};
use crate::transport::receiver::Receiver;
use crate::transport::shading;
use crate::transport::{Counters, Limits};

/// Pixels from one to the next in each round; each divides the one before.
const SPACINGS: [u32; 5] = [16, 8, 4, 2, 1];
/// A record reaches at least so many radii of a pixel's footprint.
const LEAST_REACH: f32 = 4.0;

/// Gather rays of a record where the user named no number.
const AUTOMATIC_CACHE_RAYS: u32 = 256;

/// Irradiance on the matte surfaces that a pass sees.
pub(super) struct PassCache {
    records: IrradianceCache,
    cells: HemisphereCells,
    error: f32,
}

/// A place on a matte surface.
struct MattePlace {
    /// Its BSDF, sr⁻¹.
    value: Rgb,
    query: IrradianceQuery,
}

impl MattePlace {
    /// `None` where the surface is not plainly matte. Paths limited in length see different light after different segments.
    fn new(scene: &Scene, limits: &Limits, at: &GatherPoint) -> Option<Self> {
        let receiver = Receiver::new(scene, &at.hit, at.view());
        let normal = at.hit.frame.normal;
        let query = IrradianceQuery {
            position: at.hit.position,
            normal: if receiver.view().outgoing.z < 0.0 { -normal } else { normal },
            group: limits.max_depth.map_or(0, |_| at.segments),
        };
        Some(Self { value: receiver.constant()?, query })
    }
}

impl PassCache {
    /// Indirect light that a matte surface reflects, sr⁻¹·W·m⁻²; `None` where rays must gather.
    pub(super) fn reflected(&self, method: &TwoPasses, at: &GatherPoint) -> Option<Rgb> {
        let place = MattePlace::new(&method.scene, &method.limits, at)?;
        if place.value == Rgb::ZERO {
            return Some(Rgb::ZERO);
        }
        Some(place.value * self.records.irradiance(&place.query)?)
    }
}

impl Parameters {
    /// Gather rays of a record.
    fn rays_per_record(&self) -> u32 {
        match self.cache_rays {
            Auto::Auto => AUTOMATIC_CACHE_RAYS,
            Auto::Value(rays) => rays.get(),
        }
    }
}

impl TwoPasses {
    /// Makes the cache of a pass, whose camera paths have the numbers `random`; `None` without one, and if cancelled at that.
    pub(super) fn cache_irradiance<P: OriginLookup, D: LightLookup>(
        &self,
        seen: &Seen<P, D>,
        random: &PassRandom,
        cancel: &AtomicBool,
    ) -> (Option<PassCache>, Counters) {
        let mut total = Counters::default();
        let Some(error) = self.parameters.cache_error.on() else { return (None, total) };
        let error = error.get() as f32;
        let (low, high) = self.scene.geometry.bounds();
        let cells = HemisphereCells::new(self.parameters.rays_per_record());
        let mut cache = PassCache { records: IrradianceCache::new(low, high, error), cells, error };
        for (round, spacing) in SPACINGS.into_iter().enumerate() {
            let rows: Vec<u32> = (0..self.scene.height).step_by(spacing as usize).collect();
            let visit_row = |y: &u32| {
                let pass = LocalPass::new(self, seen, Some(&cache));
                let mut row = Row { pass, cache: &cache, new: Vec::new(), counters: Counters::default() };
                let is_known = |x: u32| round > 0 && (x | *y).is_multiple_of(2 * spacing);
                for x in (0..self.scene.width).step_by(spacing as usize).filter(|x| !is_known(*x)) {
                    if cancel.load(Ordering::Relaxed) {
                        break;
                    }
                    row.visit([x, *y], &random.path(y * self.scene.width + x));
                }
                (row.new, row.counters)
            };
            let visited: Vec<(Vec<IrradianceRecord>, Counters)> = rows.par_iter().map(visit_row).collect();
            for (records, counters) in visited {
                records.into_iter().for_each(|record| cache.records.insert(record));
                total += counters;
            }
        }
        (Some(cache), total)
    }
}

/// A row of a round.
struct Row<'a, P, D> {
    pass: LocalPass<'a, P, D>,
    /// Records of earlier rounds.
    cache: &'a PassCache,
    new: Vec<IrradianceRecord>,
    counters: Counters,
}

impl<P: OriginLookup, D: LightLookup> Row<'_, P, D> {
    /// Makes a record where a pixel's camera path ends, if there is need of one.
    fn visit(&mut self, pixel: [u32; 2], random: &PathRandom) {
        let TwoPasses { scene, limits, .. } = self.pass.method;
        let ray = scene.camera_ray(pixel, random.block(dimension::CAMERA));
        let walk = CameraWalk::new(scene, ray, true);
        let (mut end, mut unused) = (None, Rgb::ZERO);
        trace_camera_path(scene, walk, random, limits, &mut unused, &mut self.counters, |at, _, _| {
            end = (!at.goes_on).then_some(*at);
        });
        let Some(at) = end else { return };
        let Some(MattePlace { value, query }) = MattePlace::new(scene, limits, &at) else { return };
        let covers = |record: &IrradianceRecord| record.weight(&query, self.cache.error).is_some();
        if value == Rgb::ZERO || self.cache.records.irradiance(&query).is_some() || self.new.iter().any(covers) {
            return;
        }
        let record = self.record(&at, &query, random);
        self.new.push(record);
    }

    /// Irradiance at a point by a ray in each cell of its hemisphere.
    fn record(&mut self, at: &GatherPoint, query: &IrradianceQuery, random: &PathRandom) -> IrradianceRecord {
        let cells = self.cache.cells;
        let frame = Frame::from_normal(query.normal);
        // What arrives, not what the camera sees of it.
        let at = GatherPoint { throughput: Rgb::ONE, ..*at };
        let mut arrivals: Vec<Arrival> = (0..cells.count())
            .map(|cell| {
                let random = random.branch(cell);
                let [x, y, _, roulette] = random.block(dimension::scattering(at.segments));
                self.arrival(&at, &frame, cells.direction(cell, [x, y]), roulette, &random)
            })
            .collect();
        let range = self.radius_range(&at);
        IrradianceRecord::new(query.position, frame, query.group, cells, &mut arrivals, range)
    }

    /// What arrives from a direction that is local to `frame`.
    fn arrival(&mut self, at: &GatherPoint, frame: &Frame, local: Vec3, u: f32, random: &PathRandom) -> Arrival {
        let direction = at.hit.frame.to_local(frame.to_world(local));
        let sample = MaterialSample {
            direction,
            weight: Rgb::ONE,
            pdf: warp::cosine_hemisphere_pdf(local.z),
            relative_index: 1.0,
        };
        let Some(scattering) = shading::finish(&at.hit, &at.view(), sample) else { return Arrival::NOTHING };
        let arrival = self.pass.gather_along(at, &scattering, u, random, &mut self.counters);
        if !arrival.radiance.is_finite() {
            self.counters.non_finite += 1;
            return Arrival { radiance: Rgb::ZERO, ..arrival };
        }
        arrival
    }

    /// A record serves at least the pixels around its own; without any surface around it does not reach through the whole scene.
    fn radius_range(&self, at: &GatherPoint) -> RadiusRange {
        let scene = &self.pass.method.scene;
        let largest = scene.geometry.bounding_sphere().1;
        let footprint = scene.camera.pixel_footprint(at.path_length, scene.film.whole[0]);
        RadiusRange { smallest: (LEAST_REACH * footprint / self.cache.error).min(largest), largest }
    }
}
