//! The one place where work goes from async tasks to the rendering threads and back.

use std::panic::{AssertUnwindSafe, catch_unwind};

use tokio::sync::oneshot;

use super::WorkerError;

/// A worker's rendering threads.
pub(super) struct RenderPool {
    threads: rayon::ThreadPool,
}

impl RenderPool {
    /// Starts `threads` threads.
    pub(super) fn new(threads: usize) -> Result<Self, WorkerError> {
        let threads = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .thread_name(|index| format!("render-{index}"))
            .build()
            .map_err(|problem| WorkerError::Start(problem.to_string()))?;
        Ok(Self { threads })
    }

    /// Runs `work` on the rendering threads; rayon inside it uses only those.
    ///
    /// # Errors
    /// The message of a panic in `work`: one job's fault must not end the worker.
    pub(super) async fn run<T: Send + 'static>(&self, work: impl FnOnce() -> T + Send + 'static) -> Result<T, String> {
        let (sender, receiver) = oneshot::channel();
        self.threads.spawn(move || {
            let result = catch_unwind(AssertUnwindSafe(work)).map_err(|panic| panic_message(panic.as_ref()));
            // Nobody waits any more when the session has ended.
            let _ = sender.send(result);
        });
        receiver.await.unwrap_or_else(|_| Err("the rendering threads are gone".to_owned()))
    }
}

fn panic_message(panic: &(dyn std::any::Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().copied().or_else(|| panic.downcast_ref::<String>().map(String::as_str));
    format!("rendering stopped by a fault: {}", text.unwrap_or("no message"))
}
