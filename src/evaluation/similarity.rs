//! SSIM: how alike the structure of two pictures is.
//!
//! Reference: Wang, Bovik, Sheikh & Simoncelli 2004, "Image quality assessment: from error visibility to structural similarity",
//! with the weights and constants given there.

use super::plane::{Plane, gaussian, normalised};
use super::shown::Shown;

/// Standard deviation of the window, pixels.
const DEVIATION: f64 = 1.5;
/// Pixels on each side of the window's middle.
const RADIUS: usize = 5;
/// C₁ and C₂ for values from 0 to 1 [eqs. 7 and 9].
const STABILISERS: [f64; 2] = [0.01 * 0.01, 0.03 * 0.03];

/// Mean SSIM of the luma of two pictures of one size, over all places where the window fits in; `None` where it never does.
pub(super) fn structural_similarity(image: &Shown, reference: &Shown) -> Option<f64> {
    let luma = |pixel: &[f64; 3]| 0.2126 * pixel[0] + 0.7152 * pixel[1] + 0.0722 * pixel[2];
    let (a, b) = (image.plane(luma), reference.plane(luma));
    let window = normalised(gaussian(DEVIATION, RADIUS));
    let mean = |plane: &Plane| plane.filtered(&window, &window);
    let product = |a: &Plane, b: &Plane| mean(&a.combined(b, |a, b| a * b));
    let (mean_a, mean_b, squares_a, squares_b, products) =
        (mean(&a), mean(&b), product(&a, &a), product(&b, &b), product(&a, &b));
    let [c1, c2] = STABILISERS;
    let mut sum = 0.0;
    let mut count = 0u32;
    for y in RADIUS..a.height.saturating_sub(RADIUS) {
        for x in RADIUS..a.width.saturating_sub(RADIUS) {
            let at = y * a.width + x;
            let (ma, mb) = (mean_a.values[at], mean_b.values[at]);
            let variances = squares_a.values[at] - ma * ma + squares_b.values[at] - mb * mb;
            let covariance = products.values[at] - ma * mb;
            // [eq. 13]
            sum += (2.0 * ma * mb + c1) * (2.0 * covariance + c2) / ((ma * ma + mb * mb + c1) * (variances + c2));
            count += 1;
        }
    }
    (count > 0).then(|| sum / f64::from(count))
}
