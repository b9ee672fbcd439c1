//! Splitting of caustic photons: what the parameters say of it, and when they contradict each other.

use super::parameters::Parameters;
use crate::method::FindsNothing;
use crate::method::parameter_values::Auto;
use crate::transport::caustic_splitting::Splitting;

/// The segments of the shortest path with a caustic: light, specular surface, what it lights, camera.
const SHORTEST_CAUSTIC: i64 = 3;

impl Parameters {
    /// What of the splitting cannot be.
    pub(super) fn contradiction_of_splitting(&self) -> Option<FindsNothing> {
        let factor = self.caustic_splitting.get();
        let refused = |problem: String, remedy: String| Some(FindsNothing { problem, remedy });
        if factor == 1 {
            return match self.splitting {
                Splitting::Brute => None,
                _ => refused(
                    "\"splitting\" is given, but \"caustic_splitting\" is 1: nothing is split".to_owned(),
                    "give \"caustic_splitting\" of at least 2, for example 20".to_owned(),
                ),
            };
        }
        let depth = self.max_depth.get();
        if (1..SHORTEST_CAUSTIC).contains(&depth) {
            return refused(
                format!("\"caustic_splitting\" is {factor}, but paths of {depth} segments have no caustic"),
                format!("give \"max_depth\" of at least {SHORTEST_CAUSTIC}, or \"caustic_splitting\" 1"),
            );
        }
        let Auto::Value(photons) = self.photons_per_pass else { return None };
        // Paths are numbered in 32 bits.
        let most = u32::MAX / photons.get();
        if factor > most {
            return refused(
                format!("{} photons in \"caustic_splitting\" {factor} are too many for a pass", photons.get()),
                format!("give \"caustic_splitting\" of at most {most}"),
            );
        }
        None
    }
}
