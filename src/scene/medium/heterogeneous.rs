//! `heterogeneous`: extinction and albedo vary from place to place.
//!
//! Flights are those through a medium that is as dense everywhere as this one is anywhere, in which the collisions that are too many
//! change nothing: "null collisions". Channels share a flight and weigh it each by itself:
//! where their extinctions differ by much, light that is scattered often is noisy.
//!
//! References: [W] Woodcock et al. 1965, "Techniques used in the GEM code"; [N] Novák, Georgiev, Hanika & Jarosz 2018, "Monte Carlo
//! methods for volumetric light transport simulation", sections 3.2 and 4.2; [K] Kutz, Habel, Li & Novák 2017, "Spectral and
//! decomposition tracking for rendering heterogeneous volumes".

use super::volume::Volume;
use crate::math::random::PathRandom;
use crate::math::{Rgb, Vec3};
use crate::scene::geometry::Ray;

/// The most collisions of a flight: beyond so many nothing is left of light that any picture shows.
const MOST_COLLISIONS: u32 = 1 << 16;

/// A medium that varies.
#[derive(Clone, Debug)]
pub(crate) struct Heterogeneous {
    extinction: Volume,
    albedo: Volume,
    /// Factor on the extinction.
    scale: f32,
    /// The largest extinction of any channel, m⁻¹.
    majorant: f32,
}

/// What a collision may be: true with the extinction, null with the rest, m⁻¹.
struct Collision {
    extinction: Rgb,
    /// The share of light that a true one scatters.
    albedo: Rgb,
    null: Rgb,
}

impl Heterogeneous {
    /// With an extinction, m⁻¹, times `scale`, and an albedo.
    pub(super) fn new(extinction: Volume, albedo: Volume, scale: f32) -> Self {
        let majorant = extinction.largest() * scale;
        Self { extinction, albedo, scale, majorant }
    }

    /// The share of light that passes the ray's length, estimated by ratio tracking [N, eq. 40].
    pub(super) fn transmittance(&self, ray: &Ray, random: &PathRandom) -> Rgb {
        let mut passing = Rgb::ONE;
        for (position, _) in self.collisions(ray, random) {
            passing *= self.collide(position).null / self.majorant;
            if passing == Rgb::ZERO {
                break;
            }
        }
        passing
    }

    /// Samples how far the ray gets within its length: where it is scattered, and the weight. At a collision the mean over the
    /// channels of what is carried chooses between a true one and none [K, section 5.1]; a true one scatters, and absorption weighs.
    pub(super) fn fly(&self, ray: &Ray, random: &PathRandom) -> (Option<f32>, Rgb) {
        let mut weight = Rgb::ONE;
        for (position, [distance, u]) in self.collisions(ray, random) {
            let Collision { extinction, albedo, null } = self.collide(position);
            // Where nothing scatters a true collision would only end the path.
            let collided = if albedo == Rgb::ZERO { Rgb::ZERO } else { weight * extinction };
            let passed = weight * null;
            let share = collided.element_sum() / (collided + passed).element_sum();
            if u < share {
                return (Some(distance), collided * albedo / (self.majorant * share));
            }
            weight = passed / (self.majorant * (1.0 - share));
            if weight == Rgb::ZERO || !weight.is_finite() {
                return (None, Rgb::ZERO);
            }
        }
        (None, weight)
    }

    /// Places, distances, m, and a number each of collisions along a ray.
    fn collisions<'a>(&'a self, ray: &'a Ray, random: &'a PathRandom) -> impl Iterator<Item = (Vec3, [f32; 2])> + 'a {
        let [mut distance, end] = self.extinction.reach(ray);
        (0..MOST_COLLISIONS).map_while(move |collision| {
            let [step, u, ..] = random.block(collision);
            distance += -libm::log1pf(-step) / self.majorant;
            (distance < end).then(|| (ray.at(distance), [distance, u]))
        })
    }

    fn collide(&self, position: Vec3) -> Collision {
        let extinction = self.extinction.at(position) * self.scale;
        let null = (Rgb::splat(self.majorant) - extinction).max(Rgb::ZERO);
        Collision { extinction, albedo: self.albedo.at(position), null }
    }
}
