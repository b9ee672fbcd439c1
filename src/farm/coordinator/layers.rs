//! Layers of a picture, each from what knows it: the estimate, the first surfaces, the denoised picture, the mattes.

use crate::estimate::Estimate;
use crate::estimate::denoise::Denoised;
use crate::estimate::picture_files::{Layer, MatteHeader, Mattes, PictureLayer};
use crate::render::first_surface::FirstSurface;

/// A layer that the estimate holds.
pub(super) fn of_estimate(layer: Layer, estimate: &Estimate) -> Option<PictureLayer> {
    if layer == Layer::LightGroups {
        return Some(of_light_groups(estimate));
    }
    let pixels = (0..estimate.pixel_count()).map(|pixel| estimate.pixel(pixel));
    let values = match layer {
        Layer::Radius => pixels.map(|pixel| pixel.radius_squared.sqrt() as f32).collect(),
        Layer::Photons => pixels.map(|pixel| pixel.photons as f32).collect(),
        // Nothing is known before each twin has a pass.
        Layer::Error => estimate.standard_error().unwrap_or_else(|| vec![f32::NAN; estimate.pixel_count()]),
        _ => return None,
    };
    Some(PictureLayer::new(layer, vec![values]))
}

/// The light of each light group.
fn of_light_groups(estimate: &Estimate) -> PictureLayer {
    let light_groups: Vec<String> = estimate.declaration().light_groups().into_iter().map(str::to_owned).collect();
    let picture = |group: &String| {
        let picture = estimate.light_group_picture(group);
        [0, 1, 2].map(|channel| picture.radiance.iter().map(|pixel| pixel[channel]).collect::<Vec<f32>>())
    };
    let channels = light_groups.iter().flat_map(picture).collect();
    PictureLayer { light_groups, ..PictureLayer::new(Layer::LightGroups, channels) }
}

/// A layer that follows from the scene.
pub(super) fn of_first_surface(layer: Layer, seen: &[FirstSurface]) -> Option<PictureLayer> {
    let axes = |value: fn(&FirstSurface) -> [f32; 3]| {
        (0..3).map(|axis| seen.iter().map(|pixel| value(pixel)[axis]).collect()).collect()
    };
    let channels = match layer {
        Layer::Albedo => axes(|pixel| pixel.albedo.to_array()),
        Layer::Normal => axes(|pixel| pixel.normal.to_array()),
        Layer::Depth => vec![seen.iter().map(|pixel| pixel.depth).collect()],
        Layer::Position => axes(|pixel| pixel.position.to_array()),
        _ => return None,
    };
    Some(PictureLayer::new(layer, channels))
}

/// A layer of the denoised picture.
pub(super) fn of_denoised(layer: Layer, denoised: &Denoised) -> Option<PictureLayer> {
    let channels = match layer {
        Layer::Denoised => (0..3).map(|c| denoised.picture.radiance.iter().map(|pixel| pixel[c]).collect()).collect(),
        Layer::DenoisedError => vec![denoised.standard_error.clone()],
        _ => return None,
    };
    Some(PictureLayer::new(layer, channels))
}

/// A layer of the mattes, and what the file's header says of it.
pub(super) fn of_mattes(layer: Layer, mattes: &Mattes) -> Option<(PictureLayer, MatteHeader)> {
    let (matte, name) = match layer {
        Layer::CryptoObject => (&mattes.objects, "CryptoObject"),
        Layer::CryptoMaterial => (&mattes.materials, "CryptoMaterial"),
        _ => return None,
    };
    Some((PictureLayer::new(layer, matte.channels()), matte.header(name)))
}
