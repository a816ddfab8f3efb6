//! What a message states of a tool beside its pose, by the keys of its metadata.
//!
//! A key that speaks of a status and is not the one that is read, is not none: who writes `transformStatus` has said something.

use igtl::{DeviceName, Metadata, TRANSFORM_STATUS, ToolStatus};

use super::names::{BYTES, Names, cut};

/// What the keys of a status end with, and of a tool's status begin with its name.
const STATUS: &str = "Status";
/// What the key of a TRANSFORM's begins with.
const TRANSFORM: &str = "Transform";

/// Of a TRANSFORM or POSITION of the tool of this name, which may say otherwise under the keys of a list.
///
/// # Errors
/// Words that say which key is not understood.
pub(super) fn of_transform(names: &Names, metadata: &Metadata, name: &DeviceName) -> Result<ToolStatus, String> {
    let own = ToolStatus::of_transform(metadata);
    let whole = names.whole(name);
    let keys = Keys {
        own: TRANSFORM_STATUS,
        is_of_it: &|key| is_of(key, name, &whole),
        is_of_another: &|_| false,
    };
    understood(metadata, &keys, own)
}

/// Of the tool of this name of a TDATA or QTDATA, which has these `tools`. PLUS cuts the names of tools to 20 bytes and the keys of their
/// status not, so that two tools, or another than the scene's, may have one name.
///
/// # Errors
/// Words that say whose status it may be too, or which key is not understood.
pub(super) fn of_tool(
    names: &Names,
    metadata: &Metadata,
    name: &DeviceName,
    tools: &[DeviceName],
) -> Result<ToolStatus, String> {
    let whole = names.whole(name);
    let own = ToolStatus::of_tool(metadata, &whole);
    let is_of_another = |key: &str| {
        let stem = key.strip_suffix(STATUS).map(cut);
        let is_it = |bytes: &[u8]| stem.as_deref() == Some(bytes) && bytes != name.as_bytes();
        tools.iter().any(|tool| is_it(tool.as_bytes())) || names.wholes().any(|whole| is_it(&cut(whole)))
    };
    let understood_as = |key: &str, own: ToolStatus| {
        let keys = Keys {
            own: key,
            is_of_it: &|key| is_of(key, name, &whole),
            is_of_another: &is_of_another,
        };
        understood(metadata, &keys, own)
    };
    let key = format!("{whole}{STATUS}");
    if name.as_bytes().len() < BYTES {
        return understood_as(&key, own);
    }
    let keys = metadata.entries().iter().map(|entry| entry.key.as_str());
    let stems = keys.filter_map(|key| key.strip_suffix(STATUS));
    let is_other = |stem: &&str| cut(stem) == name.as_bytes() && **stem != whole;
    let others: Vec<&str> = stems.filter(is_other).collect();
    match (&own, others.as_slice()) {
        (_, []) => understood_as(&key, own),
        // A peer whose own name of the tool has these 20 bytes.
        (ToolStatus::Absent, [only]) if only.as_bytes() == name.as_bytes() => {
            understood_as(&format!("{only}{STATUS}"), ToolStatus::of_tool(metadata, only))
        }
        _ => {
            let others = others.join(", ");
            Err(format!(
                "the peer means {others}, which is {name} within {BYTES} bytes, or both"
            ))
        }
    }
}

/// Which keys speak of the status of one tool.
struct Keys<'a> {
    /// The one that is read.
    own: &'a str,
    is_of_it: &'a dyn Fn(&str) -> bool,
    is_of_another: &'a dyn Fn(&str) -> bool,
}

/// `own`, which stands under its key, unless another key speaks of a status: any that is nobody else's where nothing stands under that one,
/// one that is nearly it and says anything but OK, and one that names the tool and says anything but OK and the same.
fn understood(metadata: &Metadata, keys: &Keys<'_>, own: ToolStatus) -> Result<ToolStatus, String> {
    let said = own.word().map(str::as_bytes);
    let is_unread = |other: &str, value: &[u8]| {
        let may_mean_it = match own {
            ToolStatus::Absent => letters(other).contains(&letters(STATUS)),
            _ if value == b"OK" => false,
            _ => letters(other) == letters(keys.own) || ((keys.is_of_it)(other) && said != Some(value)),
        };
        other != keys.own && may_mean_it && !(keys.is_of_another)(other)
    };
    let mut entries = metadata.entries().iter();
    match entries.find(|entry| is_unread(&entry.key, &entry.value.bytes)) {
        None => Ok(own),
        Some(entry) => {
            let found: String = entry.key.chars().take(MOST).collect();
            let key = keys.own;
            Err(format!("{found:?} states what cannot be read: the key is {key:?}"))
        }
    }
}

/// Whether a key is nearly one that speaks of the status of the tool of this name, whole or cut, in a message of one tool or in a list.
fn is_of(key: &str, name: &DeviceName, whole: &str) -> bool {
    let key_letters = letters(key);
    let Some(stem) = key_letters.strip_suffix(&letters(STATUS)) else {
        return false;
    };
    let whole = letters(whole);
    let is_name = |stem: &str| !whole.is_empty() && stem == whole;
    let of_transform = letters(TRANSFORM);
    let is_cut = name.as_bytes().len() == BYTES
        && key
            .strip_suffix(STATUS)
            .is_some_and(|stem| cut(stem) == name.as_bytes());
    let is_its = is_name(stem) || stem.strip_suffix(&of_transform).is_some_and(is_name);
    is_its || is_cut || stem == of_transform || key.strip_suffix(STATUS) == Some(&*name.to_string())
}

/// Characters of a peer's key that are told.
const MOST: usize = 40;

/// Letters and digits alone, all small.
fn letters(key: &str) -> String {
    let all = key.chars().filter(char::is_ascii_alphanumeric);
    all.map(|letter| letter.to_ascii_lowercase()).collect()
}

#[cfg(test)]
mod tests {
    use geometry::Rigid;
    use igtl::{Text, US_ASCII};
    use scene::tracking::PosedMarkers;

    use super::*;

    fn metadata(entries: &[(&str, &str)]) -> Metadata {
        entries.iter().fold(Metadata::EMPTY, |all, (key, word)| {
            let bytes = word.as_bytes().to_vec();
            let encoding = US_ASCII;
            all.with(key, Text { encoding, bytes })
        })
    }

    fn names() -> Names {
        let markers = PosedMarkers {
            marker: Some("Tool".to_owned()),
            marker_from_tool: Rigid::identity(),
            reference: Some(("Ref".to_owned(), Rigid::identity())),
            noise: None,
        };
        Names::new(&markers).unwrap()
    }

    /// `transformStatus = MISSING` counted as no status at all: a valid pose, where the scene says that an absent one is.
    #[test]
    fn a_status_under_a_key_that_is_nearly_right_is_not_none() {
        let (names, tool) = (names(), DeviceName::new("Tool").unwrap());
        let of_transform = |metadata: &Metadata| of_transform(&names, metadata, &tool);
        for key in [
            "transformStatus",
            "TransformStatus ",
            "Status",
            "TRANSFORM_STATUS",
            "tool status",
        ] {
            let words = of_transform(&metadata(&[(key, "MISSING")])).unwrap_err();
            assert!(
                words.contains(&format!("{key:?} states")) && words.contains("TransformStatus"),
                "{words}"
            );
        }
        let other = metadata(&[("TransformStatus", "OK"), ("ScannerStatus", "COLD")]);
        assert_eq!(of_transform(&other), Ok(ToolStatus::Ok));
        let twice = [("TransformStatus", "OK"), ("transformStatus", "MISSING")];
        assert!(of_transform(&metadata(&twice)).is_err());
        assert_eq!(of_transform(&metadata(&[("Frame", "7")])), Ok(ToolStatus::Absent));
    }

    /// So did `toolStatus` of a list that has the tool `Tool`.
    #[test]
    fn a_status_of_a_list_belongs_to_one_of_its_tools_or_of_the_scene_s() {
        let names = names();
        let name = |text: &str| DeviceName::new(text).unwrap();
        let tools = [name("Tool"), name("Other")];
        let found = |entries: &[(&str, &str)]| of_tool(&names, &metadata(entries), &tools[0], &tools);
        for key in ["TransformStatus", "toolStatus", "Tool_Status", "Toolstatus", "Status"] {
            assert!(found(&[("RefStatus", "OK"), (key, "MISSING")]).is_err(), "{key}");
        }
        for entries in [
            &[][..],
            &[("RefStatus", "MISSING")],
            &[("OtherStatus", "MISSING"), ("RefStatus", "OK")],
        ] {
            assert_eq!(found(entries), Ok(ToolStatus::Absent), "{entries:?}");
        }
        assert_eq!(
            found(&[("ToolStatus", "OK"), ("HallStatus", "MISSING")]),
            Ok(ToolStatus::Ok)
        );
        assert!(found(&[("ToolStatus", "OK"), ("toolStatus", "MISSING")]).is_err());
    }

    /// A TRANSFORM with `TransformStatus` = OK and `ToolStatus` = MISSING was LIVE: keys with other letters were not looked at.
    #[test]
    fn a_good_status_beside_another_of_the_same_tool_is_no_good_pose() {
        const LONG: &str = "ToolOfTwentyBytesInAllAndMore";
        let (names, name) = (names(), |text: &str| DeviceName::new(text).unwrap());
        for (tool, key) in [
            ("Tool", "ToolStatus"),
            ("Tool", "tool_status"),
            ("Tool", "ToolTransformStatus"),
            ("ToolOfTwentyBytesInA", &format!("{LONG}Status")),
            ("_", "_Status"),
        ] {
            let found = |own, other| {
                of_transform(
                    &names,
                    &metadata(&[("TransformStatus", own), (key, other)]),
                    &name(tool),
                )
            };
            assert!(found("OK", "MISSING").is_err(), "{key}");
            assert_eq!(found("OK", "OK"), Ok(ToolStatus::Ok), "{key}");
            assert_eq!(found("MISSING", "MISSING"), Ok(ToolStatus::Missing), "{key}");
        }
        for key in ["RefStatus", "Tool2Status", "ToolBatteryStatus"] {
            let both = metadata(&[("TransformStatus", "OK"), (key, "MISSING")]);
            assert_eq!(of_transform(&names, &both, &name("Tool")), Ok(ToolStatus::Ok), "{key}");
        }
        // And a list with the key of a TRANSFORM.
        let tools = [name("Tool"), name("Transform")];
        let both = metadata(&[("ToolStatus", "OK"), ("TransformStatus", "MISSING")]);
        assert!(of_tool(&names, &both, &tools[0], &tools[..1]).is_err());
        // Unless that is another tool's.
        assert_eq!(of_tool(&names, &both, &tools[0], &tools), Ok(ToolStatus::Ok));
    }
}
