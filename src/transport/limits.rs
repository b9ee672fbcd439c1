//! How long paths may get.

/// Limits on path length. Segments are counted as in Mitsuba: emission that the camera sees has 1, direct light 2.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// The longest path from light to camera, in segments; `None` is unlimited. Photons keep their segments in one byte:
    /// with limits above [`Limits::LONGEST_EXACT`], camera segments of paths longer than that are not counted.
    pub max_depth: Option<u32>,
    /// From how many segments on Russian roulette may end a path.
    pub rr_depth: u32,
}

/// After so many segments roulette always has a chance to end a path, even one that lost nothing: light can be trapped
/// in glass for ever.
const SURE_SEGMENTS: u32 = 32;
/// Where surfaces keep the share r of the light, the variance of paths that roulette ends with this chance is finite if r² is less:
/// up to r = 0.995, better than any real mirror or white. Light that is trapped is followed for 100 segments more.
const LONGEST_SURVIVAL: f32 = 0.99;

impl Limits {
    /// The largest limit that is kept to the segment.
    pub const LONGEST_EXACT: u32 = 126;

    /// Segments that a photon may have at the end of `camera_segments`; 127 lets all photons count.
    #[inline]
    pub fn most_photon_segments(&self, camera_segments: u32) -> u32 {
        self.max_depth.map_or(127, |limit| limit.saturating_sub(camera_segments).min(127))
    }

    /// Whether a path of `segments` is within the limit.
    #[inline]
    pub fn allows(&self, segments: u32) -> bool {
        self.max_depth.is_none_or(|limit| segments <= limit)
    }

    /// The probability with which a path of `segments` goes on when it keeps the share `kept` of what it started with.
    #[inline]
    pub fn survival(&self, segments: u32, kept: f32) -> f32 {
        if segments < self.rr_depth {
            return 1.0;
        }
        let most = if segments < SURE_SEGMENTS { 1.0 } else { LONGEST_SURVIVAL };
        kept.min(most)
    }
}
