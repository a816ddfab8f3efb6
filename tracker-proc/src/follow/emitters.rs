//! Emitters that another program publishes: the driver of a localizer, or a recording that is played.

use std::ops::ControlFlow;

use bus::message::{EmitterFrame, EmitterSight, ProcessState};
use bus::port::Subscriber;
use bus::process::Process;
use bus::scene::tracking::EmitterSource;
use bus::topic::EMITTERS;
use bus::wake::Waits;
use calib::pose::{BodyError, Localizer, LocalizerError, Sighting};
use geometry::Point;

use super::{Follower, Source, Stamp, examination, refuse};
use crate::chain::{Chain, Registration};
use crate::operating_room::{body, gates};
use crate::run::{LOOK_UP, Output, RunError};

/// Frames that may wait while the process is held up, a quarter of a second at 1000 Hz.
const DEPTH: usize = 256;

/// Why there is no chain for the emitters of a scene.
#[derive(Debug, thiserror::Error)]
pub enum EmitterSourceError {
    /// The tool's emitters are no marker.
    #[error("the tool's marker (tracker.emitters.marker): {0}")]
    Marker(BodyError),
    /// The patient's are none.
    #[error("the patient's marker (tracker.emitters.reference): {0}")]
    Reference(BodyError),
    /// The localizer's noise is unusable.
    #[error("tracker.emitters.localizer: {0}")]
    Localizer(#[from] LocalizerError),
}

/// Publishes a pose for each frame until asked to stop.
///
/// # Errors
/// [`RunError`].
pub(crate) fn follow(process: &mut Process, output: &Output, spec: &EmitterSource) -> Result<(), RunError> {
    let frames = Subscriber::<EmitterFrame>::open_waking(&process.bus, &EMITTERS, "", DEPTH)?;
    let Some(examination) = examination(process)? else {
        return Ok(());
    };
    let chain = chain(process, spec, &examination.grid)?;
    let source = Source {
        own: chain.links(),
        // A scene says where markers are, and not how well that is known.
        own_errors_known: false,
        errors_known: true,
        has_reference: chain.reference.is_some(),
    };
    let mut listening = Listening {
        follower: Follower::new(process, output, source, examination),
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
fn chain(process: &Process, spec: &EmitterSource, grid: &geometry::VolumeGrid) -> Result<Chain, EmitterSourceError> {
    let scene = &process.scene;
    let n = spec.noise;
    let localizer = Localizer {
        eye: Point::new(0.0, 0.0, 0.0),
        across_mm: n.across_mm,
        depth_mm: n.depth_mm,
        at_mm: n.at_mm,
        growth_across: n.growth_across,
        growth_depth: n.growth_depth,
    };
    let reference = spec.reference.as_ref();
    Ok(Chain {
        marker: body(&spec.marker).map_err(EmitterSourceError::Marker)?,
        reference: reference
            .map(|on| body(&on.shape))
            .transpose()
            .map_err(EmitterSourceError::Reference)?,
        marker_from_tool: spec.marker_from_tool.into(),
        registration: match reference {
            Some(on) => Registration::Referenced(on.ct_from_reference.into()),
            None => Registration::Fixed(scene.tracker.ct_from_tracker.into()),
        },
        localizer: localizer.checked()?,
        gates: gates(&spec.gates),
        reference_gates: gates(&spec.reference_gates),
        region: scene.targets.first().map_or(grid.centre(), |target| target.centre),
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
            self.frame(&frame, process)?;
        }
        self.follower.tend(process);
        process.beat(ProcessState::Ready, &self.follower.words())?;
        Ok(ControlFlow::Continue(()))
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
        if !self.follower.admit(&stamp, process) {
            return Ok(());
        }
        let missed = self.next_seq.map_or(0, |next| frame.seq.saturating_sub(next));
        process.counters.dropped += missed;
        self.next_seq = frame.seq.checked_add(1);
        taken(tool, &mut self.tool);
        taken(reference, &mut self.reference);
        let (chain, tool, reference) = (&self.chain, &self.tool, &self.reference);
        self.follower
            .frame(&stamp, process, |links| chain.solve_with(links, tool, reference))
    }
}

/// The sights as the chain takes them; it refuses what is not finite and emitters that the marker does not have.
fn taken(sights: &[EmitterSight], into: &mut Vec<Sighting>) {
    into.clear();
    into.extend(sights.iter().map(|sight| {
        let [x, y, z] = sight.place_mm;
        Sighting {
            emitter: sight.emitter as usize,
            place: Point::new(x, y, z),
        }
    }));
}
