//! The process: the newest pose in, its state out.

use std::ops::ControlFlow;
use std::thread;
use std::time::Duration;

use bus::BusError;
use bus::clock;
use bus::continuity::Continuity;
use bus::message::{Lost, ProcessState, TissueHeader, TissueMeshHeader, TissueState, ToolPose, Tracked};
use bus::port::{HeadedPublisher, SharedVolume, Subscriber, VolumeSubscriber};
use bus::process::{JoinError, Membership, Process};
use bus::topic::{TISSUE, TISSUE_ASKED, TISSUE_MESH, TOOL_POSE};
use bus::wake::Waits;
use scene::TissueSpec;
use simulation::space::cells::Lattice;
use simulation::space::frames::State;

use crate::anatomy::{Anatomy, LoadLabels, NoAnatomy, make};
use crate::errors::Errors;
use crate::live::{Answer, Live};
use crate::message::{header, places};
use crate::work::beside;

/// Its name in the run.
const NAME: &str = "tissue";
/// The loop comes round at least this often: for signs of life and for those who join late.
const TICK: Duration = Duration::from_millis(20);
/// Poses that wait at most: all are judged, and the newest is answered.
const ROOM: usize = 64;

/// While a state is solved, signs of life are given for so long at most: a wide step of a fine model takes seconds, and its process is not to be
/// killed for it; one that takes no end is.
const SOLVING: (ProcessState, &str, Duration) = (ProcessState::Ready, "solving", Duration::from_secs(60));

/// Why it ended.
#[derive(Debug, thiserror::Error)]
pub(crate) enum RunError {
    /// The run could not be joined.
    #[error(transparent)]
    Join(#[from] JoinError),
    /// A message could not be sent or taken.
    #[error(transparent)]
    Bus(#[from] BusError),
    /// Nothing is to be moved.
    #[error("the scene has no [tissue] table: no organ is to be moved")]
    NoTissue,
    /// What is to be moved was refused.
    #[error("the organs of [tissue]: {0}")]
    Anatomy(#[from] NoAnatomy),
}

/// Moves organs until asked to stop.
///
/// # Errors
/// [`RunError`].
pub(crate) fn run(membership: &Membership, load: LoadLabels) -> Result<(), RunError> {
    let mut process = Process::join(NAME, membership)?;
    let spec = process.scene.tissue.clone().ok_or(RunError::NoTissue)?;
    let volumes = process.volumes()?;
    let Some(volume) = waited_for(&mut process, &volumes)? else {
        return Ok(());
    };
    let anatomy = made(&mut process, &spec, &volume, load)?;
    // The voxels are nobody's need any more.
    drop((volume, volumes));
    let poses = Subscriber::open_waking(&process.bus, &TOOL_POSE, "", ROOM)?;
    let mut tissue = Tissue::open(process, anatomy)?;
    Waits::every(TICK)
        .message(&poses, None)
        .run(|| match tissue.step(&poses) {
            Ok(flow) => flow.map_break(Ok),
            Err(error) => ControlFlow::Break(Err(error)),
        })?
}

/// The run's examination; `None` where the process is to stop.
fn waited_for(process: &mut Process, volumes: &VolumeSubscriber) -> Result<Option<SharedVolume>, RunError> {
    while !process.stop.is_set() {
        if let Some(volume) = volumes.poll()? {
            return Ok(Some(volume));
        }
        process.beat(ProcessState::Starting, "waiting for the volume")?;
        thread::sleep(TICK);
    }
    Ok(None)
}

/// Reads and meshes while this thread gives signs of life.
fn made(
    process: &mut Process,
    spec: &TissueSpec,
    volume: &SharedVolume,
    load: LoadLabels,
) -> Result<Anatomy, RunError> {
    let (scene, grid, hash) = (process.scene.clone(), *volume.view().grid, volume.hash().0);
    let alive = (ProcessState::Starting, "meshing the organs", Duration::MAX);
    Ok(worked(process, alive, || make((&scene, spec), (&grid, hash), load))??)
}

/// Works while this thread gives signs of life, in the state and with the words told, for no longer than that: then whatever works may hang.
fn worked<T: Send>(
    process: &mut Process,
    (state, note, most): (ProcessState, &str, Duration),
    work: impl FnOnce() -> T + Send,
) -> Result<T, BusError> {
    // Not the session's clock: in a replay that is paused it stands still.
    let until_ns = clock::monotonic_ns().saturating_add(clock::ns(most));
    beside(TICK, work, || match clock::monotonic_ns() < until_ns {
        true => process.beat(state, note),
        false => Ok(()),
    })
}

/// The state between two wake-ups.
struct Tissue {
    process: Process,
    live: Live,
    errors: Errors,
    lattices: Vec<Lattice>,
    mesh_id: [u8; 32],
    said: String,
    meshes: HeadedPublisher<TissueMeshHeader, u8>,
    states: HeadedPublisher<TissueHeader, f32>,
    continuity: Continuity,
    /// In a replay whose states are made again: of which poses, in their order.
    asked: Option<Asked>,
    /// Of the last message.
    seq: u64,
    /// Where the nodes are now.
    places: Vec<f32>,
    /// What the last pose came to, for the status.
    note: String,
}

impl Tissue {
    fn open(process: Process, anatomy: Anatomy) -> Result<Self, BusError> {
        let (header, bytes) = anatomy.mesh.write();
        let meshes = HeadedPublisher::open(&process.bus, &TISSUE_MESH, bytes.len())?;
        let states = HeadedPublisher::open(&process.bus, &TISSUE, 3 * anatomy.mesh.nodes())?;
        meshes.send(header, &bytes)?;
        let is_again = process.run.replay.as_ref().is_some_and(|replay| replay.tissue_again);
        let asked = is_again.then(|| Subscriber::open(&process.bus, &TISSUE_ASKED, "", TISSUE_ASKED.buffer));
        let asked = asked.transpose()?.map(Asked::of);
        Ok(Self {
            process,
            live: anatomy.live,
            errors: anatomy.errors,
            lattices: anatomy.lattices,
            mesh_id: header.mesh_id,
            said: anatomy.said,
            meshes,
            states,
            continuity: Continuity::default(),
            asked,
            seq: 0,
            places: Vec::new(),
            note: "no pose yet".to_owned(),
        })
    }

    fn step(&mut self, poses: &Subscriber<ToolPose>) -> Result<ControlFlow<()>, RunError> {
        if self.process.stop.is_set() {
            self.process.beat(ProcessState::Stopping, "asked to stop")?;
            return Ok(ControlFlow::Break(()));
        }
        self.process.session.follow()?;
        match self.asked.is_some() {
            true => self.answer_again(poses)?,
            false => self.answer_newest(poses)?,
        }
        self.meshes.serve_late_joiners();
        self.states.serve_late_joiners();
        let (said, note) = (&self.said, &self.note);
        self.process
            .beat_with(ProcessState::Ready, || format!("{note}; {said}"))?;
        Ok(ControlFlow::Continue(()))
    }

    fn answer_newest(&mut self, poses: &Subscriber<ToolPose>) -> Result<(), RunError> {
        let mut newest = None;
        while let Some(sample) = poses.next()? {
            newest = Some((sample, self.judged(&sample)));
        }
        match newest {
            Some((sample, tracked)) => Ok(self.answer(&sample, tracked)?),
            None => Ok(()),
        }
    }

    /// Answers what was answered in the recorded run, and nothing else: a state depends on all those before it. What was no pose then, by all
    /// samples that came, is none now.
    fn answer_again(&mut self, poses: &Subscriber<ToolPose>) -> Result<(), RunError> {
        while let Some(sample) = poses.next()? {
            let Some(asked) = self.asked.as_mut() else {
                return Ok(());
            };
            let Some(asked) = asked.of_pose(&sample)? else { continue };
            let was_lost = asked.state_of() == Ok(TissueState::Lost);
            let tracked = match sample.tracked() {
                Ok(tracked) if !was_lost => tracked,
                _ => Tracked::Lost(Lost::Refused),
            };
            self.answer(&sample, tracked)?;
        }
        Ok(())
    }

    /// What a sample comes to, as for images: see [`bus::continuity`].
    fn judged(&mut self, sample: &ToolPose) -> Tracked {
        let session = &self.process.session;
        let Ok(tracked) = sample.tracked_at(session.clock().now_ns()) else {
            self.process.counters.refused += 1;
            return Tracked::Lost(Lost::Refused);
        };
        let frozen_ns = self.process.scene.frozen().map(clock::ns);
        self.continuity.judge(sample, tracked, frozen_ns).tracked
    }

    /// Publishes the state for a sample: without nodes where there is none, or the sample has no pose.
    fn answer(&mut self, sample: &ToolPose, tracked: Tracked) -> Result<(), BusError> {
        let answer = match tracked {
            Tracked::Valid(pose) => {
                // By the poses that are answered alone: a replay that answers them again finds the same.
                if self.live.is_of_another(sample.registration_id) {
                    self.errors.forget();
                }
                let live = &mut self.live;
                Some(worked(&mut self.process, SOLVING, || live.answer(pose))?)
            }
            Tracked::Lost(_) => None,
        };
        self.places.clear();
        if let Some(Answer::State(_)) = answer {
            places(&self.lattices, &self.live, &mut self.places);
        }
        self.note = said(answer.as_ref());
        self.seq += 1;
        let frame = match &answer {
            Some(Answer::State(frame)) => Some(frame),
            _ => None,
        };
        let header = header(sample, (self.seq, self.mesh_id), answer.as_ref(), &self.live);
        let header = TissueHeader {
            t_publish_ns: self.process.session.clock().now_ns(),
            ..self.errors.told(header, frame, &self.live)
        };
        self.process.counters.published += 1;
        self.states.send(header, &self.places)?;
        // Behind the state: nobody waits for them.
        if let Some(frame) = frame {
            let (errors, live) = (&mut self.errors, &mut self.live);
            worked(&mut self.process, SOLVING, move || errors.find(sample, frame, live))?;
        }
        Ok(())
    }
}

/// Of which poses a recording has states: told before each.
struct Asked {
    headers: Subscriber<TissueHeader>,
    /// Of a pose that did not come yet.
    next: Option<TissueHeader>,
}

impl Asked {
    fn of(headers: Subscriber<TissueHeader>) -> Self {
        Self { headers, next: None }
    }

    /// What is said of a sample; what is said of earlier ones is passed over.
    fn of_pose(&mut self, sample: &ToolPose) -> Result<Option<TissueHeader>, BusError> {
        loop {
            self.next = match self.next {
                Some(header) => Some(header),
                None => self.headers.next()?,
            };
            let Some(header) = self.next.filter(|header| header.t_capture_ns <= sample.t_capture_ns) else {
                return Ok(None);
            };
            self.next = None;
            if (header.pose_seq, header.t_capture_ns) == (sample.seq, sample.t_capture_ns) {
                return Ok(Some(header));
            }
        }
    }
}

/// What became of a pose, in words.
fn said(answer: Option<&Answer>) -> String {
    match answer {
        None => "no pose".to_owned(),
        Some(Answer::Refused(_) | Answer::Met(_) | Answer::Unseen { .. }) => {
            format!("refused: {}", answer.and_then(Answer::why).unwrap_or_default())
        }
        Some(Answer::State(frame)) => format!(
            "{}, {:.2} N, residual {:.1e}",
            match frame.state {
                State::Settled => "settled".to_owned(),
                State::CatchingUp { left } => format!("catching up, {left:.1} mm left"),
                _ => "not settled".to_owned(),
            },
            frame.force.force.norm(),
            frame.residual
        ),
    }
}
