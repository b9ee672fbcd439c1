//! Where a picture is too bright and where too dark.

use crate::estimate::Picture;

/// Below this share of the reference's mean a pixel is dark, and its difference is taken relative to that share.
const DARK_SHARE: f64 = 0.01;

/// The signed difference of two pictures of one size: white where they agree, red where `picture` is brighter, blue where it is
/// darker, full color at a difference of `full` times the reference (of the pixel's mean over the channels).
pub fn signed_difference(picture: &Picture, reference: &Picture, full: f64) -> Picture {
    let mean = |pixel: &[f32; 3]| pixel.iter().map(|channel| f64::from(*channel)).sum::<f64>() / 3.0;
    let whole: f64 = reference.radiance.iter().map(mean).sum::<f64>() / reference.radiance.len().max(1) as f64;
    let shade = |(ours, theirs): (&[f32; 3], &[f32; 3])| {
        let (ours, theirs) = (mean(ours), mean(theirs));
        let relative = (ours - theirs) / theirs.max(DARK_SHARE * whole).max(f64::MIN_POSITIVE);
        let faded = (1.0 - (relative / full).abs()).max(0.0) as f32;
        if relative > 0.0 { [1.0, faded, faded] } else { [faded, faded, 1.0] }
    };
    let radiance = picture.radiance.iter().zip(&reference.radiance).map(shade).collect();
    Picture { width: picture.width, height: picture.height, radiance }
}

#[cfg(test)]
mod tests {
    use super::signed_difference;
    use crate::estimate::Picture;

    #[test]
    fn brighter_is_red_and_darker_blue() {
        let picture = |values: [f32; 3]| Picture { width: 3, height: 1, radiance: values.map(|v| [v; 3]).to_vec() };
        let shades = signed_difference(&picture([1.0, 1.5, 0.75]), &picture([1.0; 3]), 0.5).radiance;
        assert_eq!(shades, [[1.0, 1.0, 1.0], [1.0, 0.0, 0.0], [0.5, 0.5, 1.0]]);
    }
}
