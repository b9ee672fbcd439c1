//! Why a worker ends.

/// Why a worker stopped other than by being asked.
#[derive(Debug, thiserror::Error)]
pub enum WorkerError {
    /// The coordinator's address is not one.
    #[error(
        "\"{address}\" is not an address of a coordinator ({problem}); write http://HOST:PORT or https://HOST:PORT"
    )]
    BadAddress {
        /// As given.
        address: String,
        /// What is wrong with it.
        problem: String,
    },
    /// The rendering threads or the HTTP client could not be made.
    #[error("the worker cannot start: {0}")]
    Start(String),
    /// The coordinator does not speak to this worker, for example because their builds differ.
    #[error("the coordinator refuses this worker: {0}")]
    Refused(String),
}
