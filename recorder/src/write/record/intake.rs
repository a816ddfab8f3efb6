//! Takes poses and frames from the bus on a thread of its own: a disk that makes the recorder wait for seconds costs memory,
//! and no message. It also gives the recorder's signs of life, as this thread never waits for a disk.

use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};

use bus::life::LifeLine;
use bus::message::{EmitterFrame, MarkerFrame, TissueHeader, TissueMeshHeader, ToolPose};
use bus::port::{HeadedSubscriber, Message, Subscriber, UsImageSubscriber, Value};
use bus::run::RunContext;
use bus::topic::{self, Topic};
use bus::{Bus, BusError};

use super::{RecordError, TICK};
use crate::wire::proto::{MeshFrame, TissueFrame, UsFrame};

/// Messages of one topic that wait in memory: 8 s of 4000 a second, 66 MiB of the largest. What comes beyond waits on the
/// bus, whose oldest messages give way.
pub(super) const ROOM: usize = 1 << 15;

/// Bytes of ultrasound images that wait in memory: 14 s of 15 images of 300 kB a second; and as many of states of tissue.
const IMAGE_ROOM: usize = 64 << 20;

/// What has been taken and not yet been written, in the order of its coming.
#[derive(Debug, Default)]
pub(super) struct Taken {
    pub(super) tool: Vec<ToolPose>,
    pub(super) truth: Vec<ToolPose>,
    pub(super) emitters: Vec<EmitterFrame>,
    pub(super) markers: Vec<MarkerFrame>,
    pub(super) images: Vec<UsFrame>,
    pub(super) meshes: Vec<MeshFrame>,
    pub(super) tissue: Vec<TissueFrame>,
}

impl Taken {
    fn clear(&mut self) {
        self.tool.clear();
        self.truth.clear();
        self.emitters.clear();
        self.markers.clear();
        self.images.clear();
        self.meshes.clear();
        self.tissue.clear();
    }
}

/// The thread, and what it has taken.
#[derive(Debug)]
pub(super) struct Intake {
    ask: Option<Sender<()>>,
    answer: Receiver<Result<(), BusError>>,
    taken: Arc<Mutex<Taken>>,
    /// Emptied by the recorder, filled by the thread next: memory is kept.
    spare: Taken,
    thread: Option<JoinHandle<()>>,
}

impl Intake {
    /// Joins the run once more (ports stay on the thread that made them), and subscribes before it returns. No topic has
    /// more than `room` messages in memory. `has_tissue` in a scene whose organs move.
    pub(super) fn start(
        run: &RunContext,
        (room, has_tissue): (usize, bool),
        life: LifeLine,
    ) -> Result<Self, RecordError> {
        let (ask, asked) = mpsc::channel();
        let (say, answer) = mpsc::channel();
        let taken = Arc::<Mutex<Taken>>::default();
        let (run, theirs) = (run.clone(), Arc::clone(&taken));
        let thread = thread::Builder::new()
            .name("intake".to_owned())
            .spawn(move || match Ports::open(&run, life, has_tissue) {
                Ok(ports) => {
                    // Whoever started this is gone only where it has failed.
                    let _ = say.send(Ok(()));
                    ports.work(&asked, &say, (&theirs, room), life);
                }
                Err(e) => drop(say.send(Err(e))),
            })
            .map_err(RecordError::Intake)?;
        let mut intake = Self {
            ask: Some(ask),
            answer,
            taken,
            spare: Taken::default(),
            thread: Some(thread),
        };
        intake.answered()?;
        Ok(intake)
    }

    /// Everything that has come before this call and has not been given yet.
    pub(super) fn take(&mut self) -> Result<&Taken, RecordError> {
        let asked = self.ask.as_ref().map(|ask| ask.send(()));
        // Where the thread has ended, waiting for its answer says so.
        let _ = asked;
        self.answered()?;
        self.spare.clear();
        let mut taken = self.taken.lock().unwrap_or_else(PoisonError::into_inner);
        std::mem::swap(&mut *taken, &mut self.spare);
        drop(taken);
        Ok(&self.spare)
    }

    fn answered(&mut self) -> Result<(), RecordError> {
        match self.answer.recv() {
            Ok(answer) => Ok(answer?),
            Err(_) => Err(RecordError::Intake(std::io::Error::other(
                "the thread that takes messages from the bus has ended",
            ))),
        }
    }

    /// Poses of the tool in memory.
    #[cfg(test)]
    pub(super) fn waiting(&self) -> usize {
        self.taken.lock().unwrap_or_else(PoisonError::into_inner).tool.len()
    }
}

impl Drop for Intake {
    fn drop(&mut self) {
        self.ask = None;
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// Organs that the tube moves.
struct Organs {
    meshes: HeadedSubscriber<TissueMeshHeader, u8>,
    states: HeadedSubscriber<TissueHeader, f32>,
}

/// The thread's own ends of the topics. The bus goes last.
struct Ports {
    tool: Subscriber<ToolPose>,
    truth: Subscriber<ToolPose>,
    emitters: Subscriber<EmitterFrame>,
    markers: Subscriber<MarkerFrame>,
    images: UsImageSubscriber,
    /// Where organs move.
    organs: Option<Organs>,
    _bus: Bus,
}

impl Ports {
    fn open(run: &RunContext, life: LifeLine, has_tissue: bool) -> Result<Self, BusError> {
        fn opened<T: Message>(bus: &Bus, topic: &Topic) -> Result<Subscriber<T>, BusError> {
            Subscriber::open(bus, topic, "", topic.buffer)
        }
        let bus = Bus::join_with(run, life)?;
        Ok(Self {
            tool: opened(&bus, &topic::TOOL_POSE)?,
            truth: opened(&bus, &topic::GROUND_TRUTH)?,
            emitters: opened(&bus, &topic::EMITTERS)?,
            markers: opened(&bus, &topic::MARKERS)?,
            images: UsImageSubscriber::open(&bus)?,
            organs: has_tissue.then(|| Organs::open(&bus)).transpose()?,
            _bus: bus,
        })
    }

    /// Takes when it is asked to, and once in a while where nobody does.
    fn work(
        &self,
        asked: &Receiver<()>,
        say: &Sender<Result<(), BusError>>,
        (taken, room): (&Mutex<Taken>, usize),
        life: LifeLine,
    ) {
        let mut unsaid = Ok(());
        loop {
            life.beat();
            let request = asked.recv_timeout(TICK);
            if request == Err(RecvTimeoutError::Disconnected) {
                return;
            }
            unsaid = unsaid.and_then(|()| self.take(taken, room));
            if request.is_ok() && say.send(std::mem::replace(&mut unsaid, Ok(()))).is_err() {
                return;
            }
        }
    }

    fn take(&self, taken: &Mutex<Taken>, room: usize) -> Result<(), BusError> {
        let mut taken = taken.lock().unwrap_or_else(PoisonError::into_inner);
        fill(&self.tool, &mut taken.tool, room)?;
        fill(&self.truth, &mut taken.truth, room)?;
        fill(&self.emitters, &mut taken.emitters, room)?;
        fill(&self.markers, &mut taken.markers, room)?;
        fill_images(&self.images, &mut taken.images)?;
        self.organs.as_ref().map_or(Ok(()), |organs| organs.fill(&mut taken))
    }
}

impl Organs {
    fn open(bus: &Bus) -> Result<Self, BusError> {
        Ok(Self {
            meshes: HeadedSubscriber::open(bus, &topic::TISSUE_MESH, topic::TISSUE_MESH.buffer)?,
            states: HeadedSubscriber::open(bus, &topic::TISSUE, topic::TISSUE.buffer)?,
        })
    }

    fn fill(&self, taken: &mut Taken) -> Result<(), BusError> {
        let frame = |header: &TissueMeshHeader, bytes: &[u8]| MeshFrame {
            header: *header,
            bytes: bytes.to_vec(),
        };
        fill_headed(&self.meshes, &mut taken.meshes, frame, |mesh| {
            size_of::<MeshFrame>() + mesh.bytes.len()
        })?;
        let frame = |header: &TissueHeader, nodes: &[f32]| TissueFrame {
            header: *header,
            nodes: nodes.to_vec(),
        };
        fill_headed(&self.states, &mut taken.tissue, frame, |state| {
            size_of_val(state.nodes.as_slice())
        })
    }
}

fn fill_headed<H: Message + Default, T: Value, F>(
    from: &HeadedSubscriber<H, T>,
    into: &mut Vec<F>,
    frame: impl Fn(&H, &[T]) -> F,
    bytes_of: impl Fn(&F) -> usize,
) -> Result<(), BusError> {
    let mut bytes: usize = into.iter().map(&bytes_of).sum();
    while bytes < IMAGE_ROOM
        && let Some(message) = from.next()?
    {
        let taken = frame(message.header(), message.values());
        bytes += bytes_of(&taken);
        into.push(taken);
    }
    Ok(())
}

fn fill<T: Message>(from: &Subscriber<T>, into: &mut Vec<T>, room: usize) -> Result<(), BusError> {
    while into.len() < room
        && let Some(message) = from.next()?
    {
        into.push(message);
    }
    Ok(())
}

fn fill_images(from: &UsImageSubscriber, into: &mut Vec<UsFrame>) -> Result<(), BusError> {
    let mut bytes: usize = into.iter().map(|image| image.grey.len()).sum();
    while bytes < IMAGE_ROOM
        && let Some(image) = from.next()?
    {
        bytes += image.grey().len();
        into.push(UsFrame {
            header: *image.header(),
            grey: image.grey().to_vec(),
        });
    }
    Ok(())
}
