//! Eight primitives of one kind, tested against a ray together: the leaves of the accelerator.
//!
//! The lanes compute what `Triangle::intersect`, `Rectangle::intersect` and `Disk::intersect` compute, in the same order, and
//! give the same bits; those are the plain twins.

use glam::Vec3;

use super::obstacles::Layer;
use super::one_sided_triangle::OneSidedTriangle;
use super::primitive::Primitive;
use super::ray::{PrimitiveHit, Ray, Shear};
use super::triangle::Triangle;
use crate::math::lanes::{larger, smaller};

/// How many primitives a block holds at most.
pub const LANES: usize = 8;

type Lanes = [f32; LANES];
/// A vector per lane, one array per axis.
type VectorLanes = [Lanes; 3];

/// A leaf of the accelerator.
pub enum Block {
    /// Triangles: their three vertices.
    Triangles(Box<[VectorLanes; 3]>),
    /// Triangles that are met from outside only.
    OneSidedTriangles(Box<[VectorLanes; 3]>),
    /// Rectangles and disks.
    Flat(Box<FlatLanes>),
    /// A primitive that is tested alone.
    Single,
}

/// Rectangles and disks, by lane.
pub struct FlatLanes {
    center: VectorLanes,
    normal: VectorLanes,
    dual: [VectorLanes; 2],
    /// 1 for disks, 0 for rectangles.
    roundness: Lanes,
}

/// A flat primitive: the parallelogram `center ± u ± v`, or the ellipse in it, with `dual` the coordinates in that frame.
#[derive(Clone, Copy, Debug)]
pub struct FlatFrame {
    /// The centre, m.
    pub center: Vec3,
    /// Unit normal.
    pub normal: Vec3,
    /// `dual[i]·p` is the coordinate i of a point `p` of the plane relative to the centre, -1 to 1 inside.
    pub dual: [Vec3; 2],
}

/// The nearest hit of a block.
#[derive(Clone, Copy, Debug)]
pub struct BlockHit {
    /// Which of its primitives.
    pub lane: usize,
    /// Where.
    pub hit: PrimitiveHit,
}

/// Kinds of primitives that share a block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BlockKind {
    /// Triangles.
    Triangles,
    /// Triangles that are met from outside only.
    OneSidedTriangles,
    /// Rectangles and disks.
    Flat,
    /// All others.
    Single,
}

impl BlockKind {
    /// The kind of block for a primitive.
    pub fn of(primitive: &Primitive) -> Self {
        match primitive {
            Primitive::Triangle(_) => Self::Triangles,
            Primitive::OneSidedTriangle(_) => Self::OneSidedTriangles,
            Primitive::Rectangle(_) | Primitive::Disk(_) => Self::Flat,
            _ => Self::Single,
        }
    }
}

fn set(lanes: &mut VectorLanes, lane: usize, vector: Vec3) {
    for (axis, value) in vector.to_array().into_iter().enumerate() {
        lanes[axis][lane] = value;
    }
}

/// The corners of triangles by lane; spare lanes repeat the first.
fn vertices_of(primitives: &[Primitive]) -> Box<[VectorLanes; 3]> {
    let mut vertices = Box::new([[[0.0; LANES]; 3]; 3]);
    for lane in 0..LANES {
        let (Primitive::Triangle(triangle) | Primitive::OneSidedTriangle(OneSidedTriangle(triangle))) =
            primitives.get(lane).unwrap_or(&primitives[0])
        else {
            continue;
        };
        (0..3).for_each(|vertex| set(&mut vertices[vertex], lane, triangle.vertices[vertex]));
    }
    vertices
}

impl Block {
    /// A block of 1 to [`LANES`] primitives of one kind; spare lanes repeat the first, which never wins against itself.
    pub fn new(primitives: &[Primitive]) -> Self {
        let of_lane = |lane: usize| primitives.get(lane).unwrap_or(&primitives[0]);
        match BlockKind::of(&primitives[0]) {
            BlockKind::Single => Self::Single,
            BlockKind::Triangles => Self::Triangles(vertices_of(primitives)),
            BlockKind::OneSidedTriangles => Self::OneSidedTriangles(vertices_of(primitives)),
            BlockKind::Flat => {
                let zero = [[0.0; LANES]; 3];
                let mut lanes =
                    Box::new(FlatLanes { center: zero, normal: zero, dual: [zero; 2], roundness: [0.0; LANES] });
                for lane in 0..LANES {
                    let (frame, roundness) = match of_lane(lane) {
                        Primitive::Rectangle(rectangle) => (rectangle.frame(), 0.0),
                        Primitive::Disk(disk) => (disk.frame(), 1.0),
                        _ => continue,
                    };
                    set(&mut lanes.center, lane, frame.center);
                    set(&mut lanes.normal, lane, frame.normal);
                    (0..2).for_each(|axis| set(&mut lanes.dual[axis], lane, frame.dual[axis]));
                    lanes.roundness[lane] = roundness;
                }
                Self::Flat(lanes)
            }
        }
    }

    /// The nearest hit before `length` among the block's `primitives`.
    #[inline(always)]
    pub fn intersect(&self, primitives: &[Primitive], ray: &Ray, shear: &Shear, length: f32) -> Option<BlockHit> {
        match self {
            Self::Triangles(vertices) => intersect_triangles::<true>(vertices, ray, shear, length),
            Self::OneSidedTriangles(vertices) => intersect_triangles::<false>(vertices, ray, shear, length),
            Self::Flat(lanes) => lanes.intersect(ray, length),
            Self::Single => primitives[0].intersect(ray, shear, length).map(|hit| BlockHit { lane: 0, hit }),
        }
    }

    /// Bits of the lanes whose primitive may reach into `layer`, in spare lanes too; 0 only where it does not.
    #[inline]
    pub fn may_reach(&self, layer: &Layer) -> u32 {
        match self {
            Self::Triangles(vertices) | Self::OneSidedTriangles(vertices) => triangles_may_reach(vertices, layer),
            Self::Flat(lanes) => lanes.may_reach(layer),
            Self::Single => 1,
        }
    }
}

/// By heights over the surface and by boxes; triangles of the surface itself lie below the layer.
#[inline]
fn triangles_may_reach([a, b, c]: &[VectorLanes; 3], layer: &Layer) -> u32 {
    let (low, high) = layer.bounds();
    let (low, high, center, normal) =
        (low.to_array(), high.to_array(), layer.center.to_array(), layer.normal.to_array());
    let height = |vertex: &VectorLanes, lane: usize| {
        let relative = [0, 1, 2].map(|axis| vertex[axis][lane] - center[axis]);
        relative[0] * normal[0] + relative[1] * normal[1] + relative[2] * normal[2]
    };
    let mut reaches = [false; LANES];
    for (lane, reaches) in reaches.iter_mut().enumerate() {
        let heights = [height(a, lane), height(b, lane), height(c, lane)];
        let (least, most) =
            (smaller(smaller(heights[0], heights[1]), heights[2]), larger(larger(heights[0], heights[1]), heights[2]));
        *reaches = (least <= layer.half) & (most >= -layer.half);
    }
    for axis in 0..3 {
        for (lane, reaches) in reaches.iter_mut().enumerate() {
            let (a, b, c) = (a[axis][lane], b[axis][lane], c[axis][lane]);
            let (least, most) = (smaller(smaller(a, b), c), larger(larger(a, b), c));
            *reaches &= (least <= high[axis]) & (most >= low[axis]);
        }
    }
    (0..LANES).fold(0, |mask, lane| mask | u32::from(reaches[lane]) << lane)
}

/// The lane with the smallest distance, the first of equals; `None` when all are infinite.
#[inline(always)]
fn nearest_lane(distance: &Lanes) -> Option<usize> {
    // Halves against halves, and equality as a bit mask: one vector instruction each.
    let four: [f32; 4] = std::array::from_fn(|lane| smaller(distance[lane], distance[lane + 4]));
    let two: [f32; 2] = std::array::from_fn(|lane| smaller(four[lane], four[lane + 2]));
    let nearest = smaller(two[0], two[1]);
    if nearest == f32::INFINITY {
        return None;
    }
    let mask = (0..LANES).fold(0u32, |mask, lane| mask | u32::from(distance[lane] == nearest) << lane);
    Some(mask.trailing_zeros() as usize)
}

/// Without `BACK` rays meet the triangles from outside only.
#[inline]
fn intersect_triangles<const BACK: bool>(
    vertices: &[VectorLanes; 3],
    ray: &Ray,
    shear: &Shear,
    length: f32,
) -> Option<BlockHit> {
    let [x, y, z] = shear.axes;
    let [shear_x, shear_y, shear_z] = shear.shear;
    let origin = ray.origin.to_array();
    let mut sheared = [[[0.0f32; LANES]; 3]; 3];
    for (vertex, out) in vertices.iter().zip(&mut sheared) {
        let (from_x, from_y, from_z) = (&vertex[x], &vertex[y], &vertex[z]);
        for lane in 0..LANES {
            let relative_z = from_z[lane] - origin[z];
            out[0][lane] = (from_x[lane] - origin[x]) - shear_x * relative_z;
            out[1][lane] = (from_y[lane] - origin[y]) - shear_y * relative_z;
            out[2][lane] = relative_z;
        }
    }
    let [a, b, c] = &sheared;
    let mut edges = [[0.0f32; LANES]; 3];
    let mut distance = [f32::INFINITY; LANES];
    let mut zero = 0u32;
    for lane in 0..LANES {
        edges[0][lane] = c[0][lane] * b[1][lane] - c[1][lane] * b[0][lane];
        edges[1][lane] = a[0][lane] * c[1][lane] - a[1][lane] * c[0][lane];
        edges[2][lane] = b[0][lane] * a[1][lane] - b[1][lane] * a[0][lane];
    }
    for lane in 0..LANES {
        let (u, v, w) = (edges[0][lane], edges[1][lane], edges[2][lane]);
        zero |= u32::from((u == 0.0) | (v == 0.0) | (w == 0.0));
        let outside = ((u < 0.0) | (v < 0.0) | (w < 0.0)) & ((u > 0.0) | (v > 0.0) | (w > 0.0));
        let determinant = u + v + w;
        let inverse = 1.0 / determinant;
        let at = shear_z * (u * a[2][lane] + v * b[2][lane] + w * c[2][lane]) * inverse;
        let from_back = (determinant > 0.0) != (shear_z > 0.0);
        let counts = !outside & (determinant != 0.0) & (BACK | !from_back) & (at > 0.0) & (at < length);
        distance[lane] = if counts { at } else { f32::INFINITY };
    }
    if zero != 0 {
        return through_an_edge::<BACK>(vertices, ray, shear, length);
    }
    let lane = nearest_lane(&distance)?;
    let inverse = 1.0 / (edges[0][lane] + edges[1][lane] + edges[2][lane]);
    let barycentric = [edges[1][lane] * inverse, edges[2][lane] * inverse];
    Some(BlockHit { lane, hit: PrimitiveHit { distance: distance[lane], barycentric } })
}

/// One by one, where some triangle needs double precision.
#[cold]
fn through_an_edge<const BACK: bool>(
    vertices: &[VectorLanes; 3],
    ray: &Ray,
    shear: &Shear,
    length: f32,
) -> Option<BlockHit> {
    let mut nearest = None;
    let mut length = length;
    for lane in 0..LANES {
        let corner = |vertex: usize| Vec3::from_array(vertices[vertex].map(|axis| axis[lane]));
        let triangle = Triangle { vertices: [corner(0), corner(1), corner(2)] };
        if let Some(hit) = triangle.intersect_sides::<BACK>(ray, shear, length) {
            length = hit.distance;
            nearest = Some(BlockHit { lane, hit });
        }
    }
    nearest
}

#[inline(always)]
fn dot(a: &VectorLanes, b: [f32; 3], lane: usize) -> f32 {
    a[0][lane] * b[0] + a[1][lane] * b[1] + a[2][lane] * b[2]
}

impl FlatLanes {
    #[inline]
    fn intersect(&self, ray: &Ray, length: f32) -> Option<BlockHit> {
        let (origin, direction) = (ray.origin.to_array(), ray.direction.to_array());
        let mut distance = [f32::INFINITY; LANES];
        for (lane, distance) in distance.iter_mut().enumerate() {
            let to_center = [0, 1, 2].map(|axis| self.center[axis][lane] - origin[axis]);
            let at = dot(&self.normal, to_center, lane) / dot(&self.normal, direction, lane);
            let local = [0, 1, 2].map(|axis| direction[axis] * at - to_center[axis]);
            let (u, v) = (dot(&self.dual[0], local, lane), dot(&self.dual[1], local, lane));
            let inside = if self.roundness[lane] != 0.0 { u * u + v * v } else { larger(u.abs(), v.abs()) } <= 1.0;
            *distance = if inside & (at > 0.0) & (at < length) { at } else { f32::INFINITY };
        }
        let lane = nearest_lane(&distance)?;
        Some(BlockHit { lane, hit: PrimitiveHit::at(distance[lane]) })
    }

    /// By their planes.
    #[inline]
    fn may_reach(&self, layer: &Layer) -> u32 {
        let (center, normal) = (layer.center.to_array(), layer.normal.to_array());
        let mut reaches = [false; LANES];
        for (lane, reaches) in reaches.iter_mut().enumerate() {
            let to_center = [0, 1, 2].map(|axis| self.center[axis][lane] - center[axis]);
            let cosine = dot(&self.normal, normal, lane);
            *reaches = dot(&self.normal, to_center, lane).abs() <= layer.reach(cosine);
        }
        (0..LANES).fold(0, |mask, lane| mask | u32::from(reaches[lane]) << lane)
    }
}
