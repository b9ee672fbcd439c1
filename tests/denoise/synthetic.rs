//! Pictures whose truth is known, with noise of known variance.

use photonfarm::estimate::denoise::{Color, Features, Twins};

use crate::split_mix::Random;

/// A uniform number of mean 0 and variance 1.
fn noise(random: &mut Random) -> f32 {
    let unit = (random.next() >> 40) as f32 / (1u64 << 24) as f32;
    (unit - 0.5) * 12f32.sqrt()
}

/// A picture, what is behind it, and the noise of each of its halves.
pub(crate) struct Synthetic {
    pub(crate) width: usize,
    pub(crate) truth: Color,
    pub(crate) twins: Twins,
    pub(crate) features: Features,
}

/// A picture whose pixels have a color, an albedo and a standard deviation of each half.
pub(crate) fn synthetic(
    [width, height]: [usize; 2],
    color: impl Fn(usize, usize) -> f32,
    albedo: impl Fn(usize, usize) -> f32,
    deviation: impl Fn(usize, usize) -> f32,
) -> Synthetic {
    let plane = |value: &dyn Fn(usize, usize) -> f32| -> Vec<f32> {
        (0..width * height).map(|pixel| value(pixel % width, pixel / width)).collect()
    };
    let truth = [0, 1, 2].map(|channel| plane(&|x, y| color(x, y) * (1.0 - 0.2 * channel as f32)));
    let mut random = Random(7);
    let radiance = [0, 1].map(|_| {
        truth.each_ref().map(|truth| {
            let pixel =
                |(pixel, value): (usize, &f32)| value + deviation(pixel % width, pixel / width) * noise(&mut random);
            truth.iter().enumerate().map(pixel).collect()
        })
    });
    let zero = || vec![0.0; width * height];
    let features = Features {
        albedo: [0, 1, 2].map(|_| plane(&albedo)),
        normal: [zero(), zero(), vec![1.0; width * height]],
        position: [plane(&|x, _| x as f32 / 8.0), plane(&|_, y| y as f32 / 8.0), zero()],
    };
    let twins = Twins { width, height, radiance, even_shares: vec![0.5; height] };
    Synthetic { width, truth, twins, features }
}

impl Synthetic {
    /// Mean squared error of a picture's pixels, over channels.
    pub(crate) fn squared_error(&self, radiance: &[[f32; 3]], counts: impl Fn(usize, usize) -> bool) -> f64 {
        let pixels = (0..radiance.len()).filter(|pixel| counts(pixel % self.width, pixel / self.width));
        let error = |pixel: usize| {
            (0..3).map(|c| f64::from(radiance[pixel][c] - self.truth[c][pixel]).powi(2)).sum::<f64>() / 3.0
        };
        let errors: Vec<f64> = pixels.map(error).collect();
        errors.iter().sum::<f64>() / errors.len() as f64
    }

    /// The picture as it is.
    pub(crate) fn raw(&self) -> Vec<[f32; 3]> {
        let [even, odd] = &self.twins.radiance;
        (0..even[0].len()).map(|pixel| [0, 1, 2].map(|c| 0.5 * (even[c][pixel] + odd[c][pixel]))).collect()
    }
}

/// Mean of all channels.
pub(crate) fn mean(radiance: &[[f32; 3]]) -> f64 {
    radiance.iter().flatten().map(|value| f64::from(*value)).sum::<f64>() / (3 * radiance.len()) as f64
}
