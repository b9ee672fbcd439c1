//! All surfaces of a scene, and where a path meets them.

use glam::{Vec2, Vec3, Vec4};

use super::accelerator::Accelerator;
use super::instance::{Instance, Instances};
use super::mesh::ShapeGeometry;
use super::parameterization::{AtVertices, Parameterized};
use super::primitive::Primitive;
use super::ray::{PrimitiveHit, Ray, SurfacePoint};
use super::texture_point::{Detail, TexturePoint};
use crate::math::{Frame, warp};

/// Marks a shape without light.
pub(crate) const NO_LIGHT: u32 = u32::MAX;
/// From here on the numbers of lights are those of emission that is seen and lights nothing.
pub(crate) const SEEN_ONLY: u32 = 1 << 31;
/// Marks a shape that separates no media.
pub(crate) const NO_BOUNDARY: u16 = u16::MAX;
/// Marks a hit outside of instances.
pub(crate) const NO_INSTANCE: u32 = u32::MAX;
const NO_SHADING: u32 = u32::MAX;

/// What all primitives of a shape share.
#[derive(Clone, Copy, Debug)]
pub struct Shape {
    /// Index of its material.
    pub material: u32,
    /// Index of its area light, [`SEEN_ONLY`] plus the index of what is seen only, or [`NO_LIGHT`].
    pub light: u32,
    /// Whether its hits get texture coordinates and a frame along ∂p/∂u, which costs time and memory.
    pub needs_uv: bool,
    /// Whether its hits get [`Detail::partials`].
    pub needs_partials: bool,
    /// Index of the media that it separates, or [`NO_BOUNDARY`].
    pub boundary: u16,
}

impl Shape {
    /// A shape without light whose material does not look at texture coordinates.
    pub fn new(material: u32) -> Self {
        Self { material, light: NO_LIGHT, needs_uv: false, needs_partials: false, boundary: NO_BOUNDARY }
    }
}

#[derive(Clone, Copy)]
struct PrimitiveInfo {
    shape: u32,
    shading: u32,
}

/// All surfaces.
pub struct Geometry {
    pub(super) accelerator: Accelerator,
    info: Vec<PrimitiveInfo>,
    shading_normals: Vec<[Vec3; 3]>,
    /// Texture coordinates that meshes bring along.
    pub(super) coordinates: AtVertices<Vec2>,
    /// Tangents that meshes bring along, with the sign of the bitangent.
    pub(super) tangents: AtVertices<Vec4>,
    /// By primitive, its index within its shape where textures look that up; empty when none does.
    pub(super) own_indices: Vec<u32>,
    shapes: Vec<Shape>,
    /// Only in scenes that have some; boxed since most have none.
    pub(super) instances: Option<Box<Instances>>,
    low: Vec3,
    high: Vec3,
}

/// Where a path meets a surface.
#[derive(Clone, Copy, Debug)]
pub struct Interaction {
    /// Position, m.
    pub position: Vec3,
    /// Unit normal of the true surface, on the shape's outside.
    pub geometric_normal: Vec3,
    /// Frame around the shading normal; its tangent is along ∂p/∂u where the shape needs uv.
    pub frame: Frame,
    /// Texture coordinates where the shape needs them, else 0.
    pub uv: Vec2,
    /// Unit direction back along the path, world space.
    pub outgoing: Vec3,
    /// Distance from the ray's origin, m.
    pub distance: f32,
    /// The shape.
    pub shape: Shape,
    /// The primitive in the order of its tree: the scene's, or that of the instance's group.
    pub primitive: u32,
    /// The instance in tree order, or [`NO_INSTANCE`].
    pub instance: u32,
    /// Bound on the rounding error of `position`, m.
    pub error: f32,
    /// Partial derivatives or a place on the mesh where the shape needs one of them, else 0.
    pub detail: Detail,
}

impl Interaction {
    /// Where textures are looked up.
    #[inline]
    pub fn texture_point(&self) -> TexturePoint {
        TexturePoint { uv: self.uv, detail: self.detail }
    }

    /// A ray that leaves the surface in `direction` and does not meet it again by rounding.
    #[inline]
    pub fn ray_to(&self, direction: Vec3) -> Ray {
        Ray::new(self.offset_towards(direction), direction)
    }

    /// The position, moved off the surface to the side of `direction`.
    #[inline]
    pub fn offset_towards(&self, direction: Vec3) -> Vec3 {
        self.position + self.geometric_normal * self.error.copysign(direction.dot(self.geometric_normal))
    }
}

impl Geometry {
    /// Collects shapes in order and builds the accelerator. Also gives, per shape, the tree indices of its primitives.
    pub fn build(shapes: Vec<(Shape, ShapeGeometry)>) -> (Self, Vec<Vec<u32>>) {
        let count = shapes.iter().map(|(_, geometry)| geometry.primitives.len()).sum();
        let mut primitives = Vec::with_capacity(count);
        let mut info = Vec::with_capacity(count);
        let mut shading_normals = Vec::new();
        let (mut coordinates, mut tangents) = (AtVertices::<Vec2>::default(), AtVertices::<Vec4>::default());
        let mut kept_shapes = Vec::with_capacity(shapes.len());
        let needs_places = shapes.iter().any(|(_, geometry)| geometry.needs_places);
        let mut own_indices = Vec::with_capacity(if needs_places { count } else { 0 });
        // Each shape's own copy is gone before the tree is built.
        for (shape, mut geometry) in shapes {
            let smooth = !geometry.shading_normals.is_empty();
            for index in 0..geometry.primitives.len() {
                let shading = if smooth { (shading_normals.len() + index) as u32 } else { NO_SHADING };
                info.push(PrimitiveInfo { shape: kept_shapes.len() as u32, shading });
            }
            if needs_places {
                own_indices.extend(0..geometry.primitives.len() as u32);
            }
            if !shape.needs_uv {
                (geometry.texture_coordinates, geometry.tangents) = (Vec::new(), Vec::new());
            }
            coordinates.push_shape(geometry.primitives.len(), &geometry.texture_coordinates);
            tangents.push_shape(geometry.primitives.len(), &geometry.tangents);
            primitives.append(&mut geometry.primitives);
            shading_normals.append(&mut geometry.shading_normals);
            kept_shapes.push(shape);
        }
        let boxes = primitives.iter().map(Primitive::bounds).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)));
        // Light from outside needs a place even where there is nothing.
        let (low, high) = boxes.unwrap_or((-Vec3::ONE, Vec3::ONE));
        let (accelerator, order) = Accelerator::build(&primitives);
        drop(primitives);
        coordinates.reorder(&order);
        tangents.reorder(&order);
        if needs_places {
            own_indices = order.iter().map(|index| own_indices[*index as usize]).collect();
        }
        let info: Vec<PrimitiveInfo> = order.iter().map(|index| info[*index as usize]).collect();
        let mut members = vec![Vec::new(); kept_shapes.len()];
        for (index, info) in info.iter().enumerate() {
            members[info.shape as usize].push(index as u32);
        }
        let (shapes, instances) = (kept_shapes, None);
        let geometry = Self {
            accelerator,
            info,
            shading_normals,
            coordinates,
            tangents,
            own_indices,
            shapes,
            instances,
            low,
            high,
        };
        (geometry, members)
    }

    /// Adds instances of groups that were built from their shapes; `Instance::group` counts them from 0.
    #[must_use]
    pub fn with_instances(mut self, groups: Vec<Self>, instances: &[Instance]) -> Self {
        let instances = Instances::build(groups, instances);
        let Some((low, high)) = instances.bounds() else { return self };
        let alone = self.info.is_empty();
        (self.low, self.high) = if alone { (low, high) } else { (self.low.min(low), self.high.max(high)) };
        self.instances = Some(Box::new(instances));
        self
    }

    /// The primitive at a tree index.
    pub fn primitive(&self, index: u32) -> &Primitive {
        &self.accelerator.primitives()[index as usize]
    }

    /// Whether anything reads texture coordinates.
    pub fn needs_coordinates(&self) -> bool {
        self.shapes.iter().any(|shape| shape.needs_uv)
    }

    /// Whether groups of shapes are placed several times.
    pub fn has_instances(&self) -> bool {
        self.instances.is_some()
    }

    /// How many primitives there are: triangles, and analytic shapes as one each.
    pub fn primitive_count(&self) -> usize {
        self.info.len()
    }

    /// Smallest and largest coordinates, m.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        (self.low, self.high)
    }

    /// Boxes around the primitives of those shapes that `wanted` picks, and around those of each instance, by smallest and largest
    /// coordinates, m; in the order of the trees, in which neighbors are mostly near each other.
    pub fn boxes_of(&self, wanted: &dyn Fn(Shape) -> bool) -> Vec<(Vec3, Vec3)> {
        let primitives = self.info.iter().zip(self.accelerator.primitives());
        let mut boxes: Vec<(Vec3, Vec3)> = primitives
            .filter(|(info, _)| wanted(self.shapes[info.shape as usize]))
            .map(|(_, primitive)| primitive.bounds())
            .collect();
        if let Some(instances) = &self.instances {
            boxes.extend(instances.boxes_of(wanted));
        }
        boxes
    }

    /// Centre and radius of a sphere around everything, m.
    pub fn bounding_sphere(&self) -> (Vec3, f32) {
        let center = (self.low + self.high) * 0.5;
        (center, center.distance(self.high).max(f32::MIN_POSITIVE) * 1.0001)
    }

    /// The object that a hit is on: its shape's index, or that of its instance in the order of the scene after all shapes.
    pub fn object(&self, hit: &Interaction) -> usize {
        match &self.instances {
            Some(instances) if hit.instance != NO_INSTANCE => {
                self.shapes.len() + instances.place_in_scene(hit.instance)
            }
            _ => self.info[hit.primitive as usize].shape as usize,
        }
    }

    /// Records that `shape` carries `light`.
    pub fn set_light(&mut self, shape: usize, light: u32) {
        self.shapes[shape].light = light;
    }

    /// The first surface along `ray`, with all that its material needs.
    // A call of its own that holds all of the search, so that it writes the hit to where it is wanted.
    #[inline(never)]
    pub fn intersect(&self, ray: &Ray) -> Option<Interaction> {
        let nearest = self.accelerator.nearest(ray);
        if let Some(instances) = &self.instances {
            return self.intersect_instances(instances, ray, nearest);
        }
        let (index, hit) = nearest?;
        Some(self.interaction(ray, index, &hit))
    }

    #[inline(never)]
    fn intersect_instances(
        &self,
        instances: &Instances,
        ray: &Ray,
        nearest: Option<(usize, PrimitiveHit)>,
    ) -> Option<Interaction> {
        let length = nearest.map_or(ray.length, |(_, hit)| hit.distance);
        if let Some(found) = instances.nearest(&Ray { length, ..*ray }) {
            let mut hit = instances.interaction(ray, &found);
            if hit.shape.needs_partials {
                hit.detail = Detail::in_frame(&hit.frame, self.partials(&hit));
            }
            return Some(hit);
        }
        let (index, hit) = nearest?;
        Some(self.interaction(ray, index, &hit))
    }

    /// Whether anything is between a ray's origin and its length.
    #[inline]
    pub fn is_blocked(&self, ray: &Ray) -> bool {
        self.accelerator.is_blocked(ray) || self.instances.as_ref().is_some_and(|instances| instances.is_blocked(ray))
    }

    // Inlined always: as a call of its own it would copy every hit once more.
    #[inline(always)]
    pub(super) fn interaction(&self, ray: &Ray, index: usize, hit: &PrimitiveHit) -> Interaction {
        let point = self.accelerator.primitives()[index].surface(ray, hit);
        let info = self.info[index];
        let (shading, geometric) = match info.shading {
            NO_SHADING => (point.normal, point.normal),
            shading => self.shading_normal(shading, hit.barycentric, point.normal),
        };
        let shape = self.shapes[info.shape as usize];
        // Given by value: a hit whose address is known elsewhere would be copied once more.
        let Parameterized { uv, frame, detail } = match shape.needs_uv {
            true => self.parameterized(shape, index as u32, point.position, shading, hit.barycentric),
            false => Parameterized::around(shading),
        };
        Interaction {
            position: point.position,
            geometric_normal: geometric,
            frame,
            uv,
            outgoing: -ray.direction,
            distance: hit.distance,
            shape,
            primitive: index as u32,
            instance: NO_INSTANCE,
            error: point.error,
            detail,
        }
    }

    /// A point uniform by area on the primitive at a tree index, with its normal on the side that a hit there has it.
    #[inline(always)]
    pub fn sample(&self, primitive: u32, u: [f32; 2]) -> SurfacePoint {
        let mut point = self.primitive(primitive).sample(u);
        if !self.shading_normals.is_empty() {
            point.normal = self.outside_normal(primitive, u, point.normal);
        }
        point
    }

    /// A primitive's own normal turned to the side that its hits have it on, at the point that `u` samples.
    #[inline(never)]
    fn outside_normal(&self, primitive: u32, u: [f32; 2], own: Vec3) -> Vec3 {
        match self.info[primitive as usize].shading {
            NO_SHADING => own,
            shading => self.shading_normal(shading, warp::triangle(u).to_array(), own).1,
        }
    }

    /// The interpolated normal, and the true one turned to its side: the file's normals say what is outside.
    fn shading_normal(&self, shading: u32, [v, w]: [f32; 2], geometric: Vec3) -> (Vec3, Vec3) {
        let [a, b, c] = self.shading_normals[shading as usize];
        let Some(normal) = (a * (1.0 - v - w) + b * v + c * w).try_normalize() else {
            return (geometric, geometric);
        };
        (normal, if normal.dot(geometric) < 0.0 { -geometric } else { geometric })
    }
}
