//! What a person wishes becomes requests to the processes that keep it: the window keeps nothing.

mod images;
mod level;
mod replay;
mod turning;

use std::path::PathBuf;

use bus::gather::PoseId;
use bus::message::{ClockLaw, Command, CommandKind, StepWish, ToolPose};
use bus::port::{CommandClient, Pending};
use bus::{Bus, BusError};
use guidance::workflow::Stage;
use scene::{Plane, Scene};

use crate::feed::Feed;
use crate::model::ReplayModel;
use crate::ports::Has;
use crate::screen::Wish;
use level::Level;
use replay::{Replayer, Steering, steering};
use turning::Turning;

/// So long the answers to a wish are waited for. The window goes on painting meanwhile.
const PATIENCE_NS: i64 = 1_000_000_000;
/// The same where files are written.
const WRITING_NS: i64 = 20_000_000_000;
/// So many wishes may be without an answer.
const MOST_OPEN: usize = 8;
/// The replayer's process.
const REPLAYER: &str = "replay";
/// The process that listens to the localizer.
const LOCALIZER: &str = "localizer";
/// The process that calibrates, registers and checks.
const CALIBRATOR: &str = "calib";

/// Whoever is asked.
#[derive(Debug)]
pub struct Asked {
    pilot: CommandClient,
    renderers: Vec<CommandClient>,
    replayer: Option<Replayer>,
    /// Who calibrates, registers and checks, where the scene has steps.
    calibrator: Option<CommandClient>,
    open: Vec<Open>,
    /// The window that is dragged, and the request for it.
    level: (Level, level::Open),
    /// The overview that is turned, and who draws it, where the scene has one.
    turning: Option<(Turning, CommandClient)>,
    /// The pose held that was asked for last, and when, ns on the run's clock.
    drawn: Option<(PoseId, i64)>,
    /// Where pictures of the screen go.
    pub shots: PathBuf,
}

/// What was asked for a wish and is not answered yet.
#[derive(Debug)]
struct Open {
    pending: Vec<Pending>,
    /// What the pilot is asked once all have agreed.
    then: Option<Command>,
    /// Files are written for it: it takes longer, and the answer says which.
    writes: bool,
}

impl Asked {
    /// Prepares to ask the processes of a run.
    ///
    /// # Errors
    /// [`BusError::Open`].
    pub fn open(bus: &Bus, scene: &Scene, has: Has, shots: PathBuf) -> Result<Self, BusError> {
        let renderers = scene.renderers().into_iter().map(|(plane, _)| plane.process());
        Ok(Self {
            pilot: CommandClient::open(bus, "pilot")?,
            renderers: renderers
                .map(|name| CommandClient::open(bus, &name))
                .collect::<Result<_, _>>()?,
            replayer: has
                .replay
                .then(|| CommandClient::open(bus, REPLAYER).map(Replayer::new))
                .transpose()?,
            calibrator: has.steps.then(|| CommandClient::open(bus, CALIBRATOR)).transpose()?,
            open: Vec::with_capacity(MOST_OPEN),
            level: Default::default(),
            turning: scene
                .views
                .iter()
                .any(|view| view.plane == Plane::Surface)
                .then(|| CommandClient::open(bus, &Plane::Surface.process()))
                .transpose()?
                .map(|renderer| (Turning::default(), renderer)),
            drawn: None,
            shots,
        })
    }

    /// Asks for what is wished, and waits for nothing; `replay` is the clock of a replay with what it shows now, ns, and the replay as the
    /// screen shows it.
    ///
    /// # Errors
    /// In words: that it cannot be asked for.
    pub fn carry_out(
        &mut self,
        wish: &Wish,
        feed: &Feed,
        scene: &Scene,
        (law, replay): (Option<(ClockLaw, i64)>, Option<&ReplayModel>),
    ) -> Result<(), String> {
        let steering = law.and_then(|(law, now_ns)| steering(wish, (&law, now_ns), replay));
        if let Some(steering) = steering {
            return self.steer(steering?);
        }
        let asked = match wish {
            Wish::NextTarget { is_forward } => {
                let name = next_target(feed, scene, *is_forward).ok_or("the scene has no targets")?;
                self.pilot(Command::with_text(CommandKind::Choose, &name))
            }
            Wish::Level { wider_hu, up_hu } => {
                let now = feed.guide().and_then(|guide| guide.images().ok()).unwrap_or_default();
                self.level.0.drag(images::window(now, scene)?, [*wider_hu, *up_hu]);
                return Ok(());
            }
            Wish::Turn { .. } | Wish::TurnBack(_) => {
                let (turning, _) = self.turning.as_mut().ok_or("the scene has no overview")?;
                match *wish {
                    Wish::TurnBack(view) => turning.back(view),
                    Wish::Turn {
                        view,
                        right_px,
                        down_px,
                    } => turning.drag(view, [right_px, down_px], scene),
                    _ => {}
                }
                return Ok(());
            }
            Wish::Images(key) => {
                self.level.0.forget();
                let now = feed.guide().and_then(|guide| guide.images().ok()).unwrap_or_default();
                self.pilot(Command::images(images::wish(*key, now, scene)?))
            }
            Wish::Mark => self.pilot(Command::with_text(CommandKind::Mark, "marked on the screen")),
            Wish::Hold => self.hold(feed, scene),
            Wish::Step(wish) => self.calibrator(*wish),
            Wish::NextPoint { is_forward } => self.calibrator(next_point(feed, *is_forward)?),
            Wish::Confirm => {
                let hash = feed.volume().ok_or("there is no examination to be confirmed")?;
                self.pilot(Command::with_text(CommandKind::Confirm, &hash.to_string()))
            }
            Wish::Reject => self.pilot(Command::new(CommandKind::Reject)),
            Wish::Navigate => {
                let stage = feed.workflow().and_then(|workflow| workflow.stage());
                self.pilot(Command::new(match stage {
                    Some(Stage::Navigating) => CommandKind::Rest,
                    _ => CommandKind::Navigate,
                }))
            }
            Wish::Moved => self.pilot(Command::new(CommandKind::Bumped)),
            Wish::RestartLocalizer => self.pilot(Command::with_text(CommandKind::Restart, LOCALIZER)),
            Wish::Pause
            | Wish::OnePose
            | Wish::PoseBefore
            | Wish::Moment
            | Wish::Skip(_)
            | Wish::Seek(_)
            | Wish::NextMark { .. }
            | Wish::Speed { .. } => Err("there is no recording to go through".to_owned()),
            // Of this screen alone.
            Wish::Shot | Wish::Enlarge(_) | Wish::Views(_) | Wish::Steps(_) => return Ok(()),
        };
        self.waits_for(asked?)
    }

    fn waits_for(&mut self, asked: Open) -> Result<(), String> {
        if self.open.len() == MOST_OPEN {
            return Err(format!("{MOST_OPEN} wishes are without an answer already"));
        }
        self.open.push(asked);
        Ok(())
    }

    fn steer(&mut self, steering: Steering) -> Result<(), String> {
        let replayer = self.replayer.as_mut().ok_or("this is no replay")?;
        match steering {
            Steering::Seek(to_s) => replayer.seek(to_s),
            Steering::Plain(kind) => {
                let open = Open::one(send(replayer.client(), Command::new(kind))?);
                self.waits_for(match kind {
                    CommandKind::Moment => open.patient(),
                    _ => open,
                })
            }
            Steering::Speed(speed) => {
                let command = Command::with_number(CommandKind::Speed, speed);
                let open = Open::one(send(replayer.client(), command)?);
                self.waits_for(open)
            }
        }
    }

    /// Takes in the answers that have come, and returns what of them a person is to read. To be called again and again.
    ///
    /// # Errors
    /// In words, of the first wish that was refused, or that nobody answered in time.
    pub fn hear(&mut self) -> Result<Option<String>, String> {
        let mut heard = match &mut self.replayer {
            Some(replayer) => replayer.hear(PATIENCE_NS).map(|()| None),
            None => Ok(None),
        };
        for mut open in std::mem::take(&mut self.open) {
            let answer = open.hear();
            if let Ok(Some(words)) = &answer {
                heard = heard.map(|_| Some(words.clone()));
            }
            let next = answer.and_then(|_| match (open.pending.is_empty(), open.then.take()) {
                (true, Some(command)) => self.pilot(command).map(Some),
                (true, None) => Ok(None),
                (false, then) => Ok(Some(Open { then, ..open })),
            });
            match next {
                Ok(next) => self.open.extend(next),
                Err(why) => heard = heard.and(Err(why)),
            }
        }
        heard
    }

    /// Asks for the window that was dragged to; again and again.
    ///
    /// # Errors
    /// In words, why it was refused.
    pub fn drag_level(&mut self, now_ns: i64) -> Result<(), String> {
        let (level, open) = &mut self.level;
        level.turn((&self.pilot, open), now_ns, PATIENCE_NS)
    }

    /// Asks for the overview to be seen from where it was turned to; again and again.
    ///
    /// # Errors
    /// In words, why it was refused.
    pub fn turn_overview(&mut self, feed: &Feed, scene: &Scene) -> Result<(), String> {
        match &mut self.turning {
            Some((turning, renderer)) => turning.turn(renderer, (feed.grid(), scene), PATIENCE_NS),
            None => Ok(()),
        }
    }

    fn pilot(&self, command: Command) -> Result<Open, String> {
        Ok(Open::one(send(&self.pilot, command)?))
    }

    fn calibrator(&self, wish: StepWish) -> Result<Open, String> {
        let calibrator = self.calibrator.as_ref().ok_or("the scene has no [steps]")?;
        Ok(Open::one(send(calibrator, wish.command())?))
    }

    /// Has every view drawn of the pose that is held where an image of it is missing, at `now_ns` on the run's clock; again and again,
    /// as a renderer may be about to come back.
    ///
    /// # Errors
    /// In words: that it cannot be asked for.
    pub fn draw_held(&mut self, feed: &Feed, now_ns: i64) -> Result<(), String> {
        let Some(pose) = feed.held_undrawn() else { return Ok(()) };
        let id = PoseId {
            seq: pose.seq,
            t_capture_ns: pose.t_capture_ns,
        };
        let was_asked = |(asked, at_ns): (PoseId, i64)| asked == id && now_ns.saturating_sub(at_ns) <= PATIENCE_NS;
        // A renderer is asked for one thing at a time.
        if self.drawn.is_some_and(was_asked) || !self.open.is_empty() {
            return Ok(());
        }
        self.drawn = Some((id, now_ns));
        let pending = self.render(pose)?;
        self.open.push(Open {
            pending,
            then: None,
            writes: false,
        });
        Ok(())
    }

    fn render(&self, pose: ToolPose) -> Result<Vec<Pending>, String> {
        let renderers = self.renderers.iter();
        renderers
            .map(|renderer| send(renderer, Command::render(pose)))
            .collect()
    }

    /// Has every view drawn of the pose shown, and then says that it is held; or follows again.
    fn hold(&mut self, feed: &Feed, scene: &Scene) -> Result<Open, String> {
        if feed.guide().is_some_and(|guide| guide.held().is_some()) {
            // Who follows again has done with what she wished to hold before, though its images are still being drawn.
            self.open.retain(|open| open.then.is_none());
            return self.pilot(Command::new(CommandKind::Follow));
        }
        if self.open.iter().any(|open| open.then.is_some()) {
            return Err("what is to be held is being drawn".to_owned());
        }
        let pose: ToolPose = feed.pose_shown(scene).ok_or("there is no pose to hold")?;
        Ok(Open {
            pending: self.render(pose)?,
            then: Some(Command::hold(pose)),
            writes: false,
        })
    }
}

impl Open {
    fn one(pending: Pending) -> Self {
        Self {
            pending: vec![pending],
            then: None,
            writes: false,
        }
    }

    /// The same of something for which files are written.
    fn patient(self) -> Self {
        Self { writes: true, ..self }
    }

    /// Lets go of those that have agreed; what a person is to read of their answers.
    fn hear(&mut self) -> Result<Option<String>, String> {
        let mut heard = Ok(None);
        let writes = self.writes;
        let patience_ns = if writes { WRITING_NS } else { PATIENCE_NS };
        self.pending.retain(|pending| match pending.reply() {
            Ok(None) if pending.waited_ns() <= patience_ns => true,
            Ok(Some(reply)) if !reply.refused => {
                if writes {
                    heard = Ok(Some(reply.text));
                }
                false
            }
            Ok(Some(reply)) => {
                heard = Err(reply.text);
                false
            }
            Ok(None) => {
                heard = Err(pending.no_answer().to_string());
                false
            }
            Err(error) => {
                heard = Err(error.to_string());
                false
            }
        });
        heard
    }
}

fn send(client: &CommandClient, command: Command) -> Result<Pending, String> {
    client.send(command).map_err(|error| error.to_string())
}

/// The choice of the point after the one that is touched next, or before it.
fn next_point(feed: &Feed, is_forward: bool) -> Result<StepWish, String> {
    let steps = feed.steps().ok_or("nothing came from the calibrator")?;
    let count = u32::try_from(steps.points().len()).unwrap_or(u32::MAX);
    if count == 0 {
        return Err("there are no points to choose from".to_owned());
    }
    let next = match is_forward {
        _ if steps.next >= count => {
            if is_forward {
                0
            } else {
                count - 1
            }
        }
        true => (steps.next + 1) % count,
        false => (steps.next + count - 1) % count,
    };
    Ok(StepWish::Point(next))
}

/// The target of the scene after the chosen one, or before it; the first where none is chosen.
fn next_target(feed: &Feed, scene: &Scene, is_forward: bool) -> Option<String> {
    let chosen = feed.guide().and_then(|guide| guide.chosen().ok().flatten());
    let place = chosen.and_then(|chosen| scene.targets.iter().position(|target| target.name == chosen.name));
    let count = scene.targets.len();
    let next = match (place, is_forward) {
        (None, _) => 0,
        (Some(place), true) => (place + 1) % count,
        (Some(place), false) => (place + count - 1) % count,
    };
    scene.targets.get(next).map(|target| target.name.clone())
}
