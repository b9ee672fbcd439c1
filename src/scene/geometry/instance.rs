//! `instance`: a `shapegroup` placed by any affine `to_world` (transform, identity). A group is built once; its instances
//! share it. Rays are carried into the group's space, and what they hit is carried back.

use glam::{DMat3, DVec3, Mat3, Vec3};

use super::accelerator::BoxTree;
use super::obstacles::Layer;
use super::parameterization::tangent_frame;
use super::ray::{PrimitiveHit, Ray, largest, position_error};
use super::surface::{Geometry, Interaction, Shape};
use super::transform::ToWorld;
use crate::math::Frame;
use crate::scene::error::SceneError;
use crate::scene::fields::Fields;

/// A group and where it stands.
#[derive(Clone, Copy, Debug)]
pub struct Instance {
    /// Index of its group.
    pub group: u32,
    linear: Mat3,
    translation: Vec3,
    /// The inverse of `linear`. In double precision points are rounded but once on their way in, and once on their way out,
    /// so that flattened and far instances do not magnify errors.
    inverse: DMat3,
}

impl Instance {
    /// Reads `to_world` of an instance of group `group`.
    pub fn read(fields: &mut Fields<'_>, group: u32) -> Result<Self, SceneError> {
        let given = ToWorld::read(fields)?;
        let columns = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| given.vector(axis).as_vec3());
        let linear = Mat3::from_cols(columns[0], columns[1], columns[2]);
        let translation = given.point(DVec3::ZERO).as_vec3();
        // Of the rounded numbers, so that both directions belong together.
        let inverse = linear.as_dmat3().inverse();
        let fits = inverse.is_finite() && inverse.as_mat3().is_finite();
        if linear.is_finite() && translation.is_finite() && fits {
            return Ok(Self { group, linear, translation, inverse });
        }
        let problem = "\"to_world\" and its inverse do not fit into single precision";
        Err(fields.error("to_world", problem, "scale the shapes of the group instead"))
    }

    fn point_to_world(&self, point: Vec3) -> Vec3 {
        (self.linear.as_dmat3() * point.as_dvec3() + self.translation.as_dvec3()).as_vec3()
    }

    #[inline]
    fn point_to_group(&self, point: Vec3) -> DVec3 {
        self.inverse * (point.as_dvec3() - self.translation.as_dvec3())
    }

    /// The box in the world round a box in the group's space, with room for rounding.
    pub fn bounds(&self, (low, high): (Vec3, Vec3)) -> (Vec3, Vec3) {
        let center = self.point_to_world((low + high) * 0.5);
        let half = self.linear.abs() * ((high - low) * 0.5);
        let room = half + position_error(largest(center) + largest(half));
        (center - room, center + room)
    }

    /// The ray in the group's space, and what makes a world distance of one of its distances.
    #[inline]
    fn ray_in(&self, group: &Group, ray: &Ray, length: f32) -> (Ray, ToWorldDistance) {
        let direction = self.inverse * ray.direction.as_dvec3();
        let stretch = direction.length();
        let direction = direction / stretch;
        let origin = self.point_to_group(ray.origin);
        // From nearby, where single precision can tell the group's boxes apart.
        let skipped = ((group.center.as_dvec3() - origin).dot(direction) - f64::from(group.radius)).max(0.0);
        let ray = Ray {
            origin: (origin + direction * skipped).as_vec3(),
            direction: direction.as_vec3(),
            length: (f64::from(length) * stretch - skipped) as f32,
        };
        (ray, ToWorldDistance { skipped, stretch })
    }

    /// Carries a hit in the group's space into the world.
    fn carry(&self, local: Interaction, group: &Geometry, ray: &Ray, distance: f32, index: u32) -> Interaction {
        let normal_matrix = self.inverse.as_mat3().transpose();
        let normal = normal_matrix * local.geometric_normal;
        let stretch = normal.length();
        let shading = (normal_matrix * local.frame.normal).normalize();
        let frame = if local.shape.needs_uv {
            let own = group.tangents.get(local.primitive).is_some();
            let tangent = if own { local.frame.tangent } else { group.partials_at(local.primitive, local.position)[0] };
            let tangent = self.linear * tangent;
            let mirrored = own && local.frame.is_left_handed() != (self.linear.determinant() < 0.0);
            tangent_frame(shading, tangent, mirrored)
        } else {
            Frame::from_normal(shading)
        };
        Interaction {
            position: self.point_to_world(local.position),
            geometric_normal: normal / stretch,
            frame,
            outgoing: -ray.direction,
            distance,
            instance: index,
            error: self.error(&local, stretch),
            ..local
        }
    }

    /// How far along its normal a point must be moved in the world to be off the surface in the group's space too:
    /// its own error there and that of rounding points there, `1/stretch` being what they grow by along the normal, and
    /// that of rounding points here.
    fn error(&self, local: &Interaction, stretch: f32) -> f32 {
        let there = local.error + position_error(largest(local.position));
        there / stretch + position_error(largest(self.point_to_world(local.position)))
    }
}

#[derive(Clone, Copy)]
struct ToWorldDistance {
    skipped: f64,
    stretch: f64,
}

impl ToWorldDistance {
    fn of(self, distance: f32) -> f32 {
        ((f64::from(distance) + self.skipped) / self.stretch) as f32
    }
}

/// Shapes that are placed many times.
struct Group {
    geometry: Geometry,
    /// A sphere around them.
    center: Vec3,
    radius: f32,
}

/// All instances of a scene in the order of their tree.
pub(super) struct Instances {
    tree: BoxTree,
    instances: Vec<Instance>,
    /// Their places in the order of the scene.
    order: Vec<u32>,
    groups: Vec<Group>,
}

/// The nearest hit within instances.
pub(super) struct InstanceHit {
    instance: usize,
    primitive: usize,
    hit: PrimitiveHit,
    /// Distance in the world, m.
    distance: f32,
}

impl Instances {
    /// Builds the tree. Every instance's group is one of `groups`.
    pub(super) fn build(groups: Vec<Geometry>, instances: &[Instance]) -> Self {
        let around = |geometry: Geometry| {
            let (center, radius) = geometry.bounding_sphere();
            Group { geometry, center, radius }
        };
        let groups: Vec<Group> = groups.into_iter().map(around).collect();
        let boxes = instances.iter().map(|instance| instance.bounds(groups[instance.group as usize].geometry.bounds()));
        let (tree, order) = BoxTree::build(boxes);
        let instances = order.iter().map(|index| instances[*index as usize]).collect();
        Self { tree, instances, order, groups }
    }

    /// Smallest and largest coordinates of all instances, m.
    pub(super) fn bounds(&self) -> Option<(Vec3, Vec3)> {
        let bounds = self.instances.iter().map(|instance| instance.bounds(self.group(instance).geometry.bounds()));
        bounds.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
    }

    /// For each instance with primitives of shapes that `wanted` picks, the box around them, m.
    pub(super) fn boxes_of(&self, wanted: &dyn Fn(Shape) -> bool) -> Vec<(Vec3, Vec3)> {
        let around = |group: &Group| {
            let boxes = group.geometry.boxes_of(wanted).into_iter();
            boxes.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
        };
        let of_groups: Vec<Option<(Vec3, Vec3)>> = self.groups.iter().map(around).collect();
        let placed = |instance: &Instance| of_groups[instance.group as usize].map(|found| instance.bounds(found));
        self.instances.iter().filter_map(placed).collect()
    }

    /// The place in the order of the scene of an instance in tree order.
    pub(super) fn place_in_scene(&self, instance: u32) -> usize {
        self.order[instance as usize] as usize
    }

    fn group(&self, instance: &Instance) -> &Group {
        &self.groups[instance.group as usize]
    }

    pub(super) fn nearest(&self, ray: &Ray) -> Option<InstanceHit> {
        let mut found = None;
        let mut length = ray.length;
        self.tree.visit_nearest(ray, |index| {
            let instance = &self.instances[index];
            let group = self.group(instance);
            let (local, to_world) = instance.ray_in(group, ray, length);
            let (primitive, hit) = group.geometry.accelerator.nearest(&local)?;
            let distance = to_world.of(hit.distance);
            if distance >= length {
                return None;
            }
            length = distance;
            found = Some(InstanceHit { instance: index, primitive, hit, distance });
            Some(distance)
        });
        found
    }

    pub(super) fn is_blocked(&self, ray: &Ray) -> bool {
        self.tree.visit_any(ray, |index| {
            let instance = &self.instances[index];
            let group = self.group(instance);
            group.geometry.accelerator.is_blocked(&instance.ray_in(group, ray, ray.length).0)
        })
    }

    /// Whether the box of an instance reaches into `layer`.
    pub(super) fn may_reach(&self, layer: &Layer) -> bool {
        self.tree.may_meet(layer)
    }

    pub(super) fn interaction(&self, ray: &Ray, found: &InstanceHit) -> Interaction {
        let instance = &self.instances[found.instance];
        let group = self.group(instance);
        let (local, _) = instance.ray_in(group, ray, ray.length);
        let interaction = group.geometry.interaction(&local, found.primitive, &found.hit);
        instance.carry(interaction, &group.geometry, ray, found.distance, found.instance as u32)
    }

    pub(super) fn partials(&self, hit: &Interaction) -> [Vec3; 2] {
        let instance = &self.instances[hit.instance as usize];
        let local = instance.point_to_group(hit.position).as_vec3();
        let partials = self.group(instance).geometry.partials_at(hit.primitive, local);
        partials.map(|partial| instance.linear * partial)
    }
}
