//! Another direction from the first surface of the camera path that is not specular back towards the light, as a final gather spreads its rays
//! [Fan et al. 2005, section 5.3].

use super::{Draft, Kept, Known};
use crate::scene::material::TransportMode;
use crate::transport::metropolis::mutation::Source;
use crate::transport::metropolis::path_space::extension::Tracer;
use crate::transport::metropolis::path_space::{Path, PathSpace};

/// The largest turn, radians: 30°, as in the paper.
const LARGEST_TURN: f32 = std::f32::consts::FRAC_PI_6;

impl PathSpace<'_> {
    /// Turns the segment from the first smooth vertex to the second, follows it, and joins its end with the rest.
    pub(super) fn turn_at_first_smooth(
        &self,
        from: Known<'_>,
        to: &mut Path,
        tracer: &mut Tracer<'_>,
        source: &mut Source,
    ) -> Option<Draft> {
        let first = from.path.first_smooth_from_eye()?;
        let second = (1..first).rev().find(|index| !from.path.is_specular(*index))?;
        if second > 1 && from.path.is_specular(second - 1) {
            return None;
        }
        let turned = source.turned_evenly(from.terms.vertices[first - 1].light_direction, LARGEST_TURN);
        let ray = from.path.vertices[first - 1].hit.ray_to(turned);
        tracer.follow_specular(&ray, TransportMode::Radiance, source)?;
        (to.light, to.lens) = (from.path.light, from.path.lens);
        to.vertices.clear();
        to.vertices.extend_from_slice(&from.path.vertices[..second - 1]);
        to.vertices.extend(tracer.chain.iter().rev());
        to.vertices.extend_from_slice(&from.path.vertices[first - 1..]);
        let camera = from.path.segments() + 1 - first;
        Some(Draft { kept: Kept { light: second, camera }, connection: second })
    }
}

/// The density with which the chain between the kept vertices is made.
pub(super) fn first_smooth_density(kept: Kept, to: Known<'_>) -> f64 {
    let (vertices, edges) = (&to.terms.vertices, &to.terms.edges);
    let first = to.path.segments() + 1 - kept.camera;
    let second = kept.light;
    // A direction has the same density both ways by solid angle.
    let turned = edges[first - 1] / vertices[first - 1].light_cosine;
    let chain: f64 = (second + 1..first).map(|index| vertices[index - 1].to_light * edges[index - 1]).product();
    turned * chain * vertices[second - 1].camera_lobe
}
