//! What a run has cost. Processor time is what a busy machine does not falsify as it does the clock's.

use std::path::{Path, PathBuf};
use std::time::Instant;

/// Time spent, s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spent {
    /// Of all processors together, in user and system mode.
    pub processor: f64,
    /// By the clock.
    pub wall: f64,
}

/// Says what has been spent since some beginning.
pub trait Stopwatch {
    /// Time spent so far.
    fn spent(&mut self) -> Result<Spent, StopwatchError>;
}

/// The operating system does not tell processor time.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("cannot tell processor time: {problem}; evaluate on Linux with /proc mounted")]
pub struct StopwatchError {
    problem: String,
}

/// Counts the time of this process from its making. Linux only.
#[derive(Debug)]
pub struct ProcessStopwatch {
    processor: f64,
    wall: Instant,
}

impl ProcessStopwatch {
    /// Starts to count.
    pub fn start() -> Result<Self, StopwatchError> {
        Ok(Self { processor: processor_seconds()?, wall: Instant::now() })
    }
}

/// Counts the time of the calling rayon pool's threads alone, so that others in the same process do not count. Linux only.
#[derive(Debug)]
pub struct PoolStopwatch {
    threads: Vec<PathBuf>,
    processor: f64,
    wall: Instant,
}

impl PoolStopwatch {
    /// Starts to count, on a thread of the pool.
    pub fn start() -> Result<Self, StopwatchError> {
        let threads = rayon::broadcast(|_| std::fs::read_link("/proc/thread-self"));
        let threads: Result<Vec<PathBuf>, _> = threads.into_iter().collect();
        let threads = threads.map_err(|error| StopwatchError { problem: error.to_string() })?;
        let threads = threads.into_iter().map(|thread| Path::new("/proc").join(thread).join("schedstat")).collect();
        let mut stopwatch = Self { threads, processor: 0.0, wall: Instant::now() };
        stopwatch.processor = stopwatch.processor_seconds()?;
        Ok(stopwatch)
    }

    fn processor_seconds(&self) -> Result<f64, StopwatchError> {
        let seconds = |file: &PathBuf| {
            let text = std::fs::read_to_string(file).map_err(|error| StopwatchError { problem: error.to_string() })?;
            // The first number is the time on a processor, ns.
            let time = text.split_whitespace().next().and_then(|nanoseconds| nanoseconds.parse::<f64>().ok());
            let missing = || StopwatchError { problem: format!("{} has no time", file.display()) };
            time.map(|nanoseconds| nanoseconds * 1e-9).ok_or_else(missing)
        };
        self.threads.iter().map(seconds).sum()
    }
}

impl Stopwatch for PoolStopwatch {
    fn spent(&mut self) -> Result<Spent, StopwatchError> {
        let processor = self.processor_seconds()? - self.processor;
        Ok(Spent { processor, wall: self.wall.elapsed().as_secs_f64() })
    }
}

impl Stopwatch for ProcessStopwatch {
    fn spent(&mut self) -> Result<Spent, StopwatchError> {
        Ok(Spent { processor: processor_seconds()? - self.processor, wall: self.wall.elapsed().as_secs_f64() })
    }
}

/// User and system time of this process so far.
fn processor_seconds() -> Result<f64, StopwatchError> {
    /// Linux reports times in hundredths of a second whatever the kernel's own clock.
    const TICKS_PER_SECOND: f64 = 100.0;
    let unreadable = |problem: String| StopwatchError { problem };
    let text = std::fs::read_to_string("/proc/self/stat").map_err(|error| unreadable(error.to_string()))?;
    let (_, after_name) = text.rsplit_once(')').ok_or_else(|| unreadable("/proc/self/stat has no name".to_owned()))?;
    let fields: Vec<&str> = after_name.split_whitespace().collect();
    let ticks = |index: usize| fields.get(index).and_then(|field| field.parse::<f64>().ok());
    match (ticks(11), ticks(12)) {
        (Some(user), Some(system)) => Ok((user + system) / TICKS_PER_SECOND),
        _ => Err(unreadable("/proc/self/stat has no times".to_owned())),
    }
}
