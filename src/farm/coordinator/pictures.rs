//! Pictures, also of jobs that ended long ago, with further layers. What the first surface is like follows from the scene alone: a worker looks
//! when someone asks, once a scene, and the coordinator keeps what it saw.

use std::sync::Arc;
use std::time::Duration;

use tokio::time::timeout;

use super::blocking::blocking;
use super::denoising::PictureState;
use super::layers::{of_denoised, of_estimate, of_first_surface, of_mattes};
use super::seen_first::SeenFirst;
use super::shared::{JobRecord, Shared};
use crate::estimate::denoise::{Denoised, Twins};
use crate::estimate::picture_files::{Layer, MatteHeader, Mattes, PictureLayer};
use crate::estimate::{Estimate, Picture};
use crate::farm::error::FarmError;
use crate::farm::ids::JobId;
use crate::farm::job::JobStatus;
use crate::farm::locks::lock;
use crate::farm::merging::Merging;
use crate::farm::rules::Event;
use crate::farm::rules::lease::{Errand, WorkIndex};
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
    /// What the mattes among them are called.
    pub mattes: Vec<MatteHeader>,
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
        let needs_mattes = wanted.iter().any(|layer| layer.is_matte());
        let mattes = if needs_mattes { Some(shared.mattes(&job).await?) } else { None };
        let is_denoised = wanted.iter().any(|layer| layer.is_denoised());
        let (record, wanted, surfaces) = (job.clone(), wanted.to_vec(), seen.clone());
        let read = move |merging: &Merging| {
            let status = shared.lock().status(&record, &shared.clock);
            let seen = surfaces.as_deref().unwrap_or_default();
            let layer =
                |layer: &Layer| of_estimate(*layer, &merging.estimate).or_else(|| of_first_surface(*layer, seen));
            let layers: Vec<PictureLayer> = wanted.iter().filter_map(layer).collect();
            let halves = is_denoised.then(|| shared.halves(&merging.estimate, PictureState::new(record.id, &status)));
            let picture = merging.estimate.picture();
            (LayeredPicture { picture, layers, status, mattes: Vec::new(), denoised_relmse: None }, halves, wanted)
        };
        let (mut picture, halves, wanted) = self.with_merged(&job, read).await?;
        if let Some((halves, seen)) = halves.zip(seen) {
            let denoised = self.denoised(halves?, PictureState::new(id, &picture.status), seen).await?;
            picture.denoised_relmse = Some(denoised.relmse);
            picture.layers.extend(wanted.iter().filter_map(|layer| of_denoised(*layer, &denoised)));
        }
        if let Some(mattes) = mattes {
            let found = blocking(move || Ok(wanted.iter().filter_map(|layer| of_mattes(*layer, &mattes)).unzip()));
            let (layers, headers): (Vec<_>, Vec<_>) = found.await?;
            picture.layers.extend(layers);
            picture.mattes = headers;
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
        self.seen(job, Errand::FirstSurfaces, &self.surfaces_seen).await
    }

    /// How much of a job's pixels objects and materials cover. Lets a worker look if nobody has yet.
    async fn mattes(&self, job: &JobRecord) -> Result<Arc<Mattes>, FarmError> {
        self.seen(job, Errand::Mattes, &self.mattes_seen).await
    }

    /// What `errand` finds out of a job's scene, once it is among what is `known`.
    async fn seen<T: ?Sized>(
        &self,
        job: &JobRecord,
        errand: Errand,
        known: &SeenFirst<T>,
    ) -> Result<Arc<T>, FarmError> {
        let scene = job.description().scene;
        let mut arrived = known.arrived.subscribe();
        if let Some(seen) = known.get(&scene) {
            return Ok(seen);
        }
        self.apply(Event::ErrandWanted { job: job.id, errand });
        let look = async {
            loop {
                arrived.mark_unchanged();
                if let Some(seen) = known.get(&scene) {
                    return Some(seen);
                }
                if !self.lock().rules.has_errand(job.id, errand) {
                    return None;
                }
                arrived.changed().await.ok()?;
            }
        };
        timeout(PATIENCE, look).await.ok().flatten().ok_or_else(|| FarmError::NotYet {
            problem: format!("no worker has looked at the {} of job {} yet", WorkIndex::Errand(errand), job.id),
            retry_after: self.options.limits.retry_after(),
        })
    }
}
