//! Another place of the film: near the old one or anywhere [Veach 1997, 11.4.3.1, 11.4.4], and through further chains of mirrors and glass behind matte
//! surfaces by small turns there [11.4.3.3].

use super::{Draft, Kept, Known};
use crate::math::Vec2;
use crate::math::trigonometry::sin_cos_turn;
use crate::scene::geometry::Interaction;
use crate::scene::material::{TransportMode, View};
use crate::transport::metropolis::mutation::Source;
use crate::transport::metropolis::path_space::extension::Tracer;
use crate::transport::metropolis::path_space::light_end::LightEnd;
use crate::transport::metropolis::path_space::lobe_choice::{Lobe, LobeChoice};
use crate::transport::metropolis::path_space::path::PathVertex;
use crate::transport::metropolis::path_space::{Path, PathSpace};

/// Where on the film a path goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Move {
    /// Anywhere.
    Anywhere,
    /// By at least [`NEAREST`] pixels, and at most a circle of [`FARTHEST`] of the picture.
    Near,
}

/// The smallest step, pixels.
const NEAREST: f32 = 0.1;
/// The area of the circle that the largest step reaches, as a share of the picture.
const FARTHEST: f32 = 0.05;
/// The smallest and the largest turn behind a matte surface, radians.
const TURNS: [f32; 2] = [1e-4, 0.1];

impl PathSpace<'_> {
    /// Moves the end of a path on the film, and joins what is seen there with the rest.
    pub(super) fn move_film(
        &self,
        from: Known<'_>,
        to: &mut Path,
        kind: Move,
        tracer: &mut Tracer<'_>,
        source: &mut Source,
    ) -> Option<Draft> {
        let first = from.path.first_smooth_from_eye()?;
        let last = from.path.last_of_eye(first)?;
        if kind == Move::Anywhere && last != first {
            return None;
        }
        let u = [source.number(), source.number()];
        let film = match kind {
            Move::Anywhere => self.window.place(u),
            Move::Near => self.near(from.terms.film, u),
        };
        to.lens = from.path.lens;
        if kind == Move::Anywhere {
            to.lens = [source.number(), source.number()];
        }
        if !self.window.contains(film) {
            return None;
        }
        let hit = tracer.seen(film, to.lens)?;
        to.light = from.path.light;
        match last == first {
            true => tracer.follow_specular_from(hit, TransportMode::Radiance, source)?,
            false => {
                let end = self.retrace(from, last, hit, tracer, source)?;
                to.light = end.or(to.light);
            }
        }
        to.vertices.clear();
        to.vertices.extend_from_slice(&from.path.vertices[..last.saturating_sub(1)]);
        to.vertices.extend(tracer.chain.iter().rev());
        Some(Draft { kept: Kept { light: last, camera: 1 }, connection: last })
    }

    /// Goes on from where the camera's ray met a surface down to vertex x_`last`, through vertices of the kinds that the path had, so that the way back is
    /// the same: by specular lobes, and by small turns at the others. Where x₀ is to be hit, too, what is hit there.
    fn retrace(
        &self,
        from: Known<'_>,
        last: usize,
        mut hit: Interaction,
        tracer: &mut Tracer<'_>,
        source: &mut Source,
    ) -> Option<Option<LightEnd>> {
        tracer.chain.clear();
        for index in (last.max(1)..from.path.segments()).rev() {
            let choice = LobeChoice::new(self.scene, hit.shape, &View::at(&hit, TransportMode::Radiance));
            let specular = choice.pick(source.number());
            if from.path.is_specular(index) != specular.is_some() {
                return None;
            }
            let lobe = if specular.is_some() { Lobe::Specular } else { Lobe::Smooth };
            tracer.chain.push(PathVertex { hit, lobe });
            if index == last {
                break;
            }
            let direction = match specular {
                Some(specular) => hit.frame.to_world(specular.direction),
                None => source.turned(from.terms.vertices[index - 1].light_direction, TURNS),
            };
            let next = tracer.surface(&hit.ray_to(direction));
            if index == 1 {
                let end = match next {
                    Some(hit) => LightEnd::of_hit(self.scene, &hit, false)?,
                    None => LightEnd::outside(self.scene, direction)?,
                };
                return Some(Some(end));
            }
            hit = next?;
        }
        Some(None)
    }

    /// A place near another: as likely to lead back.
    fn near(&self, film: Vec2, u: [f32; 2]) -> Vec2 {
        let farthest = (FARTHEST * self.window.pixels() / std::f32::consts::PI).sqrt().max(2.0 * NEAREST);
        let radius = farthest * libm::powf(NEAREST / farthest, u[0]);
        let (sine, cosine) = sin_cos_turn(u[1]);
        film + self.window.pixel() * (radius * Vec2::new(cosine, sine))
    }

    /// The density with which the vertices from the kept ones to the eye are made.
    pub(super) fn film_density(&self, kept: Kept, to: Known<'_>) -> f64 {
        let segments = to.path.segments();
        let mut density = to.terms.camera_subpath(segments - 1, segments, &self.window);
        for index in kept.light..segments - 1 {
            let before = &to.terms.vertices[index];
            let direction = match to.path.vertices[index].lobe {
                Lobe::Specular => before.to_light,
                Lobe::Smooth => 1.0 / before.light_cosine,
            };
            density *= direction * to.terms.edges[index];
        }
        let smooth = (kept.light.max(1)..segments).filter(|index| !to.path.is_specular(*index));
        density * smooth.map(|index| to.terms.vertices[index - 1].camera_lobe).product::<f64>()
    }
}

impl Path {
    /// The smooth vertex, from x_`first` towards the light, that a light subpath which ends before it can be joined with; 0 where a camera subpath has to
    /// hit the light.
    fn last_of_eye(&self, first: usize) -> Option<usize> {
        let is_smooth = |index: usize| index == 0 || !self.is_specular(index);
        let joined = (1..=first).rev().find(|index| is_smooth(*index) && is_smooth(*index - 1));
        joined.or_else(|| self.light.is_some_and(|light| light.can_be_hit()).then_some(0))
    }
}
