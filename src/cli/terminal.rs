//! Lines to standard output and standard error that do not panic when nobody listens any more.

use std::io::{ErrorKind, IsTerminal, Write};
use std::sync::atomic::{AtomicBool, Ordering};

use time::format_description::well_known::Rfc3339;

use super::exit_code::CliError;
use crate::farm::EVENTS;

/// Prints a result. A reader that has seen enough (`| head`) is no error.
pub(super) fn result(text: &str) -> Result<(), CliError> {
    let mut output = std::io::stdout().lock();
    match writeln!(output, "{text}").and_then(|()| output.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(CliError::File(format!("cannot write to standard output: {error}; choose another place for it")))
        }
        _ => Ok(()),
    }
}

/// Prints the heads of columns where people read standard output; programs are spared them.
pub(super) fn heads(columns: &[&str]) -> Result<(), CliError> {
    if std::io::stdout().is_terminal() { result(&columns.join("\t")) } else { Ok(()) }
}

/// Whether nothing but errors is told.
static IS_QUIET: AtomicBool = AtomicBool::new(false);

/// From now on only errors are told.
pub(super) fn be_quiet() {
    IS_QUIET.store(true, Ordering::Relaxed);
}

/// Whether only errors are told.
pub(super) fn is_quiet() -> bool {
    IS_QUIET.load(Ordering::Relaxed)
}

/// Whether programs read standard error.
static IS_LOGGED: AtomicBool = AtomicBool::new(false);

/// From now on what is told to the user is a line of the log, which programs read.
pub(super) fn log_notes() {
    IS_LOGGED.store(true, Ordering::Relaxed);
}

/// Tells the user something on standard error, unless they want to hear of errors only.
pub(super) fn note(text: &str) {
    if !is_quiet() {
        error(text);
    }
}

/// Tells the user of an error on standard error.
pub(super) fn error(text: &str) {
    if IS_LOGGED.load(Ordering::Relaxed) {
        return tracing::info!(target: EVENTS, "{text}");
    }
    // Where standard error is closed there is nobody to tell.
    let _ = writeln!(std::io::stderr(), "{text}");
}

/// A time in milliseconds since 1970 as people read it, as 2026-11-29T12:00:00Z.
pub(super) fn moment(milliseconds: i64) -> String {
    let known = time::OffsetDateTime::from_unix_timestamp(milliseconds.div_euclid(1000)).ok();
    known.and_then(|moment| moment.format(&Rfc3339).ok()).unwrap_or_else(|| "-".to_owned())
}

/// A result as JSON.
pub(super) fn json(value: &impl serde::Serialize) -> Result<(), CliError> {
    result(&serde_json::to_string_pretty(value).map_err(CliError::failed)?)
}
