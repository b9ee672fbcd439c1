//! `cylinder`: the open tube of `radius` (m, above 0, 1) between `p0` (point, origin) and `p1` (point, 0 0 1), then `to_world`;
//! where that makes more of it than a round tube, it is a fine mesh. Outside is away from the axis; `flip_normals` (boolean, false) turns it round. It has no caps.

use std::f32::consts::TAU;

use glam::{DVec3, Vec2, Vec3};

use super::Primitive;
use super::mesh::ShapeGeometry;
use super::parameterization::{cosine_and_sine, turns};
use super::ray::{PrimitiveHit, Ray, Shear, SurfacePoint, largest, position_error};
use super::sphere::positive_radius;
use super::transform::{ToWorld, to_single};
use super::triangle::Triangle;
use crate::math::Frame;
use crate::math::trigonometry::sin_cos_turn;
use crate::scene::error::SceneError;
use crate::scene::fields::Fields;

/// An open tube.
#[derive(Clone, Copy, Debug)]
pub struct Cylinder {
    start: Vec3,
    /// Unit direction.
    axis: Vec3,
    height: f32,
    radius: f32,
    orientation: f32,
    /// Unit direction across the axis where u is 0; u grows towards `handedness` times axis × meridian.
    meridian: Vec3,
    handedness: f32,
}

/// Reads the shape.
pub(crate) fn read(fields: &mut Fields<'_>) -> Result<ShapeGeometry, SceneError> {
    let start = fields.vector("p0")?.unwrap_or(DVec3::ZERO);
    let end = fields.vector("p1")?.unwrap_or(DVec3::Z);
    let radius = positive_radius(fields)?;
    let to_world = ToWorld::read(fields)?;
    let flip = fields.boolean("flip_normals")?.unwrap_or(false);
    let axis = to_world.vector(end - start);
    if axis.length() == 0.0 {
        return Err(fields.error("p1", "the cylinder has no height", "give p0 and p1 that differ"));
    }
    let across = Frame::from_normal((end - start).normalize().as_vec3()).tangent.as_dvec3();
    let other = (end - start).normalize().cross(across);
    let (one, two) = (to_world.vector(across), to_world.vector(other));
    let longest = one.length().max(two.length());
    let is_round = (one.length() - two.length()).abs() <= 1e-4 * longest
        && one.dot(two).abs() <= 1e-4 * longest * longest
        && [one, two].iter().all(|side| side.dot(axis).abs() <= 1e-4 * longest * axis.length());
    if !is_round {
        return tube_of_triangles(fields, &to_world, [start, end], [across * radius, other * radius], flip);
    }
    let cylinder = Cylinder {
        start: to_single(to_world.point(start), fields)?,
        axis: axis.normalize().as_vec3(),
        height: to_single(DVec3::splat(axis.length()), fields)?.x,
        radius: to_single(DVec3::splat(radius * one.length()), fields)?.x,
        orientation: if flip { -1.0 } else { 1.0 },
        meridian: to_world.vector(across).reject_from(axis).normalize().as_vec3(),
        handedness: to_world.handedness(),
    };
    Ok(ShapeGeometry::from_primitives(vec![Primitive::Cylinder(cylinder)]))
}

/// Quadrilaterals round a tube that is no round one.
const SIDES: usize = 512;

/// The tube between two points, with two radii across, as triangles with smooth normals.
fn tube_of_triangles(
    fields: &Fields<'_>,
    to_world: &ToWorld,
    [start, end]: [DVec3; 2],
    radii: [DVec3; 2],
    flip: bool,
) -> Result<ShapeGeometry, SceneError> {
    let mut shape = ShapeGeometry::default();
    let sign = if flip { -1.0 } else { 1.0 };
    let corner = |side: usize, top: bool| {
        let turn = side as f32 / SIDES as f32;
        let (sin, cos) = sin_cos_turn(turn);
        let outward = radii[0] * f64::from(cos) + radii[1] * f64::from(sin);
        let point = to_single(to_world.point(if top { end } else { start } + outward), fields)?;
        let normal = to_world.normal(outward.normalize()).as_vec3() * sign;
        Ok((point, normal, Vec2::new(turn, if top { 1.0 } else { 0.0 })))
    };
    let reversed = flip != (to_world.handedness() < 0.0);
    for side in 0..SIDES {
        let corners = [corner(side, false)?, corner(side + 1, false)?, corner(side + 1, true)?, corner(side, true)?];
        for order in [[0, 1, 2], [0, 2, 3]] {
            let order = if reversed { [order[2], order[1], order[0]] } else { order };
            let vertices = order.map(|index: usize| corners[index].0);
            shape.primitives.push(Primitive::Triangle(Triangle { vertices }));
            shape.shading_normals.push(order.map(|index| corners[index].1));
            shape.texture_coordinates.push(order.map(|index| corners[index].2));
        }
    }
    Ok(shape)
}

impl Cylinder {
    /// Nearest hit before `length`.
    #[inline]
    pub fn intersect(&self, ray: &Ray, _shear: &Shear, length: f32) -> Option<PrimitiveHit> {
        let from_start = ray.origin - self.start;
        let along = ray.direction.dot(self.axis);
        let across = ray.direction - self.axis * along;
        let offset = from_start - self.axis * from_start.dot(self.axis);
        let a = across.length_squared();
        let half_b = -offset.dot(across);
        // The discriminant from the point nearest to the axis, which loses no digits far away.
        let nearest = offset + across * (half_b / a);
        let discriminant = self.radius * self.radius - nearest.length_squared();
        if !(discriminant >= 0.0 && a > 0.0) {
            return None;
        }
        let q = half_b + (a * discriminant).sqrt().copysign(half_b);
        let c = offset.length_squared() - self.radius * self.radius;
        let (one, other) = (c / q, q / a);
        [one.min(other), one.max(other)].into_iter().find_map(|distance| {
            let height = from_start.dot(self.axis) + distance * along;
            (distance > 0.0 && distance < length && (0.0..=self.height).contains(&height))
                .then(|| PrimitiveHit::at(distance))
        })
    }

    /// The point of a hit, moved back onto the tube.
    #[inline]
    pub fn surface(&self, ray: &Ray, hit: &PrimitiveHit) -> SurfacePoint {
        let relative = ray.at(hit.distance) - self.start;
        let height = relative.dot(self.axis);
        self.point((relative - self.axis * height).normalize(), height)
    }

    fn point(&self, outward: Vec3, height: f32) -> SurfacePoint {
        SurfacePoint {
            position: self.start + self.axis * height + outward * self.radius,
            normal: outward * self.orientation,
            error: position_error(largest(self.start) + self.height + self.radius),
        }
    }

    /// The axes across the tube, and the coordinates of `position` along them and along the axis.
    fn local(&self, position: Vec3) -> ([Vec3; 2], Vec3) {
        let axes = [self.meridian, self.axis.cross(self.meridian) * self.handedness];
        let relative = position - self.start;
        (axes, Vec3::new(relative.dot(axes[0]), relative.dot(axes[1]), relative.dot(self.axis)))
    }

    /// Angle in turns, and height over the whole.
    pub fn uv(&self, position: Vec3, _barycentric: [f32; 2]) -> Vec2 {
        let (_, local) = self.local(position);
        Vec2::new(turns(local.x, local.y), local.z / self.height)
    }

    /// ∂p/∂u and ∂p/∂v, m.
    pub fn partials(&self, position: Vec3) -> [Vec3; 2] {
        let ([x, y], local) = self.local(position);
        let [cosine, sine] = cosine_and_sine(local.x, local.y);
        [(y * cosine - x * sine) * (TAU * self.radius), self.axis * self.height]
    }

    /// Area, m².
    pub fn area(&self) -> f32 {
        TAU * self.radius * self.height
    }

    /// Smallest and largest coordinates.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        let end = self.start + self.axis * self.height;
        let reach = (Vec3::ONE - self.axis * self.axis).max(Vec3::ZERO).map(f32::sqrt) * self.radius;
        (self.start.min(end) - reach, self.start.max(end) + reach)
    }

    /// A point uniform by area.
    pub fn sample(&self, u: [f32; 2]) -> SurfacePoint {
        let (sin, cos) = sin_cos_turn(u[1]);
        let frame = Frame::from_normal(self.axis);
        self.point(frame.tangent * cos + frame.bitangent * sin, u[0] * self.height)
    }
}
