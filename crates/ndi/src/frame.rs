//! A frame for whoever uses it: every tool with a pose or a reason, every marker with a place or a reason.

use crate::bx2::{Bx2, Bx2Frame, FrameKind};
use crate::fields::Fields;
use crate::handle::Handle;
use crate::polled::{Polled, PolledTool, Spots};
use crate::pose::{Pose, PoseError, Transform, check_place};
use crate::why::Why;

/// All that a device saw at one moment.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame {
    /// The device's number of it; `None` where TX or BX gave strays alone.
    pub number: Option<u32>,
    /// For which tools; `None` of TX and BX, which do not say it.
    pub kind: Option<FrameKind>,
    /// Which of several of its kind that have one number; 0 of TX and BX.
    pub index: u8,
    /// When it was taken, ns of the device's own clock; `None` of TX and BX, which do not say it.
    pub device_ns: Option<i64>,
    /// Tools, each once.
    pub tools: Vec<Sight>,
    /// Single markers, of a tool or of none.
    pub markers: Vec<Marker>,
}

/// A tool as it was seen, or why not.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sight {
    handle: Handle,
    outcome: Result<Pose, Why>,
}

/// A single marker as it was seen, or why not.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Marker {
    tool: Option<Handle>,
    index: u16,
    outcome: Result<[f64; 3], Why>,
}

impl Sight {
    /// A tool of which this is said, with this transform.
    fn new(handle: Handle, why: Why, transform: Option<&Transform>, tolerance: f64) -> Self {
        let outcome = match (why, transform) {
            (Why::Valid, Some(transform)) => transform.check(tolerance).map_err(Why::Refused),
            (Why::Valid, None) => Err(Why::Refused(PoseError::Absent)),
            (why, _) => Err(why),
        };
        Self { handle, outcome }
    }

    /// Which tool.
    pub const fn handle(&self) -> Handle {
        self.handle
    }

    /// `tracker_from_tool` in the device's frame.
    ///
    /// # Errors
    /// Why there is none; never [`Why::Valid`].
    pub const fn pose(&self) -> Result<Pose, Why> {
        self.outcome
    }

    /// [`Why::Valid`], or why not.
    pub fn why(&self) -> Why {
        self.outcome.err().unwrap_or(Why::Valid)
    }
}

impl Marker {
    fn new(tool: Option<Handle>, index: u16, why: Why, place_mm: Option<&[f64; 3]>) -> Self {
        let outcome = match (why, place_mm) {
            (Why::Valid, Some(place)) => check_place(place, "place").map(|()| *place).map_err(Why::Refused),
            (Why::Valid, None) => Err(Why::Refused(PoseError::Absent)),
            (why, _) => Err(why),
        };
        Self { tool, index, outcome }
    }

    /// Of which tool; `None` for a stray.
    pub const fn tool(&self) -> Option<Handle> {
        self.tool
    }

    /// Which of its tool, from 0; strays are counted.
    pub const fn index(&self) -> u16 {
        self.index
    }

    /// Where, mm, in the device's frame.
    ///
    /// # Errors
    /// Why not; never [`Why::Valid`].
    pub const fn place_mm(&self) -> Result<[f64; 3], Why> {
        self.outcome
    }
}

impl Frame {
    /// The frames of a reply to BX2; a quaternion may be `tolerance` off its length.
    pub fn of_bx2(reply: &Bx2, tolerance: f64) -> Vec<Self> {
        reply
            .frames
            .iter()
            .map(|frame| Self::of_frame(frame, tolerance))
            .collect()
    }

    fn of_frame(frame: &Bx2Frame, tolerance: f64) -> Self {
        // What is wrong with the frame is wrong with all that is in it.
        let whole = frame.status.why();
        let both = |why: Why| if why.is_valid() { whole } else { why };
        let tool = |tool: &crate::bx2::Bx2Tool| {
            Sight::new(tool.handle, both(tool.status.why()), tool.transform.as_ref(), tolerance)
        };
        let markers = frame.markers.iter().flat_map(|list| {
            let of = (list.handle != Handle::STRAY).then_some(list.handle);
            let one = move |marker: &crate::bx2::Bx2Marker| {
                Marker::new(of, marker.index, both(marker.status.why()), Some(&marker.place_mm))
            };
            list.markers.iter().map(one)
        });
        Self {
            number: Some(frame.number),
            kind: Some(frame.kind),
            index: frame.index,
            device_ns: Some(frame.device_ns),
            tools: frame.tools.iter().map(tool).collect(),
            markers: markers.collect(),
        }
    }

    /// The frames of a reply to TX or BX: tools with one number are of one frame, and stand first in it. A tool without a
    /// number (a disabled one) is in all; strays are of the last one.
    pub fn of_polled(reply: &Polled, tolerance: f64) -> Vec<Self> {
        let mut frames: Vec<Self> = Vec::new();
        for tool in &reply.tools {
            if tool.frame.is_some() && !frames.iter().any(|frame| frame.number == tool.frame) {
                frames.push(Self::empty(tool.frame));
            }
        }
        if frames.is_empty() {
            frames.push(Self::empty(None));
        }
        for frame in &mut frames {
            let number = frame.number;
            let of_it = reply
                .tools
                .iter()
                .filter(|tool| tool.frame.is_some() && tool.frame == number);
            let of_all = reply.tools.iter().filter(|tool| tool.frame.is_none());
            of_it.chain(of_all).for_each(|tool| frame.add(tool, tolerance));
        }
        if let (Some(frame), Some(strays)) = (frames.last_mut(), &reply.strays) {
            frame.add_markers(None, strays);
        }
        frames
    }

    const fn empty(number: Option<u32>) -> Self {
        Self {
            number,
            kind: None,
            index: 0,
            device_ns: None,
            tools: Vec::new(),
            markers: Vec::new(),
        }
    }

    /// A handle twice has no pose: nobody can say which holds.
    fn add(&mut self, tool: &PolledTool, tolerance: f64) {
        let handle = tool.handle;
        if let Some(sight) = self.tools.iter_mut().find(|sight| sight.handle == handle) {
            let (field, code) = ("a handle that stands twice", handle.0.into());
            sight.outcome = Err(Why::Unknown { field, code });
            return;
        }
        self.tools
            .push(Sight::new(handle, tool.why(), tool.transform.as_ref(), tolerance));
        if let Some(markers) = &tool.markers {
            self.add_markers(Some(handle), markers);
        }
    }

    fn add_markers(&mut self, tool: Option<Handle>, spots: &Spots) {
        for (spot, index) in spots.0.iter().zip(0..) {
            let why = if spot.out_of_volume {
                Why::OutOfVolume
            } else {
                Why::Valid
            };
            self.markers.push(Marker::new(tool, index, why, spot.place_mm.as_ref()));
        }
    }

    /// Says [`Why::NotInFrame`] of each of these tools that is not in the frame: the device looks for tools of another
    /// kind in another frame, so that nothing is known of it in this one.
    pub fn expect(&mut self, handles: impl IntoIterator<Item = Handle>) {
        for handle in handles {
            if !self.tools.iter().any(|sight| sight.handle == handle) {
                let outcome = Err(Why::NotInFrame);
                self.tools.push(Sight { handle, outcome });
            }
        }
    }

    /// Whether nothing has a pose or a place in it.
    pub(crate) fn is_empty(&self) -> bool {
        let has_pose = self.tools.iter().any(|sight| sight.outcome.is_ok());
        !has_pose && self.markers.iter().all(|marker| marker.outcome.is_err())
    }

    /// Takes each pose and each place out of it, for this reason against the whole frame.
    pub(crate) fn doubt(&mut self, (field, code): (&'static str, u32)) {
        let why = Why::Unknown { field, code };
        for sight in &mut self.tools {
            sight.outcome = sight.outcome.and(Err(why));
        }
        for marker in &mut self.markers {
            marker.outcome = marker.outcome.and(Err(why));
        }
    }

    /// The tool of this handle.
    pub fn tool(&self, handle: Handle) -> Option<&Sight> {
        self.tools.iter().find(|sight| sight.handle == handle)
    }

    /// All of it, by name.
    pub fn fields(&self) -> Fields {
        let mut fields = Fields::default();
        self.number.iter().for_each(|number| fields.add("number", *number));
        self.kind.iter().for_each(|kind| fields.add("kind", kind.words()));
        fields.add("index", self.index);
        self.device_ns.iter().for_each(|ns| fields.add("device_ns", *ns));
        for (number, sight) in self.tools.iter().enumerate() {
            let name = format!("tools[{number}]");
            fields.add(format!("{name}.handle"), sight.handle.to_string());
            fields.add(format!("{name}.why"), sight.why().to_string());
            if let Ok(pose) = sight.outcome {
                fields.add(format!("{name}.q_wxyz"), &pose.q[..]);
                fields.add(format!("{name}.mm"), &pose.t_mm[..]);
                fields.add(format!("{name}.error_mm"), pose.error_mm);
                fields.add(format!("{name}.off_unit"), pose.off_unit);
            }
        }
        for (number, marker) in self.markers.iter().enumerate() {
            let name = format!("markers[{number}]");
            let of = marker
                .tool
                .map_or_else(|| "none".to_owned(), |handle| handle.to_string());
            fields.add(format!("{name}.tool"), of);
            fields.add(format!("{name}.index"), marker.index);
            match marker.outcome {
                Ok(mm) => fields.add(format!("{name}.mm"), &mm[..]),
                Err(why) => fields.add(format!("{name}.why"), why.to_string()),
            }
        }
        fields
    }
}
