//! Lines to standard output and standard error that do not panic when nobody listens any more.

use std::io::{ErrorKind, Write};

use super::exit_code::CliError;

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

/// Tells the user something on standard error.
pub(super) fn note(text: &str) {
    // Where standard error is closed there is nobody to tell.
    let _ = writeln!(std::io::stderr(), "{text}");
}

/// A result as JSON.
pub(super) fn json(value: &impl serde::Serialize) -> Result<(), CliError> {
    result(&serde_json::to_string_pretty(value).map_err(CliError::failed)?)
}
