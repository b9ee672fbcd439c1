//! Another direction into a chain of mirrors and glass that ends where the camera looks [Veach 1997, 11.4.3.2].

use super::{Draft, Kept, Known};
use crate::scene::geometry::Ray;
use crate::scene::material::TransportMode;
use crate::transport::metropolis::mutation::Source;
use crate::transport::metropolis::path_space::extension::Tracer;
use crate::transport::metropolis::path_space::{Path, PathSpace};

/// The smallest and the largest turn, radians.
const TURNS: [f32; 2] = [1e-4, 0.2];

impl PathSpace<'_> {
    /// Turns the segment that leads into a caustic, follows it, and joins its end with the camera.
    pub(super) fn turn_into_specular(
        &self,
        from: Known<'_>,
        to: &mut Path,
        tracer: &mut Tracer<'_>,
        source: &mut Source,
    ) -> Option<Draft> {
        let last = from.path.segments() - 1;
        if last < 2 || from.path.is_specular(last) || !from.path.is_specular(last - 1) {
            return None;
        }
        let start = (0..last).rev().find(|index| *index == 0 || !from.path.is_specular(*index))?;
        let ray = match start {
            0 => {
                let position =
                    from.path.light?.position(self.scene, &from.terms.first, from.path.vertices[0].hit.position)?;
                Ray::new(position, source.turned(-from.terms.first.direction, TURNS))
            }
            _ => {
                let direction = source.turned(from.terms.vertices[start - 1].camera_direction, TURNS);
                from.path.vertices[start - 1].hit.ray_to(direction)
            }
        };
        tracer.follow_specular(&ray, TransportMode::Flux, source)?;
        if tracer.chain.len() < 2 {
            // The way back begins with a specular surface.
            return None;
        }
        (to.light, to.lens) = (from.path.light, from.path.lens);
        to.vertices.clear();
        to.vertices.extend_from_slice(&from.path.vertices[..start]);
        to.vertices.extend_from_slice(tracer.chain);
        Some(Draft { kept: Kept { light: start + 1, camera: 1 }, connection: to.segments() })
    }
}

/// The density with which the chain behind the kept vertices is made.
pub(super) fn caustic_density(kept: Kept, to: Known<'_>) -> f64 {
    let (vertices, edges) = (&to.terms.vertices, &to.terms.edges);
    let last = vertices.len();
    let start = kept.light - 1;
    // A direction has the same density both ways by solid angle.
    let turned = match start {
        0 => vertices[0].light_cosine / f64::from(to.terms.first.distance * to.terms.first.distance),
        _ => edges[start] / vertices[start - 1].camera_cosine,
    };
    let chain: f64 = (start + 1..last).map(|index| vertices[index - 1].to_camera * edges[index]).product();
    turned * chain * vertices[last - 1].light_lobe
}
