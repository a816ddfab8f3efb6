//! What a person chose, out of the whole of a recording: few messages, each of which holds until the next.

use bus::message::Guide;

use super::Session;
use crate::read::damage::OpenError;
use crate::read::reader::{Messages, ReadError, decode};
use crate::read::scan::Item;
use crate::wire::schema::GUIDE;

/// More are not read: a file of nothing else must not fill the memory.
const MOST: usize = 1 << 16;

/// What a person chose, in the order of the file, and what could not be read of it, in words.
#[derive(Debug, Default)]
pub struct Found {
    /// What can be read.
    pub guides: Vec<Guide>,
    /// What cannot.
    pub unread: Vec<String>,
}

impl Session {
    /// Every guide of the recording. Where its index can be relied on, only the chunks that hold some are read.
    ///
    /// # Errors
    /// [`OpenError::Io`].
    pub fn guides(&self) -> Result<Found, OpenError> {
        let mut found = Found::default();
        let Ok(indexed) = self.indexed() else {
            for guide in Messages::<Guide>::of(self.items_from(0)?, GUIDE, 0) {
                let is_end = matches!(&guide, Err(ReadError::Damage(damage)) if damage.stops);
                found.take(guide);
                if is_end {
                    break;
                }
            }
            return Ok(found);
        };
        for chunk in indexed.chunks_of(GUIDE) {
            match indexed.items(chunk)? {
                Some(items) => items.into_iter().for_each(|item| found.item(&item)),
                None => found.unread.push(format!(
                    "its chunk at byte {}, with what was chosen, cannot be read",
                    chunk.chunk_start_offset
                )),
            }
        }
        Ok(found)
    }
}

impl Found {
    fn item(&mut self, item: &Item) {
        if let Item::Message(message) = item
            && message.channel.topic == GUIDE
        {
            self.take(decode(message));
        }
    }

    fn take(&mut self, guide: Result<Guide, ReadError>) {
        match guide {
            Ok(guide) if self.guides.len() < MOST => self.guides.push(guide),
            Ok(_) => {}
            // Damage elsewhere in the file is told by those who read it there.
            Err(ReadError::Damage(_)) => {}
            Err(error) => self.unread.push(error.to_string()),
        }
    }
}
