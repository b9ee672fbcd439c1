//! A scene that is another one with changes. Only these are kept and travel, beside the hash of the other: a sequence of a thousand frames has the
//! bytes of one scene.

use serde::{Deserialize, Serialize};

use super::job::SceneChanges;

/// Begins what is kept of such a scene, as no format of scenes does.
const MARK: &[u8] = b"photonfarm changed scene\n";

/// What is kept of a scene that is another one with changes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ChangedScene {
    /// Hash of the other, which is none of these.
    pub(super) base: String,
    /// What is changed.
    pub(super) changes: SceneChanges,
}

impl ChangedScene {
    /// Its bytes, whose hash is the scene's.
    pub(super) fn encode(&self) -> Vec<u8> {
        // Plain data with string keys always has a JSON form.
        [MARK, &serde_json::to_vec(self).unwrap_or_default()].concat()
    }

    /// Reads the bytes of a scene; `None` where they are a whole one.
    ///
    /// # Errors
    /// They begin as those of a changed scene, and are none.
    pub(super) fn decode(bytes: &[u8]) -> Result<Option<Self>, serde_json::Error> {
        bytes.strip_prefix(MARK).map(serde_json::from_slice).transpose()
    }
}
