//! Spectra as colors: what Mitsuba's RGB mode makes of them.

use super::cie;

/// Linear Rec. 709 of a spectral density over wavelength in nm, with the scale on which a constant 1 has luminance 1.
/// Negative channels of colors outside the gamut become 0, as in Mitsuba.
pub(in super::super) fn to_rgb(density: impl Fn(f64) -> f64) -> [f64; 3] {
    weighted(|wavelength, _| density(wavelength), |_| 1.0)
}

/// The same of a reflectance, which is seen in daylight: a constant 1 is about white.
pub(in super::super) fn reflectance_to_rgb(reflectance: impl Fn(f64) -> f64) -> [f64; 3] {
    // Mitsuba's scale of daylight is so much off 1.
    const SCALE: f64 = 0.99889;
    weighted(|wavelength, daylight| reflectance(wavelength) * daylight, |daylight| daylight)
        .map(|channel| channel * SCALE)
}

/// Of the values of `density`, for wavelengths in nm and daylight there; a luminance of 1 is that of `white`.
fn weighted(density: impl Fn(f64, f64) -> f64, white: impl Fn(f64) -> f64) -> [f64; 3] {
    const STEPS: usize = 1000;
    let mut xyz = [0.0; 3];
    let mut luminance = 0.0;
    for step in 0..STEPS {
        let share = step as f64 / (STEPS - 1) as f64;
        let wavelength = cie::FIRST + share * cie::STEP * (cie::TABLE.len() - 1) as f64;
        let [x, y, z, daylight] = cie::at(wavelength);
        let value = density(wavelength, daylight);
        for (sum, weight) in xyz.iter_mut().zip([x, y, z]) {
            *sum += value * weight;
        }
        luminance += white(daylight) * y;
    }
    let [x, y, z] = xyz.map(|sum| sum / luminance);
    let rgb = [
        3.240479 * x - 1.537150 * y - 0.498535 * z,
        -0.969256 * x + 1.875991 * y + 0.041556 * z,
        0.055648 * x - 0.204043 * y + 1.057311 * z,
    ];
    rgb.map(|channel| channel.max(0.0))
}

/// Linear interpolation between points of increasing wavelength; 0 outside.
pub(in super::super) fn interpolate(points: &[(f64, f64)], wavelength: f64) -> f64 {
    let after = points.partition_point(|(position, _)| *position <= wavelength);
    match (after.checked_sub(1).map(|before| points[before]), points.get(after)) {
        (Some((start, low)), Some(&(end, high))) => low + (high - low) * (wavelength - start) / (end - start),
        (Some((last, value)), None) if last == wavelength => value,
        _ => 0.0,
    }
}

/// Planck's law: W·m⁻²·sr⁻¹·nm⁻¹ at a wavelength in nm and a temperature in K.
pub(in super::super) fn black_body(wavelength: f64, temperature: f64) -> f64 {
    const LIGHT: f64 = 299_792_458.0;
    const PLANCK: f64 = 6.626_070_15e-34;
    const BOLTZMANN: f64 = 1.380_649e-23;
    let meters = wavelength * 1e-9;
    let exponent = PLANCK * LIGHT / (meters * BOLTZMANN * temperature);
    2.0 * PLANCK * LIGHT * LIGHT / (libm::pow(meters, 5.0) * libm::expm1(exponent)) * 1e-9
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_constant_spectrum_has_luminance_1_and_the_warmth_of_equal_energy() {
        let [red, green, blue] = to_rgb(|_| 1.0);
        assert!((0.2126 * red + 0.7152 * green + 0.0722 * blue - 1.0).abs() < 2e-3);
        for (channel, expected) in [(red, 1.205), (green, 0.948), (blue, 0.909)] {
            assert!((channel - expected).abs() < 0.02, "{channel} for {expected}");
        }
    }

    /// Mitsuba 3.9.1, `scalar_rgb`: a constant emitter, and a diffuse surface in a white sky.
    #[test]
    fn colors_are_those_of_mitsuba() {
        let points = [(400.0, 0.1), (500.0, 0.5), (700.0, 0.9)];
        let spectrum = |wavelength| interpolate(&points, wavelength);
        for (found, expected) in [
            (to_rgb(spectrum), [0.91792, 0.56549, 0.24161]),
            (reflectance_to_rgb(spectrum), [0.77540, 0.59351, 0.27704]),
            (to_rgb(|_| 0.5), [0.60240, 0.47415, 0.45446]),
        ] {
            assert!(
                found.iter().zip(expected).all(|(one, other)| (one - other).abs() < 2e-4),
                "{found:?} {expected:?}"
            );
        }
    }

    #[test]
    fn a_black_body_peaks_where_wien_says_and_is_white_at_6500_kelvin() {
        let peak =
            (360..831).max_by(|a, b| black_body(f64::from(*a), 5000.0).total_cmp(&black_body(f64::from(*b), 5000.0)));
        assert!(peak.is_some_and(|peak| (579..=580).contains(&peak)), "{peak:?}");
        let [red, green, blue] = to_rgb(|wavelength| black_body(wavelength, 6500.0));
        assert!((red / green - 1.0).abs() < 0.08 && (blue / green - 1.0).abs() < 0.08, "{red} {green} {blue}");
    }

    #[test]
    fn spectra_are_zero_outside_of_their_points() {
        let points = [(400.0, 1.0), (500.0, 3.0)];
        let values = [399.0, 400.0, 450.0, 500.0, 501.0].map(|wavelength| interpolate(&points, wavelength));
        assert_eq!(values, [0.0, 1.0, 2.0, 3.0, 0.0]);
    }
}
