//! Colors of MGF: CIE 1931 chromaticities, made linear Rec. 709.
//!
//! A color has no brightness of its own: the reflectance or emittance that it applies to is photometric, and becomes the
//! luminance of the result. Spectra and black bodies are weighted with the color matching functions, here fitted by
//! Gaussians [Wyman et al. 2013, eq. 4], from 380 to 780 nm. Black bodies follow Planck's law. Mixtures add the
//! tristimulus values of colors whose luminances are the weights.
//!
//! MGF's white is the equal-energy spectrum, (1/3, 1/3), and grey by default; that of Rec. 709 is D65. A von Kries
//! transform of Bradford cone responses [Fairchild 2013] takes one to the other, so that grey stays grey.

use glam::{DMat3, DVec3};

/// Chromaticity (x, y). Components of mixtures, such as those of daylight, need not be colors themselves: numbers may be
/// negative, and are not finite where there is no light at all.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Color {
    pub x: f64,
    pub y: f64,
}

/// Equal energy.
pub(super) const GREY: Color = Color { x: 1.0 / 3.0, y: 1.0 / 3.0 };

/// The first and last visible wavelength, nm.
const VISIBLE: (f64, f64) = (380.0, 780.0);

impl Color {
    /// Whether light or a surface can have it.
    pub(super) fn is_real(self) -> bool {
        self.x >= 0.0 && self.y > 1e-6 && self.x + self.y <= 1.0
    }

    /// The color of tristimulus values.
    fn of(tristimulus: DVec3) -> Self {
        let sum = tristimulus.element_sum();
        Self { x: tristimulus.x / sum, y: tristimulus.y / sum }
    }

    /// Tristimulus values of luminance 1.
    fn tristimulus(self) -> DVec3 {
        DVec3::new(self.x / self.y, 1.0, (1.0 - self.x - self.y) / self.y)
    }

    /// The color of a spectrum whose values are evenly spaced between two wavelengths, nm, linear between them and 0
    /// elsewhere.
    pub(super) fn from_spectrum(first: f64, last: f64, values: &[f64]) -> Self {
        let spacing = (last - first) / (values.len() - 1) as f64;
        Self::from_power(|wavelength| {
            let place = (wavelength - first) / spacing;
            if !(0.0..=(values.len() - 1) as f64).contains(&place) {
                return 0.0;
            }
            let below = (place as usize).min(values.len() - 2);
            let share = place - below as f64;
            values[below] * (1.0 - share) + values[below + 1] * share
        })
    }

    /// The color of a black body at `kelvin`.
    pub(super) fn from_temperature(kelvin: f64) -> Self {
        // Planck's law: c₂ = hc/k = 0.014 387 769 m·K. Over its value at 560 nm, which keeps cold bodies in range.
        let exponent = |wavelength: f64| 0.014_387_769 / (wavelength * 1e-9 * kelvin);
        let middle = exponent(560.0);
        Self::from_power(|wavelength| {
            let fraction = libm::exp(middle - exponent(wavelength)) / -libm::expm1(-exponent(wavelength));
            fraction * libm::pow(560.0 / wavelength, 5.0)
        })
    }

    /// The color of `power` as a function of the wavelength, nm.
    fn from_power(power: impl Fn(f64) -> f64) -> Self {
        // The fitted functions integrate to almost the same; dividing by that makes equal energy exactly grey.
        let (mut sum, mut white) = (DVec3::ZERO, DVec3::ZERO);
        for step in 0..=((VISIBLE.1 - VISIBLE.0) as usize) {
            let wavelength = VISIBLE.0 + step as f64;
            let matching = matching_functions(wavelength);
            sum += matching * power(wavelength);
            white += matching;
        }
        Self::of(sum / white)
    }

    /// The sum of colors with luminances as weights.
    pub(super) fn mix(parts: &[(f64, Self)]) -> Self {
        Self::of(parts.iter().map(|(weight, color)| *weight * color.tristimulus()).sum())
    }

    /// Linear Rec. 709 of this color and `luminance`, and whether some of it had to be cut off because Rec. 709 cannot
    /// show it; then the luminance is kept.
    pub(super) fn rgb(self, luminance: f64) -> ([f64; 3], bool) {
        if self == GREY {
            return ([luminance; 3], false);
        }
        let rgb = RGB_FROM_XYZ * adapt(self.tristimulus());
        let inside = rgb.max(DVec3::ZERO);
        let own = inside.dot(DVec3::new(0.2126, 0.7152, 0.0722));
        ((inside * (luminance / own)).to_array(), rgb.min_element() < -1e-3)
    }
}

/// CIE 1931 x̄, ȳ, z̄ at a wavelength, nm.
fn matching_functions(wavelength: f64) -> DVec3 {
    let lobe = |height: f64, center: f64, below: f64, above: f64| {
        let scaled = (wavelength - center) * if wavelength < center { below } else { above };
        height * libm::exp(-0.5 * scaled * scaled)
    };
    DVec3::new(
        lobe(0.362, 442.0, 0.0624, 0.0374) + lobe(1.056, 599.8, 0.0264, 0.0323) + lobe(-0.065, 501.1, 0.0490, 0.0382),
        lobe(0.821, 568.8, 0.0213, 0.0247) + lobe(0.286, 530.9, 0.0613, 0.0322),
        lobe(1.217, 437.0, 0.0845, 0.0278) + lobe(0.681, 459.0, 0.0385, 0.0725),
    )
}

/// ITU-R BT.709 primaries and D65.
const RGB_FROM_XYZ: DMat3 = DMat3::from_cols(
    DVec3::new(3.240_454_2, -0.969_266_0, 0.055_643_4),
    DVec3::new(-1.537_138_5, 1.876_010_8, -0.204_025_9),
    DVec3::new(-0.498_531_4, 0.041_556_0, 1.057_225_2),
);

/// Bradford cone responses.
const CONES_FROM_XYZ: DMat3 = DMat3::from_cols(
    DVec3::new(0.8951, -0.7502, 0.0389),
    DVec3::new(0.2664, 1.7135, -0.0685),
    DVec3::new(-0.1614, 0.0367, 1.0296),
);

/// Tristimulus values of D65.
const D65: DVec3 = DVec3::new(0.950_47, 1.0, 1.088_83);

/// What looks under D65 as `tristimulus` looks under equal energy.
fn adapt(tristimulus: DVec3) -> DVec3 {
    let scale = (CONES_FROM_XYZ * D65) / (CONES_FROM_XYZ * DVec3::ONE);
    CONES_FROM_XYZ.inverse() * (scale * (CONES_FROM_XYZ * tristimulus))
}

#[cfg(test)]
mod tests {
    use super::{Color, GREY, RGB_FROM_XYZ, adapt};
    use glam::DVec3;

    #[test]
    fn analytic_colors() {
        // Equal energy, however it is written, is grey.
        let flat = Color::from_spectrum(300.0, 900.0, &[2.0; 7]);
        assert!((flat.x - GREY.x).abs() < 1e-9 && (flat.y - GREY.y).abs() < 1e-9);
        assert!((RGB_FROM_XYZ * adapt(DVec3::ONE)).distance(DVec3::ONE) < 1e-3);
        // CIE standard illuminant A is a black body at 2855.5 K: (0.4476, 0.4074).
        let lamp = Color::from_temperature(2855.5);
        assert!((lamp.x - 0.4476).abs() < 5e-3 && (lamp.y - 0.4074).abs() < 5e-3, "{lamp:?}");
        // Equal luminances of two colors meet at the point that the tristimulus values give.
        let (red, green) = (Color { x: 0.6, y: 0.3 }, Color { x: 0.3, y: 0.6 });
        let mixed = Color::mix(&[(1.0, red), (1.0, green)]);
        assert!((mixed.x - 0.5).abs() < 1e-12 && (mixed.y - 0.4).abs() < 1e-12, "{mixed:?}");
        let (rgb, cut) = mixed.rgb(0.4);
        let luminance = 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
        assert!((luminance - 0.4).abs() < 1e-12 && rgb.iter().all(|channel| *channel >= 0.0));
        assert!(cut == (rgb[2] == 0.0));
        assert!(!Color::from_spectrum(400.0, 700.0, &[0.0, 0.0]).is_real());
        // A component of a mixture may be no color.
        let component = Color::from_spectrum(400.0, 700.0, &[3.0, -0.5, 8.0]);
        assert!(Color::mix(&[(1.0, lamp), (1e-3, component)]).is_real());
    }
}
