//! One instant of a recording, for a picture without a run: what its replay tells a renderer of it.

use std::path::{Path, PathBuf};

use bus::clock;
use bus::message::{Guide, ToolPose, Tracked};
use scene::{Scene, SceneError, raw};

use super::choices::Choices;
use super::facts::{self, Facts, FactsError};
use super::find;
use super::tape::Tape;
use crate::cli::stretch::moment;
use crate::read::damage::OpenError;
use crate::read::reader::ReadError;
use crate::report::basis::Limits;
use crate::wire::proto::{MeshFrame, TissueFrame};

/// Which instant.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place<'a> {
    /// So long behind the recording's first pose, as people type it: the pose that a replay shows that is sent there, the first that was
    /// published then or later.
    At(&'a str),
    /// The pose of this number.
    Seq(u64),
}

/// What was known then.
#[derive(Debug)]
pub struct Instant {
    /// The scene of the run.
    pub scene: Scene,
    /// The examination that was navigated in.
    pub volume_hash: String,
    /// The pose.
    pub pose: ToolPose,
    /// When it was published, s behind the first pose.
    pub behind_s: f64,
    /// Whether it is known for how long its measurement had stood still.
    pub standstill_judged: bool,
    /// What a person had chosen when it was captured.
    pub guide: Option<Guide>,
    /// Where organs were for this very pose, and those organs at rest; `None` where no model answered it.
    pub tissue: Option<(MeshFrame, Box<TissueFrame>)>,
}

/// Why there is none.
#[derive(Debug, thiserror::Error)]
pub enum InstantError {
    /// It cannot be replayed at all.
    #[error(transparent)]
    Facts(#[from] FactsError),
    /// It cannot be opened.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// Its poses cannot be read.
    #[error("{path}: {source}. `recorder verify` says what can be read")]
    Read {
        /// The recording.
        path: PathBuf,
        /// Where and why.
        source: ReadError,
    },
    /// It is damaged, or was cut off.
    #[error("{path} is not whole: {damage}. `recorder recover {path}` makes a whole file of what is readable")]
    Damaged {
        /// The recording.
        path: PathBuf,
        /// Where and how.
        damage: String,
    },
    /// Without a scene nobody knows the views.
    #[error("{0} has no scene attached, so that nobody knows its views, its tool and its examination")]
    NoScene(PathBuf),
    /// The scene.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// Without it any examination would do.
    #[error("{0} does not say in which examination it was made: nothing can tell whether it is the one that is shown")]
    NoVolume(PathBuf),
    /// No moment.
    #[error("--at {0}")]
    Moment(String),
    /// Behind the end.
    #[error("--at {at_s} s: {path} goes from 0 s to {last_s:.3} s")]
    Beyond {
        /// What was asked for, s behind the first pose.
        at_s: f64,
        /// The recording.
        path: PathBuf,
        /// Its last pose, alike.
        last_s: f64,
    },
    /// Poses are missing where it was asked for.
    #[error(
        "--at {at_s:.3} s: the next pose of {path} is {seq}, at {found_s:.3} s; expected one within {lost_ms:.0} ms (limits.lost_ms of its scene). `--seq {seq}` draws it"
    )]
    Gap {
        /// What was asked for, s behind the first pose.
        at_s: f64,
        /// The recording.
        path: PathBuf,
        /// The pose that comes next.
        seq: u64,
        /// Its publication, s behind the first pose.
        found_s: f64,
        /// How much later it may be, ms.
        lost_ms: f64,
    },
    /// No such pose.
    #[error("--seq {seq}: {path} has no pose of this number; its first is {first}, its last {last}")]
    NoPose {
        /// What was asked for.
        seq: u64,
        /// The recording.
        path: PathBuf,
        /// The number of the first pose.
        first: u64,
        /// That of the last.
        last: u64,
    },
    /// A source that was started anew counts from the beginning.
    #[error("--seq {seq}: {path} has {found} poses of this number, {places}; give one of these with --at")]
    Several {
        /// What was asked for.
        seq: u64,
        /// The recording.
        path: PathBuf,
        /// How many.
        found: usize,
        /// Where, s behind the first pose.
        places: String,
    },
    /// A pose that is none.
    #[error("pose {seq} of {path}: {why}; only a valid pose has a picture")]
    Lost {
        /// Its number.
        seq: u64,
        /// The recording.
        path: PathBuf,
        /// Why.
        why: String,
    },
    /// Organs of which nothing is known.
    #[error(
        "{path}: tissue {seq}, of pose {pose_seq}, is of mesh {found}; the recording has {expected}{unread}. Organs of another mesh are not shown"
    )]
    Mesh {
        /// The recording.
        path: PathBuf,
        /// The state's number.
        seq: u64,
        /// Its pose's.
        pose_seq: u64,
        /// Its mesh.
        found: String,
        /// Those that are there.
        expected: String,
        /// What of it could not be read.
        unread: String,
    },
}

/// The instant of a recording at a place.
///
/// # Errors
/// [`InstantError`]: nothing is left out where it cannot be read, as a picture of less would look like one of all.
pub fn instant(path: &Path, place: Place<'_>) -> Result<Instant, InstantError> {
    let facts = facts::facts(path)?;
    whole(path, facts.damage.first())?;
    let text = facts.scene.as_deref();
    let text = text.ok_or_else(|| InstantError::NoScene(path.to_owned()))?;
    let mut source = raw::parse_attached(text, path)?;
    // The recording says in which examination it was made.
    source.scene.volume.hash = None;
    let scene = Scene::from_raw(&source)?;
    let volume_hash = facts.volume_hash.clone();
    let volume_hash = volume_hash.ok_or_else(|| InstantError::NoVolume(path.to_owned()))?;
    let mut tape = Tape::open(path)?;
    let at_ns = match place {
        Place::At(text) => at(path, &facts, text)?,
        Place::Seq(seq) => numbered(path, &facts, &tape, seq)?,
    };
    let mut judge = find::go_to(&mut tape, at_ns, Limits::of(&scene).frozen_ns, &mut || true)?;
    let mut taken = tape.take();
    if let Place::Seq(seq) = place {
        // Others may have been published at the same moment.
        while taken.as_ref().is_some_and(|moment| moment.pose.seq != seq) {
            taken.iter().for_each(|moment| judge.take(&moment.pose));
            taken = tape.take();
        }
    }
    whole(path, tape.unread().first())?;
    let found = taken.ok_or_else(|| beyond(path, &facts, at_ns))?;
    let lost_ns = clock::ns(scene.limits.lost);
    if matches!(place, Place::At(_)) && found.due_ns().saturating_sub(at_ns) > lost_ns {
        return Err(InstantError::Gap {
            at_s: behind_s(&facts, at_ns),
            path: path.to_owned(),
            seq: found.pose.seq,
            found_s: behind_s(&facts, found.due_ns()),
            lost_ms: clock::ms(lost_ns),
        });
    }
    judge.take(&found.pose);
    let (pose, standstill_judged) = judge.judged(found.pose);
    valid(path, &pose)?;
    let guides = tape.session().guides()?;
    whole(path, guides.unread.first())?;
    let tissue = found.tissue.map(|state| {
        let mesh = mesh(path, &tape, &state)?;
        Ok::<_, InstantError>((mesh, state))
    });
    Ok(Instant {
        scene,
        volume_hash,
        guide: Choices::new(guides.messages).at(pose.t_capture_ns).copied(),
        behind_s: behind_s(&facts, pose.t_publish_ns),
        standstill_judged,
        pose,
        tissue: tissue.transpose()?,
    })
}

/// Refuses what cannot be read.
fn whole(path: &Path, damage: Option<&String>) -> Result<(), InstantError> {
    let damaged = |damage: &String| InstantError::Damaged {
        path: path.to_owned(),
        damage: damage.clone(),
    };
    damage.map_or(Ok(()), |damage| Err(damaged(damage)))
}

/// The moment that is so long behind the first pose, ns on the run's clock.
fn at(path: &Path, facts: &Facts, text: &str) -> Result<i64, InstantError> {
    let behind_ns = moment(text).map_err(InstantError::Moment)?;
    let at_ns = facts.first_ns.saturating_add_unsigned(behind_ns);
    match at_ns <= facts.last_ns {
        true => Ok(at_ns),
        false => Err(beyond(path, facts, at_ns)),
    }
}

fn beyond(path: &Path, facts: &Facts, at_ns: i64) -> InstantError {
    InstantError::Beyond {
        at_s: behind_s(facts, at_ns),
        path: path.to_owned(),
        last_s: behind_s(facts, facts.last_ns),
    }
}

fn behind_s(facts: &Facts, at_ns: i64) -> f64 {
    clock::ms(at_ns.saturating_sub(facts.first_ns)) / 1e3
}

/// When the pose of a number was published. All poses are looked at: a number may have been given twice.
fn numbered(path: &Path, facts: &Facts, tape: &Tape, seq: u64) -> Result<i64, InstantError> {
    let (mut found, mut ends) = (Vec::new(), None);
    for pose in tape.session().poses_from(i64::MIN)? {
        let pose = pose.map_err(|source| InstantError::Read {
            path: path.to_owned(),
            source,
        })?;
        ends = Some(ends.map_or((pose.seq, pose.seq), |(first, _)| (first, pose.seq)));
        if pose.seq == seq {
            found.push(pose.t_publish_ns);
        }
    }
    let (first, last) = ends.unwrap_or_default();
    match found[..] {
        [at_ns] => Ok(at_ns),
        [] => Err(InstantError::NoPose {
            seq,
            path: path.to_owned(),
            first,
            last,
        }),
        _ => {
            let places = found.iter().map(|ns| format!("at {} s", behind_s(facts, *ns)));
            Err(InstantError::Several {
                seq,
                path: path.to_owned(),
                found: found.len(),
                places: places.collect::<Vec<_>>().join(", "),
            })
        }
    }
}

fn valid(path: &Path, pose: &ToolPose) -> Result<(), InstantError> {
    let why = match pose.tracked() {
        Ok(Tracked::Valid(_)) => return Ok(()),
        Ok(Tracked::Lost(reason)) => format!("there is none, {}", reason.words()),
        Err(error) => error.to_string(),
    };
    Err(InstantError::Lost {
        seq: pose.seq,
        path: path.to_owned(),
        why,
    })
}

/// The organs at rest that a state is of.
fn mesh(path: &Path, tape: &Tape, state: &TissueFrame) -> Result<MeshFrame, InstantError> {
    let mut meshes = tape.session().meshes()?;
    let header = &state.header;
    let name = |id: &[u8; 32]| id[..4].iter().map(|byte| format!("{byte:02x}")).collect::<String>();
    let place = meshes
        .messages
        .iter()
        .position(|mesh| mesh.header.mesh_id == header.mesh_id);
    if let Some(place) = place {
        return Ok(meshes.messages.swap_remove(place));
    }
    let known: Vec<String> = meshes.messages.iter().map(|mesh| name(&mesh.header.mesh_id)).collect();
    Err(InstantError::Mesh {
        path: path.to_owned(),
        seq: header.seq,
        pose_seq: header.pose_seq,
        found: name(&header.mesh_id),
        expected: match known.is_empty() {
            true => "none".to_owned(),
            false => known.join(", "),
        },
        unread: meshes.unread.first().map_or(String::new(), |why| format!(" ({why})")),
    })
}

#[cfg(test)]
mod tests;
