//! Emitters that another program publishes: the driver of a localizer, or the replayer of a recording.
//!
//! In a replay poses are made again of frames that were recorded: those of another program, or of a simulated operating room,
//! through the same chain as then. Frames are as old as the clock of the replay says. A calibration or a registration that is
//! not to be had refuses the replay, as it would give nothing but lost poses.

use std::ops::ControlFlow;

use bus::BusError;
use bus::message::{EmitterFrame, ProcessState};
use bus::port::Subscriber;
use bus::process::Process;
use bus::topic::EMITTERS;
use bus::wake::Waits;
use calib::pose::Sighting;
use geometry::VolumeGrid;
use scene::operating_room::Room;
use scene::tracking::EmitterSource;

use super::{Follower, Source, Stamp, examination, numbers, refuse, region};
use crate::chain::{Chain, Registration};
use crate::markers::{Markers, MarkersError, taken};
use crate::operating_room::{chain_of, is_noiseless};
use crate::output::{LOOK_UP, OVER, Output};
use crate::run_error::RunError;

/// Frames that may wait while the process is held up, a quarter of a second at 1000 Hz.
const DEPTH: usize = 256;

/// Publishes a pose for each frame until asked to stop.
///
/// # Errors
/// [`RunError`].
pub(crate) fn follow(process: &mut Process, output: &Output, spec: &EmitterSource) -> Result<(), RunError> {
    // A scene says where markers are, and not how well that is known.
    listen(process, output, Stated::default(), |process, grid| {
        Ok(chain(process, spec, grid)?)
    })
}

/// The same for recorded frames of a simulated operating room.
///
/// # Errors
/// [`RunError`].
pub(crate) fn follow_recorded_room(process: &mut Process, output: &Output, spec: &Room) -> Result<(), RunError> {
    let stated = Stated {
        own_errors: true,
        noiseless: is_noiseless(&spec.sensor),
    };
    listen(process, output, stated, |process, grid| {
        let scene = &process.scene;
        let tracker_from_rest = scene.tracker.ct_from_tracker.inverse();
        Ok(chain_of(spec, tracker_from_rest, scene.seed, region(scene, grid))?)
    })
}

/// What a scene states of the source of its frames.
#[derive(Debug, Clone, Copy, Default)]
struct Stated {
    /// How well its own constants are known.
    own_errors: bool,
    /// That a marker at rest may give the same numbers again and again.
    noiseless: bool,
}

/// Listens to frames; the chain is made once the volume is there.
fn listen(
    process: &mut Process,
    output: &Output,
    stated: Stated,
    chain: impl FnOnce(&Process, &VolumeGrid) -> Result<Chain, RunError>,
) -> Result<(), RunError> {
    let frames = Subscriber::<EmitterFrame>::open_waking(&process.bus, &EMITTERS, "", DEPTH)?;
    let Some(examination) = examination(process)? else {
        return Ok(());
    };
    let chain = chain(process, &examination.grid)?;
    let source = Source {
        own: chain.links(),
        own_errors_known: stated.own_errors,
        errors_known: true,
        has_reference: chain.reference.is_some(),
        noiseless: stated.noiseless,
    };
    let follower = Follower::new(process, output, source, examination);
    if let (true, Some(why)) = (process.session.is_replay(), follower.constants.reason()) {
        return Err(RunError::NoLinks(why.to_owned()));
    }
    let mut listening = Listening {
        follower,
        chain,
        next_seq: None,
        tool: Vec::with_capacity(EmitterFrame::MOST),
        reference: Vec::with_capacity(EmitterFrame::MOST),
    };
    Waits::every(LOOK_UP)
        .message(&frames, None)
        .run(|| match listening.step(&frames, process) {
            Ok(ControlFlow::Continue(())) => ControlFlow::Continue(()),
            Ok(ControlFlow::Break(())) => ControlFlow::Break(Ok(())),
            Err(error) => ControlFlow::Break(Err(error)),
        })?
}

/// The chain of a scene; its own constants count as exact, as nothing is said of their errors.
fn chain(process: &Process, spec: &EmitterSource, grid: &VolumeGrid) -> Result<Chain, MarkersError> {
    let scene = &process.scene;
    let markers = Markers::of_emitters(spec)?;
    Ok(Chain {
        marker: markers.marker,
        reference: markers.reference,
        marker_from_tool: spec.marker_from_tool.into(),
        registration: match &spec.reference {
            Some(on) => Registration::Referenced(on.ct_from_reference.into()),
            None => Registration::Fixed(scene.tracker.ct_from_tracker.into()),
        },
        localizer: markers.localizer,
        gates: markers.gates,
        reference_gates: markers.reference_gates,
        region: region(scene, grid),
    })
}

/// The state between two frames.
struct Listening<'a> {
    follower: Follower<'a>,
    chain: Chain,
    /// The number that the next frame should have.
    next_seq: Option<u64>,
    tool: Vec<Sighting>,
    reference: Vec<Sighting>,
}

impl Listening<'_> {
    fn step(&mut self, frames: &Subscriber<EmitterFrame>, process: &mut Process) -> Result<ControlFlow<()>, RunError> {
        if process.stop.is_set() {
            process.beat(ProcessState::Stopping, "asked to stop")?;
            return Ok(ControlFlow::Break(()));
        }
        while let Some(frame) = frames.next()? {
            // The clock of a replay goes out before the frames for which it holds.
            self.follow_clock(process)?;
            self.frame(&frame, process)?;
        }
        self.follow_clock(process)?;
        self.follower.tend(process);
        match self.follower.output.is_beyond(process, process.clock().now_ns()) {
            true => process.beat(ProcessState::Stopping, OVER)?,
            false => process.beat(ProcessState::Ready, &self.follower.words())?,
        }
        Ok(ControlFlow::Continue(()))
    }

    fn follow_clock(&mut self, process: &mut Process) -> Result<(), BusError> {
        if process.session.follow()? {
            self.follower.went_elsewhere();
            self.next_seq = None;
        }
        Ok(())
    }

    fn frame(&mut self, frame: &EmitterFrame, process: &mut Process) -> Result<(), RunError> {
        let (tool, reference) = match (frame.tool(), frame.reference()) {
            (Ok(tool), Ok(reference)) => (tool, reference),
            (Err(error), _) | (_, Err(error)) => {
                refuse(process, frame.seq, &error.to_string());
                return Ok(());
            }
        };
        let stamp = Stamp {
            seq: frame.seq,
            t_device_ns: frame.t_device_ns,
            t_capture_ns: frame.t_capture_ns,
            visible: frame.tool_seen,
        };
        if self.follower.output.is_beyond(process, frame.t_capture_ns) || !self.follower.admit(&stamp, process) {
            return Ok(());
        }
        let missed = self.next_seq.map_or(0, |next| frame.seq.saturating_sub(next));
        process.counters.dropped += missed;
        self.next_seq = frame.seq.checked_add(1);
        taken(tool, &mut self.tool);
        taken(reference, &mut self.reference);
        let (chain, tool, reference) = (&self.chain, &self.tool, &self.reference);
        let places = [numbers(tool), numbers(reference)];
        self.follower.frame(&stamp, places, process, |links| {
            chain.solve_with(links, tool, reference)
        })
    }
}
