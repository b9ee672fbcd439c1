//! The second pass of `photon_map`: which pixels look at which maps.
//!
//! A pass goes in steps. Each traces a set of maps, has the pixels whose turn it is look at it, and drops it, so no two sets are ever held at
//! once.

use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use super::TwoPasses;
use super::direct_light::DirectLight;
use super::first_pass::Maps;
use super::hierarchy::{Hierarchy, Node};
use super::local_pass::LocalPass;
use super::parameters::{ShownPart, Structure};
use crate::estimate::PixelTally;
use crate::math::Rgb;
use crate::math::random::{PassRandom, PathRandom, Permutation, Stream};
use crate::method::Pass;
use crate::method::photon_pass::add_to_tally;
use crate::transport::Counters;
use crate::transport::photon_map::{
    Gathered, KdTree, LightLookup, LightPhoton, LightSegment, OriginLookup, OriginPhoton, PhotonMap,
};

/// Which pixels look at which sets of maps.
pub(super) enum MapChoice {
    /// All pixels at the only one.
    Only,
    /// Each at one of so many [Wald 1999, section 4.4: skipping].
    Skipping(u32),
    /// Fewer on finer levels of a scanline [Wald 1999, section 4.5].
    Hierarchy(Hierarchy),
}

impl MapChoice {
    /// Sets of maps in a pass.
    pub(super) fn sets(&self) -> u32 {
        match self {
            Self::Only => 1,
            Self::Skipping(sets) => *sets,
            Self::Hierarchy(hierarchy) => hierarchy.maps(),
        }
    }

    /// How many a pixel looks at on average, where none is localized.
    pub(super) fn mean_sets_of_a_pixel(&self) -> f64 {
        match self {
            Self::Only | Self::Skipping(_) => 1.0,
            Self::Hierarchy(hierarchy) => hierarchy.mean_samples(),
        }
    }
}

/// A pass that is being traced.
pub(super) struct TracedPass<'a> {
    pub(super) method: &'a TwoPasses,
    /// Whose numbers photons and camera paths have.
    pub(super) streams: [Stream; 2],
    pub(super) pass: &'a Pass<'a>,
    pub(super) cancel: &'a AtomicBool,
}

/// The photons that a pixel looks at.
pub(super) struct Seen<P, D> {
    pub(super) maps: Maps<Vec<P>>,
    pub(super) direct: DirectLight<D>,
}

/// Photons in cells, as they are traced.
pub(super) type SeenInGrid = Seen<PhotonMap<f32>, PhotonMap<LightSegment>>;

impl SeenInGrid {
    /// The same in trees.
    fn into_trees(self) -> Seen<KdTree<OriginPhoton>, KdTree<LightPhoton>> {
        let trees = |maps: Vec<PhotonMap<f32>>| maps.into_iter().map(KdTree::from).collect();
        let Maps { global, caustic } = self.maps;
        Seen { maps: Maps { global: trees(global), caustic: trees(caustic) }, direct: self.direct.map(KdTree::from) }
    }
}

/// A set of maps, and how often a pixel that looks at it has looked at others before.
#[derive(Clone, Copy)]
pub(super) struct Step {
    /// Index of the set in the pass.
    pub(super) set: u32,
    /// Index of the pixel's sample in the pass.
    pub(super) sample: u32,
}

impl TracedPass<'_> {
    /// Traces the pass.
    pub(super) fn trace(&self, pixels: &mut [PixelTally]) -> Option<Counters> {
        match &self.method.choice {
            MapChoice::Only => {
                let step = Step { set: 0, sample: 0 };
                self.step(step, pixels, |_, _| true, self.adds_to_tallies())
            }
            MapChoice::Skipping(sets) => self.skip(*sets, pixels),
            MapChoice::Hierarchy(hierarchy) => self.trace_hierarchy(hierarchy, pixels),
        }
    }

    fn adds_to_tallies(&self) -> impl Fn(&mut PixelTally, Rgb, &mut Counters) + Sync {
        |tally, radiance, counters| add_to_tally(tally, self.pass, radiance, &Gathered::default(), counters)
    }

    /// Every set is looked at by as many pixels of the picture, which are strewn over it at random, anew in every pass.
    fn skip(&self, sets: u32, pixels: &mut [PixelTally]) -> Option<Counters> {
        let TwoPasses { scene, seed, .. } = self.method;
        let random = PathRandom::new(*seed, Stream::MapChoice, self.pass.index, 0);
        let order = Permutation::new(&random, scene.pixel_count() as u32);
        let first = self.pass.region.row_start * scene.width;
        let chosen: Vec<u32> = (first..).zip(&*pixels).map(|(pixel, _)| order.place(pixel) % sets).collect();
        let mut total = Counters::default();
        for set in (0..sets).filter(|set| chosen.contains(set)) {
            let step = Step { set, sample: 0 };
            let looks = |pixel: u32, _: &PixelTally| chosen[(pixel - first) as usize] == set;
            total += self.step(step, pixels, looks, self.adds_to_tallies())?;
        }
        Some(total)
    }

    /// Each map adds to the details of the levels that look at it. Those pixels that are localized then look at all others, which are traced
    /// a second time: 40 bytes are kept of each pixel, and of no map.
    fn trace_hierarchy(&self, hierarchy: &Hierarchy, pixels: &mut [PixelTally]) -> Option<Counters> {
        let TwoPasses { scene, parameters, .. } = self.method;
        let width = scene.width as usize;
        let maps = hierarchy.maps();
        let step = |map: u32| Step { set: map, sample: map };
        let samples = |pixel: u32| hierarchy.samples(pixel % scene.width);
        let mut nodes = vec![Node::default(); pixels.len()];
        let mut total = Counters::default();
        for map in 0..maps {
            let looks = |pixel: u32, _: &Node| samples(pixel) > map;
            total += self.step(step(map), &mut nodes, looks, |node, radiance, counters| {
                node.seen = finite_or_black(radiance, counters);
            })?;
            nodes.par_chunks_mut(width).for_each(|row| hierarchy.add(row, map));
        }
        let contrast = parameters.localization.get() as f32 / 100.0;
        if contrast > 0.0 {
            nodes.par_chunks_mut(width).for_each(|row| hierarchy.localize(row, contrast));
        }
        if parameters.show == ShownPart::Localized {
            nodes.iter_mut().for_each(|node| node.seen = if node.is_localized { Rgb::ONE } else { Rgb::ZERO });
        } else {
            total += self.look_at_all_maps(hierarchy, &mut nodes)?;
            nodes.par_chunks_mut(width).for_each(|row| hierarchy.reconstruct(row));
        }
        let add = self.adds_to_tallies();
        pixels.iter_mut().zip(&nodes).for_each(|(tally, node)| add(tally, node.seen, &mut total));
        Some(total)
    }

    /// Localized nodes look at the maps that they have not looked at.
    fn look_at_all_maps(&self, hierarchy: &Hierarchy, nodes: &mut [Node]) -> Option<Counters> {
        let width = self.method.scene.width;
        let samples = |pixel: u32| hierarchy.samples(pixel % width);
        let localized = (0..).zip(&*nodes).filter(|(_, node)| node.is_localized);
        let first = localized.map(|(pixel, _)| samples(pixel)).min().unwrap_or(hierarchy.maps());
        let mut total = Counters::default();
        for map in first..hierarchy.maps() {
            let step = Step { set: map, sample: map };
            let looks = |pixel: u32, node: &Node| node.is_localized && samples(pixel) <= map;
            total += self.step(step, nodes, looks, |node, radiance, counters| {
                node.sum += finite_or_black(radiance, counters);
            })?;
        }
        Some(total)
    }

    /// Traces a set of maps and has those pixels of the region look at it that `looks` names; `keep` takes what each sees.
    fn step<T: Send>(
        &self,
        step: Step,
        pixels: &mut [T],
        looks: impl Fn(u32, &T) -> bool + Sync,
        keep: impl Fn(&mut T, Rgb, &mut Counters) + Sync,
    ) -> Option<Counters> {
        let (seen, mut total) = self.trace_seen(step.set)?;
        total += self.look_at(seen, step, pixels, looks, keep)?;
        Some(total)
    }

    /// Traces the photons of a set.
    pub(super) fn trace_seen(&self, set: u32) -> Option<(SeenInGrid, Counters)> {
        let (maps, mut total) = self.method.trace_photons(self.streams[0], self.pass, set, self.cancel)?;
        let direct = self.method.trace_direct(self.streams[0], self.pass, set, &mut total, self.cancel)?;
        Some((Seen { maps, direct }, total))
    }

    /// Has pixels look at photons.
    pub(super) fn look_at<T: Send>(
        &self,
        seen: SeenInGrid,
        step: Step,
        pixels: &mut [T],
        looks: impl Fn(u32, &T) -> bool + Sync,
        keep: impl Fn(&mut T, Rgb, &mut Counters) + Sync,
    ) -> Option<Counters> {
        let counters = match self.method.parameters.structure {
            Structure::Grid => self.look_in(&seen, step, pixels, looks, keep),
            Structure::KdTree => self.look_in(&seen.into_trees(), step, pixels, looks, keep),
        };
        (!self.cancel.load(Ordering::Relaxed)).then_some(counters)
    }

    fn look_in<P: OriginLookup, D: LightLookup, T: Send>(
        &self,
        seen: &Seen<P, D>,
        step: Step,
        pixels: &mut [T],
        looks: impl Fn(u32, &T) -> bool + Sync,
        keep: impl Fn(&mut T, Rgb, &mut Counters) + Sync,
    ) -> Counters {
        let TracedPass { method, pass, cancel, .. } = *self;
        let width = method.scene.width;
        let paths = method.parameters.camera_paths.get();
        let random = PassRandom::of_pixels(method.seed, self.streams[1], pass.index).sample(step.sample);
        let (cache, mut total) = method.cache_irradiance(seen, &random.part(0, paths), cancel);
        let trace_row = |(row, pixels): (usize, &mut [T])| {
            let mut gathering = LocalPass::new(method, seen, cache.as_ref());
            let mut counters = Counters::default();
            if cancel.load(Ordering::Relaxed) {
                return counters;
            }
            let y = pass.region.row_start + row as u32;
            for (x, kept) in (0..).zip(pixels).filter(|(x, kept)| looks(y * width + x, kept)) {
                let mut sum = Rgb::ZERO;
                for path in 0..paths {
                    let random = random.part(path, paths);
                    sum += gathering.pixel([x, y], &random.path(y * width + x), &mut counters);
                }
                keep(kept, sum / paths as f32, &mut counters);
            }
            counters
        };
        let counters: Vec<Counters> = pixels.par_chunks_mut(width as usize).enumerate().map(trace_row).collect();
        counters.into_iter().for_each(|counters| total += counters);
        total
    }
}

/// A sample that is not finite counts as black; it is dropped and counted.
fn finite_or_black(radiance: Rgb, counters: &mut Counters) -> Rgb {
    if radiance.is_finite() {
        return radiance;
    }
    counters.non_finite += 1;
    Rgb::ZERO
}
