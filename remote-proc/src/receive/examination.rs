//! The sender's examination: pulled once, in pieces, checked by its hash, and only then shown.

use std::time::Duration;

use bus::clock::{monotonic_ns, ms, ns};
use bus::message::{HeaderError, VolumeHash, VolumeHeader, voxels_from};
use bus::port::{LoanedVolume, VolumePublisher};
use bus::run::{RunError, SHM_DIR, shm_free_bytes};
use bus::volume::{Hasher, Layout, SliceHash};
use bus::{Bus, BusError};
use zenoh::Wait;
use zenoh::qos::{CongestionControl, Priority};

use super::inbox::{Inbox, Incoming, Promise, answer};
use crate::protocol::{PIECE, piece, pieces};
use crate::session::Opened;

/// Pieces that are asked for at a time: 512 KiB are under way, 4 s of a link of 1 Mbit/s.
const WINDOW: usize = 4;
/// A piece that has not come after so long is asked for again.
const WITHIN: Duration = Duration::from_secs(20);
/// Behind a refusal.
const HOLD: Duration = Duration::from_millis(50);
/// Shared memory that images and messages need beside the volume.
const MARGIN_BYTES: u64 = 64 << 20;

/// Why the examination is not shown.
#[derive(Debug, thiserror::Error)]
pub enum ExaminationError {
    /// Its header is none.
    #[error(transparent)]
    Header(#[from] HeaderError),
    /// The bus.
    #[error(transparent)]
    Bus(#[from] BusError),
    /// Shared memory cannot be asked.
    #[error(transparent)]
    Folder(#[from] RunError),
    /// It does not fit into shared memory.
    #[error("it needs {needed_mib} MiB of shared memory with the images, and {SHM_DIR} has {free_mib} MiB free")]
    SharedMemory {
        /// What it needs.
        needed_mib: u64,
        /// What there is.
        free_mib: u64,
    },
    /// What came is not what the sender has.
    #[error(
        "what came has the hash {found}, and the sender's has {expected}: it was altered on the way. Nothing of it is shown"
    )]
    Altered {
        /// Of what came.
        found: VolumeHash,
        /// The sender's.
        expected: VolumeHash,
    },
    /// The sender has another one by now.
    #[error("the sender shows another one by now, {found}; this run began with {expected}")]
    Another {
        /// The sender's.
        found: VolumeHash,
        /// This run's.
        expected: VolumeHash,
    },
}

/// What a piece came to.
pub(super) enum Step {
    /// More is to come.
    More,
    /// It is whole and shown; its hash, and how long it took, s.
    Whole(VolumeHash, f64),
}

/// The examination as far as it has come.
pub(super) struct Examination {
    /// The one that is shown.
    there: Option<VolumeHash>,
    coming: Option<Coming>,
    publisher: Option<VolumePublisher>,
}

struct Coming {
    header: VolumeHeader,
    layout: Layout,
    loan: LoanedVolume,
    has_come: Vec<bool>,
    missing: u32,
    /// What was asked for, and when.
    asked: Vec<(u32, i64)>,
    next: u32,
    began_ns: i64,
    /// The sender's last refusal, and until when nothing is asked behind it.
    why: Option<String>,
    hold_ns: i64,
}

impl Examination {
    /// `held` is in memory already.
    pub(super) fn new(held: Option<VolumeHash>) -> Self {
        Self {
            there: held,
            coming: None,
            publisher: None,
        }
    }

    pub(super) fn is_there(&self) -> bool {
        self.there.is_some()
    }

    /// The one that is shown.
    pub(super) fn there(&self) -> Option<VolumeHash> {
        self.there
    }

    /// The sender has the examination of `header`: takes memory for it, unless it is here.
    pub(super) fn begin(&mut self, bus: &Bus, header: VolumeHeader) -> Result<(), ExaminationError> {
        let found = header.volume_hash();
        let begun = self.coming.as_ref().map(|coming| coming.header.volume_hash());
        if let Some(expected) = self.there.or(begun) {
            return match found == expected {
                true => Ok(()),
                false => Err(ExaminationError::Another { found, expected }),
            };
        }
        header.grid()?;
        let layout = header.layout()?;
        let (needed, free) = (layout.stored() * 2 + MARGIN_BYTES, shm_free_bytes()?);
        if needed > free {
            return Err(ExaminationError::SharedMemory {
                needed_mib: needed.div_ceil(1 << 20),
                free_mib: free >> 20,
            });
        }
        let publisher = VolumePublisher::open(bus, &layout)?;
        let count = pieces(layout.stored());
        self.coming = Some(Coming {
            loan: publisher.loan()?,
            header,
            has_come: vec![false; count as usize],
            missing: count,
            asked: Vec::new(),
            next: 0,
            began_ns: monotonic_ns(),
            why: None,
            hold_ns: i64::MIN,
            layout,
        });
        self.publisher = Some(publisher);
        Ok(())
    }

    /// What was asked for over an earlier session does not come any more.
    pub(super) fn ask_anew(&mut self) {
        if let Some(coming) = &mut self.coming {
            (coming.asked, coming.next) = (Vec::new(), 0);
        }
    }

    /// Asks for what is missing.
    pub(super) fn ask(&mut self, session: &Opened, inbox: &Inbox, now: i64) {
        let Some(coming) = &mut self.coming else { return };
        coming.asked.retain(|(_, at_ns)| now - at_ns < ns(WITHIN));
        while coming.asked.len() < WINDOW && now >= coming.hold_ns {
            let Some(index) = coming.next_missing() else { return };
            coming.asked.push((index, now));
            ask(session, inbox, coming.header.volume_hash(), index);
        }
    }

    /// Takes in a piece. `alive` is called while the whole is checked.
    pub(super) fn take(
        &mut self,
        index: u32,
        bytes: Result<Vec<u8>, String>,
        alive: impl FnMut(&str) -> Result<(), BusError>,
    ) -> Result<Step, ExaminationError> {
        let Some(coming) = &mut self.coming else {
            return Ok(Step::More);
        };
        coming.take(index, bytes);
        if coming.missing > 0 {
            return Ok(Step::More);
        }
        let Some(coming) = self.coming.take() else {
            return Ok(Step::More);
        };
        let (hash, began_ns) = (coming.header.volume_hash(), coming.began_ns);
        coming.publish(alive)?;
        self.there = Some(hash);
        Ok(Step::Whole(hash, ms(monotonic_ns() - began_ns) / 1e3))
    }

    pub(super) fn serve_late_joiners(&self) {
        if let Some(publisher) = self.publisher.as_ref().filter(|_| self.is_there()) {
            publisher.serve_late_joiners();
        }
    }

    /// How much of it is here, in words; `None` where all is.
    pub(super) fn words(&self) -> Option<String> {
        let coming = self.coming.as_ref()?;
        let (all, missing) = (coming.has_come.len(), coming.missing as usize);
        let why = coming.why.as_ref().map_or(String::new(), |why| format!(" ({why})"));
        Some(format!("examination: {} of {all} pieces{why}", all - missing))
    }
}

impl Coming {
    /// The next piece that neither came nor is under way.
    fn next_missing(&mut self) -> Option<u32> {
        let count = self.has_come.len() as u32;
        // Once round at most: what was lost on the way comes again behind the last.
        for _ in 0..count {
            let index = self.next % count;
            self.next = (index + 1) % count;
            let is_asked = self.asked.iter().any(|(asked, _)| *asked == index);
            if !self.has_come[index as usize] && !is_asked {
                return Some(index);
            }
        }
        None
    }

    fn take(&mut self, index: u32, bytes: Result<Vec<u8>, String>) {
        self.asked.retain(|(asked, _)| *asked != index);
        let voxels = self.loan.voxels_mut();
        let Some(range) = piece(index, voxels.len()).filter(|_| !self.has_come[index as usize]) else {
            return;
        };
        let written =
            bytes.and_then(|bytes| voxels_from(&bytes, &mut voxels[range]).map_err(|error| error.to_string()));
        match written {
            Ok(()) => {
                self.has_come[index as usize] = true;
                (self.missing, self.why) = (self.missing - 1, None);
            }
            Err(why) => {
                (self.why, self.hold_ns) = (Some(why), monotonic_ns().saturating_add(ns(HOLD)));
            }
        }
    }

    /// Shows it, where it is what the sender has.
    fn publish(mut self, mut alive: impl FnMut(&str) -> Result<(), BusError>) -> Result<(), ExaminationError> {
        let grid = self.header.grid()?;
        // A hostile value is another hash.
        let mut hasher = Hasher::new(&grid, self.header.padding_hu.clamp(-32_768, 32_767) as i16);
        let [nx, ny, nz] = grid.dims().map(|n| n as usize);
        let [x, y, z] = [0, 1, 2].map(|axis| self.layout.table(axis));
        let voxels = self.loan.voxels_mut();
        let mut slice = vec![0; nx * ny];
        for (k, dz) in z.iter().enumerate() {
            for (row, dy) in slice.chunks_exact_mut(nx).zip(y) {
                let at = (dy + dz) as usize;
                for (value, dx) in row.iter_mut().zip(x) {
                    *value = voxels[at + *dx as usize];
                }
            }
            hasher.update(SliceHash::of(&slice));
            alive(&format!("checking slice {} of {nz}", k + 1))?;
        }
        let (found, expected) = (hasher.finish(), self.header.volume_hash());
        if found != expected {
            return Err(ExaminationError::Altered { found, expected });
        }
        Ok(self.loan.publish(self.header)?)
    }
}

fn ask(session: &Opened, inbox: &Inbox, hash: VolumeHash, index: u32) {
    let none = |why: String| Incoming::Piece(index, Err(why));
    let promise = Promise::of(inbox, none("nobody answers".to_owned()));
    let asked = session
        .get(PIECE)
        .payload([&hash.0[..], &index.to_le_bytes()].concat())
        .timeout(WITHIN)
        .priority(Priority::DataLow)
        .congestion_control(CongestionControl::Block)
        .callback(move |reply| promise.keep(Incoming::Piece(index, answer(reply))))
        .wait();
    if let Err(why) = asked {
        inbox.put(none(why.to_string()));
    }
}
