//! `--tev`: a job's picture as it converges, in the viewer tev (github.com/Tom94/tev).
//!
//! The picture is fetched as EXR whenever the job has a newer one, and tev is sent the rows that changed. That is done beside the command, which
//! tev never holds up for long and never fails.

mod packets;

use std::fmt::Display;
use std::time::Duration;

use clap::Args;
use tokio::io::AsyncWriteExt;
use tokio::net::TcpStream;
use tokio::sync::watch;
use tokio::task::JoinHandle;
use tokio::time::{sleep, timeout};

use super::client::Client;
use super::exit_code::CliError;
use super::terminal;
use crate::estimate::picture_files::{Channels, decode_channels};
use crate::farm::job::JobStatus;

/// How long tev may take to answer or to take a packet.
const PATIENCE: Duration = Duration::from_secs(5);
/// Time between two pictures at least.
const PAUSE: Duration = Duration::from_millis(250);
/// Rows that are sent together.
const BAND: u32 = 64;

/// Where a picture is shown while it converges.
#[derive(Clone, Debug, Args)]
pub(super) struct TevOption {
    /// Show the picture as it converges in the viewer tev, which listens at this address (by tev's own default 127.0.0.1:14158).
    #[arg(long, value_name = "HOST:PORT", value_parser = address)]
    tev: Option<String>,
}

impl TevOption {
    /// A sequence has many pictures.
    pub(super) fn refuse_for_sequences(&self) -> Result<(), CliError> {
        if self.tev.is_none() {
            return Ok(());
        }
        Err(CliError::Usage("--tev shows one picture; give the id of a frame's job".to_owned()))
    }

    /// Shows the picture of a job as `name`, with further layers by their names. Nothing happens where no tev was asked for.
    pub(super) fn show(&self, client: &Client, job: &str, name: String, layers: &[String]) -> TevViewer {
        let Some(address) = self.tev.clone() else { return TevViewer { work: None } };
        let (versions, newest) = watch::channel(0);
        let image = format!("image.exr?layers={}", layers.join(","));
        let show = Show { client: client.clone(), job: job.to_owned(), image, name, newest };
        let task = tokio::spawn(async move {
            if let Err(problem) = show.run(&address).await {
                terminal::note(&format!("tev at {address} no longer shows the picture: {problem}"));
            }
        });
        TevViewer { work: Some((versions, task)) }
    }
}

/// What is shown of a job in tev.
pub(super) struct TevViewer {
    work: Option<(watch::Sender<u64>, JoinHandle<()>)>,
}

impl TevViewer {
    /// Tells that the job has come so far.
    pub(super) fn update(&self, status: &JobStatus) {
        if let Some((versions, _)) = self.work.as_ref().filter(|_| status.passes_done > 0) {
            versions.send_replace(status.picture_version);
        }
    }

    /// Waits until the last picture is shown.
    pub(super) async fn finish(self) -> Result<(), CliError> {
        let Some((versions, task)) = self.work else { return Ok(()) };
        drop(versions);
        task.await.map_err(CliError::failed)
    }
}

/// Everything that is needed to show a job.
struct Show {
    client: Client,
    job: String,
    image: String,
    name: String,
    newest: watch::Receiver<u64>,
}

impl Show {
    async fn run(mut self, address: &str) -> Result<(), String> {
        let mut stream = in_time(TcpStream::connect(address)).await?;
        let mut shown = Channels::default();
        // The last version is seen, too, when there will be no further one.
        while self.newest.changed().await.is_ok() {
            let fetched = self.client.image(&self.job, &self.image).await.map_err(|error| error.to_string())?;
            let Some(bytes) = fetched.bytes() else { continue };
            let picture = decode_channels(&bytes).map_err(|error| error.to_string())?;
            for packet in self.packets(&shown, &picture) {
                in_time(stream.write_all(&packet)).await?;
            }
            shown = picture;
            sleep(PAUSE).await;
        }
        in_time(stream.shutdown()).await
    }

    /// What makes `picture` of what is shown.
    fn packets(&self, shown: &Channels, picture: &Channels) -> Vec<Vec<u8>> {
        let is_new = !is_alike(shown, picture);
        let bands = (0..picture.height).step_by(BAND as usize).map(|row| row..(row + BAND).min(picture.height));
        let changed = bands.filter(|rows| {
            let pixels = packets::pixels_of(picture, rows);
            // By bits, because what is not a number equals nothing.
            let is_other =
                |old: &[f32], new: &[f32]| old.iter().zip(new).any(|(old, new)| old.to_bits() != new.to_bits());
            let mut both = shown.named.iter().zip(&picture.named);
            is_new || both.any(|((_, old), (_, new))| is_other(&old[pixels.clone()], &new[pixels.clone()]))
        });
        let create = is_new.then(|| packets::create_image(&self.name, picture));
        create.into_iter().chain(changed.map(|rows| packets::update_rows(&self.name, picture, rows))).collect()
    }
}

/// Whether both have one size and the same channels.
fn is_alike(a: &Channels, b: &Channels) -> bool {
    let names = |channels: &Channels| channels.named.iter().map(|(name, _)| name.clone()).collect::<Vec<_>>();
    (a.width, a.height, names(a)) == (b.width, b.height, names(b))
}

/// What comes of an exchange with tev, if it comes soon.
async fn in_time<T, E: Display>(exchange: impl Future<Output = Result<T, E>>) -> Result<T, String> {
    match timeout(PATIENCE, exchange).await {
        Ok(result) => result.map_err(|error| error.to_string()),
        Err(_) => Err(format!("it did not answer within {} s", PATIENCE.as_secs())),
    }
}

/// A host and a port.
fn address(text: &str) -> Result<String, String> {
    let port =
        text.rsplit_once(':').filter(|(host, _)| !host.is_empty()).and_then(|(_, port)| port.parse::<u16>().ok());
    port.map(|_| text.to_owned()).ok_or_else(|| "write HOST:PORT, as 127.0.0.1:14158".to_owned())
}
