//! One scattering event of a walk: sampling, the checks and corrections that shading normals need.

use crate::math::{Rgb, Vec3};
use crate::scene::geometry::Interaction;
use crate::scene::material::{Material, MaterialSample, TransportMode, View};

/// A scattered path.
#[derive(Clone, Copy, Debug)]
pub struct Scattering {
    /// Unit direction in which the path goes on, world space.
    pub direction: Vec3,
    /// Factor on what the path carries.
    pub weight: Rgb,
    /// The sample in the local frame.
    pub sample: MaterialSample,
}

impl Scattering {
    /// Whether the path passed through the surface at `hit` as if there were none.
    #[inline]
    pub fn is_straight(&self, hit: &Interaction) -> bool {
        self.sample.is_specular() && self.sample.direction == -hit.frame.to_local(hit.outgoing)
    }
}

/// The surface as the path that came to `hit` sees it, with all lobes.
#[inline]
pub fn view(hit: &Interaction, mode: TransportMode) -> View {
    View::at(hit, mode)
}

/// The true normal on the side from which the path came.
#[inline]
pub fn facing_normal(hit: &Interaction) -> Vec3 {
    if hit.outgoing.dot(hit.geometric_normal) < 0.0 { -hit.geometric_normal } else { hit.geometric_normal }
}

/// Samples `material` at `hit` with three numbers; `None` where the path ends.
#[inline]
pub fn scatter(hit: &Interaction, material: &Material, view: &View, u: [f32; 3]) -> Option<Scattering> {
    let sample = material.sample(view, u)?;
    finish(hit, view, sample)
}

/// Turns a local sample into a step of the walk.
///
/// Directions that leave on one side of the shading normal and on the other of the true one are ended: they would leak
/// through the surface. Flux takes the factor `|ωo·Ns||ωi·Ng|/(|ωo·Ng||ωi·Ns|)` [Veach 1997, eq. 5.19].
#[inline]
pub fn finish(hit: &Interaction, view: &View, sample: MaterialSample) -> Option<Scattering> {
    let direction = hit.frame.to_world(sample.direction);
    let mut weight = sample.weight;
    if hit.frame.normal != hit.geometric_normal {
        let out_geometric = hit.outgoing.dot(hit.geometric_normal);
        let in_geometric = direction.dot(hit.geometric_normal);
        if out_geometric * view.outgoing.z <= 0.0 || in_geometric * sample.direction.z <= 0.0 {
            return None;
        }
        if view.mode == TransportMode::Flux {
            weight *= ((view.outgoing.z * in_geometric) / (out_geometric * sample.direction.z)).abs();
        }
    }
    Some(Scattering { direction, weight, sample })
}
