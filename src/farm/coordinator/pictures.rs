//! Pictures, also of jobs that ended long ago, with further layers. What the first surface is like follows from the scene alone: a worker looks
//! when someone asks, once a scene, and the coordinator keeps what it saw.

use std::sync::Arc;
use std::time::Duration;

use tokio::time::timeout;

use super::blocking::blocking;
use super::denoising::PictureState;
use super::shared::{JobRecord, Shared};
use crate::estimate::denoise::{Denoised, Twins};
use crate::estimate::picture_files::{Layer, PictureLayer};
use crate::estimate::{Estimate, Picture};
use crate::farm::error::FarmError;
use crate::farm::ids::JobId;
use crate::farm::job::JobStatus;
use crate::farm::locks::lock;
use crate::farm::merging::Merging;
use crate::farm::rules::Event;
use crate::render::first_surface::FirstSurface;

/// How long a request waits for a worker to look.
const PATIENCE: Duration = Duration::from_secs(20);

/// A state as it was looked for in memory.
enum InMemory<T, Read> {
    /// What was read of it.
    Read(T),
    /// Nothing is merged yet.
    Empty,
    /// It is not in memory; nothing was read.
    Elsewhere(Read),
}

/// A picture with its layers.
#[derive(Clone, Debug)]
pub struct LayeredPicture {
    /// The picture itself.
    pub picture: Picture,
    /// Those that were asked for.
    pub layers: Vec<PictureLayer>,
    /// The job when the picture was as it is.
    pub status: JobStatus,
    /// What its own halves tell of the relMSE of the denoised picture, where a layer of that was asked for.
    pub denoised_relmse: Option<f64>,
}

/// What a denoised picture is made of.
enum Halves {
    /// It was made already.
    Denoised(Arc<Denoised>),
    /// It is made of these.
    Raw(Twins),
}

impl Shared {
    /// The picture as merged so far, the layers asked for, and the status that belongs to all of them.
    pub(super) async fn picture_with_layers(
        self: &Arc<Self>,
        id: JobId,
        wanted: &[Layer],
    ) -> Result<LayeredPicture, FarmError> {
        let (shared, job) = (self.clone(), self.job(id)?);
        if wanted.contains(&Layer::LightGroups) && job.description().light_groups.is_empty() {
            let problem = format!("job {id} keeps no light groups apart");
            let remedy = "submit one with light_groups (--light-groups)".to_owned();
            return Err(FarmError::BadRequest { problem, remedy });
        }
        let needs_surfaces = wanted.iter().any(|layer| layer.needs_first_surfaces());
        let seen = if needs_surfaces { Some(shared.first_surfaces(&job).await?) } else { None };
        let is_denoised = wanted.iter().any(|layer| layer.is_denoised());
        let (record, wanted, surfaces) = (job.clone(), wanted.to_vec(), seen.clone());
        let read = move |merging: &Merging| {
            let status = shared.lock().status(&record, &shared.clock);
            let seen = surfaces.as_deref().unwrap_or_default();
            let layer =
                |layer: &Layer| of_estimate(*layer, &merging.estimate).or_else(|| of_first_surface(*layer, seen));
            let layers: Vec<PictureLayer> = wanted.iter().filter_map(layer).collect();
            let halves = is_denoised.then(|| shared.halves(&merging.estimate, PictureState::new(record.id, &status)));
            (
                LayeredPicture { picture: merging.estimate.picture(), layers, status, denoised_relmse: None },
                halves,
                wanted,
            )
        };
        let (mut picture, halves, wanted) = self.with_merged(&job, read).await?;
        if let Some((halves, seen)) = halves.zip(seen) {
            let denoised = self.denoised(halves?, PictureState::new(id, &picture.status), seen).await?;
            picture.denoised_relmse = Some(denoised.relmse);
            picture.layers.extend(wanted.iter().filter_map(|layer| of_denoised(*layer, &denoised)));
        }
        Ok(picture)
    }

    /// The denoised picture as merged so far, and the status that belongs to it.
    pub(super) async fn denoised_picture(self: &Arc<Self>, id: JobId) -> Result<(Arc<Denoised>, JobStatus), FarmError> {
        let (shared, job) = (self.clone(), self.job(id)?);
        let seen = shared.first_surfaces(&job).await?;
        let record = job.clone();
        let read = move |merging: &Merging| {
            let status = shared.lock().status(&record, &shared.clock);
            (shared.halves(&merging.estimate, PictureState::new(record.id, &status)), status)
        };
        let (halves, status) = self.with_merged(&job, read).await?;
        Ok((self.denoised(halves?, PictureState::new(id, &status), seen).await?, status))
    }

    /// What a denoised picture is made of, or that picture where it is there already.
    fn halves(&self, estimate: &Estimate, state: PictureState) -> Result<Halves, FarmError> {
        match self.denoising.get(state) {
            Some(denoised) => Ok(Halves::Denoised(denoised)),
            None => Ok(Halves::Raw(Twins::of(estimate)?)),
        }
    }

    async fn denoised(
        &self,
        halves: Halves,
        state: PictureState,
        seen: Arc<[FirstSurface]>,
    ) -> Result<Arc<Denoised>, FarmError> {
        match halves {
            Halves::Denoised(denoised) => Ok(denoised),
            Halves::Raw(twins) => self.denoising.make(state, twins, seen).await,
        }
    }

    /// Reads a job's merged state, once there is something in it, wherever it is.
    pub(super) async fn with_merged<T: Send + 'static>(
        self: &Arc<Self>,
        job: &Arc<JobRecord>,
        read: impl FnOnce(&Merging) -> T + Send + 'static,
    ) -> Result<T, FarmError> {
        let no_picture = || FarmError::NoPictureYet(job.id);
        let record = job.clone();
        // One look under the lock decides where it is: the keeper may take it to the store at any time.
        let in_memory = blocking(move || {
            let merging = lock(&record.merging);
            Ok(match merging.as_ref() {
                Some(merging) if merging.merged() == 0 => InMemory::Empty,
                Some(merging) => InMemory::Read(read(merging)),
                None => InMemory::Elsewhere(read),
            })
        });
        let read = match in_memory.await? {
            InMemory::Read(found) => return Ok(found),
            InMemory::Empty => return Err(no_picture()),
            InMemory::Elsewhere(read) => read,
        };
        let merging = self.stored_state(job).await?.ok_or_else(no_picture)?;
        blocking(move || Ok(read(&merging))).await
    }

    /// The final state of an ended job.
    async fn stored_state(&self, job: &JobRecord) -> Result<Option<Arc<Merging>>, FarmError> {
        if let Some(merging) = self.viewed.get(job.id) {
            return Ok(Some(merging));
        }
        let newest = lock(&job.facts).snapshots.newest.clone();
        let Some(newest) = newest else { return Ok(None) };
        let merging = Arc::new(self.load(job, &newest).await?);
        self.viewed.insert_shared(job.id, merging.clone());
        Ok(Some(merging).filter(|merging| merging.totals().shards > 0))
    }

    /// What the pixels of a job's scene see first. Lets a worker look if nobody has yet.
    async fn first_surfaces(&self, job: &JobRecord) -> Result<Arc<[FirstSurface]>, FarmError> {
        let scene = job.description().scene;
        let mut arrived = self.seen_first.arrived.subscribe();
        if let Some(seen) = self.seen_first.get(&scene) {
            return Ok(seen);
        }
        self.apply(Event::FirstSurfacesWanted { job: job.id });
        let look = async {
            loop {
                arrived.mark_unchanged();
                if let Some(seen) = self.seen_first.get(&scene) {
                    return Some(seen);
                }
                if !self.lock().rules.has_errand(job.id) {
                    return None;
                }
                arrived.changed().await.ok()?;
            }
        };
        timeout(PATIENCE, look).await.ok().flatten().ok_or_else(|| FarmError::NotYet {
            problem: format!("no worker has looked at the first surfaces of job {} yet", job.id),
            retry_after: self.options.limits.retry_after(),
        })
    }
}

/// A layer that the estimate holds.
fn of_estimate(layer: Layer, estimate: &Estimate) -> Option<PictureLayer> {
    if layer == Layer::LightGroups {
        return Some(of_light_groups(estimate));
    }
    let pixels = (0..estimate.pixel_count()).map(|pixel| estimate.pixel(pixel));
    let values = match layer {
        Layer::Radius => pixels.map(|pixel| pixel.radius_squared.sqrt() as f32).collect(),
        Layer::Photons => pixels.map(|pixel| pixel.photons as f32).collect(),
        // Nothing is known before each twin has a pass.
        Layer::Error => estimate.standard_error().unwrap_or_else(|| vec![f32::NAN; estimate.pixel_count()]),
        Layer::Albedo | Layer::Normal | Layer::Depth | Layer::Position => return None,
        Layer::Denoised | Layer::DenoisedError | Layer::LightGroups => return None,
    };
    Some(PictureLayer::new(layer, vec![values]))
}

/// The light of each light group.
fn of_light_groups(estimate: &Estimate) -> PictureLayer {
    let light_groups: Vec<String> = estimate.declaration().light_groups().into_iter().map(str::to_owned).collect();
    let picture = |group: &String| {
        let picture = estimate.light_group_picture(group);
        [0, 1, 2].map(|channel| picture.radiance.iter().map(|pixel| pixel[channel]).collect::<Vec<f32>>())
    };
    let channels = light_groups.iter().flat_map(picture).collect();
    PictureLayer { light_groups, ..PictureLayer::new(Layer::LightGroups, channels) }
}

/// A layer that follows from the scene.
fn of_first_surface(layer: Layer, seen: &[FirstSurface]) -> Option<PictureLayer> {
    let axes = |value: fn(&FirstSurface) -> [f32; 3]| {
        (0..3).map(|axis| seen.iter().map(|pixel| value(pixel)[axis]).collect()).collect()
    };
    let channels = match layer {
        Layer::Albedo => axes(|pixel| pixel.albedo.to_array()),
        Layer::Normal => axes(|pixel| pixel.normal.to_array()),
        Layer::Depth => vec![seen.iter().map(|pixel| pixel.depth).collect()],
        Layer::Position => axes(|pixel| pixel.position.to_array()),
        Layer::Radius | Layer::Photons | Layer::Error => return None,
        Layer::Denoised | Layer::DenoisedError | Layer::LightGroups => return None,
    };
    Some(PictureLayer::new(layer, channels))
}

/// A layer of the denoised picture.
fn of_denoised(layer: Layer, denoised: &Denoised) -> Option<PictureLayer> {
    let channels = match layer {
        Layer::Denoised => (0..3).map(|c| denoised.picture.radiance.iter().map(|pixel| pixel[c]).collect()).collect(),
        Layer::DenoisedError => vec![denoised.standard_error.clone()],
        _ => return None,
    };
    Some(PictureLayer::new(layer, channels))
}
