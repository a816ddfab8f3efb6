//! Tools of messages as markers of the scene: each with a pose that counts, or the reason why there is none.

use bus::message::Lost;
use igtl::{DeviceName, Message, Stamp, ToolKind, ToolStatus, TypeName};
use scene::localizer::StatusRule;

use super::names::Named;
use super::pose::{PoseError, Tool, not_near};
use super::{OpenIgtLink, stamp_ns, stated, status};
use crate::driver::{Act, Frame, Seen};

/// A stamp and the kind of the message that has it.
type Said = (Stamp, TypeName);

impl OpenIgtLink {
    /// A message of one tool.
    pub(super) fn one(&mut self, message: &Message<'_>, pose: Result<Tool, PoseError>, acts: &mut Vec<Act>) {
        let said = (message.stamp, message.body.kind());
        let stated = stated::of_transform(&message.metadata);
        let Some(seen) = self.seen(said, &message.device, stated, pose, acts) else {
            return;
        };
        if self.instants.stand_still() {
            self.gather.never_combine();
        }
        let frames = self.gather.add(message.stamp, seen, self.now_ns);
        if self.gather.is_alone() && self.names.markers().len() > 1 {
            let words = "the peer's stamps do not say which poses are of one instant: those of tool and patient are not combined";
            self.doubt("stamps do not tell instants apart", words.to_owned(), acts);
        }
        acts.extend(frames.into_iter().map(Act::Frame));
    }

    /// A message of all tools of one instant. One that is not in it was not seen.
    pub(super) fn several(
        &mut self,
        message: &Message<'_>,
        tools: Vec<(DeviceName, ToolKind, Result<Tool, PoseError>)>,
        acts: &mut Vec<Act>,
    ) {
        acts.extend(self.gather.close().map(Act::Frame));
        let said = (message.stamp, message.body.kind());
        let names: Vec<DeviceName> = tools.iter().map(|(name, ..)| *name).collect();
        let mut all: Vec<Seen> = Vec::with_capacity(tools.len());
        for (name, kind, pose) in tools {
            let stated = stated::of_tool(&self.names, &message.metadata, &name, &names);
            let pose = match kind {
                ToolKind::Six => pose,
                // The turn of a 3D or 5D tool means nothing, and the tracker itself is no tool.
                other => Err(PoseError::Kind(other.word())),
            };
            let Some(seen) = self.seen(said, &name, stated, pose, acts) else {
                continue;
            };
            match all.iter_mut().find(|other| other.marker == seen.marker) {
                // Two tools that may be the surgeon's, where the scene names none: neither is.
                Some(other) => other.outcome = Err(Lost::Refused),
                None => all.push(seen),
            }
        }
        for marker in self.names.markers() {
            if self.instants.know(marker) && !all.iter().any(|seen| seen.marker == marker) {
                let _ = self.instants.judge(said, marker, Err(Lost::NotSeen), self.now_ns);
            }
        }
        acts.push(Act::Frame(Frame {
            device_ns: stamp_ns(message.stamp),
            first_ns: self.now_ns,
            arrival_ns: self.now_ns,
            asked_ns: self.now_ns,
            seen: all,
        }));
    }

    /// A tool of a message as a marker of the scene; none where the scene does not name it.
    fn seen(
        &mut self,
        said: Said,
        name: &DeviceName,
        stated: Result<ToolStatus, String>,
        pose: Result<Tool, PoseError>,
        acts: &mut Vec<Act>,
    ) -> Option<Seen> {
        let marker = match self.names.find(name) {
            Named::Marker(marker) => marker,
            Named::Unknown(words) => {
                acts.extend(self.told.say(words));
                return None;
            }
            Named::Known => return None,
        };
        // A peer that names two tools where the scene names none may mean either.
        if let Some((ambiguous, few)) = self.names.ambiguous() {
            self.doubt(&few, ambiguous, acts);
            let outcome = Err(Lost::Refused);
            return Some(Seen { marker, outcome });
        }
        let outcome = self.outcome(marker, name, stated, pose, acts);
        let (outcome, is_contradicted) = self.instants.judge(said, marker, outcome, self.now_ns);
        if is_contradicted {
            let words = format!(
                "the peer says of {name} under one stamp that it is seen and that it is not: it has no pose while that is so"
            );
            self.doubt(&format!("{name} is seen and lost under one stamp"), words, acts);
        }
        let seen = self.not_two(said.0, name, Seen { marker, outcome }, acts);
        Some(seen)
    }

    /// Its pose, where its status and its numbers are good.
    fn outcome(
        &mut self,
        marker: u32,
        name: &DeviceName,
        stated: Result<ToolStatus, String>,
        pose: Result<Tool, PoseError>,
        acts: &mut Vec<Act>,
    ) -> Result<(Tool, f64), Lost> {
        let has_stated = self.stated.contains(&marker);
        // What cannot be read is a status too.
        if !has_stated && stated != Ok(ToolStatus::Absent) {
            self.stated.push(marker);
        }
        let stated = match stated {
            Ok(ToolStatus::Absent) if has_stated && self.spec.status == StatusRule::AbsentMeansValid => {
                let words = format!(
                    "{name}: the peer states no status, and has stated one of this tool before; where another peer is there now, \
                     `pilot restart localizer`"
                );
                self.doubt(&format!("{name} has no status any more"), words, acts);
                return Err(Lost::Refused);
            }
            Ok(status) => status::judge(&status, self.spec.status).map_err(|(lost, words)| (status, lost, words)),
            Err(words) => return Err(self.refuse(name, &PoseError::Unclear(words), acts)),
        };
        if let Err((status, lost, words)) = stated {
            let few = status
                .word()
                .map_or("has no status".to_owned(), |word| format!("states {word:?}"));
            if matches!(lost, Lost::Refused | Lost::Disconnected) {
                self.reason.came(&format!("{name} {few}"), self.now_ns);
            }
            acts.extend(words.and_then(|words| self.told.say(format!("{name}: {words}"))));
            return Err(lost);
        }
        let least_mm = self.spec.least_distance_mm;
        match pose.and_then(|tool| not_near(tool, least_mm)) {
            Ok(tool) => Ok((tool, 0.0)),
            Err(error) => Err(self.refuse(name, &error, acts)),
        }
    }

    /// It, unless the peer has two tools of this name.
    fn not_two(&mut self, stamp: Stamp, name: &DeviceName, seen: Seen, acts: &mut Vec<Act>) -> Seen {
        if !self.twins.are_two(stamp, &seen, self.now_ns) {
            return seen;
        }
        let words =
            format!("the peer sends {name} twice at one time, at two places: two tools with one name have no pose");
        self.doubt(&format!("two tools are named {name}"), words, acts);
        self.gather.refuse(seen.marker);
        Seen {
            outcome: Err(Lost::Refused),
            ..seen
        }
    }

    /// A message that holds no pose is counted.
    fn refuse(&mut self, name: &DeviceName, error: &PoseError, acts: &mut Vec<Act>) -> Lost {
        acts.push(Act::Refused);
        let words = format!("{name}: {error}");
        self.doubt(&words.clone(), words, acts);
        Lost::Refused
    }

    /// Why a pose does not count, in a few words and in more.
    fn doubt(&mut self, few: &str, words: String, acts: &mut Vec<Act>) {
        self.reason.came(few, self.now_ns);
        acts.extend(self.told.say(words));
    }
}
