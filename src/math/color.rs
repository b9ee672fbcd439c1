//! Linear Rec. 709 colour.

use glam::Vec3;

/// Three linear Rec. 709 channels: reflectance (no unit), radiance (W·sr⁻¹·m⁻²) or flux (W), as the name beside it says.
pub type Rgb = Vec3;

/// Relative luminance of linear Rec. 709 (ITU-R BT.709: 0.2126, 0.7152, 0.0722).
pub fn luminance(rgb: Rgb) -> f32 {
    rgb.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}
