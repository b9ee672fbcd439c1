//! Hit points: where camera paths meet surfaces, packed to be kept for a whole job, 48 bytes each.

use crate::math::octahedral;
use crate::math::trigonometry::sin_cos_turn;
use crate::math::{Frame, Rgb, Vec2, Vec3};
use crate::scene::geometry::surface::NO_INSTANCE;
use crate::scene::geometry::{Detail, Interaction, Shape};
use crate::scene::material::Lobes;

use super::camera_walk::GatherPoint;

/// Where a camera path meets a surface with a smooth lobe.
#[derive(Clone, Copy, Debug)]
pub(crate) struct HitPoint {
    position: Vec3,
    /// Octahedral codes: true normal, shading normal, direction towards the camera.
    directions: [u32; 3],
    /// What the path carries.
    pub throughput: Rgb,
    /// Material, and segments from the camera in the top byte.
    material_and_segments: u32,
    parameterization: Parameterization,
    /// `Interaction::detail`.
    detail: Detail,
    /// The shape's border between media.
    boundary: u16,
    /// The index of the medium that the path came through, or [`NO_MEDIUM`].
    medium: u16,
}

/// The number of a medium where there is none.
const NO_MEDIUM: u16 = u16::MAX;

/// Texture coordinates as floats of 24 bits each, a 2¹⁶th exact; then the tangent's turn from that of [`Frame::from_normal`]
/// in 15 bits, and whether the bitangent is mirrored. Fractions of integers would not do: how far coordinates go, and how
/// they wrap, is each texture's own affair. All 0 where the shape needs none.
#[derive(Clone, Copy, Debug)]
struct Parameterization(u64);

const TURNS: f32 = 32768.0;

impl Parameterization {
    fn new(hit: &Interaction) -> Self {
        if !hit.shape.needs_uv {
            return Self(0);
        }
        let [u, v] = hit.uv.to_array().map(|number| u64::from(number.to_bits().saturating_add(0x80) >> 8));
        let plain = Frame::from_normal(hit.frame.normal);
        let local = plain.to_local(hit.frame.tangent);
        let turn = libm::atan2f(local.y, local.x) / std::f32::consts::TAU;
        let turn = ((turn + 1.0) * TURNS + 0.5) as u64 % TURNS as u64;
        let mirrored = hit.frame.normal.cross(hit.frame.tangent).dot(hit.frame.bitangent) < 0.0;
        Self(u | v << 24 | turn << 48 | u64::from(mirrored) << 63)
    }

    fn uv(self) -> Vec2 {
        Vec2::new(f32::from_bits((self.0 as u32) << 8), f32::from_bits(((self.0 >> 24) as u32) << 8))
    }

    fn frame(self, normal: Vec3) -> Frame {
        let plain = Frame::from_normal(normal);
        let (sin, cos) = sin_cos_turn((self.0 >> 48 & 0x7fff) as f32 / TURNS);
        let side = if self.0 >> 63 == 1 { -1.0 } else { 1.0 };
        Frame {
            tangent: plain.tangent * cos + plain.bitangent * sin,
            bitangent: (plain.bitangent * cos - plain.tangent * sin) * side,
            normal,
        }
    }
}

const MATERIAL_BITS: u32 = 24;

impl HitPoint {
    /// Packs a point.
    pub(crate) fn new(point: &GatherPoint) -> Self {
        let hit = &point.hit;
        let directions = [hit.geometric_normal, hit.frame.normal, hit.outgoing].map(octahedral::encode);
        Self {
            position: hit.position,
            directions,
            throughput: point.throughput,
            material_and_segments: hit.shape.material | point.segments.min(255) << MATERIAL_BITS,
            parameterization: Parameterization::new(hit),
            detail: hit.detail,
            boundary: hit.shape.boundary,
            medium: point.medium.unwrap_or(NO_MEDIUM),
        }
    }

    /// Segments of the path from the camera, at most 255.
    pub(crate) fn segments(&self) -> u32 {
        self.material_and_segments >> MATERIAL_BITS
    }

    /// The point, where positions of the scene are `error` off at worst, m.
    pub(crate) fn gather_point(&self, error: f32) -> GatherPoint {
        let [geometric_normal, shading_normal, outgoing] = self.directions.map(octahedral::decode);
        let material = self.material_and_segments & ((1 << MATERIAL_BITS) - 1);
        // Codes of equal normals are equal: flat surfaces stay flat.
        let flat = self.directions[0] == self.directions[1];
        let hit = Interaction {
            position: self.position,
            geometric_normal,
            frame: self.parameterization.frame(if flat { geometric_normal } else { shading_normal }),
            uv: self.parameterization.uv(),
            outgoing,
            distance: 0.0,
            shape: Shape { boundary: self.boundary, ..Shape::new(material) },
            primitive: 0,
            instance: NO_INSTANCE,
            error,
            detail: self.detail,
        };
        GatherPoint {
            hit,
            throughput: self.throughput,
            segments: self.segments(),
            path_length: 0.0,
            medium: (self.medium != NO_MEDIUM).then_some(self.medium),
            lobes: Lobes::SMOOTH,
            goes_on: false,
        }
    }
}
