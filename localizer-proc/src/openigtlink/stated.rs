//! What a message states of a tool beside its pose, by the keys of its metadata.
//!
//! A key that speaks of a status and is not the one that is read, is not none: who writes `transformStatus` has said something.

use igtl::{DeviceName, Metadata, TRANSFORM_STATUS, ToolStatus};

use super::names::{BYTES, Names, cut};

/// What the keys of a status end with, and of a tool's status begin with its name.
const STATUS: &str = "Status";

/// Of a TRANSFORM or POSITION.
///
/// # Errors
/// Words that say which key is not understood.
pub(super) fn of_transform(metadata: &Metadata) -> Result<ToolStatus, String> {
    understood(metadata, TRANSFORM_STATUS, ToolStatus::of_transform(metadata), |_| {
        false
    })
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
    let key = format!("{whole}{STATUS}");
    if name.as_bytes().len() < BYTES {
        return understood(metadata, &key, own, is_of_another);
    }
    let keys = metadata.entries().iter().map(|entry| entry.key.as_str());
    let stems = keys.filter_map(|key| key.strip_suffix(STATUS));
    let is_other = |stem: &&str| cut(stem) == name.as_bytes() && **stem != whole;
    let others: Vec<&str> = stems.filter(is_other).collect();
    match (&own, others.as_slice()) {
        (_, []) => understood(metadata, &key, own, is_of_another),
        // A peer whose own name of the tool has these 20 bytes.
        (ToolStatus::Absent, [only]) if only.as_bytes() == name.as_bytes() => {
            let key = format!("{only}{STATUS}");
            understood(metadata, &key, ToolStatus::of_tool(metadata, only), is_of_another)
        }
        _ => {
            let others = others.join(", ");
            Err(format!(
                "the peer means {others}, which is {name} within {BYTES} bytes, or both"
            ))
        }
    }
}

/// `own`, which stands under `key`, unless another key speaks of a status: any that is nobody else's where nothing stands under `key`, and
/// one that is nearly `key` and says anything but OK.
fn understood(
    metadata: &Metadata,
    key: &str,
    own: ToolStatus,
    is_of_another: impl Fn(&str) -> bool,
) -> Result<ToolStatus, String> {
    let is_unread = |other: &str, value: &[u8]| {
        let may_mean_it = match own {
            ToolStatus::Absent => letters(other).contains(&letters(STATUS)),
            _ => letters(other) == letters(key) && value != b"OK",
        };
        other != key && may_mean_it && !is_of_another(other)
    };
    let mut entries = metadata.entries().iter();
    match entries.find(|entry| is_unread(&entry.key, &entry.value.bytes)) {
        None => Ok(own),
        Some(entry) => {
            let found: String = entry.key.chars().take(MOST).collect();
            Err(format!("{found:?} states what cannot be read: the key is {key:?}"))
        }
    }
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

    /// `transformStatus = MISSING` counted as no status at all: a valid pose, where the scene says that an absent one is.
    #[test]
    fn a_status_under_a_key_that_is_nearly_right_is_not_none() {
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
        let markers = PosedMarkers {
            marker: Some("Tool".to_owned()),
            marker_from_tool: Rigid::identity(),
            reference: Some(("Ref".to_owned(), Rigid::identity())),
            noise: None,
        };
        let names = Names::new(&markers).unwrap();
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
}
