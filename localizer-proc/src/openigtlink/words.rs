//! What is told of poses that do not count, to the log and in the status.

use bus::message::Lost;
use igtl::{DeviceName, Stamp};

use super::OpenIgtLink;
use super::instants::Against;
use super::pose::PoseError;
use super::sources::News;
use crate::driver::{Act, Seen};

impl OpenIgtLink {
    /// How a peer contradicts itself.
    pub(super) fn doubt_of_peer(&mut self, name: &DeviceName, against: Against, acts: &mut Vec<Act>) {
        let (few, words) = match against {
            Against::Stamp => (
                "is seen and lost under one stamp",
                "under one stamp that it is seen and that it is not",
            ),
            Against::Kind => (
                "is seen and lost at one time",
                "in one kind of message that it is seen and in another that it is not",
            ),
            Against::Pose => (
                "is at two places under one stamp",
                "in two kinds of message under one stamp that it is at two places, or turned in two ways",
            ),
        };
        let words = format!("the peer says of {name} {words}: it has no pose while that is so");
        self.doubt(&format!("{name} {few}"), words, acts);
    }

    /// Which kind of message makes the frames of a marker, where there are two.
    pub(super) fn tell_of_sources(&mut self, news: &[News], acts: &mut Vec<Act>) {
        for news in news {
            let words = match news {
                News::LeftOut(marker, used, other) => {
                    acts.push(Act::Refused);
                    let name = self.names.of(*marker);
                    format!("{name} comes as {used} and as {other}: {other} is not used")
                }
                News::TookOver(marker, before, now) => {
                    let name = self.names.of(*marker);
                    format!("{name} comes as {now} and no longer as {before}: {now} is used now")
                }
            };
            acts.extend(self.told.say(words));
        }
    }

    /// Why the newest message, of this tool, is in no frame with others.
    pub(super) fn doubt_of_gathering(&mut self, name: &DeviceName, seen: &Seen, acts: &mut Vec<Act>) {
        if self.gather.is_alone() && self.names.markers().len() > 1 {
            let words = "the peer's stamps do not say which poses are of one instant: those of tool and patient are not combined";
            self.doubt("stamps do not tell instants apart", words.to_owned(), acts);
        }
        if self.gather.is_late() && seen.outcome.is_ok() {
            acts.push(Act::Refused);
            let words = format!("{name} comes when the frame of its stamp has gone out: such a pose is left out");
            self.doubt(&format!("{name} comes too late for its frame"), words, acts);
        }
    }

    /// Why poses come and none is of the tool in the patient.
    pub(super) fn doubt_of_stamps(&mut self, acts: &mut Vec<Act>) {
        let (few, words) = match self.instants.share_a_stamp(&self.names.markers()) {
            true => (
                "tool and patient are never in one frame",
                "poses of tool and patient come, and those of one stamp too far apart or in lists of their own: there is none of the tool in \
                 the patient",
            ),
            false => (
                "tool and patient never have one stamp",
                "poses of tool and patient come, and never under one stamp: nothing says which are of one instant, and there is none of the \
                 tool in the patient",
            ),
        };
        self.doubt(few, words.to_owned(), acts);
    }

    /// It, unless the peer has two tools of this name.
    pub(super) fn not_two(&mut self, stamp: Stamp, name: &DeviceName, seen: Seen, acts: &mut Vec<Act>) -> Seen {
        if !self.twins.are_two(stamp, &seen, self.now_ns) {
            return seen;
        }
        let words =
            format!("the peer sends {name} twice at one time, at two places: two tools with one name have no pose");
        self.doubt(&format!("two tools are named {name}"), words, acts);
        let _ = self.gather.lose(seen.marker, Lost::Refused);
        Seen {
            outcome: Err(Lost::Refused),
            ..seen
        }
    }

    /// A message that holds no pose is counted.
    pub(super) fn refuse(&mut self, name: &DeviceName, error: &PoseError, acts: &mut Vec<Act>) -> Lost {
        acts.push(Act::Refused);
        let words = format!("{name}: {error}");
        self.doubt(&words.clone(), words, acts);
        Lost::Refused
    }

    /// Why a pose does not count, in a few words and in more.
    pub(super) fn doubt(&mut self, few: &str, words: String, acts: &mut Vec<Act>) {
        self.reason.came(few, self.now_ns);
        acts.extend(self.told.say(words));
    }
}
