//! A path near one that a user gave, joined with the camera subpath up to its first surface that is not specular [Fan et al. 2005, section 5].
//!
//! Most paths could not have been made so, and the way back would be impossible; but bidirectional changes can make any. So both kinds share one density
//! [eq. 7]. The paper turns by angles θ that are uniform up to β around the segment of the given path; here directions are uniform in the cone around the
//! one that leads to the given point, so that large lamps do not lead astray, and densities are finite in its middle.

use super::{Draft, Kept, Known, Proposal};
use crate::math::{Frame, Vec3, warp};
use crate::scene::geometry::{Interaction, Ray};
use crate::scene::material::{Lobes, TransportMode, View};
use crate::transport::metropolis::mutation::Source;
use crate::transport::metropolis::path_space::extension::Tracer;
use crate::transport::metropolis::path_space::light_end::LightEnd;
use crate::transport::metropolis::path_space::lobe_choice::{Lobe, LobeChoice};
use crate::transport::metropolis::path_space::path::PathVertex;
use crate::transport::metropolis::path_space::user_path::{UserPath, UserPoint};
use crate::transport::metropolis::path_space::{Path, PathSpace};

impl PathSpace<'_> {
    /// Makes a path near a given one.
    pub(super) fn follow_user(
        &self,
        from: Known<'_>,
        to: &mut Path,
        tracer: &mut Tracer<'_>,
        source: &mut Source,
    ) -> Option<Draft> {
        let first = from.path.first_smooth_from_eye()?;
        let count = self.user_paths.len();
        let user = self.user_paths.get(((source.number() * count as f32) as usize).min(count.checked_sub(1)?))?;
        let light = LightEnd::at(self.scene, user.light, [0; 5].map(|_| source.number()))?;
        to.light = Some(light);
        to.lens = from.path.lens;
        to.vertices.clear();
        for point in &user.points {
            let ray = match to.vertices.last().copied() {
                None => self.ray_from_lamp(&light, point, source)?,
                Some(last) if last.lobe == Lobe::Specular => {
                    self.ray_from_mirror(&last, &to.vertices, &light, point)?
                }
                Some(last) => last.hit.ray_to(in_cone(last.hit.position, point, source)?),
            };
            let hit = tracer.surface(&ray)?;
            if !point.is_specular && !self.scene.lobes_at(hit.shape).any(Lobes::SMOOTH) {
                return None;
            }
            let lobe = if point.is_specular { Lobe::Specular } else { Lobe::Smooth };
            to.vertices.push(PathVertex { hit, lobe });
        }
        to.vertices.extend_from_slice(&from.path.vertices[first - 1..]);
        let camera = from.path.segments() + 1 - first;
        Some(Draft { kept: Kept { light: 0, camera }, connection: user.points.len() + 1 })
    }

    fn ray_from_lamp(&self, light: &LightEnd, point: &UserPoint, source: &mut Source) -> Option<Ray> {
        let first = light.segment(self.scene, point.position)?;
        let position = light.position(self.scene, &first, point.position)?;
        Some(Ray::new(position, in_cone(position, point, source)?))
    }

    /// The ray that leaves a mirror or glass, the last of `vertices`, nearest to the direction of the next point.
    fn ray_from_mirror(
        &self,
        mirror: &PathVertex,
        vertices: &[PathVertex],
        light: &LightEnd,
        next: &UserPoint,
    ) -> Option<Ray> {
        let hit = &mirror.hit;
        let back = match vertices.len() {
            1 => light.segment(self.scene, hit.position)?.direction,
            count => (vertices[count - 2].hit.position - hit.position).normalize(),
        };
        let arrived = Interaction { outgoing: back, ..*hit };
        let choice = LobeChoice::new(self.scene, hit.shape, &View::at(&arrived, TransportMode::Flux));
        let wanted = hit.frame.to_local((next.position - hit.position).normalize());
        Some(hit.ray_to(hit.frame.to_world(choice.nearest(wanted)?.direction)))
    }

    /// The density with which bidirectional changes and given paths together make `to` of `from` [eq. 7].
    pub(super) fn hybrid_density(&self, kept: Kept, from: Known<'_>, to: Known<'_>) -> f64 {
        let (bidirectional, user) = (self.shares.of(Proposal::Bidirectional), self.shares.of(Proposal::User));
        let density = user * self.user_density(kept, from, to) + bidirectional * self.gap_density(kept, from, to);
        density / (bidirectional + user)
    }

    /// The density with which given paths lead to `to` [eq. 6].
    fn user_density(&self, kept: Kept, from: Known<'_>, to: Known<'_>) -> f64 {
        let camera = |path: &Path| Some(path.segments() + 1 - path.first_smooth_from_eye()?);
        let has_same_end = |path: &Path| camera(path) == Some(kept.camera);
        if kept.light != 0 || !has_same_end(from.path) || !has_same_end(to.path) || self.user_paths.is_empty() {
            return 0.0;
        }
        let new = to.path.segments() - kept.camera;
        let densities = self.user_paths.iter().filter(|user| user.points.len() == new);
        densities.map(|user| self.density_near(user, to)).sum::<f64>() / self.user_paths.len() as f64
    }

    fn density_near(&self, user: &UserPath, to: Known<'_>) -> f64 {
        let Some(light) = to.path.light else { return 0.0 };
        let (first, vertices) = (&to.terms.first, &to.terms.vertices);
        let start = light.position(self.scene, first, to.path.vertices[0].hit.position);
        let (true, Some(position)) = (light.index() == Some(user.light), start) else { return 0.0 };
        let picked = f64::from(self.scene.lights.emission_pick(user.light));
        let squared = f64::from(first.distance * first.distance);
        let leaving = cone_density(position, -first.direction, &user.points[0]);
        let mut density = first.place / picked * leaving * vertices[0].light_cosine / squared;
        for (index, point) in user.points.iter().enumerate() {
            if to.path.is_specular(index + 1) != point.is_specular {
                return 0.0;
            }
            let Some(next) = user.points.get(index + 1) else { break };
            let (vertex, position) = (&vertices[index], to.path.vertices[index].hit.position);
            let direction = match point.is_specular {
                true => vertex.to_camera / vertex.light_lobe,
                false => cone_density(position, vertex.camera_direction, next) / vertex.camera_cosine,
            };
            density *= direction * to.terms.edges[index + 1];
        }
        density
    }
}

/// A direction from `position` in the cone around the one to a point.
fn in_cone(position: Vec3, point: &UserPoint, source: &mut Source) -> Option<Vec3> {
    let axis = (point.position - position).try_normalize()?;
    let local = warp::cone(point.one_minus_cosine, [source.number(), source.number()]);
    Some(Frame::from_normal(axis).to_world(local).normalize())
}

/// Its density by solid angle.
fn cone_density(position: Vec3, direction: Vec3, point: &UserPoint) -> f64 {
    let Some(axis) = (point.position - position).try_normalize() else { return 0.0 };
    // The difference of unit vectors is exact where their product is not.
    let one_minus_cosine = 0.5 * (axis - direction).length_squared();
    match one_minus_cosine <= point.one_minus_cosine {
        true => f64::from(warp::cone_pdf(point.one_minus_cosine)),
        false => 0.0,
    }
}
