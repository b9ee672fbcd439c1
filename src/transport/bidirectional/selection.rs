//! Looking at a part of all paths.

/// Which paths, and which ways of finding them, are counted. Their weights stay those of all techniques that take part.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Selection {
    /// Only paths of so many segments.
    pub length: Option<u32>,
    /// Only these numbers of vertices of the light and of the camera subpath; for merges, of segments.
    pub strategy: Option<[u32; 2]>,
}

impl Selection {
    /// Whether a path of `segments` counts that a light subpath of `light` and a camera subpath of `camera` vertices (segments
    /// where they are merged) made.
    #[inline]
    pub fn takes(&self, segments: u32, light: u32, camera: u32) -> bool {
        self.length.is_none_or(|length| length == segments)
            && self.strategy.is_none_or(|strategy| strategy == [light, camera])
    }

    /// Whether it leaves any path out.
    pub fn is_partial(&self) -> bool {
        *self != Self::default()
    }
}
