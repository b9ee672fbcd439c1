//! Photons of whole paths: Metropolis photon sampling [Fan et al. 2005, "Metropolis photon sampling with optional user guidance"].
//!
//! Chains move through paths from a light to the camera in proportion to what they bring to the picture. A path leaves a photon where a final gather looks
//! for one: in the global map at the second surface from the eye that is no mirror, in the caustic map at the first if nothing but mirrors and glass comes
//! before [section 3.1].
//!
//! The paper weights a photon by f_map/f_eye [eq. 3], where f_map is what brings its flux and f_eye the whole path. The mean of this over all paths is the
//! flux times the measure of all ways from the photon to the eye, so that it depends on the size of the scene. Here a photon has
//!
//! Φ = (b/n) · f_map/f_map* · m / mean(I_1 … I_K),
//!
//! I_1 being what the path's own way to the eye brings of the photon over the density of that way as a camera subpath, and I_2 … I_K the same of K − 1
//! camera subpaths that are independent of it. To each open way the usual importance is added, also in what chains seek: a photon whose only way brings
//! next to nothing would else have next to any power. All K are alike before one is looked at, so that by symmetry the mean of I_1/mean(I_1 … I_K) is the
//! probability that some of K ways is open; m, how many groups of K ways have to be looked at until one has an open way, has its inverse as its mean.
//! So the means of all photons are right, and K = 1 is the paper's weight with a measure of 1.

use super::chains::{Change, Space};
use super::eye_subpaths::EyeSubpaths;
use super::mutation::Source;
use super::path_space::path::{Path, PathVertex, PhotonPlace, Terms};
use super::path_space::{PathSpace, PathState};
use crate::math::color::luminance;
use crate::math::{Rgb, Vec3};
use crate::scene::geometry::Interaction;
use crate::transport::Counters;
use crate::transport::photon_map::{OriginPhoton, PathSegment, PhotonRecord, TracedPhoton};
use crate::transport::photon_tracing::stored;

/// Paths of a chain often leave their photons at the same place; it is looked for among so many.
const RECENT: usize = 16;
/// More groups of ways are not looked at: a photon that hardly anything sees brings hardly anything.
const MOST_GROUPS: u32 = 64;

/// Paths that leave photons.
pub struct PhotonPaths<'a> {
    /// The paths.
    pub paths: PathSpace<'a>,
    /// Ways to the eye.
    pub eye: &'a EyeSubpaths,
    /// K.
    pub ways: u32,
    /// Look-ups divide by so many photons.
    pub photons: f32,
}

/// A path and its photon.
#[derive(Default)]
pub struct PhotonState {
    path: PathState,
    photon: Option<OriginPhoton>,
}

impl Space for PhotonPaths<'_> {
    type State = PhotonState;
    type Brought = OriginPhoton;

    fn renew(&self, state: &mut PhotonState, source: &mut Source, counters: &mut Counters) {
        self.paths.renew(&mut state.path, source, counters);
        self.store(state, source, counters);
    }

    fn change(&self, from: &PhotonState, to: &mut PhotonState, source: &mut Source, counters: &mut Counters) -> Change {
        let change = self.paths.change(&from.path, &mut to.path, source, counters);
        self.store(to, source, counters);
        change
    }

    fn target(&self, state: &PhotonState) -> f32 {
        self.paths.target(&state.path)
    }

    fn show(&self, state: &PhotonState, weight: f32, photons: &mut Vec<OriginPhoton>) {
        let Some(photon) = state.photon.filter(|_| weight > 0.0) else { return };
        let photon = photon.scaled(weight);
        let is_same = |other: &&mut OriginPhoton| {
            (other.photon.position, other.photon.direction) == (photon.photon.position, photon.photon.direction)
        };
        match photons.iter_mut().rev().take(RECENT).find(is_same) {
            Some(same) => same.photon.flux = (Rgb::from(same.photon.flux) + Rgb::from(photon.photon.flux)).to_array(),
            None => photons.push(photon),
        }
    }
}

impl PhotonPaths<'_> {
    /// The photon of a state; its flux is that over the density of the path as an independent sample.
    fn store(&self, state: &mut PhotonState, source: &mut Source, counters: &mut Counters) {
        state.photon = None;
        let PathState { path, terms, is_known: true, .. } = &state.path else { return };
        let Some(place) = path.photon_place() else { return };
        let target = self.paths.target(&state.path) * self.photons;
        state.photon = self.photon(path, terms, place, target, source, counters);
    }

    fn photon(
        &self,
        path: &Path,
        terms: &Terms,
        place: PhotonPlace,
        target: f32,
        source: &mut Source,
        counters: &mut Counters,
    ) -> Option<OriginPhoton> {
        let PhotonPlace { index, is_caustic } = place;
        let vertex = path.vertices[index - 1];
        let (incident, color) = (terms.vertices[index - 1].light_direction, terms.color(index));
        let own = terms.importance(index, self.paths.scene, &self.paths.window);
        let share = match is_caustic {
            // There is one way to the eye from a place that it sees.
            true => 1.0 / own,
            false => self.share(&vertex, incident, color, own, source, counters),
        };
        let length = match index {
            1 => terms.first.distance,
            _ => vertex.hit.position.distance(path.vertices[index - 2].hit.position),
        };
        let flux = color * (target * share);
        let arrived = Interaction { outgoing: incident, distance: length, ..vertex.hit };
        let photon = stored(&arrived, flux, index as u32, !is_caustic).filter(|_| flux.is_finite())?;
        Some(OriginPhoton::traced(photon, PathSegment { path: 0, length }))
    }

    /// m/mean(I_1 … I_K).
    fn share(
        &self,
        at: &PathVertex,
        incident: Vec3,
        color: Rgb,
        own: f32,
        source: &mut Source,
        counters: &mut Counters,
    ) -> f32 {
        let least = self.paths.least_importance;
        let mut look = |counters: &mut Counters| {
            let way = self.eye.pick(source.number());
            let found = way.map(|way| luminance(color * way.importance(self.paths.scene, at, incident, counters)));
            found.filter(|importance| *importance > 0.0).map_or(0.0, |importance| importance + least)
        };
        let mut sum = own + least;
        for _ in 1..self.ways {
            sum += look(counters);
        }
        let mut groups = 1;
        while groups < MOST_GROUPS && !(0..self.ways).any(|_| look(counters) > 0.0) {
            groups += 1;
        }
        groups as f32 * self.ways as f32 / sum
    }
}
