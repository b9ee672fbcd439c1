//! Ctrl-C and SIGTERM.

use super::exit_code::CliError;

/// Waits for Ctrl-C or SIGTERM.
pub(super) async fn interrupted() -> Result<(), CliError> {
    let failed = |error: std::io::Error| CliError::Failed(format!("cannot listen for signals: {error}"));
    #[cfg(unix)]
    {
        use tokio::signal::unix::{SignalKind, signal};
        let mut terminate = signal(SignalKind::terminate()).map_err(failed)?;
        tokio::select! {
            result = tokio::signal::ctrl_c() => result.map_err(failed),
            _ = terminate.recv() => Ok(()),
        }
    }
    #[cfg(not(unix))]
    tokio::signal::ctrl_c().await.map_err(failed)
}

/// From now on a further Ctrl-C or SIGTERM ends the process at once.
pub(super) fn end_on_next_interrupt() {
    tokio::spawn(async {
        if interrupted().await.is_ok() {
            std::process::exit(130);
        }
    });
}
