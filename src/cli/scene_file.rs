//! The scene file as the bytes that are uploaded.

use std::path::Path;

use super::exit_code::CliError;
use crate::scene::import;

/// Reads the scene at `path` and everything it refers to.
pub(super) fn pack(path: &Path, defines: &[(String, String)]) -> Result<Vec<u8>, CliError> {
    if let Err(error) = std::fs::File::open(path) {
        let text = format!("cannot read \"{}\": {error}; check the name and the permissions", path.display());
        return Err(CliError::File(text));
    }
    Ok(import::pack(path, defines)?)
}
