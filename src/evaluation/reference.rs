//! Scenes whose picture is known: where the truth of every comparison comes from.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::estimate::Picture;
use crate::estimate::picture_files::{PictureFileError, read_exr, read_standard_error};
use crate::import;
use crate::scene::Scene;
use crate::scene::error::SceneError;

/// A scene with its converged picture.
pub struct Reference {
    /// The folder's name, or the scene file's.
    pub name: String,
    /// The prepared scene.
    pub scene: Arc<Scene>,
    /// Hash of the scene file and all it refers to; without defines, the hash under which a coordinator knows it.
    pub scene_hash: String,
    /// Hash of the picture and its noise.
    pub reference_hash: String,
    /// What the scene looks like.
    pub picture: Picture,
    /// Standard error of each pixel's channel mean; empty where the picture is exact or its noise is not known.
    pub standard_error: Option<Picture>,
}

/// Where a reference's parts are.
#[derive(Clone, Debug, Default)]
pub struct ReferencePlace {
    /// A folder with `scene.xml`, or a scene file.
    pub scene: PathBuf,
    /// The converged picture; `ref.exr` beside the scene when it is not given.
    pub picture: Option<PathBuf>,
    /// Its standard error. When it is not given: `stderr.exr` beside the scene, if it is there and the picture is not given, else the picture's
    /// own layer `error`, if it has one.
    pub standard_error: Option<PathBuf>,
    /// Names and values in place of the scene's defaults.
    pub defines: Vec<(String, String)>,
}

/// A reference that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum ReferenceError {
    /// The scene is wrong.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A picture is missing or unreadable.
    #[error(transparent)]
    Picture(#[from] PictureFileError),
    /// A file is missing or unreadable.
    #[error("cannot read \"{path}\": {source}; a reference is a folder with scene.xml and ref.exr", path = .path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the file system said.
        source: std::io::Error,
    },
    /// The picture does not fit the scene.
    #[error("{place}: {problem}")]
    Unfit {
        /// The reference.
        place: String,
        /// What is wrong, and what to do about it.
        problem: String,
    },
}

impl Reference {
    /// Loads the reference whose scene and picture are in `folder`.
    pub fn load(folder: &Path) -> Result<Self, ReferenceError> {
        Self::load_from(&ReferencePlace { scene: folder.to_owned(), ..ReferencePlace::default() })
    }

    /// Loads a reference. Where `meta.json` beside the scene states an `analytic_radiance`, that number is the truth in every pixel, unless
    /// another picture is given.
    pub fn load_from(place: &ReferencePlace) -> Result<Self, ReferenceError> {
        let is_folder = place.scene.is_dir();
        let file = if is_folder { place.scene.join("scene.xml") } else { place.scene.clone() };
        std::fs::File::open(&file).map_err(|source| ReferenceError::Read { path: file.clone(), source })?;
        let folder = file.parent().unwrap_or(Path::new(""));
        let scene = Arc::new(Scene::prepare(&import::load_file(&file, &place.defines)?)?);
        let mut hashed = import::pack(&file, &place.defines)?;
        for (name, value) in &place.defines {
            hashed.extend_from_slice(format!("\n{name}={value}").as_bytes());
        }
        let (picture, standard_error) = match &place.picture {
            Some(path) => (read_exr(path)?, standard_error_of(path, place.standard_error.as_deref())?),
            None => pictures_beside(folder, place.standard_error.as_deref())?,
        };
        let name = name_of(&file);
        check(&name, &scene, &picture)?;
        Ok(Self {
            name,
            scene,
            scene_hash: blake3::hash(&hashed).to_hex().to_string(),
            reference_hash: hash_of(&picture, standard_error.as_ref()),
            picture,
            standard_error,
        })
    }
}

/// Folders below `folder` that hold references, by name.
pub fn reference_folders(folder: &Path) -> std::io::Result<Vec<PathBuf>> {
    let mut folders = Vec::new();
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        if path.join("scene.xml").is_file() && path.join("ref.exr").is_file() {
            folders.push(path);
        }
    }
    folders.sort();
    Ok(folders)
}

fn pictures_beside(folder: &Path, standard_error: Option<&Path>) -> Result<(Picture, Option<Picture>), ReferenceError> {
    let path = folder.join("ref.exr");
    let mut picture = read_exr(&path)?;
    if let Some(radiance) = analytic_radiance(folder)? {
        picture.radiance.fill([radiance; 3]);
        return Ok((picture, None));
    }
    let beside = folder.join("stderr.exr");
    let standard_error = standard_error.or(beside.is_file().then_some(beside.as_path()));
    Ok((picture, standard_error_of(&path, standard_error)?))
}

/// The standard error of the picture at `picture`, from the file `given` or its own layer `error`; `None` when it has none.
pub fn standard_error_of(picture: &Path, given: Option<&Path>) -> Result<Option<Picture>, PictureFileError> {
    given.map_or_else(|| read_standard_error(picture), |given| read_exr(given).map(Some))
}

fn analytic_radiance(folder: &Path) -> Result<Option<f32>, ReferenceError> {
    let path = folder.join("meta.json");
    if !path.is_file() {
        return Ok(None);
    }
    let text = std::fs::read_to_string(&path).map_err(|source| ReferenceError::Read { path: path.clone(), source })?;
    let meta: serde_json::Value = serde_json::from_str(&text).map_err(|error| ReferenceError::Unfit {
        place: path.display().to_string(),
        problem: format!("{error}; correct the JSON or remove the file"),
    })?;
    Ok(meta["analytic_radiance"].as_f64().map(|radiance| radiance as f32))
}

/// The folder's name for files called `scene`, else the file's own.
fn name_of(file: &Path) -> String {
    let full = std::path::absolute(file).unwrap_or_else(|_| file.to_owned());
    let folder = full.parent().and_then(Path::file_name);
    let name = match full.file_stem() {
        Some(stem) if stem == "scene" => folder.unwrap_or(stem),
        Some(stem) => stem,
        None => "scene".as_ref(),
    };
    name.to_string_lossy().into_owned()
}

fn check(name: &str, scene: &Scene, picture: &Picture) -> Result<(), ReferenceError> {
    let unfit = |problem: String| Err(ReferenceError::Unfit { place: name.to_owned(), problem });
    if (scene.width, scene.height) != (picture.width, picture.height) {
        return unfit(format!(
            "the scene has {} × {} pixels and its reference {} × {}; give a reference of the scene's size",
            scene.width, scene.height, picture.width, picture.height
        ));
    }
    let values = || picture.radiance.iter().flatten();
    if values().any(|value| !value.is_finite()) || values().all(|value| *value <= 0.0) {
        return unfit("the reference is black or not finite, and errors relative to it mean nothing".to_owned());
    }
    Ok(())
}

fn hash_of(picture: &Picture, standard_error: Option<&Picture>) -> String {
    let mut hasher = blake3::Hasher::new();
    for part in [Some(picture), standard_error].into_iter().flatten() {
        part.radiance.iter().flatten().for_each(|value| {
            hasher.update(&value.to_le_bytes());
        });
    }
    hasher.finalize().to_hex().to_string()
}
