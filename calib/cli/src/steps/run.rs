//! The process: requests in, `steps` out, the hand, the commands and the files.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

use bus::BusError;
use bus::clock;
use bus::message::{Command, CommandKind, ProcessState, StepWish, Steps, ToolPose, Tracked, Workflow};
use bus::port::{CommandClient, CommandServer, Publisher, Request, Subscriber};
use bus::process::{JoinError, Membership, Process};
use bus::topic::{STEPS, TOOL_POSE, WORKFLOW};
use guidance::workflow::Stage;
use scene::TrackerSource;

use super::course::{Around, Moment, Proposal};
use super::desk::{Desk, Todo};
use super::hand;
use super::job::{CarryOut, Job};
use crate::store::{self, StoreError};

/// The process's name in the run.
const NAME: &str = "calib";
/// Between two turns.
const TURN: Duration = Duration::from_millis(10);
/// So long the simulated hand takes to get there.
const GOING: Duration = Duration::from_millis(1500);
/// Between two messages of a step that listens.
const TELL: Duration = Duration::from_millis(100);
/// So long an answer is waited for.
const PATIENCE: Duration = Duration::from_millis(1500);

/// Why the process ended.
#[derive(Debug, thiserror::Error)]
pub(crate) enum StepsError {
    #[error(transparent)]
    Join(#[from] JoinError),
    #[error(transparent)]
    Bus(#[from] BusError),
    #[error("the scene has no table [steps]")]
    None,
    #[error("making the folder {path}: {source}")]
    Work { path: PathBuf, source: std::io::Error },
}

struct Serving {
    process: Process,
    carry_out: CarryOut,
    server: CommandServer,
    steps: Publisher<Steps>,
    poses: Subscriber<ToolPose>,
    workflows: Subscriber<Workflow>,
    workflow: Option<Workflow>,
    pilot: CommandClient,
    /// The simulated hand.
    hand: Option<CommandClient>,
    work: PathBuf,
    desk: Desk,
    job: Option<Job>,
    /// When the hand is there, ns on the run's clock.
    arrives_ns: Option<i64>,
    /// The registration that poses rest on; `None`: there is no pose.
    registration_id: Option<u64>,
    /// That at the beginning of the step that listens.
    began_under: Option<u64>,
    told: Option<Steps>,
    next_tell_ns: i64,
}

/// Serves the run until asked to stop.
pub(crate) fn run(membership: &Membership, work: PathBuf, carry_out: CarryOut) -> Result<(), StepsError> {
    let process = Process::join(NAME, membership)?;
    let made = fs::create_dir_all(&work);
    made.map_err(|source| StepsError::Work {
        path: work.clone(),
        source,
    })?;
    let around = around(&process, &work).ok_or(StepsError::None)?;
    let hand = around.room.map(|_| CommandClient::open(&process.bus, "tracker"));
    let mut serving = Serving {
        server: CommandServer::open(&process.bus, NAME)?,
        steps: Publisher::open(&process.bus, &STEPS, "")?,
        poses: Subscriber::open(&process.bus, &TOOL_POSE, "", 1)?,
        workflows: Subscriber::open(&process.bus, &WORKFLOW, "", 1)?,
        workflow: None,
        pilot: CommandClient::open(&process.bus, "pilot")?,
        hand: hand.transpose()?,
        process,
        carry_out,
        work,
        desk: Desk::new(around),
        job: None,
        arrives_ns: None,
        registration_id: None,
        began_under: None,
        told: None,
        next_tell_ns: i64::MIN,
    };
    while !serving.process.stop.is_set() {
        serving.turn()?;
        std::thread::sleep(TURN);
    }
    serving.process.beat(ProcessState::Stopping, "asked to stop")?;
    Ok(())
}

/// What the tasks of a scene have in common; `None` where it has none.
fn around(process: &Process, work: &Path) -> Option<Around> {
    let scene = &process.scene;
    let links = &scene.tracker.links;
    let chosen = scene.guide.as_ref();
    let chosen = chosen.and_then(|name| scene.targets.iter().find(|target| target.name == *name));
    // The tracker's gate counts the error at the first target.
    let target = scene.targets.first().or(chosen);
    Some(Around {
        run: process.run.name.clone(),
        work: work.to_owned(),
        files: [
            links.calibration.as_ref().map(|link| link.file.path.clone()),
            links.registration.as_ref().map(|link| link.file.path.clone()),
        ],
        spec: scene.steps.clone()?,
        target: target.map(|target| (target.name.clone(), target.centre)),
        check_mm: scene.workflow.check_mm,
        room: match &scene.tracker.source {
            TrackerSource::OperatingRoom(room) => room.practice,
            _ => None,
        },
    })
}

impl Serving {
    fn turn(&mut self) -> Result<(), StepsError> {
        self.hear_of_the_run()?;
        while let Some(request) = self.server.next()? {
            self.answer(request)?;
        }
        if let Some(pose) = self.poses.newest()? {
            let is_valid = matches!(pose.tracked(), Ok(Tracked::Valid(_)));
            self.registration_id = is_valid.then_some(pose.registration_id);
            if self.began_under != self.registration_id {
                self.began_under = None;
            }
        }
        let now_ns = self.process.clock().now_ns();
        if self.arrives_ns.is_some_and(|at_ns| now_ns >= at_ns) {
            self.arrives_ns = None;
            let todo = self.desk.arrived();
            self.carry_out(todo.into_iter().collect());
        }
        self.job_goes_on();
        self.tell(now_ns)?;
        self.process.beat(ProcessState::Ready, "")?;
        Ok(())
    }

    /// How far the run is, and whether the marker on the patient was moved.
    fn hear_of_the_run(&mut self) -> Result<(), BusError> {
        let Some(workflow) = self.workflows.newest()? else {
            return Ok(());
        };
        let before = self.workflow.replace(workflow).map_or(0, |workflow| workflow.bumps);
        if workflow.bumps != before {
            let todo = self.desk.moved();
            self.carry_out(todo);
        }
        Ok(())
    }

    fn job_goes_on(&mut self) {
        let Some(job) = &mut self.job else { return };
        // In this order: what a command says last, before it ends, is heard.
        let said = job.poll();
        if let Some(heard) = job.heard() {
            self.desk.hears(heard);
        }
        let Some(said) = said else { return };
        self.job = None;
        let moment = Moment {
            t_ns: self.process.session.clock().now_ns(),
            registration_id: self.began_under,
        };
        let todo = self.desk.said(said, moment);
        self.carry_out(todo);
    }

    /// Whether a person navigates, who started it herself: nothing that her screen rests on is changed meanwhile.
    fn navigates(&self) -> bool {
        let is_strict = |workflow: Workflow| !workflow.has(Workflow::RESEARCH);
        self.workflow
            .is_some_and(|workflow| is_strict(workflow) && workflow.stage() == Some(Stage::Navigating))
    }

    fn answer(&mut self, request: Request) -> Result<(), BusError> {
        let command = *request.command();
        let wish = match command.command_kind() {
            Some(CommandKind::Steps) => StepWish::of(&command),
            _ => None,
        };
        let Some(wish) = wish else {
            return request.reply(Err(
                "calib answers calibrate, register, check, begin, cancel, back, point and accept",
            ));
        };
        if self.navigates() && wish != StepWish::Cancel {
            return request.reply(Err("the run navigates: end the navigation first (`pilot rest`)"));
        }
        // What a command that was given up still says is not the next one's.
        if self.job.is_some() && wish == StepWish::Begin {
            return request.reply(Err("the step before is still ending; begin again in a moment"));
        }
        let answer = self
            .desk
            .wish(wish)
            .and_then(|(words, todo)| match self.carry_out(todo) {
                None => Ok(words),
                Some(why) => Err(why),
            });
        // Who is answered finds on the bus what came of it.
        self.next_tell_ns = i64::MIN;
        self.tell(self.process.clock().now_ns())?;
        request.reply(answer.as_deref().map_err(String::as_str))
    }

    /// Does what the desk asks for; why something could not be done, in words, which the desk knows then.
    fn carry_out(&mut self, todo: Vec<Todo>) -> Option<String> {
        let mut failed = None;
        for one in todo {
            if let Err(why) = self.one(one) {
                bus::stderr_line!("calib: {why}");
                self.desk.failed(why.clone());
                failed = Some(why);
            }
        }
        failed
    }

    fn one(&mut self, todo: Todo) -> Result<(), String> {
        match todo {
            Todo::Send(practice) => {
                let hand = self.hand.as_ref().ok_or("there is no simulated hand")?;
                let asked = ask(hand, Command::practise(&practice));
                asked.map_err(|why| format!("the simulated hand is not there yet, or does not do it: {why}"))?;
                self.arrives_ns = Some(self.process.clock().now_ns() + clock::ns(GOING));
            }
            Todo::Start(words) => {
                self.began_under = self.registration_id;
                self.job = Some(Job::start(words, &self.carry_out)?);
            }
            Todo::Cancel => {
                self.arrives_ns = None;
                self.job.iter().for_each(Job::cancel);
            }
            Todo::Write(proposal) => {
                self.write(&proposal)?;
                self.desk.written();
                self.follow_the_script();
            }
            Todo::Report(report) => {
                let moment = report.moment;
                let id = moment.registration_id.unwrap_or_default();
                let command = Command::checked(report.worst_mm, report.points, moment.t_ns, id).because(&report.fails);
                ask(&self.pilot, command)?;
                self.follow_the_script();
            }
        }
        Ok(())
    }

    /// The simulated hand goes on with its script.
    fn follow_the_script(&self) {
        if let Some(hand) = &self.hand {
            // Where it cannot be told it holds still, and nothing that is shown of it is false.
            let _ = ask(hand, Command::practise(&hand::approach()));
        }
    }

    /// Writes what a person accepted where the tracker reads it; what was there before is kept in the work folder.
    fn write(&self, proposal: &Proposal) -> Result<(), String> {
        let path = &proposal.path;
        if path.exists() {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            let at_ms = self.process.clock().now_ns() / 1_000_000;
            let kept = self.work.join(format!("replaced-{at_ms}-{name}"));
            fs::copy(path, &kept)
                .map_err(|error| format!("keeping {} as {}: {error}", path.display(), kept.display()))?;
        }
        let written = store::write(path, Ok(proposal.text.clone()), std::iter::empty());
        written.map_err(|error: StoreError| error.to_string())
    }

    fn tell(&mut self, now_ns: i64) -> Result<(), BusError> {
        self.steps.serve_late_joiners();
        if now_ns < self.next_tell_ns {
            return Ok(());
        }
        let told = self.desk.show(self.process.session.clock().now_ns());
        let is_news = self.told.is_none_or(|before| !same(&before, &told));
        if is_news {
            self.next_tell_ns = now_ns.saturating_add(clock::ns(TELL));
            self.steps.send(told)?;
            self.told = Some(told);
        }
        Ok(())
    }
}

/// Whether two messages say the same, whenever they do. NaNs are alike.
fn same(a: &Steps, b: &Steps) -> bool {
    format!("{:?}", Steps { t_ns: 0, ..*a }) == format!("{:?}", Steps { t_ns: 0, ..*b })
}

fn ask(whom: &CommandClient, command: Command) -> Result<String, String> {
    let reply = whom.ask(command, PATIENCE).map_err(|error| error.to_string())?;
    match reply.refused {
        true => Err(reply.text),
        false => Ok(reply.text),
    }
}
