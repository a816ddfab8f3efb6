//! A run that shows another one, made by hand.

use std::path::Path;
use std::process::Command;

use bus::Bus;
use bus::clock::monotonic_ns;
use bus::message::{ClockLaw, Event, Guide, Heartbeat, Identity, ToolPose, Workflow};
use bus::port::{Subscriber, VolumeSubscriber};
use bus::run::{RemoteOf, RunContext, RunLock};
use bus::topic::{EVENT, GUIDE, HEARTBEAT, IDENTITY, SESSION_CLOCK, TOOL_POSE, WORKFLOW};

use super::{Program, SCENE, run, verb};

/// A run of another machine, as far as this test can see: what `pilot remote` would have made.
pub(crate) struct Second {
    pub(crate) run: RunContext,
    _lock: RunLock,
    pub(crate) bus: Bus,
    pub(crate) volumes: VolumeSubscriber,
    pub(crate) poses: Subscriber<ToolPose>,
    pub(crate) laws: Subscriber<ClockLaw>,
    pub(crate) beats: Subscriber<Heartbeat>,
    pub(crate) guides: Subscriber<Guide>,
    pub(crate) workflows: Subscriber<Workflow>,
    pub(crate) identities: Subscriber<Identity>,
    pub(crate) events: Subscriber<Event>,
}

impl Second {
    pub(crate) fn open(world: &Path, name: &str, endpoint: &str) -> Self {
        let (lock, run, bus) = run((world, name, SCENE), monotonic_ns(), |run| {
            run.remote = Some(RemoteOf {
                endpoint: endpoint.to_owned(),
                run: "room".to_owned(),
            });
        });
        Self {
            volumes: VolumeSubscriber::open(&bus).unwrap(),
            poses: Subscriber::open(&bus, &TOOL_POSE, "", TOOL_POSE.buffer).unwrap(),
            laws: Subscriber::open(&bus, &SESSION_CLOCK, "", 1).unwrap(),
            beats: Subscriber::open(&bus, &HEARTBEAT, "remote", 1).unwrap(),
            guides: Subscriber::open(&bus, &GUIDE, "", GUIDE.buffer).unwrap(),
            workflows: Subscriber::open(&bus, &WORKFLOW, "", WORKFLOW.buffer).unwrap(),
            identities: Subscriber::open(&bus, &IDENTITY, "", 1).unwrap(),
            events: Subscriber::open(&bus, &EVENT, "remote", EVENT.buffer).unwrap(),
            _lock: lock,
            run,
            bus,
        }
    }

    /// The receiver in it.
    pub(crate) fn receive(&self, world: &Path, endpoint: &str, id: &str) -> Program {
        self.receive_by(verb("receive"), world, endpoint, id)
    }

    pub(crate) fn receive_by(&self, mut command: Command, world: &Path, endpoint: &str, id: &str) -> Program {
        command
            .args([endpoint, "--session", id, "--run-dir"])
            .arg(&self.run.dir);
        Program::start(world, &self.run.name, command)
    }

    /// What the receiver says of itself.
    pub(crate) fn note(&self) -> Option<String> {
        self.beats.newest().unwrap().map(|beat| beat.note_text())
    }
}

impl Drop for Second {
    fn drop(&mut self) {
        self.run.sweep();
    }
}
