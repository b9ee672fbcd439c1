//! What is kept of light subpaths for a whole pass: vertices to connect with, 80 bytes each, and photons to merge with, 52 bytes each.

use super::vertex::Vertex;
use super::weights::Sums;
use crate::math::{Frame, Rgb, Vec2, Vec3, octahedral};
use crate::scene::geometry::surface::NO_INSTANCE;
use crate::scene::geometry::{Detail, Interaction, Shape};
use crate::transport::photon_map::{Photon, PhotonWith};
use crate::transport::photon_tracing::stored;
use crate::transport::shading::facing_normal;

/// A packed vertex: a photon with the flux that arrives, and what else there is of its hit.
#[derive(Clone, Copy, Debug)]
pub struct StoredVertex {
    photon: Photon,
    hit: PackedHit,
    sums: Sums,
    /// All of them, where the photon counts to 127.
    segments: u16,
}

/// A hit without its position and its direction. Normals and tangents are octahedral codes, 0.05 mrad off at worst.
#[derive(Clone, Copy, Debug)]
struct PackedHit {
    geometric_normal: u32,
    shading_normal: u32,
    /// Of the frame; its lowest bit says whether the frame is left-handed.
    tangent: u32,
    uv: [f32; 2],
    material: u32,
    /// `Interaction::detail`.
    detail: Detail,
    /// `Interaction::error`, rounded up to its upper 16 bits.
    error: u16,
}

impl PackedHit {
    #[inline]
    fn new(hit: &Interaction) -> Self {
        let tangent = octahedral::encode(hit.frame.tangent);
        Self {
            geometric_normal: octahedral::encode(hit.geometric_normal),
            shading_normal: octahedral::encode(hit.frame.normal),
            tangent: tangent & !1 | u32::from(hit.frame.is_left_handed()),
            uv: hit.uv.to_array(),
            material: hit.shape.material,
            detail: hit.detail,
            error: (hit.error.to_bits().saturating_add(0xffff) >> 16) as u16,
        }
    }

    /// The hit at `photon`, without the primitive and the distance that led to it.
    #[inline]
    fn unpack(&self, photon: &Photon) -> Interaction {
        let normal = octahedral::decode(self.shading_normal);
        let tangent = octahedral::decode(self.tangent & !1);
        let tangent = (tangent - normal * normal.dot(tangent)).normalize();
        let side = if self.tangent & 1 == 1 { -1.0 } else { 1.0 };
        let geometric = octahedral::decode(self.geometric_normal);
        Interaction {
            position: Vec3::from_array(photon.position),
            geometric_normal: if self.geometric_normal == self.shading_normal { normal } else { geometric },
            frame: Frame { tangent, bitangent: normal.cross(tangent) * side, normal },
            uv: Vec2::from_array(self.uv),
            outgoing: octahedral::decode(photon.direction),
            distance: 0.0,
            shape: Shape::new(self.material),
            primitive: 0,
            instance: NO_INSTANCE,
            error: f32::from_bits(u32::from(self.error) << 16),
            detail: self.detail,
        }
    }
}

impl StoredVertex {
    /// Packs a vertex.
    #[inline]
    pub fn new(vertex: &Vertex) -> Self {
        let Vertex { hit, throughput, sums, segments, .. } = vertex;
        let direction = octahedral::encode(hit.outgoing);
        let photon = Photon::new(hit.position, direction, facing_normal(hit), *throughput, *segments, false);
        let segments = (*segments).min(u32::from(u16::MAX)) as u16;
        Self { photon, hit: PackedHit::new(hit), sums: *sums, segments }
    }

    /// The vertex without the primitive and the distance that led to it.
    #[inline]
    pub fn unpack(&self) -> Vertex {
        let Self { photon, hit, sums, segments } = self;
        let (throughput, segments) = (Rgb::from_array(photon.flux), u32::from(*segments));
        // Joints look at the media of the vertex at their other end.
        Vertex { hit: hit.unpack(photon), throughput, sums: *sums, segments, steps: segments, medium: None }
    }
}

/// What a merge needs of a light vertex beside its photon.
#[derive(Clone, Copy, Debug, Default)]
pub struct MergeRecord {
    /// Its part of the weights.
    pub(super) sums: Sums,
    /// Segments of the light subpath up to here.
    pub(super) segments: u32,
    /// How far the photon came from, m.
    pub(super) origin_distance: f32,
}

/// A light vertex to merge with.
pub type MergePhoton = PhotonWith<MergeRecord>;

impl MergePhoton {
    /// `None` where the surface is seen from another side than it is shaded.
    #[inline]
    pub fn new(vertex: &Vertex) -> Option<Self> {
        let Vertex { hit, throughput, sums, segments, .. } = vertex;
        let photon = stored(hit, *throughput, *segments, false)?;
        Some(Self { photon, extra: MergeRecord { sums: *sums, segments: *segments, origin_distance: hit.distance } })
    }
}
