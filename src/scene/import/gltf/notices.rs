//! What an import could not represent, each thing once with its first place.

use std::collections::HashMap;

use super::super::report::Notice;

/// Notices that differ in their place only are one, so that a big file does not make a long report.
#[derive(Default)]
pub(super) struct Notices {
    list: Vec<(Notice, usize)>,
    places: HashMap<(String, String), usize>,
}

impl Notices {
    /// Adds a notice, or counts it if its subject was reported before.
    pub(super) fn add(&mut self, notice: Notice) {
        let next = self.list.len();
        let place = *self.places.entry((notice.subject.clone(), notice.explanation.clone())).or_insert(next);
        match self.list.get_mut(place) {
            Some((_, count)) => *count += 1,
            None => self.list.push((notice, 1)),
        }
    }

    /// The notices in the order of their first places.
    pub(super) fn into_list(self) -> Vec<Notice> {
        let finish = |(mut notice, count): (Notice, usize)| {
            if count > 1 {
                let comma = if notice.explanation.is_empty() { "" } else { ", " };
                notice.explanation = format!("{}{comma}here and in {} more places", notice.explanation, count - 1);
            }
            notice
        };
        self.list.into_iter().map(finish).collect()
    }
}
