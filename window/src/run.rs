//! The window's process: from the bus to the glass.

use std::ops::ControlFlow;
use std::os::fd::AsFd;
use std::time::Duration;

use bus::BusError;
use bus::clock;
use bus::gather::Set;
use bus::message::ProcessState;
use bus::process::{Membership, Process};
use bus::wake::Waits;

use crate::display::{Display, Happened};
use crate::feed::{Feed, Now, began_ns, stale_ns};
use crate::frame::{Coded, Frames, Painted};
use crate::look;
use crate::model::{Model, ReplayModel};
use crate::planning;
use crate::ports::{Has, Ports};
use crate::program::{Options, RunError, write_shot};
use crate::screen::{Look, Wish};
use crate::wishes::Asked;

/// The loop comes round at least this often.
const TICK: Duration = Duration::from_millis(15);
/// A frame is painted at least this often: an age on it stays true, and a coded cell that stands still is a window that does.
const SLOWEST: Duration = Duration::from_millis(50);
/// Sets of different poses follow one another with each image: not more often than this.
const MIXED: Duration = Duration::from_millis(33);

/// So long a refusal stands on the screen.
const SAID: Duration = Duration::from_secs(5);

struct Window {
    process: Process,
    display: Display,
    feed: Feed,
    frames: Frames,
    asked: Asked,
    look: Look,
    coded: Coded,
    /// Keys and touches since the last frame.
    events: Vec<egui::Event>,
    /// What the last frame showed, and when it was painted, ns on the run's clock.
    painted: Option<(Option<Set>, i64)>,
    /// Until then the answer to a wish that was refused stands on the screen, ns on the run's clock.
    said_until_ns: i64,
    shots: u32,
}

/// Shows the run until asked to stop.
///
/// # Errors
/// Each variant of [`RunError`].
pub(crate) fn run(membership: &Membership, options: Options) -> Result<(), RunError> {
    let mut process = Process::join(&options.name, membership)?;
    process.beat(ProcessState::Starting, "opening the display")?;
    let display = Display::open(&options.wanted)?;
    if process.run.planning {
        return planning::run(process, display, options);
    }
    let has = Has::of(&process.run, &process.scene);
    let ports = Ports::open(&process.bus, &process.scene, has)?;
    let asked = Asked::open(&process.bus, &process.scene, has, options.shots)?;
    let coded = Coded {
        key: crate::code::key(process.run.epoch_ns),
        pid: std::process::id(),
    };
    let look = look::read(&process.run.dir, &options.name, &process.scene);
    let mut window = Window {
        feed: Feed::new(process.scene.views.len(), process.volumes()?),
        look: Look {
            only_sight: options.only_sight,
            ..look
        },
        process,
        display,
        frames: Frames::default(),
        asked,
        coded,
        events: Vec::new(),
        painted: None,
        said_until_ns: 0,
        shots: 0,
    };
    let connection = window.display.connection();
    let waits = ports.waits(Waits::every(TICK)).readable(connection.stream().as_fd());
    waits.run(|| match window.step(&ports) {
        Ok(ControlFlow::Continue(())) => ControlFlow::Continue(()),
        Ok(ControlFlow::Break(())) => ControlFlow::Break(Ok(())),
        Err(error) => ControlFlow::Break(Err(error)),
    })?
}

impl Window {
    fn step(&mut self, ports: &Ports) -> Result<ControlFlow<()>, RunError> {
        if self.process.stop.is_set() {
            self.process.beat(ProcessState::Stopping, "asked to stop")?;
            return Ok(ControlFlow::Break(()));
        }
        for happened in self.display.happened()? {
            match happened {
                Happened::Input(event) => self.events.push(event),
                Happened::Exposed => self.show_all()?,
                Happened::Resized(_) => {
                    self.frames.forget();
                    self.painted = None;
                }
            }
        }
        // Before the images: those of poses behind a jump come after it.
        if self.follow()? {
            self.feed.forget();
        }
        self.feed.take(ports)?;
        match self.asked.hear() {
            Ok(None) => {}
            Ok(Some(words)) => self.tell(format!("written: {words}"), true),
            Err(why) => self.say(why),
        }
        let now = self.now();
        let set = self.feed.choose(now.session_ns, stale_ns(&self.process.scene));
        if let Err(why) = self.asked.draw_held(&self.feed, now.run_ns) {
            self.say(why);
        }
        if let Err(why) = self.asked.drag_level(now.run_ns) {
            self.say(why);
        }
        if let Err(why) = self.asked.turn_overview(&self.feed, &self.process.scene) {
            self.say(why);
        }
        if self.is_due(set, now.run_ns) {
            self.paint(set, now)?;
        }
        self.process.beat(ProcessState::Ready, &self.look.note)?;
        Ok(ControlFlow::Continue(()))
    }

    /// Takes over the clock of a replay; returns whether that went elsewhere. An impossible clock is refused, and the one before goes on.
    fn follow(&mut self) -> Result<bool, BusError> {
        match self.process.session.follow() {
            Err(BusError::Law(_)) => Ok(false),
            followed => followed,
        }
    }

    fn now(&self) -> Now {
        Now {
            session_ns: self.process.session.clock().now_ns(),
            run_ns: self.process.clock().now_ns(),
            began_ns: began_ns(&self.process.run),
        }
    }

    fn is_due(&self, set: Option<Set>, now_ns: i64) -> bool {
        let Some((shown, at_ns)) = self.painted else {
            return true;
        };
        let since = now_ns - at_ns;
        match set {
            Some(Set::One(_)) if shown != set => true,
            Some(Set::Mixed { .. }) if shown != set && since >= clock::ns(MIXED) => true,
            _ => !self.events.is_empty() || since >= clock::ns(SLOWEST),
        }
    }

    fn paint(&mut self, set: Option<Set>, now: Now) -> Result<(), RunError> {
        let (scene, replay) = (&self.process.scene, self.process.run.replay.as_ref());
        let mut known = self.feed.known(scene, &self.process.session, now, replay);
        // What is read back is the window with the images.
        known.watched_ns = known.watched_ns.filter(|_| !self.look.only_sight);
        let model = Model::of(&known);
        if self.said_until_ns <= now.run_ns {
            self.look.note.clear();
        }
        let screen = self.display.screen();
        let events = (std::mem::take(&mut self.events), clock::ms(now.run_ns) / 1000.0);
        let with = (screen, &self.look);
        let pixels = self.display.pixels();
        let painted = self
            .frames
            .paint((&model, &self.feed), with, events, self.coded, pixels)?;
        self.tell_place(&painted)?;
        self.display.present(&painted.parts)?;
        self.painted = Some((set, now.run_ns));
        self.process.counters.published += 1;
        for wish in &painted.outcome.wishes {
            self.carry_out(wish, model.replay.as_ref());
        }
        Ok(())
    }

    /// Where the coded cell lies, before the first frame that has it is on the glass.
    fn tell_place(&mut self, painted: &Painted) -> Result<(), RunError> {
        let Some((code, place)) = painted.code else {
            return Ok(());
        };
        self.process.painted = (code.word(), self.process.clock().now_ns());
        if self.frames.has_moved(place) {
            self.display.set_place(place)?;
        }
        Ok(())
    }

    fn show_all(&mut self) -> Result<(), RunError> {
        let [width, height] = self.display.screen().pixels;
        self.display.present(&[[0, 0, width, height]])?;
        Ok(())
    }

    fn carry_out(&mut self, wish: &Wish, replay: Option<&ReplayModel>) {
        let answer = match wish {
            Wish::Enlarge(view) => {
                // The same again shows all.
                self.look.enlarged = view.filter(|_| self.look.enlarged != *view);
                self.keep_look()
            }
            Wish::Views(views) => {
                self.look.views = *views;
                self.keep_look()
            }
            Wish::Steps(steps) => {
                self.look.steps = *steps;
                self.keep_look()
            }
            Wish::Shot => self.shot(),
            wish => {
                let now_ns = self.process.session.clock().now_ns();
                let law = self.process.session.replay().map(|law| (*law, now_ns));
                self.asked
                    .carry_out(wish, &self.feed, &self.process.scene, (law, replay))
            }
        };
        if let Err(why) = answer {
            self.say(why);
        }
    }

    /// Why a wish was refused stands on the screen for a while.
    fn say(&mut self, why: String) {
        bus::stderr_line!("window: {why}");
        self.tell(why, false);
    }

    /// Words for a while: of what was done, or of a refusal.
    fn tell(&mut self, words: String, is_done: bool) {
        (self.look.note, self.look.is_done) = (words, is_done);
        self.said_until_ns = self.process.clock().now_ns() + clock::ns(SAID);
    }

    fn keep_look(&self) -> Result<(), String> {
        let (run, scene) = (&self.process.run, &self.process.scene);
        look::write(&run.dir, self.process_name(), &self.look, scene)
    }

    fn process_name(&self) -> &'static str {
        if self.look.only_sight { "sight" } else { "window" }
    }

    /// A picture of the screen as it stands there. Written by a thread of its own: a window that stands still while a file is
    /// compressed is taken for frozen.
    fn shot(&mut self) -> Result<(), String> {
        self.shots += 1;
        let size = self.display.screen().pixels;
        let at_ms = self.process.clock().now_ns() / 1_000_000;
        let path = self.asked.shots.join(format!("screen-{at_ms}-{}.png", self.shots));
        write_shot(self.display.pixels(), size, path)
    }
}
