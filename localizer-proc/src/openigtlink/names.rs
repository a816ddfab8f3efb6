//! The names of tools on the wire, and which marker of the scene each is.
//!
//! A name on the wire has at most 20 bytes, and PLUS cuts longer ones there: so does the scene's name before it is compared.

use bus::message::MarkerFrame;
use igtl::DeviceName;
use scene::tracking::PosedMarkers;

/// Bytes of a name on the wire.
pub(super) const BYTES: usize = 20;
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
    /// Where the scene names no tool: the names that came on this connection and those before, but the reference's.
    only: Vec<DeviceName>,
    /// How many of them came before this connection.
    before: usize,
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
            before: 0,
            unmapped: Vec::new(),
            has_more: false,
        })
    }

    /// The numbers of the markers that are looked for.
    pub(super) fn markers(&self) -> Vec<u32> {
        let reference = self.reference.as_ref().map(|_| MarkerFrame::REFERENCE);
        [MarkerFrame::TOOL].into_iter().chain(reference).collect()
    }

    /// Another connection: its peer may use other names. What was the surgeon's tool stays it, as another instrument may be there now.
    pub(super) fn forget(&mut self) {
        self.before = self.only.len();
        self.unmapped.clear();
        self.has_more &= self.tool.is_none();
    }

    /// Where the scene names no tool: the names that came.
    pub(super) fn came(&self) -> Vec<Vec<u8>> {
        self.only.iter().map(|name| name.as_bytes().to_vec()).collect()
    }

    /// These came before, to another process. One that is cut in the middle of a letter is none of the wire's: it stays as something that every
    /// name differs from, as a name that is forgotten lets another instrument in.
    pub(super) fn go_on(&mut self, came: &[Vec<u8>]) {
        let names = came
            .iter()
            .map(|name| String::from_utf8_lossy(name).replace(char::REPLACEMENT_CHARACTER, "?"));
        let names = names.filter_map(|name| DeviceName::label(&name).ok());
        self.only = names.take(if self.tool.is_none() { LISTED } else { 0 }).collect();
        self.before = self.only.len();
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

    /// The name of a marker, for people.
    pub(super) fn of(&self, marker: u32) -> String {
        let own = match marker {
            MarkerFrame::REFERENCE => &self.reference,
            _ => &self.tool,
        };
        let only = || {
            self.only
                .first()
                .map_or_else(|| "the tool".to_owned(), ToString::to_string)
        };
        let name = own.as_ref().map(|bytes| String::from_utf8_lossy(bytes).into_owned());
        name.unwrap_or_else(only)
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

    /// The scene's names.
    pub(super) fn wholes(&self) -> impl Iterator<Item = &str> {
        self.whole.iter().map(String::as_str)
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

    /// Where the scene names no tool and the peer names several, now or over its connections: in words, and in a few of them.
    pub(super) fn ambiguous(&self) -> Option<(String, String)> {
        let (before, now) = self.only.split_at_checked(self.before)?;
        let (sent, one_of) = (
            self.list(&self.only),
            "tracker.markers.marker must say which is the tool's",
        );
        let words = match (before, now) {
            ([], [_, _, ..]) => format!("the peer sends {sent}: {one_of}"),
            ([_, ..], [_, ..]) => {
                let (before, now) = (self.list(before), self.list(now));
                format!(
                    "the tool was {before} on the connection before, and the peer sends {now}: none has a pose until the scene's \
                     tracker.markers.marker says which is the tool's, or `pilot restart localizer` takes the only one that comes then"
                )
            }
            ([_, _, ..], []) => format!(
                "the peer sent {sent} before: {one_of}, or `pilot restart localizer` takes the only one that comes then"
            ),
            _ => return None,
        };
        let few = match (before, now) {
            ([_, ..], [new, ..]) => format!("{new} is not {}", self.list(before)),
            _ => format!("which is the tool: {sent}?"),
        };
        Some((words, few))
    }

    /// The name that the surgeon's tool has where the scene names none, for the status.
    pub(super) fn used(&self) -> String {
        match self.only.as_slice() {
            [name] => format!(", tool {name}"),
            _ => String::new(),
        }
    }

    /// Names that come and that the scene does not name, for the status; how many, where it is more than one.
    pub(super) fn unmapped(&self) -> String {
        let more = if self.has_more { " or more" } else { "" };
        match self.unmapped.as_slice() {
            [] => String::new(),
            [name] => format!("not in the scene: {name}"),
            names => format!("{}{more} not in the scene: {}", names.len(), self.list(names)),
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
        assert_eq!(names.unmapped(), "not in the scene: stylustotracker");
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
        assert!(status.starts_with("8 or more not in the scene: N0, "), "{status}");
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
                .is_some_and(|(words, _)| words.contains("N7 and others:"))
        );
    }

    #[test]
    fn the_only_tool_needs_no_name_until_there_are_two() {
        let mut names = Names::new(&markers(None, Some("R"))).unwrap();
        for _ in 0..3 {
            assert_eq!(names.find(&name("R")), Named::Marker(1));
            assert_eq!(names.find(&name("A")), Named::Marker(0));
        }
        assert_eq!((names.ambiguous(), names.used()), (None, ", tool A".to_owned()));
        names.find(&name("B"));
        let words = "the peer sends A, B: tracker.markers.marker must say which is the tool's";
        let few = "which is the tool: A, B?";
        assert_eq!(names.ambiguous(), Some((words.to_owned(), few.to_owned())));
        assert_eq!(names.used(), "");
        // Which of them it was stays unknown on the next connection.
        names.forget();
        names.find(&name("A"));
        let (words, _) = names.ambiguous().unwrap();
        assert!(
            words.starts_with("the peer sent A, B before: ") && words.contains("`pilot restart localizer`"),
            "{words}"
        );
    }

    /// Names with other letters than those of ASCII, as lists have them, would be forgotten, and a drill be the tool.
    #[test]
    fn a_name_in_any_letters_is_known_to_the_process_that_follows() {
        let found = |came: &[u8], comes: &str| {
            let mut names = Names::new(&PosedMarkers {
                marker: None,
                marker_from_tool: geometry::Rigid::identity(),
                reference: None,
                noise: None,
            })
            .unwrap();
            names.go_on(&[came.to_vec()]);
            let _ = names.find(&DeviceName::label(comes).unwrap());
            names.ambiguous().is_some()
        };
        let pointer = "Zeigegerät".as_bytes();
        assert!(!found(pointer, "Zeigegerät") && found(pointer, "Drill"));
        // Twenty bytes that end in the middle of a letter.
        let cut = b"Langes Zeigeger\xc3\xa4t \xc3";
        assert!(found(cut, "Drill"));
    }

    /// The drill that was there after a connection had broken was the pointer that was there before, without a word.
    #[test]
    fn another_name_on_the_next_connection_is_not_the_tool_of_the_one_before() {
        let mut names = Names::new(&markers(None, None)).unwrap();
        names.find(&name("Pointer"));
        names.forget();
        names.find(&name("Pointer"));
        assert_eq!((names.ambiguous(), names.used()), (None, ", tool Pointer".to_owned()));
        names.forget();
        assert_eq!(names.find(&name("Drill")), Named::Marker(MarkerFrame::TOOL));
        let (words, few) = names.ambiguous().unwrap();
        assert!(
            words.starts_with(
                "the tool was Pointer on the connection before, and the peer sends Drill: none has a pose until"
            ),
            "{words}"
        );
        assert!(words.contains("`pilot restart localizer`"), "{words}");
        assert_eq!(few, "Drill is not Pointer");
    }
}
