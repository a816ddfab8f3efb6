//! Tools of messages as markers of the scene: each with a pose that counts, or the reason why there is none.

use bus::message::Lost;
use igtl::{DeviceName, Message, Stamp, ToolKind, ToolStatus};
use scene::localizer::StatusRule;

use super::names::Named;
use super::pose::{PoseError, Tool, not_near};
use super::sources::Source;
use super::{OpenIgtLink, stamp_ns, stated, status};
use crate::driver::{Act, Frame, Seen};

/// A stamp and the kind of the message that has it.
type Said = (Stamp, Source);

impl OpenIgtLink {
    /// A message of one tool.
    pub(super) fn one(&mut self, message: &Message<'_>, pose: Result<Tool, PoseError>, acts: &mut Vec<Act>) {
        let (stamp, from) = (message.stamp, Source::one(message.body.kind()));
        let stated = stated::of_transform(&self.names, &message.metadata, &message.device);
        let Some(seen) = self.seen((stamp, from), &message.device, stated, pose, acts) else {
            return;
        };
        if self.instants.stand_still() {
            self.gather.never_combine();
        }
        let taken = self.sources.take(from, stamp, vec![seen], self.now_ns);
        self.tell_of_sources(&taken.news, acts);
        for seen in taken.lost {
            // Of what is being gathered it goes out with the rest.
            if let Err(lost) = seen.outcome
                && !self.gather.lose(seen.marker, lost)
            {
                self.go_out(Some(self.at_once(stamp, vec![seen])), acts);
            }
        }
        for seen in taken.frame {
            let frames = self.gather.add(stamp, seen, self.now_ns);
            self.doubt_of_gathering(&message.device, &seen, acts);
            self.go_out(frames, acts);
        }
    }

    /// A message of all tools of one instant. One that is not in it was not seen, unless it belongs to another list.
    pub(super) fn several(
        &mut self,
        message: &Message<'_>,
        tools: Vec<(DeviceName, ToolKind, Result<Tool, PoseError>)>,
        acts: &mut Vec<Act>,
    ) {
        let (stamp, from) = (message.stamp, Source::list(message.body.kind(), message.device));
        let mut all = self.listed((stamp, from), message, tools, acts);
        let in_it: Vec<u32> = all.iter().map(|seen| seen.marker).collect();
        for marker in self.names.markers() {
            if !in_it.contains(&marker) && self.sources.loses(marker, message.device) {
                let outcome = Err(Lost::NotSeen);
                let (outcome, _) = self.instants.judge((stamp, from), marker, outcome, self.now_ns);
                all.push(Seen { marker, outcome });
            }
        }
        let is_first = self.sources.are_none();
        let taken = self.sources.take(from, stamp, all, self.now_ns);
        in_it
            .into_iter()
            .for_each(|marker| self.sources.list_has(marker, message.device));
        self.tell_of_sources(&taken.news, acts);
        for seen in &taken.lost {
            let _ = self
                .gather
                .lose(seen.marker, seen.outcome.err().unwrap_or(Lost::Refused));
        }
        let seen = [taken.frame, taken.lost].concat();
        if is_first || !seen.is_empty() {
            let gathered = self.gather.close();
            self.go_out(gathered, acts);
            self.go_out(Some(self.at_once(stamp, seen)), acts);
        }
    }

    /// The markers that are in a list, each once.
    fn listed(
        &mut self,
        said: Said,
        message: &Message<'_>,
        tools: Vec<(DeviceName, ToolKind, Result<Tool, PoseError>)>,
        acts: &mut Vec<Act>,
    ) -> Vec<Seen> {
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
        all
    }

    /// What came in this moment.
    fn at_once(&self, stamp: Stamp, seen: Vec<Seen>) -> Frame {
        Frame {
            device_ns: stamp_ns(stamp),
            first_ns: self.now_ns,
            arrival_ns: self.now_ns,
            asked_ns: self.now_ns,
            seen,
        }
    }

    /// Frames go out.
    pub(super) fn go_out(&mut self, frames: impl IntoIterator<Item = Frame>, acts: &mut Vec<Act>) {
        for frame in frames {
            let are_apart = self.together.are_apart(&frame, self.now_ns);
            if are_apart && !self.gather.is_alone() {
                self.doubt_of_stamps(acts);
            }
            acts.push(Act::Frame(frame));
        }
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
        let (outcome, against) = self.instants.judge(said, marker, outcome, self.now_ns);
        if let Some(against) = against {
            self.doubt_of_peer(name, against, acts);
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
}
