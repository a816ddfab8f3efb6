//! At full speed: the next pose goes out when every view has drawn the one before.

use bus::message::{FrameStamp, ToolPose};
use bus::port::Subscriber;
use bus::scene::Scene;
use bus::topic::FRAME_STAMP;
use bus::{Bus, BusError};

/// Which views have drawn the pose that was published last.
#[derive(Debug)]
pub struct Lockstep {
    /// Each renderer with its stamps.
    renderers: Vec<(String, Subscriber<FrameStamp>)>,
    /// The renderer of each view, and whether it has drawn the pose.
    views: Vec<(usize, bool)>,
    /// Its number and when it was captured: an image that says that there is no pose has no time.
    waiting_for: Option<(u64, i64)>,
}

impl Lockstep {
    /// Listens to every renderer of the scene.
    ///
    /// # Errors
    /// [`BusError::Open`].
    pub fn open(bus: &Bus, scene: &Scene) -> Result<Self, BusError> {
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
        Ok(Self {
            renderers,
            views,
            waiting_for: None,
        })
    }

    /// Before a pose goes out: what was drawn before does not count for it.
    ///
    /// # Errors
    /// [`BusError::Transfer`].
    pub fn expect(&mut self, pose: &ToolPose) -> Result<(), BusError> {
        for (_, stamps) in &self.renderers {
            while stamps.next()?.is_some() {}
        }
        self.views.iter_mut().for_each(|(_, drawn)| *drawn = false);
        self.waiting_for = Some((pose.seq, pose.t_capture_ns));
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
        if self.views.iter().all(|(_, drawn)| *drawn) {
            self.waiting_for = None;
        }
        Ok(self.waiting_for.is_none())
    }

    /// The first renderer that has not drawn the expected pose.
    pub fn missing(&self) -> Option<&str> {
        let (renderer, _) = self.views.iter().find(|(_, drawn)| !drawn)?;
        self.waiting_for.map(|_| self.renderers[*renderer].0.as_str())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bus::port::Publisher;
    use bus::run::RunContext;
    use std::path::Path;

    #[test]
    fn a_pose_is_drawn_when_every_view_has_stamped_it_and_nothing_else_counts() {
        let folder = tempfile::Builder::new().prefix("tc").tempdir_in("/tmp").unwrap();
        let run = RunContext::new(folder.path(), 0).unwrap();
        let bus = Bus::join(&run).unwrap();
        let scene = Scene::parse("", Path::new("")).unwrap();
        let mut lockstep = Lockstep::open(&bus, &scene).unwrap();
        let renderers: Vec<_> = scene.renderers();
        let open = |plane: bus::scene::Plane| Publisher::open(&bus, &FRAME_STAMP, &plane.process()).unwrap();
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
        let pose = ToolPose {
            seq: 7,
            t_capture_ns: 70,
            ..ToolPose::EMPTY
        };
        lockstep.expect(&pose).unwrap();
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
}
