//! The scenes that cases are made of: the repository's own, and those in `corpus` for the formats that it has none of.

use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};

use photonfarm::import::{load_file, native, pack};

/// The largest sample, bytes with all of its files: small ones let more cases run, and more of their edits count.
const MOST_BYTES: usize = 48 << 10;

/// A scene and the files that it refers to; the scene comes first.
#[derive(Clone)]
pub(crate) struct Sample {
    pub(crate) files: Vec<(String, Vec<u8>)>,
}

pub(crate) struct Format {
    pub(crate) name: &'static str,
    pub(crate) samples: Vec<Sample>,
}

/// All formats with their samples.
pub(crate) fn formats() -> Result<Vec<Format>, Box<dyn Error>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let (mut xml, mut json, mut zip) = (Vec::new(), Vec::new(), Vec::new());
    for folder in [folders(&root.join("scenes"))?, folders(&root.join("tests/references"))?].concat() {
        let path = folder.join("scene.xml");
        if !path.exists() {
            continue;
        }
        let Some(sample) = Sample::of_folder(&folder)? else { continue };
        let description = load_file(&path, &[])?;
        let files = native::files(&description)?.into_iter().map(|(name, content)| (name, content.to_vec()));
        let scene = ("scene.json".to_owned(), native::to_json(&description)?.into_bytes());
        json.push(Sample { files: [scene].into_iter().chain(files).collect() });
        zip.push(Sample { files: vec![("scene.zip".to_owned(), pack(&path, &[])?)] });
        xml.push(sample);
    }
    zip.retain(|sample| sample.files[0].1.starts_with(b"PK"));
    let mut formats = vec![("xml", xml), ("json", json), ("zip", zip)];
    for name in ["files", "old_xml", "gltf", "glb", "mgf", "pbrt", "ceng795"] {
        let folder = root.join("examples/fuzz_importers/corpus").join(name);
        formats.push((name, Sample::of_folder(&folder)?.into_iter().collect()));
    }
    let formats = formats.into_iter().map(|(name, samples)| Format { name, samples });
    let formats: Vec<Format> = formats.collect();
    match formats.iter().find(|format| format.samples.is_empty()) {
        None => Ok(formats),
        Some(format) => Err(format!("there is no sample of {}", format.name).into()),
    }
}

fn folders(folder: &Path) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    let mut folders: Vec<PathBuf> =
        fs::read_dir(folder)?.map(|entry| Ok(entry?.path())).collect::<std::io::Result<_>>()?;
    folders.sort();
    Ok(folders)
}

impl Sample {
    /// A folder's `scene.…` and what may belong to it; nothing when that is too much.
    fn of_folder(folder: &Path) -> Result<Option<Self>, Box<dyn Error>> {
        let mut files = Vec::new();
        for path in folders(folder)? {
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            // What a reference is for, and how a mesh was made.
            if !["ref.exr", "stderr.exr", "meta.json"].contains(&name.as_str()) && !name.ends_with(".py") {
                files.push((name, fs::read(path)?));
            }
        }
        files.sort_by_key(|(name, _)| !name.starts_with("scene."));
        let bytes: usize = files.iter().map(|(_, content)| content.len()).sum();
        Ok((bytes <= MOST_BYTES && !files.is_empty()).then_some(Self { files }))
    }
}
