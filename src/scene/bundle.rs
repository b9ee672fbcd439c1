//! The files of a scene: a folder on disk, or an archive in memory. No path leads out of an archive. On one's own machine
//! names may lead above the scene's folder by `..`, as in Mitsuba; links still may not leave the folder that a name leads to.

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::{Cursor, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use zip::ZipArchive;

use super::error::{Location, SceneError, closest_name};
use super::geometry::TriangleMesh;
use super::geometry::ply;

/// The largest single file that is read, in bytes.
const FILE_LIMIT: u64 = 1 << 30;
/// The most bytes that an archive may unpack to.
const ARCHIVE_LIMIT: u64 = 2 << 30;
/// How far an archive may expand: this many bytes, and [`EXPANSION_RATIO`] bytes more for every byte of the archive.
const EXPANSION_ALLOWANCE: u64 = 64 << 20;
/// See [`EXPANSION_ALLOWANCE`].
const EXPANSION_RATIO: u64 = 200;
/// The most files and folders in an archive.
const ENTRY_LIMIT: usize = 10_000;

/// Where a scene's relative file names are looked up.
#[derive(Clone, Debug)]
pub enum Bundle {
    /// The folder that holds the scene file.
    Folder(PathBuf),
    /// Files in memory, by their path with `/` separators.
    Archive(Arc<Files>),
    /// What an importer made, before the files of another bundle.
    Generated(Arc<Generated>, Box<Bundle>),
}

/// Files in memory, by their path with `/` separators.
pub type Files = BTreeMap<String, Arc<[u8]>>;

/// What an importer made and shapes and textures name as if they were files. No name is in both.
#[derive(Clone, Debug, Default)]
pub struct Generated {
    /// Files in memory, for example images that stood in a binary format.
    pub files: Files,
    /// Meshes by the names of the PLY files that they would be.
    pub meshes: BTreeMap<String, Arc<TriangleMesh>>,
}

impl Generated {
    /// Whether something of this name was made.
    pub fn contains(&self, name: &str) -> bool {
        self.files.contains_key(name) || self.meshes.contains_key(name)
    }

    fn names(&self) -> impl Iterator<Item = &String> {
        self.files.keys().chain(self.meshes.keys())
    }
}

impl Bundle {
    /// A bundle of no files: that of a scene which came as a single file.
    pub fn empty() -> Self {
        Self::Archive(Arc::default())
    }

    /// This bundle and, before its own files, what an importer made.
    pub fn with_generated(self, made: Generated) -> Self {
        let is_empty = made.names().next().is_none();
        if is_empty { self } else { Self::Generated(Arc::new(made), Box::new(self)) }
    }

    /// What an importer made; it stands neither in the folder nor in the archive that the scene came from.
    pub fn generated(&self) -> Option<&Generated> {
        match self {
            Self::Generated(made, _) => Some(made),
            Self::Folder(_) | Self::Archive(_) => None,
        }
    }

    /// The mesh of this name that an importer made, if there is one.
    pub fn mesh(&self, name: &str) -> Option<Arc<TriangleMesh>> {
        self.generated()?.meshes.get(name).cloned()
    }

    /// The files of an archive by their names as seen from its folder `folder`.
    pub fn seen_from(self, folder: &str) -> Self {
        match self {
            Self::Archive(files) if !folder.is_empty() => {
                let seen = |(name, content): (&String, &Arc<[u8]>)| (relative_name(folder, name), content.clone());
                Self::Archive(Arc::new(files.iter().map(seen).collect()))
            }
            other => other,
        }
    }

    /// The files of an archive by their names; none of a folder.
    pub fn into_files(self) -> Files {
        match self {
            Self::Archive(files) => Arc::unwrap_or_clone(files),
            Self::Folder(_) | Self::Generated(..) => Files::new(),
        }
    }

    /// Whether there is a file `name`, which may have any form.
    pub fn contains(&self, name: &str) -> bool {
        let Ok(name) = normalized_name(name, &Location::default()) else { return false };
        match self {
            Self::Generated(made, origin) => made.contains(&name) || origin.contains(&name),
            Self::Archive(files) => files.contains_key(&name),
            Self::Folder(folder) => folder.join(&name).is_file(),
        }
    }

    /// Whether there is a folder `name`: in an archive, one with files.
    pub fn contains_folder(&self, name: &str) -> bool {
        match self {
            Self::Generated(_, origin) => origin.contains_folder(name),
            Self::Archive(files) => {
                let start = format!("{name}/");
                files.range(start.clone()..).next().is_some_and(|(file, _)| file.starts_with(&start))
            }
            Self::Folder(folder) => folder.join(name).is_dir(),
        }
    }

    /// Unpacks a zip archive in memory. A single folder round everything is taken off. `archive` is the place that
    /// errors name.
    ///
    /// # Errors
    /// When the bytes are not a zip archive, when it expands beyond 2 GiB or suspiciously far, has more than 10 000
    /// entries, is encrypted, or has entries that are links or whose names lead out of it.
    pub fn from_zip(bytes: &[u8], archive: &Location) -> Result<Self, SceneError> {
        let broken = |error: zip::result::ZipError| {
            SceneError::new(archive, format!("the archive cannot be read: {error}"), "pack it again as a plain zip")
        };
        let mut zip = ZipArchive::new(Cursor::new(bytes)).map_err(broken)?;
        if zip.len() > ENTRY_LIMIT {
            let problem = format!("the archive has {} entries", zip.len());
            return Err(SceneError::new(archive, problem, format!("pack at most {ENTRY_LIMIT}")));
        }
        if zip.has_duplicate_names() {
            return Err(SceneError::new(archive, "two files of the archive have one name", "pack each file once"));
        }
        let mut files = BTreeMap::new();
        let expansion = EXPANSION_ALLOWANCE.saturating_add(EXPANSION_RATIO.saturating_mul(bytes.len() as u64));
        let mut budget = expansion.min(ARCHIVE_LIMIT);
        for index in 0..zip.len() {
            let mut entry = zip.by_index(index).map_err(broken)?;
            let name = entry.name().map_err(broken)?.into_owned();
            // macOS adds these beside the user's files.
            if entry.is_dir() || name.starts_with("__MACOSX/") {
                continue;
            }
            let name = checked_name(&name, archive)?;
            if entry.is_symlink() {
                let problem = format!("\"{name}\" in the archive is a link");
                return Err(SceneError::new(archive, problem, "pack the file itself"));
            }
            files.insert(name.clone(), read_entry(&mut entry, &name, &mut budget, archive)?);
        }
        Ok(Self::Archive(Arc::new(without_common_folder(files))))
    }

    /// The bytes of file `name`, which is referred to at `location`; of a mesh that an importer made those of a PLY file.
    ///
    /// # Errors
    /// When `name` is absolute, leads out of an archive, or is a symbolic link that leads out of the folder; when there is
    /// no such file, with the nearest name that there is; when it is larger than 1 GiB or cannot be read.
    pub fn read(&self, name: &str, location: &Location) -> Result<Arc<[u8]>, SceneError> {
        let name = normalized_name(name, location)?;
        match self {
            Self::Generated(made, origin) => match (made.files.get(&name), made.meshes.get(&name)) {
                (Some(content), _) => Ok(content.clone()),
                (None, Some(mesh)) => Ok(ply::write(mesh).into()),
                (None, None) => origin.read(&name, location),
            },
            Self::Archive(files) => match files.get(&name) {
                Some(content) => Ok(content.clone()),
                None => checked_name(&name, location).and_then(|name| Err(self.missing(&name, location))),
            },
            Self::Folder(folder) => {
                let (above, inside) = steps_up(&name);
                let folder = folder.join("../".repeat(above));
                match folder.join(inside).canonicalize() {
                    Ok(path) => read_inside(&folder, &path, &name, location),
                    Err(error) if error.kind() == std::io::ErrorKind::NotFound => Err(self.missing(&name, location)),
                    Err(error) => Err(unreadable(&name, &error, location)),
                }
            }
        }
    }

    /// The names of the bundle's files, sorted; of a folder on disk the first few thousand.
    pub fn names(&self) -> BTreeSet<String> {
        match self {
            Self::Archive(files) => files.keys().cloned().collect(),
            Self::Generated(made, origin) => made.names().cloned().chain(origin.names()).collect(),
            Self::Folder(folder) => {
                let mut names = BTreeSet::new();
                list_folder(folder, "", &mut 4096, &mut names);
                names
            }
        }
    }

    fn missing(&self, name: &str, location: &Location) -> SceneError {
        let names = self.names();
        let base = |path: &str| path.rsplit('/').next().unwrap_or_default().to_lowercase();
        let namesake = names.iter().map(String::as_str).find(|candidate| base(candidate) == base(name));
        let remedy = match namesake.or_else(|| closest_name(name, names.iter().map(String::as_str))) {
            Some(candidate) => format!("did you mean \"{candidate}\"?"),
            None if names.is_empty() => "send the scene in a zip archive with every file it refers to".to_owned(),
            None => "names are relative to the folder of the scene file".to_owned(),
        };
        SceneError::new(location, format!("there is no file \"{name}\""), remedy)
    }
}

/// What the comment of an archive begins with whose scene file is not at its top level; the file's name follows.
pub const SCENE_COMMENT: &str = "photonfarm scene: ";

/// The name of the scene file that the comment of a zip archive tells, if it does.
pub fn scene_in_comment(archive: &[u8]) -> Option<String> {
    let zip = ZipArchive::new(Cursor::new(archive)).ok()?;
    let comment = std::str::from_utf8(zip.comment()).ok()?;
    comment.strip_prefix(SCENE_COMMENT).map(str::to_owned)
}

/// How many folders a normalised name leads up, and the rest of it.
pub fn steps_up(name: &str) -> (usize, &str) {
    let mut rest = name;
    let mut above = 0;
    while let Some(inside) = rest.strip_prefix("../") {
        (above, rest) = (above + 1, inside);
    }
    (above, rest)
}

/// File `name` of an archive as seen from its folder `folder`.
fn relative_name(folder: &str, name: &str) -> String {
    let folders: Vec<&str> = folder.split('/').collect();
    let parts: Vec<&str> = name.split('/').collect();
    let shared = folders.iter().zip(&parts[..parts.len() - 1]).take_while(|(one, other)| one == other).count();
    "../".repeat(folders.len() - shared) + &parts[shared..].join("/")
}

/// `name` with `/` separators, without `.` parts, and with `..` at its beginning alone; refused when it is absolute.
pub fn normalized_name(name: &str, location: &Location) -> Result<String, SceneError> {
    let mut parts: Vec<&str> = Vec::new();
    for part in name.split('/').filter(|part| !part.is_empty() && *part != ".") {
        if part == ".." && parts.last().is_some_and(|last| *last != "..") {
            parts.pop();
        } else {
            parts.push(part);
        }
    }
    let above = parts.iter().take_while(|part| **part == "..").count();
    // A name that leads upwards and back down is checked without the steps up; an absolute one keeps its slash.
    let inside = parts[above..].join("/");
    let rooted = if name.starts_with('/') { format!("/{inside}") } else { inside };
    let rooted = if name.len() > 1024 || above > 64 { name } else { &rooted };
    Ok("../".repeat(above) + &checked_name(rooted, location)?)
}

/// `name` with `/` separators and without `.` parts; refused when it is absolute or leads upwards.
pub fn checked_name(name: &str, location: &Location) -> Result<String, SceneError> {
    let refuse = |problem: &str, remedy: &str| {
        let shown: String = name.chars().take(200).collect();
        Err(SceneError::new(location, format!("file name {shown:?} {problem}"), remedy))
    };
    let drive = name.as_bytes().get(1) == Some(&b':') && name.as_bytes()[0].is_ascii_alphabetic();
    if name.contains('\\') {
        return refuse("has backslashes", "write \"/\" between folders");
    }
    if name.starts_with('/') || drive {
        return refuse("is absolute", "give a name relative to the folder of the scene file");
    }
    if name.split('/').any(|part| part == "..") {
        return refuse("leads upwards", "keep every file in or below the folder of the scene file");
    }
    let parts: Vec<&str> = name.split('/').filter(|part| !part.is_empty() && *part != ".").collect();
    // Every place in an included file repeats the file's name: long names would multiply.
    if parts.is_empty() || name.contains('\0') || name.len() > 1024 {
        return refuse("is not the name of a file", "give the name of a file, of at most 1024 bytes");
    }
    Ok(parts.join("/"))
}

fn read_entry(
    entry: &mut impl Read,
    name: &str,
    budget: &mut u64,
    archive: &Location,
) -> Result<Arc<[u8]>, SceneError> {
    let mut content = Vec::new();
    // The sizes in the archive's directory may lie: only what is really unpacked is counted.
    let read = entry.take(*budget + 1).read_to_end(&mut content);
    read.map_err(|error| unreadable(name, &error, archive))?;
    let size = content.len() as u64;
    if size > *budget {
        let problem = format!("the archive expands too far (at \"{name}\")");
        let remedy = "an archive may unpack to 2 GiB, and to 64 MiB plus 200 times its own size";
        return Err(SceneError::new(archive, problem, remedy));
    }
    if size > FILE_LIMIT {
        return Err(too_large(name, archive));
    }
    *budget -= size;
    Ok(content.into())
}

/// Takes off the folder that holds every file of an archive, which many programs add when they pack a folder.
pub fn without_common_folder(files: BTreeMap<String, Arc<[u8]>>) -> BTreeMap<String, Arc<[u8]>> {
    let Some((folder, _)) = files.keys().next().and_then(|name| name.split_once('/')) else { return files };
    let prefix = format!("{folder}/");
    if !files.keys().all(|name| name.starts_with(&prefix)) {
        return files;
    }
    files.into_iter().map(|(name, content)| (name[prefix.len()..].to_owned(), content)).collect()
}

fn read_inside(folder: &Path, path: &Path, name: &str, location: &Location) -> Result<Arc<[u8]>, SceneError> {
    let folder = folder.canonicalize().map_err(|error| unreadable(name, &error, location))?;
    if !path.starts_with(&folder) {
        let problem = format!("file \"{name}\" is a link that leads out of the scene's folder");
        return Err(SceneError::new(location, problem, "copy the file into the folder"));
    }
    read_file(path).map_err(|error| unreadable(name, &error, location))?.ok_or_else(|| too_large(name, location))
}

/// A text file without the byte order mark of UTF-8, which some editors write at its beginning.
pub fn without_byte_order_mark(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)
}

/// What a text file says, without the byte order mark; what is no UTF-8, as in comments of other encodings, is replaced.
pub fn text_of(bytes: &[u8]) -> Cow<'_, str> {
    String::from_utf8_lossy(without_byte_order_mark(bytes))
}

/// The bytes of a regular file; nothing when it is larger than 1 GiB.
pub fn read_file(path: &Path) -> std::io::Result<Option<Arc<[u8]>>> {
    // Asked before opening: opening a pipe would wait for a writer.
    if !path.metadata()?.is_file() {
        return Err(std::io::Error::other("not a regular file"));
    }
    let mut content = Vec::new();
    File::open(path)?.take(FILE_LIMIT + 1).read_to_end(&mut content)?;
    Ok((content.len() as u64 <= FILE_LIMIT).then(|| content.into()))
}

fn unreadable(name: &str, error: &std::io::Error, location: &Location) -> SceneError {
    SceneError::new(location, format!("file \"{name}\" cannot be read: {error}"), "")
}

fn too_large(name: &str, location: &Location) -> SceneError {
    SceneError::new(location, format!("file \"{name}\" is larger than 1 GiB"), "split or simplify it")
}

/// Adds the files in and below `folder`, visiting at most `budget` entries, since it only serves the search for a
/// similar name.
fn list_folder(folder: &Path, prefix: &str, budget: &mut usize, names: &mut BTreeSet<String>) {
    let Ok(entries) = folder.read_dir() else { return };
    for entry in entries.flatten() {
        let (Ok(kind), Ok(file_name)) = (entry.file_type(), entry.file_name().into_string()) else { continue };
        let Some(left) = budget.checked_sub(1) else { return };
        *budget = left;
        let name = format!("{prefix}{file_name}");
        if kind.is_dir() && prefix.matches('/').count() < 8 {
            list_folder(&entry.path(), &format!("{name}/"), budget, names);
        } else if !kind.is_dir() {
            names.insert(name);
        }
    }
}
