//! A photon in 20 bytes, after Wald 1999, section 2.2: the flux shares an exponent, directions are coarse. No method keeps photons so, since
//! unpacking takes longer than memory saves; `docs/measured/PHOTON-MAPS.md` has the figures.

use super::photon::{MOST_SEGMENTS, SCATTERED};
use super::{Photon, StoredPhoton};
use crate::math::{Rgb, Vec3, octahedral};

/// A photon as small as can be.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CompactPhoton {
    position: [f32; 3],
    /// Mantissas of 8 bits and their exponent, RGBE [Ward 1991, "Real pixels"].
    flux: u32,
    /// Octahedral, 8 bits an axis.
    direction: u16,
    /// Octahedral, 4 bits an axis; then the segments, and whether a lobe with a density scattered it.
    normal_and_segments: u16,
}

/// The exponent of RGBE is that of the largest channel plus this.
const EXPONENT_BIAS: i32 = 128;
/// Bits of an axis of the normal.
const NORMAL_BITS: u32 = 4;
/// Bits of an axis of the direction.
const DIRECTION_BITS: u32 = 8;

impl From<&Photon> for CompactPhoton {
    fn from(photon: &Photon) -> Self {
        let normal = shortened(octahedral::encode(photon.normal().normalize()), NORMAL_BITS) as u16;
        Self {
            position: photon.position,
            flux: shared_exponent(Rgb::from_array(photon.flux)),
            direction: shortened(photon.direction, DIRECTION_BITS) as u16,
            normal_and_segments: normal | (photon.normal_and_segments >> 24 << (2 * NORMAL_BITS)) as u16,
        }
    }
}

impl StoredPhoton for CompactPhoton {
    #[inline]
    fn position(&self) -> [f32; 3] {
        self.position
    }

    #[inline]
    fn unpacked(&self) -> Photon {
        let normal = octahedral::decode(lengthened(u32::from(self.normal_and_segments), NORMAL_BITS));
        let top = u32::from(self.normal_and_segments) >> (2 * NORMAL_BITS);
        let direction = lengthened(u32::from(self.direction), DIRECTION_BITS);
        let (segments, is_scattered) = (top & MOST_SEGMENTS, top & SCATTERED != 0);
        let position = Vec3::from_array(self.position);
        Photon::new(position, direction, normal, unshared(self.flux), segments, is_scattered)
    }
}

/// The upper `bits` of both axes of an octahedral code.
fn shortened(code: u32, bits: u32) -> u32 {
    let most = (1u32 << bits) - 1;
    let rounded = |axis: u32| ((axis & 0xffff) * most + 0x7fff) / 0xffff;
    rounded(code) | rounded(code >> 16) << bits
}

/// The octahedral code that a short one stands for.
#[inline]
fn lengthened(code: u32, bits: u32) -> u32 {
    let most = (1u32 << bits) - 1;
    let axis = |short: u32| (short & most) * 0xffff / most;
    axis(code) | axis(code >> bits) << 16
}

/// RGBE, rounded to the nearest.
fn shared_exponent(flux: Rgb) -> u32 {
    let largest = flux.max_element();
    if largest <= 0.0 {
        return 0;
    }
    let exponent = libm::frexpf(largest).1;
    let mantissa = |channel: f32| (libm::ldexpf(channel, 8 - exponent) + 0.5).min(255.0) as u32;
    let [red, green, blue] = flux.to_array().map(mantissa);
    let exponent = (exponent + EXPONENT_BIAS).clamp(0, 255) as u32;
    red | green << 8 | blue << 16 | exponent << 24
}

#[inline]
fn unshared(code: u32) -> Rgb {
    let scale = libm::ldexpf(1.0, (code >> 24) as i32 - EXPONENT_BIAS - 8);
    let mantissa = |shift: u32| (code >> shift & 0xff) as f32 * scale;
    Rgb::new(mantissa(0), mantissa(8), mantissa(16))
}
