//! What the accelerator holds. A new kind of primitive is one file and one row in `primitives!`; a new kind of shape is one
//! file and one row in [`SHAPES`].

use glam::{Vec2, Vec3};

use super::curve;
use super::cylinder::{self, Cylinder};
use super::disk::{self, Disk};
use super::mesh::{self, ShapeGeometry};
use super::one_sided_triangle::OneSidedTriangle;
use super::ray::{PrimitiveHit, Ray, Shear, SurfacePoint};
use super::rectangle::{self, Rectangle};
use super::sphere::{self, Sphere};
use super::triangle::Triangle;
use crate::scene::bundle::Bundle;
use crate::scene::error::SceneError;
use crate::scene::fields::Fields;

/// Reads the parameters of a shape plugin.
pub type ReadShape = fn(&mut Fields<'_>, &Bundle) -> Result<ShapeGeometry, SceneError>;

/// Shape plugins by name.
pub const SHAPES: &[(&str, ReadShape)] = &[
    ("rectangle", |fields, _| rectangle::read(fields)),
    ("cube", |fields, _| mesh::read_cube(fields)),
    ("sphere", |fields, _| sphere::read(fields)),
    ("disk", |fields, _| disk::read(fields)),
    ("cylinder", |fields, _| cylinder::read(fields)),
    ("ply", mesh::read_ply),
    ("obj", mesh::read_obj),
    ("serialized", mesh::read_serialized),
    ("linearcurve", curve::read_linear),
    ("bsplinecurve", curve::read_spline),
];

macro_rules! primitives {
    ($($kind:ident),+) => {
        /// One thing that rays can hit.
        #[derive(Clone, Copy, Debug)]
        pub enum Primitive {
            $(#[doc = concat!("A ", stringify!($kind), ".")] $kind($kind)),+
        }

        impl Primitive {
            /// Nearest hit before `length`, m.
            #[inline(always)]
            pub fn intersect(&self, ray: &Ray, shear: &Shear, length: f32) -> Option<PrimitiveHit> {
                match self { $(Self::$kind(primitive) => primitive.intersect(ray, shear, length)),+ }
            }

            /// The surface at a hit.
            #[inline]
            pub fn surface(&self, ray: &Ray, hit: &PrimitiveHit) -> SurfacePoint {
                match self { $(Self::$kind(primitive) => primitive.surface(ray, hit)),+ }
            }

            /// Area, m².
            pub fn area(&self) -> f32 {
                match self { $(Self::$kind(primitive) => primitive.area()),+ }
            }

            /// Smallest and largest coordinates, m.
            pub fn bounds(&self) -> (Vec3, Vec3) {
                match self { $(Self::$kind(primitive) => primitive.bounds()),+ }
            }

            /// Texture coordinates at `position`; `barycentric` as in a triangle's hit.
            pub fn uv(&self, position: Vec3, barycentric: [f32; 2]) -> Vec2 {
                match self { $(Self::$kind(primitive) => primitive.uv(position, barycentric)),+ }
            }

            /// ∂p/∂u and ∂p/∂v at `position`, m.
            pub fn partials(&self, position: Vec3) -> [Vec3; 2] {
                match self { $(Self::$kind(primitive) => primitive.partials(position)),+ }
            }

            /// A point uniform by area.
            pub fn sample(&self, u: [f32; 2]) -> SurfacePoint {
                match self { $(Self::$kind(primitive) => primitive.sample(u)),+ }
            }
        }
    };
}

primitives!(Triangle, OneSidedTriangle, Rectangle, Sphere, Disk, Cylinder);

impl Primitive {
    /// Whether all of it lies in one plane.
    pub fn is_flat(&self) -> bool {
        match self {
            Self::Triangle(_) | Self::OneSidedTriangle(_) | Self::Rectangle(_) | Self::Disk(_) => true,
            Self::Sphere(_) | Self::Cylinder(_) => false,
        }
    }

    /// A point and the unit normal of the plane that it lies in, if it lies in one.
    #[inline]
    pub fn plane(&self) -> Option<(Vec3, Vec3)> {
        match self {
            Self::Triangle(triangle) | Self::OneSidedTriangle(OneSidedTriangle(triangle)) => {
                let [a, b, c] = triangle.vertices;
                Some((a, (b - a).cross(c - a).normalize()))
            }
            Self::Rectangle(rectangle) => Some((rectangle.frame().center, rectangle.frame().normal)),
            Self::Disk(disk) => Some((disk.frame().center, disk.frame().normal)),
            Self::Sphere(_) | Self::Cylinder(_) => None,
        }
    }
}
