//! A localizer of NDI: its tools as frames of markers.

use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use bus::message::{Lost, MarkerFrame};
use ndi::session::{Action, Client, ClientRules, Event, Notice, Poll, Tool};
use ndi::{Markers, Pose, Rom, RomError, Why};
use scene::localizer::NdiSpec;
use scene::tracking::PosedMarkers;

use crate::driver::{Act, Driver, Follows, Frame, Seen};

mod pose;
mod single;
mod told;

use pose::UNIT_TOLERANCE;
use single::{ShapeError, Single};
use told::Told;

/// The longest file of a tool definition: what devices hold is 1024 bytes, and files may be padded.
const MOST_BYTES: u64 = 64 << 10;

/// Why a localizer cannot be set up.
#[derive(Debug, thiserror::Error)]
pub enum SetUpError {
    /// A definition cannot be read.
    #[error("the tool definition {path}: {source}")]
    Read {
        /// Its file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// What stands in it is none.
    #[error("the tool definition {path}: {source}")]
    Rom {
        /// Its file.
        path: PathBuf,
        /// What is wrong with it.
        source: RomError,
    },
    /// The emitters of the scene are not the markers of the tool.
    #[error(transparent)]
    Shape(#[from] ShapeError),
    /// The scene leaves open which tool is meant.
    #[error("localizer.tools has {found} tools, and tracker.markers.marker does not say which is the surgeon's")]
    Which {
        /// How many it has.
        found: usize,
    },
}

/// The client's side.
pub(crate) struct Ndi {
    session: Client,
    /// The tools that are markers of the scene: their names at the device, and their numbers on the bus.
    markers: Vec<(String, u32)>,
    /// Single markers are published in place of their poses.
    single: Option<Single>,
    poll_ns: i64,
    sent_ns: i64,
    told: Told,
    /// What the device says of itself, in words that no other words begin with.
    words: String,
    /// When it was looked at last.
    now_ns: i64,
}

impl Ndi {
    /// Not connected yet; the definitions are read and checked.
    ///
    /// # Errors
    /// [`SetUpError`].
    pub(crate) fn new(spec: &NdiSpec, follows: Follows<'_>) -> Result<Self, SetUpError> {
        let tools = spec.tools.iter().map(|(name, path)| {
            Ok(Tool {
                name: name.clone(),
                rom: rom(path)?,
                priority: 'D',
            })
        });
        let mut rules = ClientRules {
            tools: tools.collect::<Result<_, SetUpError>>()?,
            tolerance: UNIT_TOLERANCE,
            ..ClientRules::default()
        };
        let (markers, single) = match (follows, &spec.single) {
            (Follows::Markers(markers), _) => (named(spec, markers)?, None),
            (Follows::Emitters(source), Some(single)) => {
                // BX and TX do not say which marker of a tool is which.
                (rules.markers, rules.poll) = (Markers::Tools, Some(Poll::Bx2));
                (Vec::new(), Some(Single::new(single, source, &rules.tools)?))
            }
            (Follows::Emitters(_), None) => {
                return Err(SetUpError::Which {
                    found: spec.tools.len(),
                });
            }
        };
        Ok(Self {
            markers,
            single,
            poll_ns: rules.poll_ns,
            session: Client::new(rules),
            sent_ns: 0,
            told: Told::default(),
            words: String::new(),
            now_ns: 0,
        })
    }

    fn carry_out(&mut self, actions: Vec<Action>, now_ns: i64) -> Vec<Act> {
        let mut acts = Vec::new();
        self.now_ns = now_ns;
        // A reply is to the question before: the next one may be among the actions already.
        let asked_ns = self.sent_ns;
        for action in actions {
            match action {
                Action::Send(bytes) => {
                    self.sent_ns = now_ns;
                    acts.push(Act::Send(bytes));
                }
                Action::Publish(frame, _) => acts.extend(self.published(&frame, (asked_ns, now_ns))),
                Action::Tell(notice) => {
                    if let Notice::Version(version) = &notice {
                        self.words = device_words(version);
                    }
                    acts.extend(self.told.notice(&notice, now_ns));
                }
                Action::Close(reason) => acts.push(Act::Close(reason.to_string())),
                // A network has no speed.
                Action::Speed(_) => {}
            }
        }
        acts
    }

    fn published(&mut self, frame: &ndi::Frame, times: (i64, i64)) -> Vec<Act> {
        let Some(single) = &mut self.single else {
            return self.frame(frame, times).map(Act::Frame).into_iter().collect();
        };
        let places = single.places(frame, |name| self.session.handle(name));
        let of = Frame::of_device(frame.device_ns, times, Vec::new());
        let published = places.map(|places| Act::Emitters(of, places));
        let told = single.words().and_then(|words| self.told.say(words));
        published.into_iter().chain(told).collect()
    }

    /// The markers of a frame. One in which the device did not look for any of them says nothing of them: passive and active
    /// tools alternate.
    fn frame(&mut self, frame: &ndi::Frame, times: (i64, i64)) -> Option<Frame> {
        let mut seen = Vec::with_capacity(self.markers.len());
        let mut is_about_them = false;
        for (name, marker) in &self.markers {
            let sight = self.session.handle(name).and_then(|handle| frame.tool(handle));
            let outcome = sight.map_or(Err(Why::NotInFrame), ndi::Sight::pose);
            is_about_them |= outcome != Err(Why::NotInFrame);
            let outcome = match outcome {
                Ok(pose) => posed(&pose),
                Err(why) => Err(lost(why)),
            };
            seen.push(Seen {
                marker: *marker,
                outcome,
            });
        }
        is_about_them.then(|| Frame::of_device(frame.device_ns, times, seen))
    }
}

/// The tools that are markers of the scene, with their numbers on the bus.
fn named(spec: &NdiSpec, markers: &PosedMarkers) -> Result<Vec<(String, u32)>, SetUpError> {
    let reference = markers.reference.as_ref().map(|(name, _)| name);
    let mut others = spec
        .tools
        .iter()
        .map(|(name, _)| name)
        .filter(|name| Some(*name) != reference);
    let tool = match (&markers.marker, others.next(), others.next()) {
        (Some(name), ..) => name,
        (None, Some(only), None) => only,
        (None, ..) => {
            return Err(SetUpError::Which {
                found: spec.tools.len(),
            });
        }
    };
    let reference = reference.map(|name| (name.clone(), MarkerFrame::REFERENCE));
    Ok([(tool.clone(), MarkerFrame::TOOL)]
        .into_iter()
        .chain(reference)
        .collect())
}

fn posed(pose: &Pose) -> Result<(geometry::Rigid<geometry::Tracker, geometry::Marker>, f64), Lost> {
    let rigid = pose::rigid(pose).map_err(|_| Lost::Refused)?;
    Ok((rigid, pose.error_mm))
}

/// What a device says of itself, for the status. In quotes, so that it passes for nobody's words but its own.
fn device_words(version: &str) -> String {
    let line: String = version.lines().next().unwrap_or_default().chars().take(40).collect();
    format!("device {line:?}")
}

/// What a device says of a tool, as a reason of the bus: one table.
fn lost(why: Why) -> Lost {
    match why {
        Why::Missing | Why::NotInFrame => Lost::NotSeen,
        Why::OutOfVolume | Why::PartlyOutOfVolume | Why::SaturatedOutOfVolume => Lost::OutOfVolume,
        Why::TooFewMarkers => Lost::TooFew,
        Why::Interference | Why::Saturated => Lost::Interference,
        Why::BadFit | Why::MarkerError => Lost::Residual,
        Why::Disabled | Why::Unplugged | Why::NotInitialized => Lost::Disconnected,
        // The device measured something that it does not stand for itself, or a status that nobody knows.
        Why::Valid
        | Why::PartlyAveraged
        | Why::BufferLimit
        | Why::AlgorithmLimit
        | Why::FellBehind
        | Why::OutOfSync
        | Why::ProcessingError
        | Why::SteepAngle
        | Why::Phantom
        | Why::Refused(_)
        | Why::Unknown { .. } => Lost::Refused,
    }
}

/// A tool definition, bounded before it is held.
pub(crate) fn rom(path: &Path) -> Result<Rom, SetUpError> {
    let failed = |source| SetUpError::Read {
        path: path.to_owned(),
        source,
    };
    // Asked for before opening: opening a pipe would wait for its writer.
    if !std::fs::metadata(path).map_err(failed)?.is_file() {
        return Err(failed(io::Error::other("this is not a file")));
    }
    let mut bytes = Vec::new();
    File::open(path)
        .map_err(failed)?
        .take(MOST_BYTES)
        .read_to_end(&mut bytes)
        .map_err(failed)?;
    Rom::checked(&bytes).map_err(|source| SetUpError::Rom {
        path: path.to_owned(),
        source,
    })
}

impl Driver for Ndi {
    fn connected(&mut self, now_ns: i64) -> Vec<Act> {
        self.told = Told::default();
        self.single.iter_mut().for_each(Single::forget);
        "setting up".clone_into(&mut self.words);
        let actions = self.session.step(Event::Connected, now_ns);
        self.carry_out(actions, now_ns)
    }

    fn bytes(&mut self, bytes: &[u8], now_ns: i64) -> Vec<Act> {
        let actions = self.session.step(Event::Bytes(bytes), now_ns);
        self.carry_out(actions, now_ns)
    }

    fn tick(&mut self, now_ns: i64) -> Vec<Act> {
        let actions = self.session.step(Event::Tick, now_ns);
        self.carry_out(actions, now_ns)
    }

    fn closed(&mut self, now_ns: i64) -> Vec<Act> {
        let actions = self.session.step(Event::Closed, now_ns);
        self.carry_out(actions, now_ns)
    }

    fn due_ns(&self) -> Option<i64> {
        self.session
            .is_tracking()
            .then_some(self.sent_ns.saturating_add(self.poll_ns))
    }

    fn wrong(&self) -> String {
        self.told.wrong(self.now_ns)
    }

    fn words(&self) -> String {
        self.told.before(&self.words, self.now_ns)
    }

    fn markers(&self) -> Vec<u32> {
        self.markers.iter().map(|(_, marker)| *marker).collect()
    }

    fn reconnects(&self) -> bool {
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The first line of VER began the status, and the pilot believed what it said of a queue.
    #[test]
    fn what_a_device_calls_itself_passes_for_no_words_of_the_localizer() {
        let said = device_words(&format!("{}9999\nmore", bus::message::MAY_BE_OLDER));
        assert_eq!(said, "device \"poses may be older by ms: 9999\"");
        assert_eq!(bus::message::may_be_older_ms(&said), None);
        assert_eq!(device_words("a\u{1b}[2K"), "device \"a\\u{1b}[2K\"");
    }

    #[test]
    fn every_reason_of_a_device_has_one_of_the_bus() {
        let unknown = Why::Unknown { field: "x", code: 1 };
        for (why, expected) in [
            (Why::Missing, Lost::NotSeen),
            (Why::NotInFrame, Lost::NotSeen),
            (Why::OutOfVolume, Lost::OutOfVolume),
            (Why::PartlyOutOfVolume, Lost::OutOfVolume),
            (Why::SaturatedOutOfVolume, Lost::OutOfVolume),
            (Why::TooFewMarkers, Lost::TooFew),
            (Why::Interference, Lost::Interference),
            (Why::Saturated, Lost::Interference),
            (Why::BadFit, Lost::Residual),
            (Why::MarkerError, Lost::Residual),
            (Why::Disabled, Lost::Disconnected),
            (Why::Unplugged, Lost::Disconnected),
            (Why::NotInitialized, Lost::Disconnected),
            (Why::Valid, Lost::Refused),
            (Why::PartlyAveraged, Lost::Refused),
            (Why::BufferLimit, Lost::Refused),
            (Why::AlgorithmLimit, Lost::Refused),
            (Why::FellBehind, Lost::Refused),
            (Why::OutOfSync, Lost::Refused),
            (Why::ProcessingError, Lost::Refused),
            (Why::SteepAngle, Lost::Refused),
            (Why::Phantom, Lost::Refused),
            (unknown, Lost::Refused),
        ] {
            assert_eq!(lost(why), expected, "{why:?}");
        }
    }
}
