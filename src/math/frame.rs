//! Local frames whose z axis is a normal.

use glam::Vec3;

/// An orthonormal frame; `normal` is its z axis.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    /// x axis.
    pub tangent: Vec3,
    /// y axis.
    pub bitangent: Vec3,
    /// z axis.
    pub normal: Vec3,
}

impl Frame {
    /// A frame around a unit `normal`, without a branch on its direction [Duff et al. 2017, listing 3].
    #[inline]
    pub fn from_normal(normal: Vec3) -> Self {
        let sign = 1.0f32.copysign(normal.z);
        let a = -1.0 / (sign + normal.z);
        let b = normal.x * normal.y * a;
        Self {
            tangent: Vec3::new(1.0 + sign * normal.x * normal.x * a, sign * b, -sign * normal.x),
            bitangent: Vec3::new(b, sign + normal.y * normal.y * a, -normal.y),
            normal,
        }
    }

    /// Whether `bitangent` is on the other side of normal × tangent.
    pub fn is_left_handed(&self) -> bool {
        self.normal.cross(self.tangent).dot(self.bitangent) < 0.0
    }

    /// World to local.
    #[inline]
    pub fn to_local(&self, world: Vec3) -> Vec3 {
        Vec3::new(world.dot(self.tangent), world.dot(self.bitangent), world.dot(self.normal))
    }

    /// Local to world.
    #[inline]
    pub fn to_world(&self, local: Vec3) -> Vec3 {
        self.tangent * local.x + self.bitangent * local.y + self.normal * local.z
    }
}
