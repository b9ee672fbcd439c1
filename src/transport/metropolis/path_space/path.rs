//! A path from a light to the camera, and every factor of what it brings and of the densities with which it can be found.
//!
//! Vertices are x₀ at the light, x₁ … x_{k−1} on surfaces, x_k at the camera; k segments. What a path brings is
//! f = Le · Π G(x_i, x_{i+1}) · Π f_s(x_i) · W [V97, 8.6], and every density a product of the same geometry terms and of densities by projected solid
//! angle. The directions of specular lobes are in both and cancel: there f_s is the lobe's weight, and the density the probability of picking it [V97, 10.3.5].
//!
//! Reference: \[V97\] Veach 1997.

use super::light_end::{LightEnd, LightSegment};
use super::lobe_choice::{Lobe, LobeChoice};
use super::window::FilmWindow;
use crate::math::color::luminance;
use crate::math::{Rgb, Vec2, Vec3};
use crate::scene::Scene;
use crate::scene::geometry::Interaction;
use crate::scene::geometry::surface::NO_LIGHT;
use crate::scene::material::{Lobes, TransportMode, View};

/// A vertex on a surface.
#[derive(Clone, Copy, Debug)]
pub struct PathVertex {
    /// Where; its direction back belongs to the walk that found it and says nothing of the path.
    pub hit: Interaction,
    /// What the path follows there.
    pub lobe: Lobe,
}

/// A path.
#[derive(Clone, Debug, Default)]
pub struct Path {
    /// x₀.
    pub light: Option<LightEnd>,
    /// x₁ to x_{k−1}.
    pub vertices: Vec<PathVertex>,
    /// Where on the lens it ends, in [0, 1)².
    pub lens: [f32; 2],
}

/// The factors of a vertex.
#[derive(Clone, Copy, Debug)]
pub struct VertexTerms {
    /// Density with which a light subpath goes on to the next vertex: by projected solid angle, or the probability of its specular lobe.
    pub to_camera: f64,
    /// The same of a camera subpath and the vertex before.
    pub to_light: f64,
    /// Probability that a light subpath follows the specular lobe that the path follows, or none if it follows none.
    pub light_lobe: f64,
    /// The same of a camera subpath.
    pub camera_lobe: f64,
    /// Unit direction to the next vertex.
    pub camera_direction: Vec3,
    /// Unit direction to the vertex before.
    pub light_direction: Vec3,
    /// Cosine between the normal and the direction to the next vertex, positive.
    pub camera_cosine: f64,
    /// The same of the vertex before.
    pub light_cosine: f64,
}

/// The factors of a path.
#[derive(Clone, Debug, Default)]
pub struct Terms {
    /// Place in the whole film, (0, 0) top left to (1, 1) bottom right.
    pub film: Vec2,
    /// How far from x_{k−1} the camera's ray begins, m.
    pub visible_distance: f32,
    /// The first segment.
    pub first: LightSegment,
    /// Of x₁ to x_{k−1}.
    pub vertices: Vec<VertexTerms>,
    /// G of the segments from x₀ on; of the last one the density by area with which a camera ray through a uniform place of the film finds x_{k−1}.
    pub edges: Vec<f64>,
    /// f_s of x₁ to x_{k−1}.
    pub values: Vec<Rgb>,
    /// What media let pass of the segments from x₀ on; empty where there are none.
    pub passing: Vec<Rgb>,
    /// f without the geometry terms.
    pub carried: Rgb,
    /// Their product, times the number of pixels: f is the radiance of a pixel around the place.
    pub size: f64,
}

impl Path {
    /// k.
    pub fn segments(&self) -> usize {
        self.vertices.len() + 1
    }

    /// Whether x_i, not at an end of the path, is on a specular lobe.
    pub fn is_specular(&self, index: usize) -> bool {
        self.vertices[index - 1].lobe == Lobe::Specular
    }

    /// The index of the first vertex from the eye that is not specular.
    pub fn first_smooth_from_eye(&self) -> Option<usize> {
        (1..self.segments()).rev().find(|index| !self.is_specular(*index))
    }

    /// Computes all factors; `None` where the path brings nothing. What lies between its vertices is not looked at.
    pub fn compute(&self, scene: &Scene, terms: &mut Terms) -> Option<()> {
        let (first, last) = (self.vertices.first()?, self.vertices.last()?);
        if scene.hides_lights && last.hit.shape.light != NO_LIGHT {
            return None;
        }
        let seen = scene.camera.look_at(last.hit.position, self.lens).filter(|seen| scene.film.reaches(seen.film))?;
        let segment = self.light?.segment(scene, first.hit.position)?;
        (terms.film, terms.visible_distance, terms.first) = (seen.film, seen.visible_distance, segment);
        terms.vertices.clear();
        terms.edges.clear();
        terms.values.clear();
        (terms.carried, terms.size) = (segment.radiance, f64::from(scene.film.whole_pixel_count()));
        let mut light_direction = segment.direction;
        let mut geometry = segment.geometry;
        for (index, vertex) in self.vertices.iter().enumerate() {
            let next = self.vertices.get(index + 1);
            let (camera_direction, falloff) = match next {
                None => (seen.direction, f64::from(seen.pdf) / f64::from(seen.spread)),
                Some(next) => {
                    let offset = next.hit.position - vertex.hit.position;
                    let distance = offset.length();
                    (offset / distance, 1.0 / f64::from(distance * distance))
                }
            };
            let (of_vertex, value) = vertex.terms(scene, light_direction, camera_direction)?;
            terms.edges.push(geometry * of_vertex.light_cosine);
            terms.carried *= value;
            terms.values.push(value);
            terms.vertices.push(of_vertex);
            geometry = falloff * of_vertex.camera_cosine;
            light_direction = -camera_direction;
        }
        terms.edges.push(geometry);
        self.absorb(scene, terms);
        terms.size *= terms.edges.iter().product::<f64>();
        if scene.hides_lights && self.goes_straight(terms) {
            return None;
        }
        (terms.target() > 0.0 && terms.target().is_finite()).then_some(())
    }

    /// Whether nothing turns the light that comes from outside of the scene.
    fn goes_straight(&self, terms: &Terms) -> bool {
        let is_straight = |vertex: &VertexTerms| vertex.camera_direction.dot(vertex.light_direction) < -0.999_999;
        matches!(self.light, Some(LightEnd::Distant { .. }))
            && (1..self.segments()).all(|index| self.is_specular(index))
            && terms.vertices.iter().all(is_straight)
    }
}

/// Where a path leaves a photon.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PhotonPlace {
    /// The index of its vertex.
    pub index: usize,
    /// Whether nothing but mirrors and glass lies between the light and it.
    pub is_caustic: bool,
}

impl Path {
    /// At the second vertex from the eye that is not specular, if the first sees it without mirrors; where the first is the only one, there, if the camera
    /// sees it [Fan et al. 2005, section 3.1].
    pub fn photon_place(&self) -> Option<PhotonPlace> {
        let first = self.first_smooth_from_eye()?;
        if first > 1 && !self.is_specular(first - 1) {
            return Some(PhotonPlace { index: first - 1, is_caustic: false });
        }
        let is_seen = first + 1 == self.segments();
        let is_caustic = is_seen && first > 1 && (1..first).all(|index| self.is_specular(index));
        is_caustic.then_some(PhotonPlace { index: first, is_caustic })
    }
}

impl Terms {
    /// f*: the luminance of what the path brings.
    pub fn target(&self) -> f64 {
        f64::from(luminance(self.carried)) * self.size
    }

    /// What the path brings over a density.
    pub fn over(&self, density: f64) -> Rgb {
        // Long paths carry next to nothing, over a density that is smaller still.
        let share = self.size / density;
        Rgb::from(self.carried.to_array().map(|value| (f64::from(value) * share) as f32))
    }

    /// The density of vertices x_from … x_{to−1} as parts of a light subpath whose vertices before stay; 0 where a light subpath does not make them.
    pub fn light_subpath(&self, from: usize, to: usize) -> f64 {
        let (mut density, mut begin) = (1.0, from);
        match (from, to) {
            (from, to) if from == to => return 1.0,
            (0, 1) => return self.first.place,
            (0, _) => {
                density = self.first.emission * self.vertices[0].light_cosine;
                begin = 2;
            }
            // Which directions a given place of a light emits to is not asked.
            (1, _) => return 0.0,
            _ => {}
        }
        for index in begin..to {
            density *= self.vertices[index - 2].to_camera * self.edges[index - 1];
        }
        density
    }

    /// The density of vertices x_from … x_{to−1} as parts of a camera subpath whose vertices from x_to on stay.
    pub fn camera_subpath(&self, from: usize, to: usize, window: &FilmWindow) -> f64 {
        let segments = self.edges.len();
        let of = |index: usize| match index + 1 == segments {
            true => self.edges[index] * window.density(),
            false => self.vertices[index].to_light * self.edges[index],
        };
        (from..to).map(of).product()
    }
}

impl Terms {
    /// What light of 1 W that arrives at vertex x_`index`, of the color of the path's, brings to the picture by the rest of the path, over the density with
    /// which a camera subpath makes all behind the vertex.
    pub fn importance(&self, index: usize, scene: &Scene, window: &FilmWindow) -> f32 {
        let segments = self.edges.len();
        let mut size = f64::from(scene.film.whole_pixel_count());
        let mut value = self.color(index) * self.values[index - 1];
        value *= self.passing.get(index..).unwrap_or_default().iter().product::<Rgb>();
        if index + 1 == segments {
            // Seen by the camera itself.
            return luminance(value * (size * self.edges[index]) as f32);
        }
        size *= self.edges[index] / (window.density() * self.vertices[index].camera_lobe);
        value *= self.values[index];
        for specular in index + 2..segments {
            value *= self.values[specular - 1];
            size /= self.vertices[specular - 1].to_light;
        }
        luminance(value * size as f32)
    }

    /// The color of what arrives at vertex x_`index`, of luminance 1.
    pub fn color(&self, index: usize) -> Rgb {
        let passing = self.passing.get(..index).unwrap_or_default().iter().product::<Rgb>();
        let arriving = self.first.radiance * passing * self.values[..index - 1].iter().product::<Rgb>();
        arriving / luminance(arriving)
    }
}

impl PathVertex {
    /// The factors where light comes from `to_light` and goes to `to_camera`, unit directions away from the surface, and f_s; `None` where that is
    /// nothing.
    pub fn terms(&self, scene: &Scene, to_light: Vec3, to_camera: Vec3) -> Option<(VertexTerms, Rgb)> {
        let hit = &self.hit;
        let (light, camera) = (hit.frame.to_local(to_light), hit.frame.to_local(to_camera));
        let (light_cosine, camera_cosine) = (to_light.dot(hit.geometric_normal), to_camera.dot(hit.geometric_normal));
        // Light would leak through the true surface.
        if light_cosine * light.z <= 0.0 || camera_cosine * camera.z <= 0.0 {
            return None;
        }
        let view = |outgoing, mode| View { point: hit.texture_point(), outgoing, mode, lobes: Lobes::ALL };
        let (by_camera, by_light) = (view(camera, TransportMode::Radiance), view(light, TransportMode::Flux));
        let camera_choice = LobeChoice::new(scene, hit.shape, &by_camera);
        let light_choice = LobeChoice::new(scene, hit.shape, &by_light);
        let cosines = [light_cosine, camera_cosine].map(|cosine| f64::from(cosine.abs()));
        let (lobes, directions, value) = match self.lobe {
            Lobe::Smooth => {
                let lobes = [light_choice.smooth(), camera_choice.smooth()];
                let material = scene.material(hit.shape);
                let value = material.evaluate(&by_camera, light) * (light.z / light_cosine).abs();
                let pdf = |view: View, direction| f64::from(material.pdf(&view.of(Lobes::SMOOTH), direction));
                (lobes, [pdf(by_light, camera) / cosines[1], pdf(by_camera, light) / cosines[0]], value)
            }
            Lobe::Specular => {
                let (back, on) = (camera_choice.towards(light)?, light_choice.towards(camera)?);
                // Flux takes a factor where the shading normal is another [V97, eq. 5.19], and none where radiance is refracted.
                let correction = (light.z * camera_cosine / (light_cosine * camera.z)).abs();
                let carried = on.weight.max_element() * correction;
                let same_measure = f64::from(back.weight.max_element() / carried);
                ([on.share, back.share], [same_measure, 1.0], back.weight)
            }
        };
        let [light_lobe, camera_lobe] = lobes.map(f64::from);
        (value != Rgb::ZERO).then_some((
            VertexTerms {
                to_camera: light_lobe * directions[0],
                to_light: camera_lobe * directions[1],
                light_lobe,
                camera_lobe,
                camera_direction: to_camera,
                light_direction: to_light,
                camera_cosine: cosines[1],
                light_cosine: cosines[0],
            },
            value,
        ))
    }
}
