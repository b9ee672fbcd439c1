//! Looking at a part of all paths, or at their weights.

use crate::math::Rgb;
use crate::math::color::luminance;

/// Which paths, and which ways of finding them, are counted. Their weights stay those of all techniques that take part.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Selection {
    /// Only paths of so many segments.
    pub length: Option<u32>,
    /// Only these numbers of vertices of the light and of the camera subpath; for merges, of segments.
    pub strategy: Option<[u32; 2]>,
    /// What the picture shows.
    pub show: Show,
}

/// What a path adds to the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Show {
    /// Its radiance, weighted.
    #[default]
    Radiance,
    /// Its radiance as if no other way of finding it took part.
    Unweighted,
    /// Its luminance in green and the part that its weight leaves in red: red over green is the mean weight of what was found.
    Weights,
}

impl Selection {
    /// Whether a path of `segments` counts that a light subpath of `light` and a camera subpath of `camera` vertices (segments
    /// where they are merged) made.
    #[inline]
    pub fn takes(&self, segments: u32, light: u32, camera: u32) -> bool {
        self.length.is_none_or(|length| length == segments)
            && self.strategy.is_none_or(|strategy| strategy == [light, camera])
    }

    /// What a path shows that was found with `radiance` and `weight`.
    #[inline]
    pub fn shown(&self, radiance: Rgb, weight: f32) -> Rgb {
        match self.show {
            Show::Radiance => radiance * weight,
            Show::Unweighted => radiance,
            Show::Weights => Rgb::new(weight, 1.0, 0.0) * luminance(radiance),
        }
    }
}
