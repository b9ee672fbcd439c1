//! The files of a scene: a folder on disk, or an archive in memory. No path leads out of either.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use super::error::{Location, SceneError};

/// Where a scene's relative file names are looked up.
#[derive(Clone, Debug)]
pub enum Bundle {
    /// The folder that holds the scene file.
    Folder(PathBuf),
    /// Files in memory, by their path with `/` separators.
    Archive(Arc<BTreeMap<String, Arc<[u8]>>>),
}
