//! The one place where work goes from async tasks to the rendering threads and back.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

use super::error::WorkerError;
use crate::farm::locks::panic_message;

/// A worker's rendering threads.
pub(super) struct RenderPool {
    threads: Arc<rayon::ThreadPool>,
}

impl RenderPool {
    /// Starts `threads` threads.
    pub(super) fn new(threads: usize) -> Result<Self, WorkerError> {
        let threads = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .thread_name(|index| format!("render-{index}"))
            .build()
            .map_err(|problem| WorkerError::Start(problem.to_string()))?;
        Ok(Self { threads: Arc::new(threads) })
    }

    /// Runs `work` on the rendering threads; rayon inside it uses only those.
    ///
    /// # Errors
    /// The message of a panic in `work`: one job's fault must not end the worker.
    pub(super) async fn run<T: Send + 'static>(&self, work: impl FnOnce() -> T + Send + 'static) -> Result<T, String> {
        let threads = self.threads.clone();
        let work = move || catch_unwind(AssertUnwindSafe(|| threads.install(work)));
        // A thread that may block waits for the rendering threads, so that simulated clocks wait, too.
        match tokio::task::spawn_blocking(work).await {
            Ok(result) => result.map_err(|panic| format!("rendering stopped by a fault: {}", panic_message(&*panic))),
            Err(_) => Err("the rendering threads are gone".to_owned()),
        }
    }
}
