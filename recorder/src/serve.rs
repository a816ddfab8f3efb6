//! A run, live in Foxglove: what a recording would hold, as it comes, and a scene of the tool, the targets and the planes.
//!
//! A research display: what it shows may be late or lost on its way, and nobody who operates goes by it. It says so on every image and
//! in the scene, and the tool is drawn only as long as an image of the run may claim its pose and the workflow lets it be shown.

mod cli;
mod label;
mod late;
mod outlet;
mod scene_update;
mod standing;
mod views;

use std::collections::VecDeque;
use std::net::{IpAddr, SocketAddr};
use std::time::Duration;

use bus::clock;
use bus::message::{Level, ToolPose, Workflow};
use bus::port::Subscriber;
use bus::process::{JoinError, StopFlag};
use bus::run::{RunContext, RunError, run_dir};
use bus::session::Session;
use bus::topic::TOOL_POSE;
use bus::{Bus, BusError};
use foxglove::messages::Timestamp;
use scene::Scene;

use crate::wire::proto::Log;
use crate::wire::schema::Source;
use crate::write::pose_log::{Entry, Take};
use crate::write::record::watch::Watch;
pub(crate) use cli::{SERVE_HELP, ServeArgs};
use label::Label;
use late::Late;
use outlet::Outlet;
use standing::Standing;
use views::{Claim, Views};

/// Between two looks at the topics.
const TICK: Duration = Duration::from_millis(20);
/// Between two scenes, and between two notices that this is a research display: who comes late has them then.
const SCENE_EVERY: Duration = Duration::from_millis(100);
const NOTICE_EVERY: Duration = Duration::from_secs(5);
/// Between two looks whether the run goes on.
const LOOK_EVERY: Duration = Duration::from_millis(200);
/// Behind every process of the run.
const NICE: i32 = 10;
/// What clients are told where this process ends and the run does not.
const STOPPED: &str = "NOT SERVED ANY MORE";
/// What is said wherever there is room.
pub(super) const NOTICE: &str = "RESEARCH DISPLAY";
/// Poses that are kept for the images that show them.
const KEPT: usize = 4096;

/// Why nothing is served, or not any longer.
#[derive(Debug, thiserror::Error)]
pub(crate) enum ServeError {
    /// There is no such run.
    #[error(transparent)]
    Run(#[from] RunError),
    /// Its scene.
    #[error("the run's scene: {0}")]
    Scene(#[from] scene::SceneError),
    /// Signals.
    #[error(transparent)]
    Join(#[from] JoinError),
    /// The bus.
    #[error(transparent)]
    Bus(#[from] BusError),
    /// Other machines could look on.
    #[error(
        "--listen {found}: only this machine's own addresses are served, as nothing asks who looks on: for another machine forward the \
         port, for instance with `ssh -L 8765:localhost:8765`"
    )]
    NotLoopback {
        /// The address.
        found: IpAddr,
    },
    /// The server did not start.
    #[error("serving on {address}: {source}")]
    Server {
        /// Where.
        address: SocketAddr,
        /// Why.
        source: foxglove::FoxgloveError,
    },
}

/// Serves a run until it ends or this process is asked to stop.
///
/// # Errors
/// [`ServeError`].
pub(crate) fn serve(args: &ServeArgs) -> Result<(), ServeError> {
    if !args.listen.ip().is_loopback() {
        return Err(ServeError::NotLoopback {
            found: args.listen.ip(),
        });
    }
    let (run, text) = RunContext::load_with_scene(&run_dir(&args.run)?, None)?;
    let scene = Scene::parse(&text, &run.scene_path())?;
    let stop = StopFlag::install(false)?;
    // Threads that are started from here on have it too. Where the system refuses it, this only takes the more of the processor.
    let _ = rustix::process::setpriority_process(None, NICE);
    let mut served = Served::open(&run, &scene, args)?;
    bus::stderr_line!(
        "recorder: serving run {} on ws://{}; in Foxglove open a connection of the kind Foxglove WebSocket. {NOTICE}: nobody operates by it",
        run.name,
        SocketAddr::new(args.listen.ip(), served.outlet.port())
    );
    let (ended, result) = served.follow(&run, &stop);
    served.goodbye(ended);
    result
}

/// A run being served.
struct Served<'a> {
    scene: &'a Scene,
    origin: &'static str,
    session: Session,
    poses: Subscriber<ToolPose>,
    watch: Watch,
    views: Views,
    outlet: Outlet,
    /// The newest, for the images that show them.
    known: VecDeque<ToolPose>,
    standing: Standing,
    next_scene_ns: i64,
    next_notice_ns: i64,
}

impl<'a> Served<'a> {
    fn open(run: &RunContext, scene: &'a Scene, args: &ServeArgs) -> Result<Self, ServeError> {
        let bus = Bus::join(run)?;
        let origin = standing::origin(run, scene);
        Ok(Self {
            scene,
            origin,
            session: Session::open(&bus, run)?,
            poses: Subscriber::open(&bus, &TOOL_POSE, "", TOOL_POSE.buffer)?,
            watch: Watch::open(&bus, scene)?,
            views: Views::open(&bus, scene, args.every)?,
            outlet: Outlet::start(scene, origin, args.listen)?,
            known: VecDeque::new(),
            standing: Standing::NoImage,
            next_scene_ns: i64::MIN,
            next_notice_ns: i64::MIN,
        })
    }

    /// Until the run ends or this process is asked to stop: what clients are to be told of it.
    fn follow(&mut self, run: &RunContext, stop: &StopFlag) -> (&'static str, Result<(), ServeError>) {
        let mut next_look_ns = i64::MIN;
        let mut late = Late::new(self.outlet.port());
        while !stop.is_set() {
            let steady_ns = clock::monotonic_ns();
            if steady_ns >= next_look_ns {
                next_look_ns = steady_ns.saturating_add(clock::ns(LOOK_EVERY));
                if !run.is_running() {
                    bus::stderr_line!("recorder: run {} has ended", run.name);
                    return ("THE RUN HAS ENDED", Ok(()));
                }
            }
            if let Err(error) = self.step(steady_ns) {
                return (STOPPED, Err(error));
            }
            late.step(steady_ns);
            std::thread::sleep(TICK);
        }
        (STOPPED, Ok(()))
    }

    fn step(&mut self, steady_ns: i64) -> Result<(), ServeError> {
        self.poses()?;
        let now_ns = self.session.clock().now_ns();
        self.watch.step(now_ns, &mut self.outlet)?;
        let label = Label {
            origin: self.origin,
            is_withheld: standing::withheld(self.outlet.workflow()).is_some(),
        };
        self.views.step((now_ns, steady_ns), label, &mut self.outlet)?;
        let had_pose = self.standing.has_pose();
        self.standing = self.judged(now_ns);
        let has_pose = self.standing.has_pose();
        self.outlet.tool(now_ns, has_pose);
        if has_pose && !had_pose {
            self.tell_transform(now_ns);
        }
        if had_pose != has_pose || steady_ns >= self.next_scene_ns {
            self.next_scene_ns = steady_ns.saturating_add(clock::ns(SCENE_EVERY));
            self.tell_scene(now_ns);
        }
        if steady_ns >= self.next_notice_ns {
            self.next_notice_ns = steady_ns.saturating_add(clock::ns(NOTICE_EVERY));
            self.tell_again(now_ns);
        }
        Ok(())
    }

    /// Takes the poses that came.
    fn poses(&mut self) -> Result<(), ServeError> {
        let mut samples = Vec::new();
        while let Some(sample) = self.poses.next()? {
            samples.push(sample);
        }
        // After the poses were taken: a replayer has said before them what time it is.
        let has_jumped = self.session.follow()?;
        let now_ns = self.session.clock().now_ns();
        if has_jumped {
            // Transforms of later are none of now: Foxglove would go on with them.
            self.outlet.forget(now_ns);
            samples.retain(|sample| !self.session.is_yet_to_come(sample.t_publish_ns));
        }
        for sample in samples {
            self.outlet.put(now_ns, Entry::Pose(Source::Tool, &sample));
            self.watch.pose(now_ns, &sample, &mut self.outlet);
            if self.known.len() == KEPT {
                self.known.pop_front();
            }
            self.known.push_back(sample);
        }
        Ok(())
    }

    /// Of the pose that is shown: it came when no transform might be told yet.
    fn tell_transform(&mut self, now_ns: i64) {
        let shown = self.views.claim(now_ns).and_then(|claim| self.sample(claim)).copied();
        if let Some(sample) = shown {
            self.outlet.transform(&sample);
        }
    }

    /// The sample that an image shows; `None` where it did not come here.
    fn sample(&self, claim: Claim) -> Option<&ToolPose> {
        let is_it = |pose: &&ToolPose| pose.seq == claim.seq && pose.t_capture_ns == claim.t_capture_ns;
        self.known.iter().rev().find(is_it)
    }

    fn judged(&self, now_ns: i64) -> Standing {
        let claim = self.views.claim(now_ns);
        let shows = claim.and_then(|claim| self.sample(claim));
        Standing::of(self.outlet.workflow(), self.known.back(), claim.as_ref(), shows, now_ns)
    }

    fn tell_scene(&mut self, now_ns: i64) {
        if !self.standing.has_pose() {
            // Again and again: who came late or lost messages still draws the last one.
            self.outlet.forget(now_ns);
        }
        let marks = self.outlet.workflow().map(Workflow::marks).unwrap_or_default();
        let marks = [self.origin].into_iter().chain(marks.iter().map(|mark| mark.word()));
        let marks: Vec<_> = marks.filter(|mark| !mark.is_empty()).collect();
        let planes = self.views.planes(now_ns);
        let update = scene_update::of(self.scene, Timestamp::now(), &self.standing, &marks, &planes);
        self.outlet.scene(now_ns, &update);
    }

    fn tell_again(&mut self, now_ns: i64) {
        self.outlet.again();
        self.views.again();
        let words = format!("{NOTICE}: what is shown here may be late or lost on its way; nobody operates by it");
        let words = [self.origin, &words].join(" ").trim().to_owned();
        let log = Log::new(now_ns, Level::Warning, "recorder", words);
        self.outlet.put(now_ns, Entry::Log(now_ns, &log));
    }

    /// Takes the tool back, says why, and ends all connections.
    fn goodbye(mut self, why: &'static str) {
        self.standing = Standing::Ended(why);
        self.tell_scene(self.session.clock().now_ns());
        self.outlet.stop();
    }
}
