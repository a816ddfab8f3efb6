//! The loop of the planning screen: from the bus and the person to the glass and back.

use std::ops::ControlFlow;
use std::os::fd::AsFd;
use std::path::PathBuf;
use std::rc::Rc;
use std::time::Duration;

use bus::clock;
use bus::message::{Heartbeat, Identity, ImagePlane, Plan as Told, ProcessState, Workflow};
use bus::port::Subscriber;
use bus::process::Process;
use bus::topic::{HEARTBEAT, IDENTITY, PLAN, WORKFLOW};
use bus::wake::Waits;
use bus::{Bus, BusError};
use guidance::plan::Plan;
use guidance::workflow::VolumeId;

use super::asked::Asked;
use super::band::{self, Heard};
use super::camera::CUTS;
use super::desk::Desk;
use super::labels::Labels;
use super::looks::Looks;
use super::screen::{self, Known, Outcome};
use super::volume::Examination;
use crate::code::Shown;
use crate::display::{Display, Happened};
use crate::frame::{Coded, Frames, image};
use crate::program::{Options, RunError, write_shot};

/// The loop comes round at least this often: an answer does not wake it, and the next request waits for the answer.
const TICK: Duration = Duration::from_millis(4);
/// A frame is painted at least this often: a coded cell that stands still is a window that does.
const SLOWEST: Duration = Duration::from_millis(100);
/// After a step of the wheel the next slice is awaited so long before a frame is painted without it.
const AWAITED: Duration = Duration::from_millis(12);
/// So long a refusal stands on the screen.
const SAID: Duration = Duration::from_secs(5);

/// What comes over the bus.
struct Ports {
    plan: Subscriber<Told>,
    identity: Subscriber<Identity>,
    workflow: Subscriber<Workflow>,
    watcher: Subscriber<Heartbeat>,
}

struct Planning {
    process: Process,
    display: Display,
    options: Options,
    frames: Frames,
    coded: Coded,
    examination: Examination,
    labels: Labels,
    heard: Heard,
    desk: Option<Desk>,
    kept: Option<Desk>,
    asked: Asked,
    events: Vec<egui::Event>,
    painted_ns: i64,
    /// While an image is awaited that a frame was not painted for: when it is painted all the same, ns on the run's clock.
    paint_by_ns: Option<i64>,
    is_due: bool,
    said_until_ns: i64,
    shots: u32,
}

impl Ports {
    fn open(bus: &Bus) -> Result<Self, BusError> {
        Ok(Self {
            plan: Subscriber::open_waking(bus, &PLAN, "", 1)?,
            identity: Subscriber::open(bus, &IDENTITY, "", 1)?,
            workflow: Subscriber::open(bus, &WORKFLOW, "", 1)?,
            watcher: Subscriber::open(bus, &HEARTBEAT, crate::watch::NAME, 1)?,
        })
    }
}

/// Shows the planning screen until asked to stop.
///
/// # Errors
/// Each variant of [`RunError`].
pub(crate) fn run(mut process: Process, display: Display, options: Options) -> Result<(), RunError> {
    let ports = Ports::open(&process.bus)?;
    let mut looks = Looks::open(&process.bus, &process.scene)?;
    let coded = Coded {
        key: crate::code::key(process.run.epoch_ns),
        pid: std::process::id(),
    };
    let mut planning = Planning {
        examination: Examination::new(process.volumes()?),
        labels: Labels::open(
            process.scene.plan.labels.as_deref(),
            &process.scene.volume,
            process.scene.tool.diameter_mm,
            options.load,
        ),
        asked: Asked::open(&process.bus)?,
        process,
        display,
        options,
        frames: Frames::default(),
        coded,
        heard: Heard::default(),
        desk: None,
        kept: None,
        events: Vec::new(),
        painted_ns: i64::MIN / 2,
        paint_by_ns: None,
        is_due: true,
        said_until_ns: 0,
        shots: 0,
    };
    let connection = planning.display.connection();
    // Images wake through ports that the step needs as well.
    let wakes = Looks::open(&planning.process.bus, &planning.process.scene)?;
    let waits = Waits::every(TICK)
        .message(&ports.plan, None)
        .readable(connection.stream().as_fd());
    let waits = wakes.waits(waits);
    waits.run(|| match planning.step(&ports, &mut looks) {
        Ok(ControlFlow::Continue(())) => ControlFlow::Continue(()),
        Ok(ControlFlow::Break(())) => ControlFlow::Break(Ok(())),
        Err(error) => ControlFlow::Break(Err(error)),
    })?
}

fn is_wheel(events: &[egui::Event]) -> bool {
    let is_moving =
        |event: &egui::Event| matches!(event, egui::Event::MouseWheel { .. } | egui::Event::PointerMoved(_));
    let is_held = |event: &egui::Event| matches!(event, egui::Event::ModifiersChanged(_));
    events.iter().any(is_moving) && events.iter().all(|event| is_moving(event) || is_held(event))
}

impl Planning {
    fn step(&mut self, ports: &Ports, looks: &mut Looks) -> Result<ControlFlow<()>, RunError> {
        if self.process.stop.is_set() {
            self.process.beat(ProcessState::Stopping, "asked to stop")?;
            return Ok(ControlFlow::Break(()));
        }
        self.happened()?;
        // The pilot tells the plan before it answers: a change that was answered is in the plan that is heard after it.
        if let Err(why) = self.asked.turn() {
            self.say(why);
        }
        self.hear(ports)?;
        let (came, refused) = looks.turn(self.process.clock().now_ns())?;
        self.is_due |= came || self.labels.take();
        if let Some(why) = refused {
            self.say(why);
        }
        let now_ns = self.process.clock().now_ns();
        let is_awaited_for_long = self.paint_by_ns.is_some_and(|by_ns| now_ns >= by_ns);
        if self.is_due
            || is_awaited_for_long
            || !self.events.is_empty()
            || now_ns - self.painted_ns >= clock::ns(SLOWEST)
        {
            self.paint(looks, now_ns)?;
        }
        let note = self.desk.as_ref().map_or("", |desk| &desk.note);
        self.process.beat(ProcessState::Ready, note)?;
        Ok(ControlFlow::Continue(()))
    }

    fn happened(&mut self) -> Result<(), RunError> {
        for happened in self.display.happened()? {
            match happened {
                Happened::Input(event) => self.events.push(event),
                Happened::Exposed => {
                    let [width, height] = self.display.screen().pixels;
                    self.display.present(&[[0, 0, width, height]])?;
                }
                Happened::Resized(_) => {
                    self.frames.forget();
                    self.is_due = true;
                }
            }
        }
        Ok(())
    }

    fn hear(&mut self, ports: &Ports) -> Result<(), RunError> {
        let heard = &mut self.heard;
        heard.identity = ports.identity.newest()?.or(heard.identity);
        heard.workflow = ports.workflow.newest()?.or(heard.workflow);
        heard.watcher = ports.watcher.newest()?.or(heard.watcher);
        if self.examination.take()? {
            let (run, grid) = (&self.process.run, self.examination.grid());
            self.desk = grid.map(|grid| Desk::restored((&run.dir, run.epoch_ns), grid));
            self.is_due = true;
        }
        let Some(told) = ports.plan.newest()? else {
            return Ok(());
        };
        match told.plan() {
            Ok(plan) => {
                self.heard.concerns = self.examination.concerns(&plan);
                self.heard.plan = Some((told, plan));
            }
            // A plan that is none is shown by nobody, nor the one before it.
            Err(error) => {
                self.heard.plan = None;
                self.say(error.to_string());
            }
        }
        self.is_due = true;
        Ok(())
    }

    fn say(&mut self, why: String) {
        bus::stderr_line!("window: {why}");
        if let Some(desk) = &mut self.desk {
            desk.note = why;
        }
        self.said_until_ns = self.process.clock().now_ns() + clock::ns(SAID);
        self.is_due = true;
    }

    fn paint(&mut self, looks: &mut Looks, now_ns: i64) -> Result<(), RunError> {
        self.is_due = false;
        self.painted_ns = now_ns;
        let screen = self.display.screen();
        let hash = self.examination.hash();
        let model = band::model(&self.process.scene, now_ns, hash, &self.heard);
        let told = self.heard.plan.as_ref().map(|(told, _)| *told);
        let heard = self.heard.plan.as_ref();
        let plan = heard.map_or(Plan::new(VolumeId([0; 32])), |(_, plan)| self.asked.made_of(plan));
        if let (Some(desk), true) = (&mut self.desk, told.is_some()) {
            desk.follow(&plan);
        }
        let way = self.desk.as_ref().and_then(|desk| desk.way(&desk.shown(&plan)));
        let beside = self.labels.beside(way.as_ref(), self.examination.grid());
        let error_mm = self.process.scene.plan.error_mm;
        let is_writing = self.asked.is_some();
        // Of another examination than the plan's nothing is shown.
        let header = |cut: usize| {
            looks
                .header(cut)
                .filter(|(header, _)| Some(header.stamp.volume()) == hash)
        };
        let images = std::array::from_fn(header);
        // The images that are laid out, whatever comes before they are painted.
        let frames: Vec<_> = (0..CUTS.len())
            .filter_map(|cut| Some((cut, Rc::clone(looks.frame(cut)?))))
            .collect();
        let frames: Vec<_> = frames.iter().filter_map(|(cut, frame)| image(*cut, frame)).collect();
        let events = (self.next_events(), clock::ms(now_ns) / 1000.0);
        let (examination, desk, heard) = (&self.examination, &mut self.desk, &self.heard);
        let hu = |p| examination.hu(p);
        let tube_mm = self.process.scene.tool.diameter_mm;
        let show = |ui: &mut egui::Ui| {
            let (Some(desk), Some(grid)) = (desk.as_mut(), examination.grid()) else {
                return screen::waiting(ui, &model, screen);
            };
            let known = Known {
                model: &model,
                plan: &plan,
                is_writing,
                file_id: told.map_or(0, |told| told.file_id),
                depth: told.map_or([0; 2], |told| [told.undos, told.redos]),
                concerns: &heard.concerns,
                grid,
                hu: &hu,
                images,
                tube_mm,
                beside: &beside,
                error_mm,
            };
            screen::show(ui, &known, desk, screen)
        };
        let is_wheel = is_wheel(&events.0);
        let (outcome, laid) = self.frames.lay_out(screen, events, show);
        // Before anything is painted: renderers draw meanwhile.
        self.want(looks, &plan);
        let (came, refused) = looks.turn(now_ns)?;
        self.is_due |= came;
        if let Some(why) = refused {
            self.say(why);
        }
        // A slice that is about to come is painted with what was asked for beside it, unless it takes longer than a frame may.
        let paint_by_ns = *self.paint_by_ns.get_or_insert(now_ns + clock::ns(AWAITED));
        if is_wheel && looks.is_awaited() && now_ns < paint_by_ns {
            self.frames.drop_laid(laid);
            self.carry_out(outcome);
            return Ok(());
        }
        self.paint_by_ns = None;
        let pixels = self.display.pixels();
        let mut parts = self.frames.paint_laid(screen, laid, &frames, pixels)?;
        let shown = if frames.is_empty() {
            Shown::Nothing
        } else {
            Shown::NotLive
        };
        let code = self
            .frames
            .stamp((outcome.code, self.coded), (0, shown), screen, (pixels, &mut parts));
        if let Some((code, place)) = code {
            self.process.painted = (code.word(), self.process.clock().now_ns());
            if self.frames.has_moved(place) {
                self.display.set_place(place)?;
            }
        }
        self.display.present(&parts)?;
        self.process.counters.published += 1;
        self.carry_out(outcome);
        Ok(())
    }

    /// What happened up to the first press or release: a frame sees the pointer where it was then. The rest has frames of its own.
    fn next_events(&mut self) -> Vec<egui::Event> {
        let is_press = |event: &egui::Event| matches!(event, egui::Event::PointerButton { .. });
        let end = self
            .events
            .iter()
            .position(is_press)
            .map_or(self.events.len(), |place| place + 1);
        let rest = self.events.split_off(end);
        std::mem::replace(&mut self.events, rest)
    }

    /// Says which planes are to be seen now.
    fn want(&mut self, looks: &mut Looks, plan: &Plan) {
        let Some(desk) = &self.desk else { return };
        let way = desk.way(&desk.shown(plan));
        for cut in CUTS {
            let size = self.process.scene.views.get(cut.place()).map(|view| view.size);
            let plane = size.and_then(|size| desk.camera.plane(cut, way.as_ref(), size));
            looks.want(
                cut.place(),
                plane.map(|plane| ImagePlane::of(Some(&plane), desk.camera.window)),
            );
        }
    }

    fn carry_out(&mut self, outcome: Outcome) {
        for wish in outcome.wishes {
            if let Err(why) = self.asked.ask(wish) {
                self.say(why);
            }
            self.is_due = true;
        }
        if outcome.shot {
            self.shots += 1;
            let (size, folder) = (self.display.screen().pixels, self.options.shots.clone());
            let at_ms = self.process.clock().now_ns() / 1_000_000;
            let path: PathBuf = folder.join(format!("plan-{at_ms}-{}.png", self.shots));
            if let Err(why) = write_shot(self.display.pixels(), size, path) {
                self.say(why);
            }
        }
        let now_ns = self.process.clock().now_ns();
        let Some(desk) = &mut self.desk else { return };
        if self.said_until_ns <= now_ns {
            desk.note.clear();
        }
        if desk.dragged.is_none() && self.kept.as_ref() != Some(&*desk) {
            // A window that cannot keep where it looked looks at all of the examination when it comes back.
            let run = &self.process.run;
            let _ = desk.keep((&run.dir, run.epoch_ns));
            self.kept = Some(desk.clone());
        }
    }
}
