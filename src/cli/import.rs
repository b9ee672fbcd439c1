//! `import`: a scene of any format in the native form.

use std::path::{Path, PathBuf};

use clap::Args;
use serde_json::{Value, json};

use super::exit_code::CliError;
use super::scene_input::scene_help;
use super::scene_options::SceneOptions;
use super::terminal;
use crate::import::native;
use crate::scene::description::SceneDescription;
use crate::scene::notice::Notice;

/// Write a scene of any format in the native form, Mitsuba 3's tree as JSON.
///
/// Files that the scene refers to are copied beside it under the same names; -o scene.zip packs all into one file.
#[derive(Clone, Debug, Args)]
pub(super) struct Import {
    #[arg(help = scene_help())]
    scene: PathBuf,
    /// File to write, .json or .zip.
    #[arg(short, long, value_name = "FILE", required_unless_present = "report")]
    output: Option<PathBuf>,
    /// Print what the native form cannot represent: what was approximated and what was ignored.
    #[arg(long)]
    report: bool,
    /// Print the report as JSON.
    #[arg(long, requires = "report")]
    json: bool,
    #[command(flatten)]
    options: SceneOptions,
}

impl Import {
    pub(super) fn run(self) -> Result<(), CliError> {
        let format = self.output.as_deref().map(NativeFormat::of_path).transpose()?;
        let description = self.options.load(&self.scene)?;
        if let Some((output, format)) = self.output.as_ref().zip(format) {
            write(&description, output, format)?;
        }
        if self.report {
            return terminal::result(&report(&description.notices, self.json)?);
        }
        description.notices.iter().for_each(|notice| terminal::note(&format!("note: {notice}")));
        Ok(())
    }
}

fn report(notices: &[Notice], as_json: bool) -> Result<String, CliError> {
    if as_json {
        let notices: Vec<Value> = notices.iter().map(notice_json).collect();
        return serde_json::to_string_pretty(&notices).map_err(CliError::failed);
    }
    if notices.is_empty() {
        return Ok("the scene is represented completely".to_owned());
    }
    let lines: Vec<String> = notices.iter().map(ToString::to_string).collect();
    Ok(lines.join("\n"))
}

/// A notice as JSON.
pub(super) fn notice_json(notice: &Notice) -> Value {
    json!({
        "file": notice.location.file,
        "line": notice.location.line,
        "path": notice.location.path,
        "subject": notice.subject,
        "treatment": notice.treatment.name(),
        "explanation": notice.explanation,
    })
}

/// The files of a scene in the native form.
#[derive(Clone, Copy)]
enum NativeFormat {
    /// A JSON file, with what it refers to beside it.
    Json,
    /// All in one.
    Zip,
}

impl NativeFormat {
    /// What the end of a file's name asks for.
    fn of_path(path: &Path) -> Result<Self, CliError> {
        match path.extension().map(|extension| extension.to_ascii_lowercase()) {
            Some(extension) if extension == "zip" => Ok(Self::Zip),
            Some(extension) if extension == "json" => Ok(Self::Json),
            _ => Err(CliError::Usage(format!("cannot write \"{}\"; end its name in .json or .zip", path.display()))),
        }
    }
}

fn write(description: &SceneDescription, output: &Path, format: NativeFormat) -> Result<(), CliError> {
    match format {
        NativeFormat::Zip => write_file(output, &native::to_zip(description)?),
        NativeFormat::Json => {
            let text = native::to_json(description)?;
            let folder = output.parent().unwrap_or(Path::new(""));
            let files = native::files(description)?;
            for (name, content) in &files {
                let path = folder.join(name);
                if path == output {
                    let text =
                        format!("the scene refers to a file that is called \"{name}\" itself; choose another -o");
                    return Err(CliError::Usage(text));
                }
                copy_beside(&path, content)?;
            }
            write_file(output, text.as_bytes())
        }
    }
}

/// Writes a file that the scene refers to, unless it is there already. Another file of that name is left alone.
fn copy_beside(path: &Path, content: &[u8]) -> Result<(), CliError> {
    match std::fs::read(path) {
        Ok(present) if present == content => return Ok(()),
        Ok(_) => {
            let text = format!("\"{}\" is there with other contents; write into an empty folder", path.display());
            return Err(CliError::File(text));
        }
        Err(_) => {}
    }
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(|error| unwritable(folder, &error))?;
    }
    write_file(path, content)
}

fn write_file(path: &Path, content: &[u8]) -> Result<(), CliError> {
    std::fs::write(path, content).map_err(|error| unwritable(path, &error))
}

fn unwritable(path: &Path, error: &std::io::Error) -> CliError {
    CliError::File(format!("cannot write \"{}\": {error}; check the folder and its permissions", path.display()))
}
