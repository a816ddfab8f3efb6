//! What a file that was made of a damaged one says of that: the new file is whole, and what is lost must not be forgotten with it.

use std::collections::BTreeMap;
use std::path::Path;

use mcap::records::Metadata;

use crate::read::damage::Damage;

/// The name of the metadata record. A file that was made whole twice has two: each says what was lost then.
pub(crate) const RECOVERED: &str = "recovered";
/// So many places are written down in words, the rest is counted.
const IN_WORDS: usize = 20;

/// The record of what could not be read of `input`; `None` where all was there.
pub(crate) fn record(input: &Path, damage: &[Damage]) -> Option<Metadata> {
    if damage.is_empty() {
        return None;
    }
    let is_end = |damage: &&Damage| damage.fault.is_mere_ending();
    let unreadable = damage.iter().filter(|damage| !is_end(damage)).count();
    let mut lost = BTreeMap::new();
    for topic in damage
        .iter()
        .filter_map(|damage| damage.lost.as_ref())
        .flat_map(|lost| &lost.topics)
    {
        *lost.entry(topic.topic.as_str()).or_insert(0_u64) += topic.count;
    }
    let lost: Vec<String> = lost
        .iter()
        .map(|(topic, count)| format!("{count} of {topic}"))
        .collect();
    let file = input.file_name().unwrap_or_default().to_string_lossy();
    let mut facts = BTreeMap::from([
        ("file".to_owned(), file.into_owned()),
        ("unreadable".to_owned(), unreadable.to_string()),
        ("lost".to_owned(), lost.join(", ")),
        (
            "is_cut_off".to_owned(),
            damage.iter().any(|damage| is_end(&damage)).to_string(),
        ),
    ]);
    if let Some(stop) = damage.iter().find(|damage| damage.stops) {
        facts.insert("read_to".to_owned(), stop.at.to_string());
    }
    let places = damage.iter().take(IN_WORDS).enumerate();
    facts.extend(places.map(|(k, damage)| (format!("place_{:02}", k + 1), damage.to_string())));
    Some(Metadata {
        name: RECOVERED.to_owned(),
        metadata: facts,
    })
}

/// What such a record says, in words that go on behind `it was made of`.
pub(crate) fn words(facts: &BTreeMap<String, String>) -> String {
    let fact = |key: &str| facts.get(key).map_or("", String::as_str);
    let mut words = match fact("file") {
        "" => "a file that was not whole".to_owned(),
        file => format!("{file}, which was not whole"),
    };
    match fact("unreadable") {
        "" | "0" => {}
        unreadable => words.push_str(&format!(": {unreadable} places of it could not be read")),
    }
    if !fact("lost").is_empty() {
        words.push_str(&format!("; known to be lost are {}", fact("lost")));
    }
    if fact("is_cut_off") == "true" {
        words.push_str("; it ended before its recording did");
    }
    words
}

#[cfg(test)]
mod tests {
    use crate::edit::{cut, recover};
    use crate::read::{info, verify};
    use crate::testing;

    /// It was "whole", and nothing said that a third of it was lost.
    #[test]
    fn what_was_lost_is_told_by_the_file_that_was_made_whole() {
        let tmp = tempfile::tempdir().unwrap();
        let at = |name: &str| tmp.path().join(name);
        std::fs::write(at("s.mcap"), testing::damaged()).unwrap();
        recover::recover(&at("s.mcap"), &at("once.mcap")).unwrap();
        let stretch = cut::Stretch {
            from_ns: 0,
            to_ns: u64::MAX,
        };
        cut::cut(&at("s.mcap"), stretch, &at("cut.mcap"), false).unwrap();
        // Cut short, and made whole again: what was lost first is still told.
        let once = std::fs::read(at("once.mcap")).unwrap();
        std::fs::write(at("once.mcap.recording"), &once[..once.len() - 20]).unwrap();
        recover::recover(&at("once.mcap.recording"), &at("twice.mcap")).unwrap();
        let lost = "s.mcap, which was not whole: 2 places of it could not be read; known to be lost are 5 of /emitters, \
                    5 of /ground_truth, 10 of /tf, 5 of /tool_pose";
        for name in ["once.mcap", "cut.mcap", "twice.mcap"] {
            let said = info::info(&at(name)).unwrap().to_string();
            assert!(said.contains(&format!("It was made of {lost}")), "{name}: {said}");
            assert!(!said.contains("The file is whole.\n"), "{name}: {said}");
            let verified = verify::verify(&at(name)).unwrap();
            assert_eq!(verified.found, 0, "{name}: {:?}", verified.findings);
            let told = verified.left_out.iter().any(|words| words.contains(lost));
            assert!(told, "{name}: {:?}", verified.left_out);
        }
        let said = info::info(&at("twice.mcap")).unwrap().to_string();
        assert!(
            said.contains("once.mcap.recording, which was not whole; it ended before"),
            "{said}"
        );
    }

    #[test]
    fn of_a_whole_file_nothing_is_said() {
        let tmp = tempfile::tempdir().unwrap();
        let (from, to) = (tmp.path().join("s.mcap"), tmp.path().join("t.mcap"));
        std::fs::write(&from, testing::finished(2, 5)).unwrap();
        recover::recover(&from, &to).unwrap();
        assert!(info::info(&to).unwrap().to_string().ends_with("The file is whole.\n"));
    }
}
