//! Emitters that another program publishes: the driver of a localizer, or the replayer of a recording.
//!
//! In a replay poses are made again of frames that were recorded: those of another program, or of a simulated operating room,
//! through the same chain as then. Frames are as old as the clock of the replay says. A calibration or a registration that is
//! not to be had refuses the replay, as it would give nothing but lost poses.

use bus::message::{EmitterFrame, TooManyEmitters};
use bus::port::Subscriber;
use bus::process::Process;
use bus::topic::EMITTERS;
use calib::pose::Sighting;
use geometry::{Ct, Point, VolumeGrid};
use scene::Scene;
use scene::operating_room::Room;
use scene::tracking::EmitterSource;

use super::listening::{self, DEPTH, Taker};
use super::{Follower, Source, Stamp, examination, numbers, region};
use crate::chain::{Chain, Registration};
use crate::markers::{Markers, MarkersError, taken};
use crate::operating_room::{chain_of, is_noiseless};
use crate::output::Output;
use crate::run_error::RunError;

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
    let mut taking = Taking {
        chain,
        tool: Vec::with_capacity(EmitterFrame::MOST),
        reference: Vec::with_capacity(EmitterFrame::MOST),
    };
    listening::listen(process, &frames, follower, &mut taking)
}

/// The chain of a scene; its own constants count as exact, as nothing is said of their errors.
fn chain(process: &Process, spec: &EmitterSource, grid: &VolumeGrid) -> Result<Chain, MarkersError> {
    chain_of_scene(&process.scene, spec, region(&process.scene, grid))
}

/// The same for errors that count at `region`.
pub(super) fn chain_of_scene(scene: &Scene, spec: &EmitterSource, region: Point<Ct>) -> Result<Chain, MarkersError> {
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
        region,
    })
}

/// Makes poses of frames of emitters.
struct Taking {
    chain: Chain,
    tool: Vec<Sighting>,
    reference: Vec<Sighting>,
}

impl Taker for Taking {
    type Frame = EmitterFrame;

    fn stamp(&self, frame: &EmitterFrame) -> Result<Stamp, (u64, String)> {
        let refused = |error: TooManyEmitters| (frame.seq, error.to_string());
        frame.reference().map_err(refused)?;
        // At most 32.
        let visible = frame.tool().map_err(refused)?.len() as u32;
        Ok(Stamp {
            seq: frame.seq,
            t_device_ns: frame.t_device_ns,
            t_capture_ns: frame.t_capture_ns,
            t_order_ns: frame.t_device_ns,
            visible,
        })
    }

    fn take(
        &mut self,
        frame: &EmitterFrame,
        stamp: &Stamp,
        follower: &mut Follower<'_>,
        process: &mut Process,
    ) -> Result<(), RunError> {
        taken(frame.tool().unwrap_or_default(), &mut self.tool);
        taken(frame.reference().unwrap_or_default(), &mut self.reference);
        let (chain, tool, reference) = (&self.chain, &self.tool, &self.reference);
        let places = [numbers(tool), numbers(reference)];
        follower.frame(stamp, places, process, |links| chain.solve_with(links, tool, reference))
    }
}
