//! Whole files or none: written beside the target under another name, then renamed over it.

use std::ffi::OsString;
use std::fs::{self, File, OpenOptions};
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};

use super::PictureFileError;

/// Writes `bytes` to `path`, replacing what is there, so that `path` holds either the old or the new bytes at any time.
/// What is not a plain file (a pipe, a device) is written directly.
pub fn write_file(path: &Path, bytes: &[u8]) -> Result<(), PictureFileError> {
    let written = if is_special(path) { write_special(path, bytes) } else { write_beside(path, bytes) };
    written.map_err(|source| write_error(path, source))
}

/// Finds out whether [`write_file`] could write to `path`, without changing what is there.
pub fn check_writable(path: &Path) -> Result<(), PictureFileError> {
    let probe = || {
        if is_special(path) {
            return OpenOptions::new().write(true).open(path).map(drop);
        }
        if path.is_dir() {
            return Err(io::Error::from(ErrorKind::IsADirectory));
        }
        let (file, temporary) = create_beside(&target_of(path))?;
        drop(file);
        fs::remove_file(temporary)
    };
    probe().map_err(|source| write_error(path, source))
}

fn is_special(path: &Path) -> bool {
    fs::metadata(path).is_ok_and(|metadata| !metadata.is_file() && !metadata.is_dir())
}

fn write_special(path: &Path, bytes: &[u8]) -> io::Result<()> {
    OpenOptions::new().write(true).open(path)?.write_all(bytes)
}

fn write_beside(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let target = target_of(path);
    let (mut file, temporary) = create_beside(&target)?;
    let written = file.write_all(bytes).and_then(|()| file.sync_all());
    drop(file);
    written.and_then(|()| fs::rename(&temporary, &target)).inspect_err(|_| {
        // The first error is the one to tell; a left-over temporary file is the lesser evil.
        let _ = fs::remove_file(&temporary);
    })
}

/// The file itself where `path` is a symbolic link, so that the link survives.
fn target_of(path: &Path) -> PathBuf {
    fs::canonicalize(path).unwrap_or_else(|_| path.to_owned())
}

/// A new file in the folder of `target`, and its name.
fn create_beside(target: &Path) -> io::Result<(File, PathBuf)> {
    let name = target.file_name().ok_or_else(|| io::Error::from(ErrorKind::IsADirectory))?;
    for attempt in 0..100u32 {
        let mut temporary_name = OsString::from(".");
        temporary_name.push(name);
        temporary_name.push(format!(".{}-{attempt}.part", std::process::id()));
        let temporary = target.with_file_name(temporary_name);
        match OpenOptions::new().write(true).create_new(true).open(&temporary) {
            Ok(file) => return Ok((file, temporary)),
            Err(error) if error.kind() == ErrorKind::AlreadyExists => {}
            Err(error) => return Err(error),
        }
    }
    Err(io::Error::from(ErrorKind::AlreadyExists))
}

fn write_error(path: &Path, source: io::Error) -> PictureFileError {
    let remedy = match source.kind() {
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded => "make room, or choose a folder on another disk",
        ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem => "choose a folder that you may write to",
        ErrorKind::NotFound | ErrorKind::NotADirectory => "create the folder first, or choose another one",
        ErrorKind::IsADirectory => "name a file, not a folder",
        _ => "choose another file",
    };
    PictureFileError::Write { path: path.to_owned(), source, remedy }
}
