//! What the replayer says: to requests, to people, and at the end.

use bus::clock::{self, monotonic_ns};
use bus::message::{Command, CommandKind, ProcessState};
use bus::port::Request;
use bus::process::Process;

use super::{ReplayError, Replayer};
use crate::replay::Speed;
use crate::replay::account::Account;
use crate::replay::moment::{MomentError, Moments, Whence};
use crate::replay::transport::Control;

/// At other speeds nobody waits for the tracker's poses.
const UNKNOWN_POSE: &str = "the poses are made again, and the one that is shown is known at `--speed max` only";

impl Replayer<'_> {
    pub(super) fn answer(&mut self, request: Request, process: &mut Process) -> Result<(), ReplayError> {
        let command: Command = *request.command();
        if command.command_kind() == Some(CommandKind::Moment) {
            let written = self.moment(process)?;
            request.reply(written.as_deref().map_err(String::as_str))?;
            return Ok(());
        }
        let is_back = command.command_kind() == Some(CommandKind::StepBack) && !self.makes_again();
        let asked = match is_back {
            true => Ok(self.step_back()?),
            false => self.control(&command),
        };
        match asked {
            Ok(control) => {
                if matches!(control, Control::Seek(_) | Control::Show(_)) {
                    self.lockstep.forget();
                }
                self.transport.control(control, monotonic_ns());
                self.tell()?;
                request.reply(Ok(&self.note()))?;
            }
            Err(why) => request.reply(Err(&why))?,
        }
        Ok(())
    }

    /// Stands still and writes what is shown; in words what was written, or why not.
    fn moment(&mut self, process: &mut Process) -> Result<Result<String, String>, ReplayError> {
        let Some(folder) = &self.options.moments else {
            return Ok(Err("this replay was begun without a folder for moments".to_owned()));
        };
        self.transport.control(Control::Pause, monotonic_ns());
        self.tell()?;
        let Some(recorded) = self.last else {
            return Ok(Err("no pose was shown yet".to_owned()));
        };
        let pose = match self.options.frames.is_some() {
            false => recorded,
            true => match self.lockstep.made().filter(|made| made.seq == recorded.seq) {
                Some(made) => made,
                None => return Ok(Err(UNKNOWN_POSE.to_owned())),
            },
        };
        let (pose, standstill_judged) = self.judge.judged(pose);
        let moments = match self.moments.take() {
            Some(moments) => moments,
            None => Moments::open(&process.bus, &process.scene, folder)?,
        };
        let recorded = process
            .run
            .replay
            .as_ref()
            .and_then(|replay| replay.volume_hash.clone());
        let whence = Whence {
            recording: &self.options.recording,
            recorded_volume: recorded.as_deref(),
            shown_volume: &self.shown_volume,
            zero_ns: self.options.zero_ns,
            standstill_judged,
        };
        let guide = self.choices.at(pose.t_capture_ns);
        let written = moments.write(&pose, guide, whence, &mut || {
            process.beat(ProcessState::Ready, "writing a moment")
        });
        self.moments = Some(moments);
        Ok(match written {
            Ok((folder, images)) => Ok(format!("{} ({images} images)", folder.display())),
            Err(MomentError::Bus(error)) => return Err(error.into()),
            Err(error) => Err(error.to_string()),
        })
    }

    fn control(&self, command: &Command) -> Result<Control, String> {
        match command.command_kind() {
            Some(CommandKind::Pause) => Ok(Control::Pause),
            Some(CommandKind::Play) => Ok(Control::Play),
            Some(CommandKind::Step) => Ok(Control::Step),
            Some(CommandKind::Speed) if self.asked.is_some() => {
                Err("each pose waits for its state: this replay answers pause, play and step".to_owned())
            }
            Some(CommandKind::Speed) => Speed::from_number(command.number).map(Control::Speed),
            Some(CommandKind::Seek | CommandKind::StepBack) if self.makes_again() => {
                Err("what is made again is made in order: this replay answers pause, play, step and speed".to_owned())
            }
            Some(CommandKind::Seek) => {
                let last_s = self.seconds(self.options.span_ns[1]);
                let first_s = self.seconds(self.options.span_ns[0]);
                if !(first_s..=last_s).contains(&command.number) {
                    return Err(format!(
                        "there is no place {} s in this replay: it goes from {first_s:.3} s to {last_s:.3} s",
                        command.number
                    ));
                }
                Ok(Control::Seek(
                    self.options.zero_ns.saturating_add(clock::seconds(command.number)),
                ))
            }
            _ => Err("the replayer answers pause, play, step, step back, seek, speed and moment".to_owned()),
        }
    }

    /// A moment as people name it.
    fn seconds(&self, moment_ns: i64) -> f64 {
        clock::ms(moment_ns.saturating_sub(self.options.zero_ns)) / 1e3
    }

    /// Where the replay stands, for people.
    pub(super) fn note(&self) -> String {
        let place = self.last.map_or(self.options.span_ns[0], |pose| pose.t_publish_ns);
        let pose = self.last.map_or("-".to_owned(), |pose| pose.seq.to_string());
        let (place, end) = (self.seconds(place), self.seconds(self.options.span_ns[1]));
        let state = self.transport.state().word();
        let waits = self.lockstep.missing().map(|name| format!(", for {name}"));
        let waits = waits.unwrap_or_default();
        format!(
            "pose {pose}, {place:.2} of {end:.2} s, {state}, speed {}{waits}",
            self.transport.speed()
        )
    }

    pub(super) fn write_account(&self) -> Result<(), ReplayError> {
        let Some(path) = &self.options.account else {
            return Ok(());
        };
        let account = Account {
            recording: self.options.recording.display().to_string(),
            speed: self.transport.speed().to_string(),
            state: self.transport.state().word(),
            from_s: self.seconds(self.options.span_ns[0]),
            to_s: self.seconds(self.options.span_ns[1]),
            published: self.published,
            without_frames: self.without_frames,
            without_state: self.without_state,
            unanswered: self.unanswered,
            unread: self.unread(),
            wall_s: clock::ms(monotonic_ns() - self.began_ns) / 1e3,
            lateness: self.timing.lateness(),
            images: self.images.as_ref().map_or(0, |images| images.written),
            images_missing: self.images.as_ref().map_or(0, |images| images.missing),
            images_reason: self
                .images
                .as_ref()
                .map(|images| images.reason.clone())
                .unwrap_or_default(),
        };
        Ok(account.write(path)?)
    }
}
