//! Decoded images as textures keep them: bytes stay bytes, everything else is single precision.

use std::sync::LazyLock;

use crate::math::Rgb;

/// A decoded image, top row first, of one channel or of three.
pub struct Raster {
    width: usize,
    height: usize,
    texels: Texels,
    mean: Rgb,
    range: [Rgb; 2],
}

/// The values of a [`Raster`], one or three for each texel.
pub(super) enum Texels {
    /// One byte each, and what bytes stand for.
    GreyBytes(Vec<u8>, &'static [f32; 256]),
    /// Three bytes each, and what bytes stand for.
    ColorBytes(Vec<[u8; 3]>, &'static [f32; 256]),
    /// One number each.
    GreyFloats(Vec<f32>),
    /// Three numbers each.
    ColorFloats(Vec<[f32; 3]>),
}

impl std::fmt::Debug for Raster {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(formatter, "Raster of {} × {}", self.width, self.height)
    }
}

impl Raster {
    /// An image of colors; `texels` are `width` × `height`, both at least 1.
    pub fn of_numbers(width: usize, height: usize, texels: Vec<[f32; 3]>) -> Self {
        Self::new(width, height, Texels::ColorFloats(texels))
    }

    /// An image of `width` × `height` texels; both are at least 1 and `texels` has that many.
    pub(super) fn new(width: usize, height: usize, texels: Texels) -> Self {
        let mut raster = Self { width, height, texels, mean: Rgb::ZERO, range: [Rgb::INFINITY, Rgb::NEG_INFINITY] };
        let mut sum = glam::DVec3::ZERO;
        for row in 0..height {
            for column in 0..width {
                let color = raster.texel(column, row);
                sum += color.as_dvec3();
                raster.range = [raster.range[0].min(color), raster.range[1].max(color)];
            }
        }
        raster.mean = (sum / (width as f64 * height as f64)).as_vec3();
        raster
    }

    /// Width, texels.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Height, texels.
    pub fn height(&self) -> usize {
        self.height
    }

    /// The color of a texel, linear. `column` and `row` (0 at the top) are below width and height.
    #[inline]
    pub fn texel(&self, column: usize, row: usize) -> Rgb {
        let index = row * self.width + column;
        match &self.texels {
            Texels::GreyBytes(bytes, decoded) => Rgb::splat(decoded[usize::from(bytes[index])]),
            Texels::ColorBytes(bytes, decoded) => Rgb::from_array(bytes[index].map(|byte| decoded[usize::from(byte)])),
            Texels::GreyFloats(numbers) => Rgb::splat(numbers[index]),
            Texels::ColorFloats(numbers) => Rgb::from_array(numbers[index]),
        }
    }

    /// The mean of all texels.
    pub fn mean(&self) -> Rgb {
        self.mean
    }

    /// The smallest and the largest value of each channel.
    pub fn range(&self) -> [Rgb; 2] {
        self.range
    }

    /// Memory that the texels take, bytes.
    pub fn bytes(&self) -> u64 {
        let each = match self.texels {
            Texels::GreyBytes(..) => 1,
            Texels::ColorBytes(..) => 3,
            Texels::GreyFloats(_) => 4,
            Texels::ColorFloats(_) => 12,
        };
        (self.width * self.height) as u64 * each
    }
}

/// What bytes stand for: sRGB, or shares of 255.
pub(super) fn decoded_bytes(srgb: bool) -> &'static [f32; 256] {
    static SRGB: LazyLock<[f32; 256]> = LazyLock::new(|| std::array::from_fn(|byte| linear(byte as f32 / 255.0)));
    static RAW: LazyLock<[f32; 256]> = LazyLock::new(|| std::array::from_fn(|byte| byte as f32 / 255.0));
    if srgb { &SRGB } else { &RAW }
}

/// The linear value of an sRGB one (IEC 61966-2-1).
pub(super) fn linear(encoded: f32) -> f32 {
    let encoded = f64::from(encoded);
    let linear = if encoded <= 0.04045 { encoded / 12.92 } else { libm::pow((encoded + 0.055) / 1.055, 2.4) };
    linear as f32
}
