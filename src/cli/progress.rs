//! How a job is doing, on standard error: a bar on a terminal, else a plain line now and then.

use std::io::IsTerminal;
use std::time::{Duration, Instant};

use console::Term;
use indicatif::{ProgressBar, ProgressStyle};

use super::terminal;
use crate::farm::job::{Acceptance, JobState, JobStatus};
use crate::farm::sequence::{SequenceState, SequenceStatus};

/// Time between plain lines.
const LINE_INTERVAL: Duration = Duration::from_secs(10);
/// Steps of the bar.
const STEPS: u64 = 1000;
/// Columns that the bar takes, with its brackets and the space after it.
const BAR_COLUMNS: usize = 15;

/// Shows statuses as they come.
pub(super) struct Progress {
    bar: Option<ProgressBar>,
    last_line: Option<Instant>,
    /// What was said of the job's state last.
    last_state: Option<String>,
}

impl Progress {
    pub(super) fn new() -> Self {
        let is_shown = std::io::stderr().is_terminal() && !terminal::is_quiet();
        let bar = is_shown.then(|| {
            let style = ProgressStyle::with_template("[{bar:12}] {wide_msg}").map(|style| style.progress_chars("=> "));
            ProgressBar::new(STEPS).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
        });
        Self { bar, last_line: None, last_state: None }
    }

    /// Says what is shown from here on.
    pub(super) fn announce(&mut self, text: &str) {
        match &self.bar {
            Some(bar) => bar.println(text),
            None => {
                self.last_line = Some(Instant::now());
                terminal::note(text);
            }
        }
    }

    pub(super) fn show(&mut self, status: &JobStatus) {
        if let Some(bar) = &self.bar {
            bar.set_position((share_done(status) * STEPS as f64) as u64);
            let columns = usize::from(Term::stderr().size().1).saturating_sub(BAR_COLUMNS);
            bar.set_message(description(status, columns));
            return;
        }
        // A change of state is said at once, progress now and then.
        let state = state(status);
        if state != self.last_state || self.last_line.is_none_or(|last| last.elapsed() >= LINE_INTERVAL) {
            self.last_state = state;
            self.last_line = Some(Instant::now());
            terminal::note(&description(status, usize::MAX));
        }
    }

    pub(super) fn show_sequence(&mut self, status: &SequenceStatus) {
        let SequenceStatus { frames_done, frames_total, progress, .. } = status;
        let left = status.seconds_left.map(|left| format!(", {left:.0} s left")).unwrap_or_default();
        let text = format!("{frames_done} of {frames_total} frames, {:.0} %{left}", 100.0 * progress);
        let paused = if status.state == SequenceState::Paused { ", paused" } else { "" };
        let waiting = status.waiting.as_ref().map(|reason| format!(", waiting: {reason}")).unwrap_or_default();
        let text = text + &waiting;
        if let Some(bar) = &self.bar {
            bar.set_position((progress * STEPS as f64) as u64);
            return bar.set_message(text + paused);
        }
        if self.last_line.is_none_or(|last| last.elapsed() >= LINE_INTERVAL) {
            self.last_line = Some(Instant::now());
            terminal::note(&(text + paused));
        }
    }

    /// Removes the bar and says how the job ended.
    pub(super) fn finish_with(&self, status: &JobStatus) {
        self.finish();
        let error = error_bound(status).map(|error| format!(", {error}")).unwrap_or_default();
        let (state, passes, seconds) = (status.state.name(), status.passes_done, status.seconds);
        terminal::note(&format!("{state}: {}, {seconds:.0} s{error}", passes_of(passes)));
    }

    /// Removes the bar.
    pub(super) fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

/// How much of the job is done, 0 to 1, by whichever end comes first.
fn share_done(status: &JobStatus) -> f64 {
    let by_passes = status.passes_total.map_or(0.0, |total| f64::from(status.passes_done) / f64::from(total.max(1)));
    let by_seconds = status.stop.seconds.map_or(0.0, |total| status.seconds / total);
    let bound = status.estimated_error.map_or(f64::INFINITY, |error| error.bound);
    let by_error = status.stop.error.map_or(0.0, |wanted| wanted / bound);
    by_passes.max(by_seconds).max(by_error).clamp(0.0, 1.0)
}

/// What a job waits for, or does before it traces; `None` while it makes progress.
fn state(status: &JobStatus) -> Option<String> {
    let passes = status.passes_done;
    if let Some(since) = status.waiting_for_workers_since {
        return Some(format!("{}, waiting for workers since {}", passes_of(passes), time_of_day(since)));
    }
    match (status.state, &status.paused) {
        (JobState::Queued, _) if status.waiting_for_memory => {
            Some("waiting for memory that other jobs hold".to_owned())
        }
        (JobState::Queued, _) => Some("waiting for a worker".to_owned()),
        (JobState::Choosing, _) => Some("trying methods".to_owned()),
        (JobState::Paused, Some(reason)) => Some(format!("{}, {reason}", passes_of(passes))),
        _ => None,
    }
}

/// How the job is doing, in at most so many columns if the least of it fits.
fn description(status: &JobStatus, columns: usize) -> String {
    if let Some(state) = state(status) {
        return state;
    }
    let passes = match status.passes_total {
        Some(total) => format!("{} of {}", status.passes_done, passes_of(total)),
        None => passes_of(status.passes_done),
    };
    let left = status.seconds_left.map(|left| format!("{left:.0} s left"));
    // Each with its rank: where columns are few, the highest numbers give way.
    let told = [
        (1, Some(passes)),
        (0, left),
        (2, error_bound(status)),
        (3, Some(format!("{:.0} s so far", status.seconds))),
        (4, Some(rate(status))),
    ];
    let up_to = |rank: i32| {
        let parts = told.iter().filter(|(own, _)| *own <= rank).filter_map(|(_, part)| part.as_deref());
        parts.collect::<Vec<_>>().join(", ")
    };
    (1..=4).rev().map(up_to).find(|text| text.len() <= columns).unwrap_or_else(|| up_to(1))
}

/// The bound of the estimated error; `None` while none is known.
fn error_bound(status: &JobStatus) -> Option<String> {
    status.estimated_error.map(|error| format!("relMSE < {:.2e}", error.bound))
}

/// Hours, minutes and seconds of a time, in UTC.
fn time_of_day(unix_seconds: u64) -> String {
    let [hours, minutes, seconds] = [unix_seconds / 3600 % 24, unix_seconds / 60 % 60, unix_seconds % 60];
    format!("{hours:02}:{minutes:02}:{seconds:02} UTC")
}

/// How often chains accepted what was proposed to them, with a comma before it; nothing for methods without chains.
pub(super) fn acceptance(status: &JobStatus) -> String {
    let share = |of: &Acceptance| {
        let percent = 100.0 * of.accepted as f64 / of.proposed.max(1) as f64;
        format!(", {percent:.0} % of {} accepted", of.proposal.replace('_', " "))
    };
    status.acceptance.iter().map(share).collect()
}

/// A number of passes in words.
pub(super) fn passes_of(passes: u32) -> String {
    if passes == 1 { "1 pass".to_owned() } else { format!("{passes} passes") }
}

/// Photons per second in words, of methods that emit none the samples of pixels.
pub(super) fn rate(status: &JobStatus) -> String {
    if status.photons_emitted > 0 {
        return format!("{:.2} million photons/s", status.photons_per_second / 1e6);
    }
    let samples = f64::from(status.width) * f64::from(status.height) * f64::from(status.passes_done);
    let per_second = if status.seconds > 0.0 { samples / status.seconds } else { 0.0 };
    format!("{:.2} million samples/s", per_second / 1e6)
}
