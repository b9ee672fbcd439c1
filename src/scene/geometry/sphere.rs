//! `sphere`: `center` (point, origin) and `radius` (m, above 0, 1) in its own space, then `to_world`.
//! Where that scales unevenly, it stays a sphere, as in Mitsuba: with the scale along x that is left when the rotation is taken
//! off. Outside is away from the centre; `flip_normals` (boolean, false) turns it round, and so does a `to_world` that mirrors, as in Mitsuba,
//! unless `keep_outside` (boolean, false) is set.

use std::f32::consts::{FRAC_1_PI, PI, TAU};

use glam::{DVec3, Vec2, Vec3};

use super::Primitive;
use super::mesh::ShapeGeometry;
use super::parameterization::{cosine_and_sine, turns};
use super::ray::{PrimitiveHit, Ray, Shear, SurfacePoint, largest, position_error};
use super::transform::{ToWorld, to_single};
use crate::math::{Frame, warp};
use crate::scene::error::{SceneError, shown_number};
use crate::scene::fields::Fields;

/// A sphere.
#[derive(Clone, Copy, Debug)]
pub struct Sphere {
    center: Vec3,
    radius: f32,
    /// 1, or -1 when the outside is towards the centre.
    orientation: f32,
    /// Unit images of its own z and x axes; the y axis is `handedness` times their cross product.
    pole: Vec3,
    meridian: Vec3,
    handedness: f32,
}

/// Reads the shape.
pub(crate) fn read(fields: &mut Fields<'_>) -> Result<ShapeGeometry, SceneError> {
    let center = fields.vector("center")?.unwrap_or(DVec3::ZERO);
    let radius = positive_radius(fields)?;
    let to_world = ToWorld::read(fields)?;
    let flip = fields.boolean("flip_normals")?.unwrap_or(false);
    let axis = |axis: DVec3| match to_world.is_similarity() {
        true => to_world.vector(axis).normalize(),
        false => to_world.decomposed().0 * axis,
    };
    let sphere = Sphere {
        center: to_single(to_world.point(center), fields)?,
        radius: to_single(DVec3::splat(radius * to_world.scale()), fields)?.x,
        orientation: if flip != to_world.turns_outside(fields)? { -1.0 } else { 1.0 },
        pole: axis(DVec3::Z).as_vec3(),
        meridian: axis(DVec3::X).as_vec3(),
        handedness: to_world.handedness(),
    };
    Ok(ShapeGeometry::from_primitives(vec![Primitive::Sphere(sphere)]))
}

/// Reads `radius` (m, above 0, 1 by default).
pub(crate) fn positive_radius(fields: &mut Fields<'_>) -> Result<f64, SceneError> {
    let radius = fields.float("radius")?.unwrap_or(1.0);
    if radius > 0.0 {
        return Ok(radius);
    }
    let problem = format!("a {} of radius {} is empty or inside out", fields.node().plugin, shown_number(radius));
    Err(fields.error("radius", problem, "give a radius above 0; flip_normals turns a shape inside out"))
}

impl Sphere {
    /// Nearest hit before `length` [Haines, Günther & Akenine-Möller 2019, "Precision improvements for ray/sphere intersection"].
    #[inline]
    pub fn intersect(&self, ray: &Ray, _shear: &Shear, length: f32) -> Option<PrimitiveHit> {
        let from_center = ray.origin - self.center;
        let half_b = -from_center.dot(ray.direction);
        let nearest = from_center + ray.direction * half_b;
        let discriminant = self.radius * self.radius - nearest.length_squared();
        if discriminant < 0.0 {
            return None;
        }
        let q = half_b + discriminant.sqrt().copysign(half_b);
        let c = from_center.length_squared() - self.radius * self.radius;
        let (one, other) = (c / q, q);
        let (near, far) = (one.min(other), one.max(other));
        let distance = if near > 0.0 { near } else { far };
        (distance > 0.0 && distance < length).then(|| PrimitiveHit::at(distance))
    }

    /// The point of a hit, moved back onto the sphere.
    #[inline]
    pub fn surface(&self, ray: &Ray, hit: &PrimitiveHit) -> SurfacePoint {
        self.point((ray.at(hit.distance) - self.center).normalize())
    }

    #[inline]
    fn point(&self, direction: Vec3) -> SurfacePoint {
        SurfacePoint {
            position: self.center + direction * self.radius,
            normal: direction * self.orientation,
            error: position_error(largest(self.center) + self.radius),
        }
    }

    /// The axes of its own space.
    fn axes(&self) -> [Vec3; 3] {
        [self.meridian, self.pole.cross(self.meridian) * self.handedness, self.pole]
    }

    /// φ in turns, and θ from +z in half turns.
    pub fn uv(&self, position: Vec3, _barycentric: [f32; 2]) -> Vec2 {
        let [x, y, z] = self.axes().map(|axis| axis.dot(position - self.center));
        Vec2::new(turns(x, y), libm::atan2f(libm::hypotf(x, y), z) * FRAC_1_PI)
    }

    /// ∂p/∂u and ∂p/∂v, m.
    pub fn partials(&self, position: Vec3) -> [Vec3; 2] {
        let axes = self.axes();
        let [x, y, z] = axes.map(|axis| axis.dot(position - self.center));
        let [cosine, sine] = cosine_and_sine(x, y);
        let along_u = axes[1] * x - axes[0] * y;
        let along_v = (axes[0] * cosine + axes[1] * sine) * z - axes[2] * (x * cosine + y * sine);
        [along_u * TAU, along_v * PI]
    }

    /// Area, m².
    pub fn area(&self) -> f32 {
        4.0 * PI * self.radius * self.radius
    }

    /// Smallest and largest coordinates.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        (self.center - self.radius, self.center + self.radius)
    }

    /// A point uniform by area.
    pub fn sample(&self, u: [f32; 2]) -> SurfacePoint {
        self.point(warp::sphere(u))
    }

    /// A direction from `origin` uniform in the cone that the sphere fills, the point it meets, and the density by solid
    /// angle; `None` inside.
    #[inline]
    pub fn sample_cone(&self, origin: Vec3, u: [f32; 2]) -> Option<(SurfacePoint, f32)> {
        let one_minus_cosine = self.one_minus_cosine(origin)?;
        let to_center = self.center - origin;
        let distance_to_center = to_center.length();
        let local = warp::cone(one_minus_cosine, u);
        let direction = Frame::from_normal(to_center / distance_to_center).to_world(local);
        let sine_squared = (1.0 - local.z) * (1.0 + local.z);
        let inside = self.radius * self.radius - distance_to_center * distance_to_center * sine_squared;
        let distance = distance_to_center * local.z - inside.max(0.0).sqrt();
        let point = self.point((origin + direction * distance - self.center).normalize());
        Some((point, warp::cone_pdf(one_minus_cosine)))
    }

    /// The density of [`Sphere::sample_cone`] for directions that meet the sphere; `None` inside.
    #[inline]
    pub fn cone_pdf(&self, origin: Vec3) -> Option<f32> {
        self.one_minus_cosine(origin).map(warp::cone_pdf)
    }

    fn one_minus_cosine(&self, origin: Vec3) -> Option<f32> {
        let sine_squared = self.radius * self.radius / (self.center - origin).length_squared();
        (sine_squared < 0.9999).then(|| sine_squared / (1.0 + (1.0 - sine_squared).sqrt()))
    }
}
