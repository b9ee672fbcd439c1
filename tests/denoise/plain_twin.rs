//! The same filter written straightforwardly, pixel by pixel and in double precision: the fast one must agree.

use photonfarm::estimate::denoise::{
    FEATURE_REACH, Features, MOST_DISSIMILAR, PATCH, RIDGE, SLOPE_PRIOR, Twins, WINDOW, denoise,
};

use crate::synthetic::synthetic;

/// A twin's color, of a pixel that may lie beyond the picture's edge, where the nearest one counts.
struct Plain {
    size: [isize; 2],
    color: [Vec<[f64; 3]>; 2],
    variance: Vec<f64>,
    features: Vec<[f64; 9]>,
}

type Pixel = [isize; 2];

impl Plain {
    fn new(twins: &Twins, features: &Features) -> Self {
        let count = twins.width * twins.height;
        let sum: f64 = twins.radiance.iter().flatten().flatten().map(|value| f64::from(value.abs())).sum();
        let brightness = sum / (6 * count) as f64;
        let color = [0, 1].map(|twin| {
            let at = |pixel: usize| [0, 1, 2].map(|c| f64::from(twins.radiance[twin][c][pixel]) / brightness);
            (0..count).map(at).collect::<Vec<_>>()
        });
        let size = [twins.width as isize, twins.height as isize];
        let difference = |pixel: usize| (0..3).map(|c| (color[0][pixel][c] - color[1][pixel][c]).powi(2)).sum::<f64>();
        // Halves of equally many passes have half of the expected square each.
        let around =
            |pixel: usize| if difference(pixel) == 0.0 { 0.0 } else { 0.5 * mean_around(size, pixel, 2, &difference) };
        let variance = (0..count).map(around).collect();
        let planes: Vec<Vec<f64>> = features
            .albedo
            .iter()
            .chain(&features.normal)
            .chain(&features.position)
            .map(|plane| normalized(plane))
            .collect();
        let features = (0..count).map(|pixel| std::array::from_fn(|feature| planes[feature][pixel])).collect();
        Self { size, color, variance, features }
    }

    fn index(&self, [x, y]: Pixel) -> usize {
        let [x, y] = [x.clamp(0, self.size[0] - 1), y.clamp(0, self.size[1] - 1)];
        (y * self.size[0] + x) as usize
    }

    /// Equation in src/estimate/denoise/similarity.rs.
    fn similarity(&self, guide: usize, p: Pixel, q: Pixel) -> f64 {
        let reach = PATCH as isize;
        let mut sum = 0.0;
        for [x, y] in (-reach..=reach).flat_map(|y| (-reach..=reach).map(move |x| [x, y])) {
            let [i, j] = [self.index([p[0] + x, p[1] + y]), self.index([q[0] + x, q[1] + y])];
            let square: f64 = (0..3).map(|c| (self.color[guide][i][c] - self.color[guide][j][c]).powi(2)).sum();
            let [v, w] = [self.variance[i], self.variance[j]];
            sum += ((square - v - v.min(w)) / (v + w + 1e-12)).min(f64::from(MOST_DISSIMILAR));
        }
        (-(sum / (2 * PATCH + 1).pow(2) as f64).max(0.0)).exp()
    }

    /// Mean and linear fit of a pixel of a twin.
    fn fits(&self, twin: usize, p: Pixel) -> [[f64; 3]; 2] {
        let reach = WINDOW as isize;
        let (mut weights, mut means) = (0.0, [0.0; 3]);
        let mut normal = vec![vec![0.0; 13]; 10];
        for q in (-reach..=reach).flat_map(|y| (-reach..=reach).map(move |x| [p[0] + x, p[1] + y])) {
            if (0..2).any(|axis| !(0..self.size[axis]).contains(&q[axis])) {
                continue;
            }
            let (own, other) = (self.index(p), self.index(q));
            let mut unknowns = [1.0; 10];
            (0..9).for_each(|j| unknowns[j] = self.features[other][j] - self.features[own][j]);
            let distance: f64 = unknowns[..9].iter().map(|x| x * x).sum();
            let near = (-distance / f64::from(FEATURE_REACH).powi(2)).exp();
            let similarity = self.similarity(1 - twin, p, q);
            let color = self.color[twin][other];
            weights += similarity.powi(4) * near;
            (0..3).for_each(|c| means[c] += similarity.powi(4) * near * color[c]);
            for row in 0..10 {
                let weighted = similarity * near * unknowns[row];
                (0..10).for_each(|column| normal[row][column] += weighted * unknowns[column]);
                (0..3).for_each(|c| normal[row][10 + c] += weighted * color[c]);
            }
        }
        let plain = [0, 1, 2].map(|c| normal[9][10 + c] / normal[9][9]);
        for (index, row) in normal[..9].iter_mut().enumerate() {
            row[index] = row[index] * (1.0 + f64::from(RIDGE)) + f64::from(SLOPE_PRIOR);
        }
        let solved = solve(normal);
        let linear = [0, 1, 2].map(|c| if solved[c] < 0.0 { plain[c] } else { solved[c] });
        [means.map(|mean| mean / weights), linear]
    }
}

/// The last unknown of linear equations with three right sides, by Gauss-Jordan elimination with pivots.
fn solve(mut rows: Vec<Vec<f64>>) -> [f64; 3] {
    for pivot in 0..10 {
        let best = (pivot..10).max_by(|a, b| rows[*a][pivot].abs().total_cmp(&rows[*b][pivot].abs())).expect("rows");
        rows.swap(pivot, best);
        for row in (0..10).filter(|row| *row != pivot) {
            let factor = rows[row][pivot] / rows[pivot][pivot];
            (0..13).for_each(|column| rows[row][column] -= factor * rows[pivot][column]);
        }
    }
    [0, 1, 2].map(|c| rows[9][10 + c] / rows[9][9])
}

fn normalized(plane: &[f32]) -> Vec<f64> {
    let count = plane.len() as f64;
    let mean = plane.iter().map(|value| f64::from(*value)).sum::<f64>() / count;
    let variance = plane.iter().map(|value| (f64::from(*value) - mean).powi(2)).sum::<f64>() / count;
    let scale = if variance > 1e-9 { variance.sqrt().recip() } else { 0.0 };
    plane.iter().map(|value| (f64::from(*value) - mean) * scale).collect()
}

fn mean_around(size: [isize; 2], pixel: usize, reach: isize, value: &dyn Fn(usize) -> f64) -> f64 {
    let [x, y] = [pixel as isize % size[0], pixel as isize / size[0]];
    let rows = (y - reach).max(0)..=(y + reach).min(size[1] - 1);
    let near: Vec<f64> = rows
        .flat_map(|y| ((x - reach).max(0)..=(x + reach).min(size[0] - 1)).map(move |x| (y * size[0] + x) as usize))
        .map(value)
        .collect();
    near.iter().sum::<f64>() / near.len() as f64
}

/// The picture, with the choice of src/estimate/denoise/choice.rs, over the picture's mean.
fn plainly_denoised(plain: &Plain) -> Vec<[f64; 3]> {
    let count = plain.variance.len();
    let place = |pixel: usize| [pixel as isize % plain.size[0], pixel as isize / plain.size[0]];
    let fits: [Vec<[[f64; 3]; 2]>; 2] =
        [0, 1].map(|twin| (0..count).map(|pixel| plain.fits(twin, place(pixel))).collect());
    let error = |pixel: usize, kind: usize| {
        let channel = |c: usize| {
            let [a, b] = [0, 1].map(|twin| plain.color[twin][pixel][c]);
            let [new_a, new_b] = [0, 1].map(|twin: usize| fits[twin][pixel][kind][c]);
            0.5 * (new_a - b).powi(2) + 0.5 * (new_b - a).powi(2)
                - 0.5 * (a - b).powi(2)
                - 0.25 * (new_a - new_b).powi(2)
        };
        (0..3).map(channel).sum::<f64>() / 3.0
    };
    let gray = |pixel: usize| (0..3).map(|c| fits[0][pixel][0][c] + fits[1][pixel][0][c]).sum::<f64>() / 6.0;
    let more = |pixel: usize| (error(pixel, 1) - error(pixel, 0)) / (gray(pixel).powi(2) + 1e-2);
    let linear = |pixel: usize| if mean_around(plain.size, pixel, 4, &more) < 0.0 { 1.0 } else { 0.0 };
    let joined = |pixel: usize| {
        let share = mean_around(plain.size, pixel, 1, &linear);
        [0, 1, 2].map(|c| {
            let of = |kind: usize| 0.5 * (fits[0][pixel][kind][c] + fits[1][pixel][kind][c]);
            of(0) + share * (of(1) - of(0))
        })
    };
    (0..count).map(joined).collect()
}

#[test]
fn the_fast_filter_agrees_with_a_plain_one() {
    let color = |x: usize, y: usize| if x < 14 { 0.3 + y as f32 / 30.0 } else { 0.05 * (x % 5) as f32 };
    let albedo = |x: usize, y: usize| if x < 14 { 0.6 } else { 0.1 * ((x + y) % 5) as f32 };
    let picture = synthetic([29, 19], color, albedo, |x, y| if y == 3 { 0.0 } else { 0.1 + 0.01 * x as f32 });
    let plain = Plain::new(&picture.twins, &picture.features);
    let expected = plainly_denoised(&plain);
    let found = denoise(&picture.twins, &picture.features).expect("it can be denoised").picture;
    let values = picture.twins.radiance.iter().flatten().flatten();
    let brightness = values.map(|value| f64::from(value.abs())).sum::<f64>() / (6 * expected.len()) as f64;
    for (pixel, (found, expected)) in found.radiance.iter().zip(&expected).enumerate() {
        for (found, expected) in found.iter().zip(expected) {
            let found = f64::from(*found) / brightness;
            assert!((found - expected).abs() < 2e-3, "pixel {pixel}: {found} where {expected} is right");
        }
    }
}
