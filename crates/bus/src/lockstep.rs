//! At full speed, in a replay and in a run in simulated time: the next pose goes out when every view has drawn the one before;
//! where poses are made again, also when the tracker has made it.

use crate::message::{FrameStamp, ToolPose};
use crate::port::Subscriber;
use crate::topic::{FRAME_STAMP, TOOL_POSE};
use crate::{Bus, BusError};
use scene::Scene;

/// Which views have drawn the pose that was published last.
#[derive(Debug)]
pub struct Lockstep {
    /// Each renderer with its stamps.
    renderers: Vec<(String, Subscriber<FrameStamp>)>,
    /// The renderer of each view, and whether it has drawn the pose.
    views: Vec<(usize, bool)>,
    /// Its number and when it was captured: an image that says that there is no pose has no time.
    waiting_for: Option<(u64, i64)>,
    /// The tracker that makes the poses, where another process does.
    tracker: Option<Subscriber<ToolPose>>,
    /// What it made.
    made: Option<ToolPose>,
}

/// The name of the tracker's process.
pub const TRACKER: &str = "tracker";

impl Lockstep {
    /// Listens to every renderer of the scene, and to the tracker where that makes the poses.
    ///
    /// # Errors
    /// [`BusError::Open`].
    pub fn open(bus: &Bus, scene: &Scene, tracked: bool) -> Result<Self, BusError> {
        let mut views = vec![(0, true); scene.views.len()];
        let mut renderers = Vec::new();
        for (renderer, (plane, indices)) in scene.renderers().into_iter().enumerate() {
            let name = plane.process();
            renderers.push((
                name.clone(),
                Subscriber::open(bus, &FRAME_STAMP, &name, FRAME_STAMP.buffer)?,
            ));
            indices.into_iter().for_each(|view| views[view] = (renderer, true));
        }
        let tracker = tracked.then(|| Subscriber::open(bus, &TOOL_POSE, "", TOOL_POSE.buffer));
        Ok(Self {
            renderers,
            views,
            waiting_for: None,
            tracker: tracker.transpose()?,
            made: None,
        })
    }

    /// Before pose `seq`, captured at `t_capture_ns`, goes out: what was drawn before does not count for it.
    ///
    /// # Errors
    /// [`BusError::Transfer`].
    pub fn expect(&mut self, seq: u64, t_capture_ns: i64) -> Result<(), BusError> {
        for (_, stamps) in &self.renderers {
            while stamps.next()?.is_some() {}
        }
        self.poses(|_| {})?;
        self.made = None;
        self.views.iter_mut().for_each(|(_, drawn)| *drawn = false);
        self.waiting_for = Some((seq, t_capture_ns));
        Ok(())
    }

    /// No longer waits.
    pub fn forget(&mut self) {
        self.waiting_for = None;
    }

    /// Whether every view has drawn the expected pose.
    ///
    /// # Errors
    /// [`BusError::Transfer`].
    pub fn is_drawn(&mut self) -> Result<bool, BusError> {
        let Some(expected) = self.waiting_for else {
            return Ok(true);
        };
        for (_, stamps) in &self.renderers {
            while let Some(stamp) = stamps.next()? {
                if let Some((_, drawn)) = self.views.get_mut(stamp.view as usize) {
                    *drawn |= (stamp.seq, stamp.t_capture_ns) == expected;
                }
            }
        }
        let mut made = self.made;
        self.poses(|pose| {
            if (pose.seq, pose.t_capture_ns) == expected {
                made = Some(pose);
            }
        })?;
        self.made = made;
        if self.is_made() && self.views.iter().all(|(_, drawn)| *drawn) {
            self.waiting_for = None;
        }
        Ok(self.waiting_for.is_none())
    }

    /// Gives what the tracker has published since the last time to `take`.
    fn poses(&self, mut take: impl FnMut(ToolPose)) -> Result<(), BusError> {
        let Some(tracker) = &self.tracker else { return Ok(()) };
        while let Some(pose) = tracker.next()? {
            take(pose);
        }
        Ok(())
    }

    fn is_made(&self) -> bool {
        self.tracker.is_none() || self.made.is_some()
    }

    /// The expected pose as the tracker made it.
    pub fn made(&self) -> Option<ToolPose> {
        self.made
    }

    /// Who is waited for: the tracker, or the first renderer that has not drawn the expected pose.
    pub fn missing(&self) -> Option<&str> {
        if self.waiting_for.is_some() && !self.is_made() {
            return Some(TRACKER);
        }
        let (renderer, _) = self.views.iter().find(|(_, drawn)| !drawn)?;
        self.waiting_for.map(|_| self.renderers[*renderer].0.as_str())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::port::Publisher;
    use crate::run::RunContext;
    use std::path::Path;

    #[test]
    fn a_pose_is_drawn_when_every_view_has_stamped_it_and_nothing_else_counts() {
        let folder = tempfile::Builder::new().prefix("tc").tempdir_in("/tmp").unwrap();
        let run = RunContext::new(folder.path(), 0).unwrap();
        let bus = Bus::join(&run).unwrap();
        let scene = Scene::parse("", Path::new("")).unwrap();
        let mut lockstep = Lockstep::open(&bus, &scene, false).unwrap();
        let renderers: Vec<_> = scene.renderers();
        let open = |plane: scene::Plane| Publisher::open(&bus, &FRAME_STAMP, &plane.process()).unwrap();
        let stamps: Vec<Publisher<FrameStamp>> = renderers.iter().map(|(plane, _)| open(*plane)).collect();
        let stamp = |view: usize, seq, t_capture_ns| FrameStamp {
            view: view as u32,
            seq,
            t_capture_ns,
            ..FrameStamp::default()
        };
        assert!(lockstep.is_drawn().unwrap(), "nothing is expected yet");
        // Drawn before it was expected: of an earlier round.
        stamps[0].send(stamp(0, 7, 70)).unwrap();
        lockstep.expect(7, 70).unwrap();
        for ((plane, views), port) in renderers.iter().zip(&stamps) {
            for &view in views {
                assert!(!lockstep.is_drawn().unwrap(), "view {view}");
                assert_eq!(lockstep.missing(), Some(plane.process().as_str()));
                // Another pose, another round, and a view that the scene does not have.
                for (view, seq, at) in [(view, 6, 70), (view, 7, 0), (99, 7, 70)] {
                    port.send(stamp(view, seq, at)).unwrap();
                }
                assert!(!lockstep.is_drawn().unwrap(), "view {view}");
                port.send(stamp(view, 7, 70)).unwrap();
                let _ = lockstep.is_drawn().unwrap();
            }
        }
        assert!(lockstep.is_drawn().unwrap() && lockstep.missing().is_none());
        drop((lockstep, stamps, bus));
        run.sweep();
    }

    #[test]
    fn a_pose_that_is_made_again_is_waited_for_and_handed_on() {
        let folder = tempfile::Builder::new().prefix("tc").tempdir_in("/tmp").unwrap();
        let run = RunContext::new(folder.path(), 0).unwrap();
        let bus = Bus::join(&run).unwrap();
        let view = "[[views]]\nname = \"a\"\nplane = \"axial\"\nextent = \"local\"";
        let scene = Scene::parse(view, Path::new("")).unwrap();
        let poses = Publisher::open(&bus, &TOOL_POSE, "").unwrap();
        let stamps = Publisher::open(&bus, &FRAME_STAMP, "view-axial").unwrap();
        let mut lockstep = Lockstep::open(&bus, &scene, true).unwrap();
        let recorded = ToolPose {
            seq: 7,
            t_capture_ns: 70,
            ..ToolPose::EMPTY
        };
        poses.send(recorded).unwrap();
        lockstep.expect(recorded.seq, recorded.t_capture_ns).unwrap();
        let stamp = FrameStamp {
            seq: 7,
            t_capture_ns: 70,
            ..FrameStamp::default()
        };
        stamps.send(stamp).unwrap();
        // What was published before it was expected does not count, and another pose neither.
        poses.send(ToolPose { seq: 8, ..recorded }).unwrap();
        assert!(!lockstep.is_drawn().unwrap());
        assert_eq!((lockstep.missing(), lockstep.made()), (Some(TRACKER), None));
        let again = ToolPose {
            fre_rms_mm: 0.25,
            ..recorded
        };
        poses.send(again).unwrap();
        assert!(lockstep.is_drawn().unwrap());
        assert_eq!((lockstep.missing(), lockstep.made()), (None, Some(again)));
        drop((lockstep, stamps, poses, bus));
        run.sweep();
    }
}
