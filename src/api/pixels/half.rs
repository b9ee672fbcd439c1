//! 16-bit floats.

/// The bits of the 16-bit float (IEEE 754 binary16) that is nearest.
pub(super) fn half_bits(value: f32) -> u16 {
    let sign = (value.to_bits() >> 16) as u16 & 0x8000;
    let size = value.abs();
    if size.is_nan() {
        return sign | 0x7e00;
    }
    // Halfway between the largest and what would be the next power of two.
    if size >= 65520.0 {
        return sign | 0x7c00;
    }
    // Between two powers of two there are 1024 steps, and below 2^-14 they get no smaller.
    let exponent = (size.to_bits() >> 23).max(127 - 14);
    let steps_of_one = f32::from_bits((127 + 127 + 10 - exponent) << 23);
    let steps = (size * steps_of_one).round_ties_even() as u16;
    sign | ((exponent - (127 - 14)) as u16 * 1024 + steps)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_are_the_nearest() {
        let known: [(f32, u16); 13] = [
            (0.0, 0),
            (-0.0, 0x8000),
            (1.0, 0x3c00),
            (-2.0, 0xc000),
            (65504.0, 0x7bff),
            (65519.9, 0x7bff),
            (65520.0, 0x7c00),
            (6.097_555e-5, 0x03ff),
            (5.960_464_5e-8, 1),
            (2.0e-8, 0),
            (2046.4 / 2048.0, 0x3bfe),
            (2047.6 / 2048.0, 0x3c00),
            (f32::INFINITY, 0x7c00),
        ];
        for (value, bits) in known {
            assert_eq!(half_bits(value), bits, "{value}");
        }
        assert_eq!(half_bits(f32::NAN) & 0x7c00, 0x7c00);
        assert_ne!(half_bits(f32::NAN) & 0x03ff, 0);
    }
}
