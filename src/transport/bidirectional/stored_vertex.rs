//! Vertices of light subpaths as they are kept for a whole pass, 76 bytes each; another 32 bytes stand in the photon map.

use super::vertex::Vertex;
use super::weights::Sums;
use crate::math::{Frame, Rgb, Vec2, Vec3, octahedral};
use crate::scene::geometry::surface::NO_INSTANCE;
use crate::scene::geometry::{Detail, Interaction, Shape};

/// A packed vertex. Directions and normals are octahedral codes, 0.05 mrad off at worst.
#[derive(Clone, Copy, Debug)]
pub struct StoredVertex {
    position: [f32; 3],
    outgoing: u32,
    geometric_normal: u32,
    shading_normal: u32,
    /// Of the frame; its lowest bit says whether the frame is left-handed.
    tangent: u32,
    uv: [f32; 2],
    throughput: [f32; 3],
    sums: Sums,
    material: u32,
    segments: u16,
    /// `Interaction::error`, rounded up to its upper 16 bits.
    error: u16,
    /// `Interaction::detail`.
    detail: Detail,
}

impl StoredVertex {
    /// Packs a vertex.
    #[inline]
    pub fn new(vertex: &Vertex) -> Self {
        let hit = &vertex.hit;
        let tangent = octahedral::encode(hit.frame.tangent);
        Self {
            position: hit.position.to_array(),
            outgoing: octahedral::encode(hit.outgoing),
            geometric_normal: octahedral::encode(hit.geometric_normal),
            shading_normal: octahedral::encode(hit.frame.normal),
            tangent: tangent & !1 | u32::from(hit.frame.is_left_handed()),
            uv: hit.uv.to_array(),
            throughput: vertex.throughput.to_array(),
            sums: vertex.sums,
            material: hit.shape.material,
            segments: vertex.segments.min(u32::from(u16::MAX)) as u16,
            error: (hit.error.to_bits().saturating_add(0xffff) >> 16) as u16,
            detail: hit.detail,
        }
    }

    /// The vertex without the primitive and the distance that led to it.
    #[inline]
    pub fn unpack(&self) -> Vertex {
        let normal = octahedral::decode(self.shading_normal);
        let tangent = octahedral::decode(self.tangent & !1);
        let tangent = (tangent - normal * normal.dot(tangent)).normalize();
        let side = if self.tangent & 1 == 1 { -1.0 } else { 1.0 };
        let geometric = octahedral::decode(self.geometric_normal);
        let hit = Interaction {
            position: Vec3::from_array(self.position),
            geometric_normal: if self.geometric_normal == self.shading_normal { normal } else { geometric },
            frame: Frame { tangent, bitangent: normal.cross(tangent) * side, normal },
            uv: Vec2::from_array(self.uv),
            outgoing: self.direction(),
            distance: 0.0,
            shape: Shape::new(self.material),
            primitive: 0,
            instance: NO_INSTANCE,
            error: f32::from_bits(u32::from(self.error) << 16),
            detail: self.detail,
        };
        let throughput = Rgb::from_array(self.throughput);
        let segments = self.segments();
        // Joints look at the media of the vertex at their other end.
        Vertex { hit, throughput, sums: self.sums, segments, steps: segments, medium: None }
    }

    /// Unit direction back along the light subpath.
    #[inline]
    pub fn direction(&self) -> Vec3 {
        octahedral::decode(self.outgoing)
    }

    /// The octahedral code of [`StoredVertex::direction`].
    #[inline]
    pub fn direction_code(&self) -> u32 {
        self.outgoing
    }

    /// Its part of the weights.
    #[inline]
    pub fn sums(&self) -> Sums {
        self.sums
    }

    /// Segments of the light subpath up to here.
    #[inline]
    pub fn segments(&self) -> u32 {
        u32::from(self.segments)
    }
}
