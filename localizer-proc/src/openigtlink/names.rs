//! The names of tools on the wire, and which marker of the scene each is.
//!
//! A name on the wire has at most 20 bytes, and PLUS cuts longer ones there: so does the scene's name before it is compared.

use bus::message::MarkerFrame;
use igtl::{DeviceName, Metadata, ToolStatus};
use scene::tracking::PosedMarkers;

/// Bytes of a name on the wire.
const BYTES: usize = 20;
/// Names that nobody asked for are listed up to this number.
const LISTED: usize = 8;

/// Why the scene's names cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum NamesError {
    /// They differ behind what goes over the wire.
    #[error(
        "tracker.markers: {tool:?} and {reference:?} are one name within the {BYTES} bytes that OpenIGTLink has for it; name the tools \
         otherwise at the peer"
    )]
    Same {
        /// The tool's.
        tool: String,
        /// The patient's.
        reference: String,
    },
}

/// A name of the scene as it is on the wire.
pub(super) fn cut(name: &str) -> Vec<u8> {
    name.as_bytes().iter().take(BYTES).copied().collect()
}

/// What a name is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Named {
    /// This marker.
    Marker(u32),
    /// None, and it comes for the first time: in words.
    Unknown(String),
    /// None, as was told.
    Known,
}

/// The names.
#[derive(Debug, Clone)]
pub(super) struct Names {
    tool: Option<Vec<u8>>,
    reference: Option<Vec<u8>>,
    /// As the scene has them.
    whole: Vec<String>,
    /// Where the scene names no tool: the names that came, but the reference's.
    only: Vec<DeviceName>,
    unmapped: Vec<DeviceName>,
    /// There are more than [`LISTED`].
    has_more: bool,
}

impl Names {
    pub(super) fn new(markers: &PosedMarkers) -> Result<Self, NamesError> {
        let (tool, reference) = (
            markers.marker.as_ref(),
            markers.reference.as_ref().map(|(name, _)| name),
        );
        if let (Some(tool), Some(reference)) = (tool, reference)
            && cut(tool) == cut(reference)
        {
            let (tool, reference) = (tool.clone(), reference.clone());
            return Err(NamesError::Same { tool, reference });
        }
        Ok(Self {
            tool: tool.map(|name| cut(name)),
            reference: reference.map(|name| cut(name)),
            whole: [tool, reference].into_iter().flatten().cloned().collect(),
            only: Vec::new(),
            unmapped: Vec::new(),
            has_more: false,
        })
    }

    /// The numbers of the markers that are looked for.
    pub(super) fn markers(&self) -> Vec<u32> {
        let reference = self.reference.as_ref().map(|_| MarkerFrame::REFERENCE);
        [MarkerFrame::TOOL].into_iter().chain(reference).collect()
    }

    /// Another peer may use other names.
    pub(super) fn forget(&mut self) {
        self.only.clear();
        self.unmapped.clear();
        self.has_more = false;
    }

    /// What `name` is.
    pub(super) fn find(&mut self, name: &DeviceName) -> Named {
        let bytes = name.as_bytes();
        if self.reference.as_deref() == Some(bytes) {
            return Named::Marker(MarkerFrame::REFERENCE);
        }
        match &self.tool {
            Some(tool) if tool == bytes => Named::Marker(MarkerFrame::TOOL),
            Some(_) => self.unknown(name),
            None => {
                match self.only.len() < LISTED {
                    _ if self.only.contains(name) => {}
                    true => self.only.push(*name),
                    false => self.has_more = true,
                }
                Named::Marker(MarkerFrame::TOOL)
            }
        }
    }

    /// The scene's name of a tool that has this one on the wire: the status of a TDATA has a key of the whole name.
    pub(super) fn whole(&self, name: &DeviceName) -> String {
        let is_it = |whole: &&String| whole.as_bytes().iter().take(BYTES).eq(name.as_bytes());
        self.whole
            .iter()
            .find(is_it)
            .cloned()
            .unwrap_or_else(|| name.to_string())
    }

    /// What a TDATA or QTDATA says of the tool of this name, or the words that say that it may be of another one: PLUS cuts the names of
    /// tools to 20 bytes and the keys of their status not, so that two tools, or another than the scene's, may have one name.
    pub(super) fn status(&self, metadata: &Metadata, name: &DeviceName) -> Result<ToolStatus, String> {
        let whole = self.whole(name);
        let own = ToolStatus::of_tool(metadata, &whole);
        if name.as_bytes().len() < BYTES {
            return Ok(own);
        }
        let keys = metadata.entries().iter().map(|entry| entry.key.as_str());
        let stems = keys.filter_map(|key| key.strip_suffix("Status"));
        let is_other = |stem: &&str| stem.as_bytes().iter().take(BYTES).eq(name.as_bytes()) && **stem != whole;
        let others: Vec<&str> = stems.filter(is_other).collect();
        match (&own, others.as_slice()) {
            (_, []) => Ok(own),
            // A peer whose own name of the tool has these 20 bytes.
            (ToolStatus::Absent, [only]) if only.as_bytes() == name.as_bytes() => {
                Ok(ToolStatus::of_tool(metadata, only))
            }
            _ => {
                let others = others.join(", ");
                Err(format!(
                    "the peer means {others}, which is {name} within {BYTES} bytes, or both"
                ))
            }
        }
    }

    fn unknown(&mut self, name: &DeviceName) -> Named {
        if self.has_more || self.unmapped.contains(name) {
            return Named::Known;
        }
        if self.unmapped.len() >= LISTED {
            self.has_more = true;
            return Named::Unknown(format!(
                "the peer sends {name}, which the scene does not name, beside {LISTED} others; what comes more is not listed"
            ));
        }
        self.unmapped.push(*name);
        Named::Unknown(format!("the peer sends {name}, which the scene does not name"))
    }

    /// Where the scene names no tool and the peer names several, in words.
    pub(super) fn ambiguous(&self) -> Option<String> {
        (self.only.len() > 1).then(|| {
            let names = self.list(&self.only);
            format!("the peer sends {names}: tracker.markers.marker must say which is the tool's")
        })
    }

    /// Names that come and that the scene does not name, for the status.
    pub(super) fn unmapped(&self) -> String {
        match self.unmapped.as_slice() {
            [] => String::new(),
            names => format!(", not in the scene: {}", self.list(names)),
        }
    }

    fn list(&self, names: &[DeviceName]) -> String {
        let names: Vec<String> = names.iter().map(ToString::to_string).collect();
        let more = if self.has_more { " and others" } else { "" };
        format!("{}{more}", names.join(", "))
    }
}

#[cfg(test)]
mod tests {
    use geometry::Rigid;

    use super::*;

    fn markers(tool: Option<&str>, reference: Option<&str>) -> PosedMarkers {
        PosedMarkers {
            marker: tool.map(str::to_owned),
            marker_from_tool: Rigid::identity(),
            reference: reference.map(|name| (name.to_owned(), Rigid::identity())),
            noise: None,
        }
    }

    fn name(text: &str) -> DeviceName {
        DeviceName::new(text).unwrap()
    }

    #[test]
    fn names_are_those_of_the_scene_and_others_are_told_once() {
        let mut names = Names::new(&markers(Some("StylusToTracker"), Some("ReferenceToTrackerOfTheRoom"))).unwrap();
        assert_eq!(names.markers(), [0, 1]);
        assert_eq!(names.find(&name("StylusToTracker")), Named::Marker(0));
        // Cut at 20 bytes, as it comes.
        assert_eq!(names.find(&name("ReferenceToTrackerOf")), Named::Marker(1));
        assert_eq!(
            names.whole(&name("ReferenceToTrackerOf")),
            "ReferenceToTrackerOfTheRoom"
        );
        assert_eq!(names.whole(&name("Other")), "Other");
        let told = "the peer sends stylustotracker, which the scene does not name".to_owned();
        assert_eq!(names.find(&name("stylustotracker")), Named::Unknown(told));
        assert_eq!(names.find(&name("stylustotracker")), Named::Known);
        assert_eq!(names.unmapped(), ", not in the scene: stylustotracker");
        names.forget();
        assert_eq!(names.unmapped(), "");
        let same = markers(Some("StylusToTrackerOfTheRoom"), Some("StylusToTrackerOfTheHall"));
        let error = Names::new(&same).unwrap_err().to_string();
        assert!(error.contains("are one name within the 20 bytes"), "{error}");
    }

    /// From the ninth on they were neither told nor listed.
    #[test]
    fn names_beyond_the_list_are_told_to_be_there() {
        let mut names = Names::new(&markers(Some("Tool"), None)).unwrap();
        let many: Vec<DeviceName> = (0..12).map(|k| name(&format!("N{k}"))).collect();
        let told = many.iter().filter(|name| matches!(names.find(name), Named::Unknown(_)));
        assert_eq!(told.count(), LISTED + 1);
        let status = names.unmapped();
        assert!(status.ends_with("N6, N7 and others"), "{status}");
        names.forget();
        assert!(matches!(names.find(&many[11]), Named::Unknown(_)));
        let mut unnamed = Names::new(&markers(None, None)).unwrap();
        for name in &many {
            assert_eq!(unnamed.find(name), Named::Marker(MarkerFrame::TOOL));
        }
        assert!(
            unnamed
                .ambiguous()
                .is_some_and(|words| words.contains("N7 and others:"))
        );
    }

    #[test]
    fn the_only_tool_needs_no_name_until_there_are_two() {
        let mut names = Names::new(&markers(None, Some("R"))).unwrap();
        for _ in 0..3 {
            assert_eq!(names.find(&name("R")), Named::Marker(1));
            assert_eq!(names.find(&name("A")), Named::Marker(0));
        }
        assert_eq!(names.ambiguous(), None);
        names.find(&name("B"));
        let words = "the peer sends A, B: tracker.markers.marker must say which is the tool's";
        assert_eq!(names.ambiguous().as_deref(), Some(words));
    }
}
