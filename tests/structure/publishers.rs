//! What a process that speaks with strangers may publish: what is forged there must not pass for something else of the run.

use std::collections::BTreeSet;
use std::fs;

use crate::floors::{root, rust_files};

/// A process, and all that its sources open to publish on; its heartbeat and the answers to commands are the library's.
const PUBLISHES: &[(&str, &[&str])] = &[
    (
        "localizer-proc",
        &["&EMITTERS", "&EVENT", "&MARKERS", "UsImagePublisher"],
    ),
    ("gateway-proc", &[]),
];

/// The topic of each publisher that a text opens, or the publisher's own name where the topic is within it.
fn opened(text: &str) -> BTreeSet<String> {
    text.match_indices("Publisher::")
        .filter_map(|(at, _)| {
            let (before, call) = (&text[..at], &text[at..]);
            let (call, arguments) = call.split_once('(')?;
            call.contains("::open").then(|| {
                let arguments = arguments.split(')').next().unwrap_or_default();
                let topic = arguments
                    .split(',')
                    .map(str::trim)
                    .find(|word| word.starts_with("&") && *word == word.to_uppercase());
                let start = before.rfind(|c: char| !c.is_alphanumeric()).map_or(0, |k| k + 1);
                topic.map_or_else(|| format!("{}Publisher", &before[start..]), str::to_owned)
            })
        })
        .collect()
}

#[test]
fn who_speaks_with_strangers_publishes_what_it_is_for_and_nothing_else() {
    for (process, allowed) in PUBLISHES {
        let mut found = BTreeSet::new();
        let mut files = Vec::new();
        rust_files(&root().join(process).join("src"), &mut files);
        assert!(!files.is_empty());
        for file in files {
            let text = fs::read_to_string(&file).unwrap();
            let own = text.split("#[cfg(test)]\nmod tests {").next().unwrap();
            found.extend(opened(own));
        }
        let allowed: BTreeSet<String> = allowed.iter().map(|name| (*name).to_owned()).collect();
        assert_eq!(found, allowed, "{process}");
    }
}

#[test]
fn what_is_opened_is_found_however_it_is_written() {
    let text = "Publisher::open(&process.bus, &MARKERS, \"\")?; HeadedPublisher::<H, u8>::open(\n    &bus,\n    &TOOL_POSE,\n    1,\n); FramePublisher::open_once(&bus, room)";
    let expected = ["&MARKERS", "&TOOL_POSE", "FramePublisher"];
    assert_eq!(opened(text), expected.into_iter().map(str::to_owned).collect());
}
