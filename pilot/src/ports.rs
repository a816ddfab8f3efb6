//! The pilot's ends of the topics.

use bus::message::{Event, FrameStamp, Heartbeat, ToolPose};
use bus::port::{
    CommandClient, CommandServer, FrameSubscriber, Members, Publisher, Services, Subscriber, VolumeSubscriber,
};
use bus::run::RunContext;
use bus::topic::{EVENT, FRAME_STAMP, HEARTBEAT, HELD_FRAME, TOOL_POSE};
use bus::{Bus, BusError};
use scene::Scene;

use crate::plan::{CALIBRATOR, Planned, REPLAYER, TRACKER};

/// Everything the pilot listens to.
#[derive(Debug)]
pub(crate) struct Ports {
    pub(crate) volume: VolumeSubscriber,
    pub(crate) poses: Subscriber<ToolPose>,
    /// One for each planned process.
    pub(crate) beats: Vec<Subscriber<Heartbeat>>,
    /// One for each renderer, with the number of its process.
    pub(crate) stamps: Vec<(usize, Subscriber<FrameStamp>)>,
    /// One for each renderer, with the number of its process.
    pub(crate) renderers: Vec<(usize, CommandClient)>,
    /// In a replay.
    pub(crate) replayer: Option<CommandClient>,
    /// One for each view.
    pub(crate) held: Vec<FrameSubscriber>,
    /// How far it has come, for a tracker in simulated time, which waits for it.
    pub(crate) taken: Option<Publisher<Heartbeat>>,
    /// What the pilot does and is asked to do, for the recording.
    pub(crate) events: Publisher<Event>,
    pub(crate) services: Services,
}

impl Ports {
    /// Opens them all; the pilot comes first and so creates every service that its children join.
    pub(crate) fn open(bus: &Bus, run: &RunContext, scene: &Scene, planned: &[Planned]) -> Result<Self, BusError> {
        let services = Services::create(bus, &members(run, scene, planned))?;
        let beats = planned.iter().map(|p| Subscriber::open(bus, &HEARTBEAT, &p.name, 1));
        let renderers = || planned.iter().enumerate().filter(|(_, p)| !p.views.is_empty());
        let stamps =
            renderers().map(|(i, p)| Ok((i, Subscriber::open(bus, &FRAME_STAMP, &p.name, FRAME_STAMP.buffer)?)));
        let clients = renderers().map(|(i, p)| Ok((i, CommandClient::open(bus, &p.name)?)));
        let replayer = planned.iter().find(|p| p.name == REPLAYER);
        let replayer = replayer.map(|p| CommandClient::open(bus, &p.name));
        let held = scene
            .views
            .iter()
            .map(|v| FrameSubscriber::open(bus, &HELD_FRAME, &v.name));
        Ok(Self {
            volume: VolumeSubscriber::open(bus)?,
            poses: Subscriber::open(bus, &TOOL_POSE, "", TOOL_POSE.buffer)?,
            beats: beats.collect::<Result<_, _>>()?,
            stamps: stamps.collect::<Result<_, BusError>>()?,
            renderers: clients.collect::<Result<_, BusError>>()?,
            replayer: replayer.transpose()?,
            held: held.collect::<Result<_, _>>()?,
            taken: run
                .simulated_time
                .then(|| Publisher::open(bus, &HEARTBEAT, "pilot"))
                .transpose()?,
            events: Publisher::open(bus, &EVENT, "pilot")?,
            services,
        })
    }
}

fn members<'a>(run: &RunContext, scene: &'a Scene, planned: &'a [Planned]) -> Members<'a> {
    let name = |p: &'a Planned| p.name.as_str();
    let renderers: Vec<&str> = planned.iter().filter(|p| !p.views.is_empty()).map(name).collect();
    let replayer = planned.iter().map(name).filter(|name| *name == REPLAYER);
    let has_steps = planned.iter().any(|p| p.name == CALIBRATOR);
    Members {
        has_steps,
        has_tissue: scene.tissue.is_some(),
        processes: planned.iter().map(name).collect(),
        servers: renderers
            .iter()
            .copied()
            .chain(replayer)
            .chain(has_steps.then_some([CALIBRATOR, TRACKER]).into_iter().flatten())
            .chain(["pilot"])
            .collect(),
        renderers,
        views: scene.views.iter().map(|v| v.name.as_str()).collect(),
        is_ruled: run.replay.is_some() || run.remote.is_some() || run.simulated_time,
        has_timeline: run.replay.is_some(),
        is_planning: run.planning,
    }
}

/// The port on which the pilot answers `pilot status` and `pilot stop`.
pub(crate) fn server(bus: &Bus) -> Result<CommandServer, BusError> {
    CommandServer::open(bus, "pilot")
}
