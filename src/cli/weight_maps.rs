//! `render --weight-maps`: which strategy is trusted where, one job for each.

use std::path::{Path, PathBuf};

use super::client::{Client, Fetched};
use super::exit_code::CliError;
use super::progress::Progress;
use super::render::follow_or_cancel;
use crate::api::images::metadata_of;
use crate::api::jobs::JobSubmission;
use crate::estimate::picture_files::{
    Channels, LUMINANCE, PictureFormat, check_writable, decode_channels, decode_exr, encode_channels, write_file,
};
use crate::evaluation::chart::{ColorScale, Map, MapSheet, Spacing, to_png};
use crate::farm::job::{JobState, JobStatus, StopRule};
use crate::method::{self, MethodChoice, Strategy};

/// Without `--length`, strategies of paths from 2 to so many segments are shown.
const LONGEST: u32 = 4;

/// Refuses a file that is no EXR or cannot be written, or has no place for the sheet beside it.
pub(super) fn check(file: &Path) -> Result<(), CliError> {
    if PictureFormat::of_path(file)? != PictureFormat::Exr {
        let text = format!("--weight-maps \"{}\" is no EXR; the sheet is written beside it, as PNG", file.display());
        return Err(CliError::Usage(text));
    }
    check_writable(file)?;
    Ok(check_writable(&sheet_file(file))?)
}

fn sheet_file(file: &Path) -> PathBuf {
    file.with_extension("png")
}

/// The strategies that a job's picture is made of.
pub(super) fn strategies(job: &JobStatus) -> Result<Vec<Strategy>, CliError> {
    let choice = MethodChoice { name: job.method.clone(), parameters: job.parameters.clone() };
    let found = method::strategies(&choice, LONGEST);
    let found = found.map_err(|error| CliError::BadInput(format!("no weight maps: {error}")))?;
    if found.is_empty() {
        let text = "no weight maps: the method has no strategy for these paths; change length, strategy or max_depth";
        return Err(CliError::BadInput(text.to_owned()));
    }
    Ok(found)
}

/// Renders the weights of `strategies` with as many passes as `picture`, a job that is done, and writes them as layers of `file` and as
/// a sheet beside it.
///
/// In every pixel, a strategy's weight is its part of the luminance of all paths of the length: the mean of its multiple importance
/// weights over that light, 0 for paths that it cannot find. So weights add up to one.
pub(super) async fn write(
    client: &Client,
    picture: &JobStatus,
    strategies: &[Strategy],
    file: &Path,
) -> Result<(), CliError> {
    let image = decode_exr(&image(client, picture).await?)?;
    let mut channels = Channels::of(&image, &[])?;
    let mut progress = Progress::new();
    let mut rows: Vec<(String, Vec<Map>)> = Vec::new();
    for of_length in strategies.chunk_by(|a, b| a.segments == b.segments) {
        let segments = of_length[0].segments;
        let whole = luminance(client, picture, segments, "all", &mut progress).await?;
        let mut maps = Vec::new();
        for strategy in of_length {
            let Strategy { light, camera, .. } = strategy;
            let part = luminance(client, picture, segments, &format!("{light},{camera}"), &mut progress).await?;
            let weight = |(part, whole): (f32, &f32)| if *whole > 0.0 { part / whole } else { f32::NAN };
            let values: Vec<f32> = part.into_iter().zip(&whole).map(weight).collect();
            channels.named.push((format!("length{segments}.s{light}t{camera}.Y"), values.clone()));
            maps.push(Map { caption: caption(*strategy, &values), values });
        }
        rows.push((format!("{segments} segments"), maps));
    }
    progress.finish();
    let size = [image.width, image.height];
    write_file(file, &encode_channels(channels, &metadata_of(picture))?)?;
    write_file(&sheet_file(file), &sheet(picture, size, rows)?)?;
    Ok(())
}

/// All maps on one scale, as PNG.
fn sheet(picture: &JobStatus, [width, height]: [u32; 2], rows: Vec<(String, Vec<Map>)>) -> Result<Vec<u8>, CliError> {
    let sheet = MapSheet {
        title: format!("Weights of {}", picture.method),
        note: format!(
            "Which part of the light of such paths each strategy s,t brings, and its mean over the picture; {} passes",
            picture.passes_done
        ),
        unit: "weight".to_owned(),
        width,
        height,
        rows,
        scale: ColorScale::new(Spacing::Linear, 0.0, 1.0).map_err(CliError::failed)?,
    };
    to_png(&sheet.draw()).map_err(CliError::failed)
}

/// The luminance of all paths of `segments` that `strategy` finds, by a job of its own.
async fn luminance(
    client: &Client,
    picture: &JobStatus,
    segments: u32,
    strategy: &str,
    progress: &mut Progress,
) -> Result<Vec<f32>, CliError> {
    progress.announce(&format!("weight maps: {segments} segments, strategy {strategy}"));
    let mut parameters = picture.parameters.clone();
    parameters.insert("show".to_owned(), "radiance".into());
    parameters.insert("length".to_owned(), segments.into());
    parameters.insert("strategy".to_owned(), strategy.into());
    // Photons found decide radii, and radii decide weights: by schedule they are the same for all strategies.
    if let Some(rule) = parameters.get_mut("radius_rule") {
        *rule = "schedule".into();
    }
    let submission = JobSubmission {
        scene: Some(picture.scene.clone()),
        method: Some(picture.method.clone()),
        parameters,
        stop: StopRule { passes: Some(picture.passes_done), ..StopRule::default() },
        cut: picture.cut,
        seed: picture.seed,
        ..JobSubmission::default()
    };
    let job = client.submit(&submission).await?;
    let (status, interrupted) = follow_or_cancel(client, &job.id, |status| progress.show(status)).await?;
    match (interrupted, status.state) {
        (true, _) => return Err(CliError::Interrupted),
        (false, JobState::Done) => {}
        _ => return Err(CliError::Failed(status.error.unwrap_or_else(|| "the job failed".to_owned()))),
    }
    Ok(decode_channels(&image(client, &status).await?)?.layer(LUMINANCE)?.values)
}

async fn image(client: &Client, job: &JobStatus) -> Result<Vec<u8>, CliError> {
    match client.image(&job.id, "image.exr").await? {
        Fetched::Image(image) => Ok(image.bytes),
        _ => Err(CliError::Failed("a job ended without a picture; give it more time".to_owned())),
    }
}

fn caption(strategy: Strategy, values: &[f32]) -> String {
    let kind = match strategy {
        _ if strategy.merges() => "merged",
        Strategy { light: 0, .. } => "light hit",
        Strategy { light: 1, .. } => "light sampled",
        Strategy { camera: 1, .. } => "camera sampled",
        _ => "connected",
    };
    let known = || values.iter().filter(|value| value.is_finite()).map(|value| f64::from(*value));
    let mean = match known().count() {
        0 => "nothing found".to_owned(),
        count => format!("{:.2}", known().sum::<f64>() / count as f64),
    };
    format!("{},{} {kind}: {mean}", strategy.light, strategy.camera)
}
