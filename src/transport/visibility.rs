//! How much light passes from one point to another.

use super::{Counters, shading};
use crate::math::Rgb;
use crate::math::random::{Numbers, dimension};
use crate::scene::geometry::Ray;
use crate::scene::material::TransportMode;
use crate::scene::{MediumIndex, Scene};

/// Rays to lights end this share before the light, so that rounding does not let the light hide itself.
pub(crate) const SHADOW_END: f32 = 1.0 - 1.0 / 65_536.0;
/// The most surfaces that light is sampled through: what is left is lost in rounding.
const MOST_PASSED: u32 = dimension::FLIGHTS;

/// Which surfaces are in the way of light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Blockers {
    /// All.
    All,
    /// Those that the camera sees.
    Seen,
    /// Those that nothing passes straight on: light goes through panes, holes of masks and the borders of media.
    Turning,
}

/// A straight line between two points that a path joins.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Joint<'a, N> {
    /// From one to the other.
    pub ray: Ray,
    /// The medium that it begins in.
    pub medium: MediumIndex,
    /// What is in the way.
    pub blockers: Blockers,
    /// The random numbers of the path; media that vary are tracked with them.
    pub random: &'a N,
    /// The step of the path at which it is joined.
    pub step: u32,
}

/// The share of light that passes: 0 where something is in the way, less than 1 where a medium is.
#[inline(always)]
pub(crate) fn transmittance<N: Numbers>(scene: &Scene, joint: &Joint<'_, N>, counters: &mut Counters) -> Rgb {
    if joint.blockers == Blockers::Turning {
        return through_surfaces(scene, *joint, counters);
    }
    counters.rays += 1;
    // A copy: a joint whose parts are known elsewhere by address would not be kept in registers.
    let ray = joint.ray;
    let is_blocked = match joint.blockers {
        Blockers::Seen => scene.is_hidden_from_camera(&ray),
        _ => scene.geometry.is_blocked(&ray),
    };
    match is_blocked {
        true => Rgb::ZERO,
        false => transmittance_of_media(scene, joint),
    }
}

/// The same where nothing is known to be in the way.
#[inline(always)]
pub(crate) fn transmittance_of_media<N: Numbers>(scene: &Scene, joint: &Joint<'_, N>) -> Rgb {
    if joint.medium.is_none() { Rgb::ONE } else { through_medium(scene, *joint, 0) }
}

// What scenes without media never call takes values, for the same reason.

/// The share that the medium lets pass on the part of a joint behind `passed` surfaces.
#[cold]
#[inline(never)]
fn through_medium<N: Numbers>(scene: &Scene, part: Joint<'_, N>, passed: u32) -> Rgb {
    let numbers = || part.random.branch(dimension::joint(part.step, passed));
    scene.medium(part.medium).map_or(Rgb::ONE, |medium| medium.transmittance(&part.ray, numbers))
}

#[cold]
#[inline(never)]
fn through_surfaces<N: Numbers>(scene: &Scene, mut rest: Joint<'_, N>, counters: &mut Counters) -> Rgb {
    let direction = rest.ray.direction;
    let mut passing = Rgb::ONE;
    for passed in 0..MOST_PASSED {
        counters.rays += 1;
        let found = scene.intersect(&rest.ray);
        let length = found.as_ref().map_or(rest.ray.length, |hit| hit.distance);
        if rest.medium.is_some() {
            passing *= through_medium(scene, Joint { ray: Ray { length, ..rest.ray }, ..rest }, passed);
        }
        let Some(hit) = found else { return passing };
        let view = shading::view(&hit, TransportMode::Radiance);
        let lobes = scene.material(hit.shape).specular_lobes(&view);
        let Some(straight) = lobes.iter().flatten().find(|lobe| lobe.direction == -view.outgoing) else {
            return Rgb::ZERO;
        };
        passing *= straight.weight;
        if passing == Rgb::ZERO {
            return passing;
        }
        rest.medium = scene.medium_beyond(&hit, direction, rest.medium);
        rest.ray = Ray { length: rest.ray.length - length, ..hit.ray_to(direction) };
    }
    Rgb::ZERO
}
