//! The simulated operating room: each frame as it arrives, with the truth beside the pose.

use bus::clock;
use bus::message::{CommandKind, EmitterFrame, ProcessState, ToolPose, Tracked};
use bus::port::{CommandServer, Publisher};
use bus::process::Process;
use bus::topic::{EMITTERS, GROUND_TRUTH};
use scene::operating_room::Room;

use super::{Follower, Source, Stamp, examination, numbers, region};
use crate::chain::Chain;
use crate::operating_room::{Arrival, Frame, OperatingRoom, Script, is_noiseless};
use crate::output::{LOOK_UP, OVER, Output, catch_up_ns};
use crate::probe::{ProbeError, Publishing, SimulatedProbe, Tank};
use crate::run_error::RunError;
use crate::simulated_time::SimulatedTime;

/// In simulated time frames are looked for so far ahead at a time.
const STRETCH_NS: i64 = 1_000_000_000;
/// The process that is told what the hand is to do.
const NAME: &str = "tracker";

/// The room, and where its frames and its truth go.
struct InRoom {
    room: OperatingRoom,
    chain: Chain,
    frames: Publisher<EmitterFrame>,
    truths: Publisher<ToolPose>,
    /// What the hand is told; `None` where nobody tells it anything.
    orders: Option<CommandServer>,
}

/// Publishes what the chain makes of the frames until asked to stop.
///
/// # Errors
/// [`RunError`].
pub(crate) fn follow(process: &mut Process, output: &Output, spec: &Room) -> Result<(), RunError> {
    let Some(examination) = examination(process)? else {
        return Ok(());
    };
    let scene = &process.scene;
    let script = Script::of_room(spec, &scene.targets, Some(&examination.grid))?.practised(spec, scene.seed);
    let region = region(scene, &examination.grid);
    let tracker = &scene.tracker;
    let room = OperatingRoom::new(script, spec, &tracker.ct_from_tracker, scene.seed, tracker.rate_hz)?;
    let chain = room.chain(region)?;
    let source = Source {
        own: chain.links(),
        own_errors_known: true,
        errors_known: true,
        has_reference: spec.reference.is_some(),
        noiseless: is_noiseless(&spec.sensor),
    };
    let mut follower = Follower::new(process, output, source, examination);
    let mut in_room = InRoom {
        orders: spec
            .practice
            .filter(|_| scene.steps.is_some() && !process.run.simulated_time)
            .map(|_| CommandServer::open(&process.bus, NAME))
            .transpose()?,
        frames: Publisher::open(&process.bus, &EMITTERS, "")?,
        truths: Publisher::open(&process.bus, &GROUND_TRUTH, "")?,
        room,
        chain,
    };
    let mut arrivals: Vec<Arrival> = Vec::new();
    let Some(start) = output.start(process)? else {
        return Ok(());
    };
    if process.run.simulated_time {
        return in_room.follow_in_simulated_time(process, &mut follower);
    }
    let probe = probe(spec, process.scene.seed)?;
    let of = (&process.run, &process.scene);
    let mut images = probe
        .map(|probe| Publishing::start(of, &in_room.room, probe, start.at_ns))
        .transpose()?;
    let catch_up = catch_up_ns(&process.scene);
    let mut after = match start.is_first {
        true => -1,
        false => process.clock().now_ns() - start.at_ns,
    };
    while !process.stop.is_set() {
        let now = process.clock().now_ns() - start.at_ns;
        in_room.obey(now)?;
        images.as_mut().map_or(Ok(()), Publishing::look)?;
        after = after.max(now - catch_up);
        in_room.room.arrivals(after, now, &mut arrivals);
        for arrival in &arrivals {
            in_room.frame(&in_room.room.frame(arrival.seq), &mut follower, process)?;
        }
        follower.tend(process);
        match process
            .run
            .is_beyond(now.saturating_sub(in_room.room.longest_delay_ns()))
        {
            true => process.beat(ProcessState::Stopping, OVER)?,
            false => process.beat_with(ProcessState::Ready, || follower.words())?,
        }
        after = now;
        let look_up = now + clock::ns(LOOK_UP);
        let next = in_room.room.next_arrival(now, look_up);
        let until = next.map_or(look_up, |arrival| arrival.t_arrival_ns);
        process.clock().sleep_until(start.at_ns + until);
    }
    process.beat(ProcessState::Stopping, "asked to stop")?;
    Ok(())
}

/// The room's probe, with the tank that it images where that is not the patient.
fn probe(spec: &Room, seed: u64) -> Result<Option<(SimulatedProbe, Option<Tank>)>, ProbeError> {
    let Some(probe) = spec.probe else { return Ok(None) };
    let Some(tank) = &spec.tank else {
        return Ok(Some((SimulatedProbe::new(probe, seed)?, None)));
    };
    let tank = Tank::load(tank, spec, seed).map_err(Box::new)?;
    Ok(Some((SimulatedProbe::in_tank(probe, &tank, seed)?, Some(tank))))
}

impl InRoom {
    /// Takes what the hand is told to do from script time `now_ns` on.
    fn obey(&mut self, now_ns: i64) -> Result<(), RunError> {
        let Some(orders) = &self.orders else { return Ok(()) };
        while let Some(request) = orders.next()? {
            let told = match request.command().command_kind() {
                Some(CommandKind::Practise) => request.command().practice(),
                _ => Err("the simulated hand can only practise".to_owned()),
            };
            let done = told.and_then(|practice| self.room.order(&practice, now_ns as f64 / 1e9));
            request.reply(done.as_ref().map(|()| "on its way").map_err(String::as_str))?;
        }
        Ok(())
    }

    /// The same in simulated time: one frame after the other, each at the time of its arrival.
    fn follow_in_simulated_time(&self, process: &mut Process, follower: &mut Follower<'_>) -> Result<(), RunError> {
        let (output, start_ns) = (follower.output, follower.output.start_ns());
        let mut time = SimulatedTime::open(process, output)?;
        let mut arrivals: Vec<Arrival> = Vec::new();
        let mut after: i64 = -1;
        // Frames are under way for so long at most.
        while !process
            .run
            .is_beyond(after.saturating_sub(self.room.longest_delay_ns()))
        {
            let until = after + STRETCH_NS;
            self.room.arrivals(after, until, &mut arrivals);
            for arrival in &arrivals {
                let (frame, at_ns) = (self.room.frame(arrival.seq), start_ns + arrival.t_arrival_ns);
                if process.run.is_beyond(frame.t_capture_ns) || SimulatedTime::is_past(output, at_ns) {
                    continue;
                }
                time.expect(process, frame.seq, start_ns + frame.t_capture_ns, at_ns)?;
                follower.tend(process);
                if !self.frame(&frame, follower, process)? {
                    time.forget();
                }
                if !time.wait(process, output, frame.seq)? {
                    return Ok(time.end(process, output)?);
                }
            }
            after = until;
        }
        Ok(time.end(process, output)?)
    }

    /// Every frame of the run's time goes out as the localizer saw it; one that is believed, with its pose and the truth. Returns
    /// whether there was a pose.
    fn frame(&self, frame: &Frame, follower: &mut Follower<'_>, process: &mut Process) -> Result<bool, RunError> {
        if process.run.is_beyond(frame.t_capture_ns) {
            return Ok(false);
        }
        let t_capture_ns = follower.output.start_ns() + frame.t_capture_ns;
        let stamp = Stamp {
            seq: frame.seq,
            t_device_ns: frame.t_device_ns,
            t_order_ns: frame.t_device_ns,
            t_capture_ns,
            // At most 32 emitters.
            visible: frame.tool.len() as u32,
        };
        self.frames
            .send(frame.message(t_capture_ns, process.session.clock().now_ns()))?;
        if !follower.admit(&stamp, process) {
            return Ok(false);
        }
        let places = [numbers(&frame.tool), numbers(&frame.reference)];
        follower.frame(&stamp, places, process, |links| {
            self.chain.solve_with(links, &frame.tool, &frame.reference)
        })?;
        let mut truth = follower.message(&stamp);
        truth.t_publish_ns = process.session.clock().now_ns();
        truth.set(Tracked::Valid(frame.ct_from_tool));
        self.truths.send(truth)?;
        Ok(true)
    }
}
