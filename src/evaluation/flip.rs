//! FLIP: the difference that an eye sees when two pictures are shown in turn at the same place.
//!
//! Reference: Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström & Fairchild 2020, "FLIP: a difference evaluator for alternating
//! images", the form for pictures of low dynamic range. Section and equation numbers are those of the paper.

use super::plane::{Plane, gaussian, normalised};
use super::shown::{Shown, decoded};

/// A 0.7 m wide screen of 3840 pixels seen from 0.7 m, pixels per degree.
const PIXELS_PER_DEGREE: f64 = 67.020_643_276_582_26;
/// Contrast sensitivity: terms `[a, b]` for luminance, red–green and blue–yellow [table 1].
const SENSITIVITY: [&[[f64; 2]]; 3] = [&[[1.0, 0.0047]], &[[1.0, 0.0053]], &[[34.1, 0.04], [13.5, 0.025]]];
/// Largest b, which sets the filters' common radius.
const WIDEST: f64 = 0.04;
/// q_c, p_c and p_t of the mapping of color differences [4.1].
const COLOR_EXPONENT: f64 = 0.7;
const COLOR_KNEE: [f64; 2] = [0.4, 0.95];
/// w: width of the features looked for, degrees; q_f [4.2].
const FEATURE_WIDTH: f64 = 0.082;
const FEATURE_EXPONENT: f64 = 0.5;

/// Linear Rec. 709 to XYZ; rows add up to the white of D65.
const TO_XYZ: [[f64; 3]; 3] = [
    [0.412_390_8, 0.357_584_3, 0.180_480_8],
    [0.212_639_0, 0.715_168_7, 0.072_192_3],
    [0.019_330_8, 0.119_194_8, 0.950_532_2],
];
const FROM_XYZ: [[f64; 3]; 3] = [
    [3.240_969_9, -1.537_383_2, -0.498_610_8],
    [-0.969_243_6, 1.875_967_5, 0.041_555_1],
    [0.055_630_1, -0.203_977_0, 1.056_971_5],
];

/// Mean over pixels: 0 for equal pictures, at most 1.
pub(super) fn mean_flip(image: &Shown, reference: &Shown) -> f64 {
    let [ours, theirs] = [image, reference].map(opponent_planes);
    let [ours_seen, theirs_seen] = [&ours, &theirs].map(perceived);
    let (edges, points) = (feature_filters(Derivative::First), feature_filters(Derivative::Second));
    let features = |planes: &[Plane; 3]| [&edges, &points].map(|filters| strength(&planes[0], filters));
    let (ours_features, theirs_features) = (features(&ours), features(&theirs));
    let largest = largest_difference();
    let pixel = |at: usize| {
        let color = mapped(color_difference(ours_seen[at], theirs_seen[at]).powf(COLOR_EXPONENT), largest);
        let difference = |kind: usize| (ours_features[kind].values[at] - theirs_features[kind].values[at]).abs();
        let feature = (difference(0).max(difference(1)) / 2f64.sqrt()).powf(FEATURE_EXPONENT);
        // [eq. 6]: a difference in features makes a difference in color count for more.
        color.powf(1.0 - feature)
    };
    let count = image.pixels.len();
    (0..count).map(pixel).sum::<f64>() / count as f64
}

fn multiplied(matrix: &[[f64; 3]; 3], vector: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|row| (0..3).map(|column| matrix[row][column] * vector[column]).sum())
}

/// XYZ relative to white.
fn relative_xyz(linear: [f64; 3]) -> [f64; 3] {
    let (xyz, white) = (multiplied(&TO_XYZ, linear), multiplied(&TO_XYZ, [1.0; 3]));
    [0, 1, 2].map(|index| xyz[index] / white[index])
}

/// The linear opponent space Y Cx Cz, here with Y from 0 to 1 in place of −16 to 100: filters add up to 1 and do not mind.
fn opponent_planes(picture: &Shown) -> [Plane; 3] {
    let channel = |index: usize| {
        picture.plane(|pixel| {
            let [x, y, z] = relative_xyz(pixel.map(decoded));
            [y, x - y, y - z][index]
        })
    };
    [0, 1, 2].map(channel)
}

/// Blurred as the eye does at this distance, and then L*a*b* of every pixel with Hunt's adjustment [4.1.1, 4.1.2].
fn perceived(planes: &[Plane; 3]) -> Vec<[f64; 3]> {
    let filtered = [0, 1, 2].map(|channel| sensitivity_filtered(&planes[channel], SENSITIVITY[channel]));
    let white = multiplied(&TO_XYZ, [1.0; 3]);
    let pixel = |at: usize| {
        let [y, x_over, z_under] = [0, 1, 2].map(|channel| filtered[channel].values[at]);
        let xyz = [(y + x_over) * white[0], y * white[1], (y - z_under) * white[2]];
        hunt_adjusted_lab(multiplied(&FROM_XYZ, xyz).map(|value| value.clamp(0.0, 1.0)))
    };
    (0..planes[0].values.len()).map(pixel).collect()
}

/// Sum of Gaussians `a·√(π/b)·exp(−π²x²/b)` with `x` in degrees [eq. 1], normalised.
fn sensitivity_filtered(plane: &Plane, terms: &[[f64; 2]]) -> Plane {
    let deviation = |b: f64| (b / 2.0).sqrt() / std::f64::consts::PI * PIXELS_PER_DEGREE;
    let radius = (3.0 * deviation(WIDEST)).ceil() as usize;
    let mut sum = Plane { values: vec![0.0; plane.values.len()], ..*plane };
    let mut total = 0.0;
    for [a, b] in terms {
        let weights = gaussian(deviation(*b), radius);
        let scale = a * (std::f64::consts::PI / b).sqrt();
        total += scale * weights.iter().sum::<f64>().powi(2);
        sum = sum.combined(&plane.filtered(&weights, &weights), |sum, value| sum + scale * value);
    }
    sum.values.iter_mut().for_each(|value| *value /= total);
    sum
}

fn hunt_adjusted_lab(linear: [f64; 3]) -> [f64; 3] {
    const DELTA: f64 = 6.0 / 29.0;
    let root = |t: f64| if t > DELTA.powi(3) { t.cbrt() } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 };
    let [x, y, z] = relative_xyz(linear).map(root);
    let lightness = 116.0 * y - 16.0;
    [lightness, 0.01 * lightness * 500.0 * (x - y), 0.01 * lightness * 200.0 * (y - z)]
}

/// HyAB [eq. 3]: city blocks between lightness and color.
fn color_difference(a: [f64; 3], b: [f64; 3]) -> f64 {
    (a[0] - b[0]).abs() + ((a[1] - b[1]).powi(2) + (a[2] - b[2]).powi(2)).sqrt()
}

/// c_max: between the primaries that lie farthest from each other.
fn largest_difference() -> f64 {
    let (green, blue) = (hunt_adjusted_lab([0.0, 1.0, 0.0]), hunt_adjusted_lab([0.0, 0.0, 1.0]));
    color_difference(green, blue).powf(COLOR_EXPONENT)
}

/// Differences below the knee get most of the range from 0 to 1 [4.1.3].
fn mapped(difference: f64, largest: f64) -> f64 {
    let [share, value] = COLOR_KNEE;
    let knee = share * largest;
    match difference < knee {
        true => value / knee * difference,
        false => value + (difference - knee) / (largest - knee) * (1.0 - value),
    }
}

#[derive(Clone, Copy)]
enum Derivative {
    First,
    Second,
}

/// A derivative of a Gaussian, and the Gaussian itself for the other direction. Positive and negative weights each add up to 1 [4.2].
fn feature_filters(derivative: Derivative) -> [Vec<f64>; 2] {
    let deviation = 0.5 * FEATURE_WIDTH * PIXELS_PER_DEGREE;
    let radius = (3.0 * deviation).ceil() as usize;
    let smooth = gaussian(deviation, radius);
    let factor = |index: usize| {
        let x = index as f64 - radius as f64;
        match derivative {
            Derivative::First => -x,
            Derivative::Second => x * x / (deviation * deviation) - 1.0,
        }
    };
    let weights: Vec<f64> = smooth.iter().enumerate().map(|(index, weight)| factor(index) * weight).collect();
    let sum = |sign: f64| weights.iter().map(|weight| (sign * weight).max(0.0)).sum::<f64>();
    let (positive, negative) = (sum(1.0), sum(-1.0));
    let scaled = weights.iter().map(|weight| if *weight > 0.0 { weight / positive } else { weight / negative });
    [scaled.collect(), normalised(smooth)]
}

/// Length of the vector of both directions' answers.
fn strength(plane: &Plane, [sharp, smooth]: &[Vec<f64>; 2]) -> Plane {
    plane.filtered(sharp, smooth).combined(&plane.filtered(smooth, sharp), libm::hypot)
}
