//! Plausibility tests: what a photon's direction and place alone tell of whether it belongs to a point [Wald 1999, section 4.1].
//!
//! | test | photons that do not count | right | wrong |
//! |---|---|---|---|
//! | arrival angle | came from more than so many degrees off the point's normal | over a ridge | round a convex surface, which is lit from more than one half space |
//! | culling plane | lie behind the plane through the point | on a floor under a shelf | on a convex surface, all of which lies behind the plane |
//!
//! They are heuristics. What a wall hides is what [`occlusion`](super::occlusion) finds out. On a sphere of radius R a disc of radius r, at most R/2, and
//! light from everywhere the angle of 90° loses (r/R)²/8 of the light with the disc kernel, and the culling plane all of it.

use crate::math::{Vec3, octahedral};
use crate::scene::geometry::Interaction;

use super::photon_map::{GatherQuery, Photon};

/// Which tests photons have to pass.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Plausibility {
    /// The cosine of the largest angle between the normal and the direction that photons came from; `None` lets all count.
    pub least_arrival_cosine: Option<f32>,
    /// Whether photons behind the plane through the point do not count.
    pub culls_behind: bool,
}

/// Photons up to so many rounding errors behind the plane lie in it.
const IN_PLANE: f32 = 4.0;

impl Plausibility {
    /// The tests at `hit`, for photons that `query` finds; `None` where all pass.
    #[inline]
    pub(crate) fn at(&self, hit: &Interaction, query: &GatherQuery) -> Option<PlausibilityTest> {
        if *self == Self::default() {
            return None;
        }
        Some(PlausibilityTest {
            position: query.position,
            normal: query.normal,
            both_sides: query.both_sides,
            least_cosine: self.least_arrival_cosine.unwrap_or(f32::NEG_INFINITY),
            least_height: if self.culls_behind { -IN_PLANE * hit.error } else { f32::NEG_INFINITY },
        })
    }
}

/// The tests at a point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PlausibilityTest {
    position: Vec3,
    normal: Vec3,
    both_sides: bool,
    least_cosine: f32,
    /// Over the plane, m.
    least_height: f32,
}

impl PlausibilityTest {
    /// Whether `photon` passes.
    #[inline]
    pub(crate) fn accepts(&self, photon: &Photon) -> bool {
        let cosine = octahedral::decode(photon.direction).dot(self.normal);
        let cosine = if self.both_sides { cosine.abs() } else { cosine };
        let height = (Vec3::from_array(photon.position) - self.position).dot(self.normal);
        cosine > self.least_cosine && height >= self.least_height
    }
}
