//! Whether a recording is of one run: a pose of one drawn in the examination, or by the scene, of another would be a patient's in another's CT.

use std::collections::BTreeMap;

use mcap::Attachment;
use mcap::records::Metadata;

use crate::read::scan::Item;
use crate::wire::schema::{RUN, SCENE};

/// What the records of one run say alike, where they say it.
const SAME: [&str; 3] = ["name", "epoch_ns", "volume_hash"];
/// So much of a value is told, characters.
const TOLD: usize = 64;

/// What was said of the run so far.
#[derive(Debug, Default, Clone, PartialEq)]
pub(crate) struct OneRun {
    known: BTreeMap<&'static str, String>,
    scene: Option<blake3::Hash>,
}

impl OneRun {
    /// What lies beside the messages and is of another run than what came before it, in words.
    pub(crate) fn beside(&mut self, item: &Item) -> Option<String> {
        match item {
            Item::Attachment(file) => self.another_scene(file),
            Item::Metadata(record) => self.differs(record),
            _ => None,
        }
    }

    /// What a record says of another run than those before it, in words.
    fn differs(&mut self, record: &Metadata) -> Option<String> {
        let values = SAME.iter().filter(|_| record.name == RUN);
        let mut values = values.filter_map(|key| Some((*key, record.metadata.get(*key)?)));
        values.find_map(|(key, found)| {
            let expected = self.known.entry(key).or_insert_with(|| found.clone());
            let told = |text: &str| text.chars().take(TOLD).collect::<String>();
            (expected != found).then(|| {
                let (found, expected) = (told(found), told(expected));
                format!("it holds two runs: a record {RUN:?} has {key} {found:?}, and one before it {expected:?}")
            })
        })
    }

    /// That an attached scene is another than one before it, in words.
    fn another_scene(&mut self, file: &Attachment<'_>) -> Option<String> {
        if file.name != SCENE {
            return None;
        }
        let found = blake3::hash(&file.data);
        let expected = *self.scene.get_or_insert(found);
        (found != expected).then(|| {
            let told = |hash: blake3::Hash| hash.to_hex()[..8].to_owned();
            let (found, expected) = (told(found), told(expected));
            format!("it holds two scenes: an attached {SCENE} has BLAKE3 {found}, and one before it {expected}")
        })
    }
}
