//! What an import could not represent, each thing once with its first place.

use std::collections::HashMap;

use crate::scene::error::Location;
use crate::scene::notice::Notice;

/// Notices that differ in their place only are one, so that a big file does not make a long report.
#[derive(Default)]
pub(crate) struct Notices {
    list: Vec<Entry>,
    places: HashMap<(String, String), usize>,
}

struct Entry {
    notice: Notice,
    /// In how many places, and the last of them.
    count: usize,
    last: Location,
}

impl Notices {
    /// Adds a notice, or counts it if its subject was reported before.
    pub(crate) fn add(&mut self, notice: Notice) {
        let next = self.list.len();
        let place = *self.places.entry((notice.subject.clone(), notice.explanation.clone())).or_insert(next);
        match self.list.get_mut(place) {
            // A texture with two channels in use is read twice.
            Some(known) if known.last == notice.location => {}
            Some(known) => {
                known.count += 1;
                known.last = notice.location;
            }
            None => self.list.push(Entry { count: 1, last: notice.location.clone(), notice }),
        }
    }

    /// The notices in the order of their first places.
    pub(crate) fn into_list(self) -> Vec<Notice> {
        let finish = |Entry { mut notice, count, .. }: Entry| {
            if count > 1 {
                let space = if notice.explanation.is_empty() { "" } else { " " };
                notice.explanation.push_str(&format!("{space}({count} times)"));
            }
            notice
        };
        self.list.into_iter().map(finish).collect()
    }
}
