//! What is told seldom and holds until it is told again, out of the whole of a recording: what a person chose, organs at rest.

use bus::message::Guide;

use super::Session;
use crate::read::damage::OpenError;
use crate::read::reader::{Messages, ReadError, Recorded, decode};
use crate::read::scan::Item;
use crate::wire::proto::MeshFrame;
use crate::wire::schema::{GUIDE, TISSUE_MESH};

/// More guides are not read: a file of nothing else must not fill the memory.
const MOST_GUIDES: usize = 1 << 16;
/// Nor are more meshes: a model that is started again publishes its mesh anew, and it is kept once.
const MOST_MESHES: usize = 16;
/// Nor more bytes of all meshes.
const MOST_BYTES: usize = 64 << 20;

/// Messages of a topic, in the order of the file, and what could not be read of it, in words.
#[derive(Debug)]
pub struct Found<T> {
    /// What can be read.
    pub messages: Vec<T>,
    /// What cannot.
    pub unread: Vec<String>,
}

impl Session {
    /// Every guide of the recording. Where its index can be relied on, only the chunks that hold some are read.
    ///
    /// # Errors
    /// [`OpenError::Io`].
    pub fn guides(&self) -> Result<Found<Guide>, OpenError> {
        self.few(GUIDE, "with what was chosen", |guides, _| guides.len() < MOST_GUIDES)
    }

    /// The organs at rest that a tube moves, alike.
    ///
    /// # Errors
    /// [`OpenError::Io`].
    pub fn meshes(&self) -> Result<Found<MeshFrame>, OpenError> {
        self.few(TISSUE_MESH, "with organs at rest", |known: &[MeshFrame], mesh| {
            let bytes: usize = known.iter().map(|mesh| mesh.bytes.len()).sum();
            let is_new = known.iter().all(|one| one.header.mesh_id != mesh.header.mesh_id);
            is_new && known.len() < MOST_MESHES && bytes + mesh.bytes.len() <= MOST_BYTES
        })
    }

    /// The messages of `topic` that `takes` wants beside those that it has.
    fn few<T: Recorded>(
        &self,
        topic: &str,
        with: &str,
        takes: impl Fn(&[T], &T) -> bool,
    ) -> Result<Found<T>, OpenError> {
        let mut found = Found {
            messages: Vec::new(),
            unread: Vec::new(),
        };
        let Ok(indexed) = self.indexed() else {
            for message in Messages::<T>::of(self.items_from(0)?, topic, 0) {
                let is_end = matches!(&message, Err(ReadError::Damage(damage)) if damage.stops);
                found.take(message, &takes);
                if is_end {
                    break;
                }
            }
            return Ok(found);
        };
        for chunk in indexed.chunks_of(topic) {
            match indexed.items(chunk)? {
                Some(items) => items.into_iter().for_each(|item| found.item(&item, topic, &takes)),
                None => found.unread.push(format!(
                    "its chunk at byte {}, {with}, cannot be read",
                    chunk.chunk_start_offset
                )),
            }
        }
        Ok(found)
    }
}

impl<T: Recorded> Found<T> {
    fn item(&mut self, item: &Item, topic: &str, takes: impl Fn(&[T], &T) -> bool) {
        if let Item::Message(message) = item
            && message.channel.topic == topic
        {
            self.take(decode(message), takes);
        }
    }

    fn take(&mut self, message: Result<T, ReadError>, takes: impl Fn(&[T], &T) -> bool) {
        match message {
            Ok(message) if takes(&self.messages, &message) => self.messages.push(message),
            Ok(_) => {}
            // Damage elsewhere in the file is told by those who read it there.
            Err(ReadError::Damage(_)) => {}
            Err(error) => self.unread.push(error.to_string()),
        }
    }
}
