//! The services of a run, made before anybody joins.

use super::places::{Crowded, Places};
use super::{command, event_service, frame, headed, stream, volume};
use crate::message::{
    ClockLaw, EmitterFrame, Event, FrameStamp, Guide, Heartbeat, Identity, MarkerFrame, Plan, Steps, Timeline,
    TissueHeader, TissueMeshHeader, ToolPose, UsImageHeader, Workflow,
};
use crate::node::patiently;
use crate::topic::{
    COMMAND, EMITTERS, EVENT, FRAME_STAMP, GROUND_TRUTH, GUIDE, HEARTBEAT, HELD_FRAME, IDENTITY, LOOK_FRAME, MARKERS,
    PLAN, SESSION_CLOCK, STEPS, TIMELINE, TISSUE, TISSUE_ASKED, TISSUE_MESH, TOOL_POSE, Topic, US_IMAGE, VIEW_FRAME,
    WORKFLOW,
};
use crate::{Bus, BusError};

/// Who takes part in a run, by name.
#[derive(Debug, Clone, Default)]
pub struct Members<'a> {
    /// All processes but the pilot: each gives signs of life.
    pub processes: Vec<&'a str>,
    /// Those that draw: each gives the stamps of its images.
    pub renderers: Vec<&'a str>,
    /// Those that answer requests, the pilot included.
    pub servers: Vec<&'a str>,
    /// The views.
    pub views: Vec<&'a str>,
    /// Whether somebody rules the clock: in a replay, where another machine's run is shown, and in simulated time. The pilot then gives
    /// signs of life too.
    pub is_ruled: bool,
    /// Whether a recording is replayed for a person to go about in: the replayer then tells what it holds.
    pub has_timeline: bool,
    /// Whether an operation is planned: the pilot then tells the plan.
    pub is_planning: bool,
    /// Whether calibration, registration and check are guided.
    pub has_steps: bool,
    /// Whether organs move with the tube.
    pub has_tissue: bool,
}

/// Every service of a run, held open by its pilot for as long as the run lasts. Whoever is killed while it makes a service
/// leaves one that hangs in its making, and that nobody can open; so those that are killed and started again only ever open.
#[derive(Debug)]
pub struct Services {
    kept: Vec<Box<dyn Places>>,
}

impl Services {
    /// Makes the services of a run.
    ///
    /// # Errors
    /// [`BusError::Open`].
    pub fn create(bus: &Bus, members: &Members<'_>) -> Result<Self, BusError> {
        let mut kept = Vec::new();
        keep(&mut kept, bus, || volume::service(bus))?;
        keep_stream::<Identity>(&mut kept, bus, &IDENTITY, "")?;
        keep_stream::<ToolPose>(&mut kept, bus, &TOOL_POSE, "")?;
        keep_stream::<EmitterFrame>(&mut kept, bus, &EMITTERS, "")?;
        keep_stream::<MarkerFrame>(&mut kept, bus, &MARKERS, "")?;
        keep(&mut kept, bus, || headed::service::<UsImageHeader, u8>(bus, &US_IMAGE))?;
        keep_stream::<ToolPose>(&mut kept, bus, &GROUND_TRUTH, "")?;
        keep_stream::<Event>(&mut kept, bus, &EVENT, "pilot")?;
        keep_stream::<Guide>(&mut kept, bus, &GUIDE, "")?;
        keep_stream::<Workflow>(&mut kept, bus, &WORKFLOW, "")?;
        if members.is_ruled {
            keep_stream::<ClockLaw>(&mut kept, bus, &SESSION_CLOCK, "")?;
            keep_stream::<Heartbeat>(&mut kept, bus, &HEARTBEAT, "pilot")?;
        }
        if members.has_timeline {
            keep_stream::<Timeline>(&mut kept, bus, &TIMELINE, "")?;
        }
        if members.has_steps {
            keep_stream::<Steps>(&mut kept, bus, &STEPS, "")?;
        }
        if members.has_tissue {
            keep(&mut kept, bus, || {
                headed::service::<TissueMeshHeader, u8>(bus, &TISSUE_MESH)
            })?;
            keep(&mut kept, bus, || headed::service::<TissueHeader, f32>(bus, &TISSUE))?;
            keep(&mut kept, bus, || event_service(bus, &TISSUE, TISSUE.name))?;
            keep_stream::<TissueHeader>(&mut kept, bus, &TISSUE_ASKED, "")?;
        }
        if members.is_planning {
            keep_stream::<Plan>(&mut kept, bus, &PLAN, "")?;
        }
        for view in &members.views {
            for topic in [&VIEW_FRAME, &HELD_FRAME, &LOOK_FRAME] {
                let name = topic.of(view);
                keep(&mut kept, bus, || frame::service(bus, topic, &name))?;
                if topic.wakes {
                    keep(&mut kept, bus, || event_service(bus, topic, &name))?;
                }
            }
        }
        for process in &members.processes {
            keep_stream::<Heartbeat>(&mut kept, bus, &HEARTBEAT, process)?;
        }
        for renderer in &members.renderers {
            keep_stream::<FrameStamp>(&mut kept, bus, &FRAME_STAMP, renderer)?;
        }
        for server in &members.servers {
            let name = COMMAND.of(server);
            keep(&mut kept, bus, || command::service(bus, &name))?;
            keep(&mut kept, bus, || event_service(bus, &COMMAND, &name))?;
        }
        Ok(Self { kept })
    }

    /// The services that have hardly a place left for another reader: a process of the run that is started again may find none.
    pub fn crowded(&self) -> Vec<Crowded> {
        self.kept.iter().filter_map(|service| service.crowded()).collect()
    }
}

fn keep<S: Places + 'static>(
    kept: &mut Vec<Box<dyn Places>>,
    bus: &Bus,
    open: impl FnMut() -> Result<S, BusError>,
) -> Result<(), BusError> {
    kept.push(Box::new(patiently(bus, open)?));
    Ok(())
}

/// The service of a topic of plain structs, with the event that wakes its receivers.
fn keep_stream<T: super::Message>(
    kept: &mut Vec<Box<dyn Places>>,
    bus: &Bus,
    topic: &Topic,
    part: &str,
) -> Result<(), BusError> {
    let name = topic.of(part);
    keep(kept, bus, || stream::service::<T>(bus, topic, &name))?;
    if topic.wakes {
        keep(kept, bus, || event_service(bus, topic, &name))?;
    }
    Ok(())
}
