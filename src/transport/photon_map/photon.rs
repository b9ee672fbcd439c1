//! A photon, as a record while it is traced and as columns once it is sorted. 32 bytes either way, and 4 for how far it came.

use bytemuck::{Pod, Zeroable};

use crate::math::{Rgb, Vec3};

/// A stored photon.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Photon {
    /// Position, m.
    pub position: [f32; 3],
    /// Octahedral code of the direction it came from.
    pub direction: u32,
    /// The surface's normal on the side of arrival, three signed bytes of 1/127; in the top byte the segment count, and
    /// [`SCATTERED`] above it.
    pub normal_and_segments: u32,
    /// Un-normalised flux, W.
    pub flux: [f32; 3],
}

/// What is sorted into a map: a photon, and what else a method needs of it.
pub trait PhotonRecord: Copy + Default + Send + Sync {
    /// What else there is; `()` for nothing.
    type Extra: Copy + Default + Send + Sync;

    /// The photon.
    fn photon(&self) -> &Photon;

    /// What else there is of it.
    fn extra(&self) -> Self::Extra;

    /// The same photon with `factor` times its flux.
    #[must_use]
    fn scaled(self, factor: f32) -> Self;
}

/// What a tree keeps of a photon.
pub trait StoredPhoton: Copy + Send + Sync {
    /// Position, m.
    fn position(&self) -> [f32; 3];

    /// The photon, as far as it is kept.
    fn unpacked(&self) -> Photon;
}

impl<R: PhotonRecord> StoredPhoton for R {
    #[inline]
    fn position(&self) -> [f32; 3] {
        self.photon().position
    }

    #[inline]
    fn unpacked(&self) -> Photon {
        *self.photon()
    }
}

impl PhotonRecord for Photon {
    type Extra = ();

    #[inline]
    fn photon(&self) -> &Photon {
        self
    }

    #[inline]
    fn extra(&self) {}

    #[inline]
    fn scaled(self, factor: f32) -> Self {
        Self { flux: self.flux.map(|channel| channel * factor), ..self }
    }
}

/// The last segment of a photon's path.
#[derive(Clone, Copy, Debug, Default)]
pub struct PathSegment {
    /// The path's index in its pass.
    pub path: u32,
    /// Its length, m: the photon came from so far in its direction.
    pub length: f32,
}

/// What photon tracing stores.
pub trait TracedPhoton: PhotonRecord {
    /// A photon at the end of `segment`.
    fn traced(photon: Photon, segment: PathSegment) -> Self;
}

impl TracedPhoton for Photon {
    #[inline(always)]
    fn traced(photon: Photon, _: PathSegment) -> Self {
        photon
    }
}

/// A photon, and what else a method needs of it.
#[derive(Clone, Copy, Debug, Default)]
pub struct PhotonWith<E> {
    /// The photon.
    pub photon: Photon,
    /// What else there is.
    pub extra: E,
}

/// A photon that knows how far it came, m.
pub type OriginPhoton = PhotonWith<f32>;
/// A photon that knows its path, too.
pub type PathPhoton = PhotonWith<PathSegment>;

impl<E: Copy + Default + Send + Sync> PhotonRecord for PhotonWith<E> {
    type Extra = E;

    #[inline]
    fn photon(&self) -> &Photon {
        &self.photon
    }

    #[inline]
    fn extra(&self) -> E {
        self.extra
    }

    #[inline]
    fn scaled(self, factor: f32) -> Self {
        Self { photon: self.photon.scaled(factor), ..self }
    }
}

impl TracedPhoton for OriginPhoton {
    #[inline(always)]
    fn traced(photon: Photon, segment: PathSegment) -> Self {
        Self { photon, extra: segment.length }
    }
}

impl TracedPhoton for PathPhoton {
    #[inline(always)]
    fn traced(photon: Photon, segment: PathSegment) -> Self {
        Self { photon, extra: segment }
    }
}

/// The bit of a photon's top byte that says that a lobe with a density scattered it on its way: it is no caustic.
pub(super) const SCATTERED: u32 = 0x80;
/// The largest segment count that a photon keeps; longer paths count as this.
pub(super) const MOST_SEGMENTS: u32 = 0x7f;

impl Photon {
    /// Packs a photon.
    #[inline]
    pub fn new(position: Vec3, direction: u32, normal: Vec3, flux: Rgb, segments: u32, scattered: bool) -> Self {
        // Adding and subtracting 1.5·2²³ rounds to the nearest whole number.
        const ROUND: f32 = 12_582_912.0;
        let byte = |value: f32| ((value * 127.0 + ROUND) - ROUND) as i32 as u32 & 0xff;
        let normal = byte(normal.x) | byte(normal.y) << 8 | byte(normal.z) << 16;
        Self {
            position: position.to_array(),
            direction,
            normal_and_segments: normal | (segments.min(MOST_SEGMENTS) | if scattered { SCATTERED } else { 0 }) << 24,
            flux: flux.to_array(),
        }
    }
}

impl Photon {
    /// The normal of its surface on the side where it arrived; its length is 1 to 2 %.
    #[inline]
    pub fn normal(&self) -> Vec3 {
        self.normal_bytes() / 127.0
    }

    /// The same in units of the stored bytes, 1/127.
    #[inline]
    pub(super) fn normal_bytes(&self) -> Vec3 {
        let byte = |shift: u32| f32::from((self.normal_and_segments >> shift) as u8 as i8);
        Vec3::new(byte(0), byte(8), byte(16))
    }

    /// Segments of its path from the light to here; 127 stands for more too.
    #[inline]
    pub fn segments(&self) -> u32 {
        self.normal_and_segments >> 24 & MOST_SEGMENTS
    }

    /// Whether a lobe with a density scattered it on its way; else it came straight from the light or is a caustic.
    #[inline]
    pub fn is_scattered(&self) -> bool {
        self.normal_and_segments >> 24 & SCATTERED != 0
    }

    /// Whether only mirrors and glass scattered it, at least once.
    #[inline]
    pub fn is_caustic(&self) -> bool {
        !self.is_scattered() && self.segments() > 1
    }
}

/// How many entries every column has behind its last photon, so that whole groups of lanes can be read.
const PADDING: usize = 8;

/// Sorted photons, one column per component.
#[derive(Clone, Debug, Default)]
pub struct PhotonColumns<E = ()> {
    /// x, y, z, m.
    pub position: [Vec<f32>; 3],
    /// See [`Photon::normal_and_segments`].
    pub normal_and_segments: Vec<u32>,
    /// Red, green, blue, W.
    pub flux: [Vec<f32>; 3],
    /// See [`Photon::direction`].
    pub direction: Vec<u32>,
    /// See [`PhotonRecord::Extra`]; without padding.
    pub extra: Vec<E>,
}

/// A run of every column, to be filled by one thread.
pub struct PhotonColumnsMut<'a, E = ()> {
    position: [&'a mut [f32]; 3],
    normal_and_segments: &'a mut [u32],
    flux: [&'a mut [f32]; 3],
    direction: &'a mut [u32],
    extra: &'a mut [E],
}

impl<E: Copy + Default> PhotonColumns<E> {
    /// Columns of zeros for `count` photons.
    pub fn zeroed(count: usize) -> Self {
        let floats = || vec![0.0; count + PADDING];
        let words = || vec![0; count + PADDING];
        Self {
            position: [floats(), floats(), floats()],
            normal_and_segments: words(),
            flux: [floats(), floats(), floats()],
            direction: words(),
            extra: vec![E::default(); count],
        }
    }

    /// All columns from the first to the last photon.
    pub fn as_mut(&mut self) -> PhotonColumnsMut<'_, E> {
        let Self { position: [x, y, z], normal_and_segments, flux: [red, green, blue], direction, extra } = self;
        PhotonColumnsMut { position: [x, y, z], normal_and_segments, flux: [red, green, blue], direction, extra }
    }
}

impl<E> PhotonColumns<E> {
    /// Memory of all columns, bytes.
    pub fn bytes(&self) -> usize {
        let Self { position, normal_and_segments, flux, direction, extra } = self;
        let floats: usize = position.iter().chain(flux).map(|column| size_of_val(column.as_slice())).sum();
        floats
            + size_of_val(normal_and_segments.as_slice())
            + size_of_val(direction.as_slice())
            + size_of_val(extra.as_slice())
    }
}

impl<'a, E: Copy> PhotonColumnsMut<'a, E> {
    /// The first `count` entries, and the rest.
    pub fn split(self, count: usize) -> (Self, Self) {
        let [x, y, z] = self.position.map(|column| column.split_at_mut(count));
        let [red, green, blue] = self.flux.map(|column| column.split_at_mut(count));
        let normals = self.normal_and_segments.split_at_mut(count);
        let directions = self.direction.split_at_mut(count);
        let extras = self.extra.split_at_mut(count);
        let first = Self {
            position: [x.0, y.0, z.0],
            normal_and_segments: normals.0,
            flux: [red.0, green.0, blue.0],
            direction: directions.0,
            extra: extras.0,
        };
        let rest = PhotonColumnsMut {
            position: [x.1, y.1, z.1],
            normal_and_segments: normals.1,
            flux: [red.1, green.1, blue.1],
            direction: directions.1,
            extra: extras.1,
        };
        (first, rest)
    }

    /// Writes a photon and what else there is of it.
    #[inline]
    pub fn set<R: PhotonRecord<Extra = E>>(&mut self, index: usize, record: &R) {
        let photon = record.photon();
        for axis in 0..3 {
            self.position[axis][index] = photon.position[axis];
            self.flux[axis][index] = photon.flux[axis];
        }
        self.normal_and_segments[index] = photon.normal_and_segments;
        self.direction[index] = photon.direction;
        self.extra[index] = record.extra();
    }
}
