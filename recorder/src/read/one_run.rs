//! Whether a recording is of one run: a pose of one drawn in the examination, or by the scene, of another would be a patient's in another's CT.

use std::collections::BTreeMap;

use mcap::records::Metadata;
use mcap::{Attachment, Message};
use prost::Message as _;

use crate::read::scan::Item;
use crate::wire::proto::Identity;
use crate::wire::schema::{IDENTITY_SCHEMA, RUN, SCENE};

/// What the records of one run say alike, where they say it.
const SAME: [&str; 3] = ["name", "epoch_ns", "volume_hash"];
/// So much of a value is told, characters.
const TOLD: usize = 64;

/// What was said of the run so far.
#[derive(Debug, Default, Clone, PartialEq)]
pub(crate) struct OneRun {
    known: BTreeMap<&'static str, String>,
    scene: Option<blake3::Hash>,
    /// Whose examination it is, by the fields that say so.
    person: BTreeMap<&'static str, String>,
}

impl OneRun {
    /// What is of another run, or of another person, than what came before it, in words.
    pub(crate) fn beside(&mut self, item: &Item) -> Option<String> {
        match item {
            Item::Attachment(file) => self.another_scene(file),
            Item::Metadata(record) => self.differs(record),
            Item::Message(message) => self.another_person(message),
            Item::Channel(_) => None,
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

    /// That an identity contradicts one before it, in words that name nobody.
    fn another_person(&mut self, message: &Message<'_>) -> Option<String> {
        let schema = message.channel.schema.as_ref().map_or("", |schema| &schema.name);
        let identity = match schema == IDENTITY_SCHEMA {
            true => Identity::decode(&*message.data).ok()?,
            false => return None,
        };
        let said = [
            ("name", identity.name),
            ("patient_id", identity.patient_id),
            ("birth_date", identity.birth_date),
        ];
        // What is not said contradicts nothing.
        let mut said = said.into_iter().filter(|(_, found)| !found.is_empty());
        said.find_map(|(field, found)| {
            let is_other = *self.person.entry(field).or_insert_with(|| found.clone()) != found;
            is_other.then(|| format!("it holds two people's identities: their {field:?} differ"))
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing;
    use crate::write::pose_log::Entry;

    /// The last of two was told as the recording's.
    #[test]
    fn two_peoples_identities_are_not_of_one_run() {
        let of = |identities: &[(&str, &str)]| {
            let mut log = testing::log(1, 3);
            log.with_identity().unwrap();
            for (name, patient_id) in identities {
                let identity = Identity {
                    name: (*name).to_owned(),
                    patient_id: (*patient_id).to_owned(),
                    ..Identity::default()
                };
                log.put(Entry::Identity(&identity)).unwrap();
            }
            let tmp = tempfile::tempdir().unwrap();
            let path = tmp.path().join("s.mcap");
            std::fs::write(&path, log.finish().unwrap().into_inner()).unwrap();
            let verified = crate::read::verify::verify(&path).unwrap().findings;
            let info = crate::read::info::info(&path).unwrap().of_two_runs;
            assert_eq!(verified.first(), info.as_ref());
            info
        };
        assert_eq!(of(&[("", ""), ("DOE^A", "7"), ("DOE^A", ""), ("DOE^A", "7")]), None);
        let words = |field: &str| Some(format!("it holds two people's identities: their {field:?} differ"));
        assert_eq!(of(&[("DOE^A", "7"), ("DOE^B", "7")]), words("name"));
        assert_eq!(of(&[("DOE^A", "7"), ("", "8")]), words("patient_id"));
    }
}
