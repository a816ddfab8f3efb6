//! What the next process is to know of the peer, should this one die: a file of the run, which is written while frames come.
//!
//! A queue on the peer's side, an instrument in the place of another, and a tool whose status was once stated do not end with this process. Who
//! has looked at the peer says `pilot restart localizer`, and all of it is forgotten.

use bus::clock::mapping::{Handed, HandedLaw};
use bus::run::RunContext;
use serde::{Deserialize, Serialize};

use crate::driver::Known;

/// As the run has its file.
const OF: &str = "localizer";
/// Between two writings, ns.
const EVERY_NS: i64 = 500_000_000;

/// What is kept.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Kept {
    /// Whose run it is: that of a run before, with another clock, is nobody's.
    epoch_ns: i64,
    waited_ns: i64,
    law: Option<Law>,
    peer: Known,
}

/// See [`HandedLaw`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Law {
    device_ns: i64,
    arrival_ns: i64,
    skew: f64,
}

/// The file of one process.
#[derive(Debug, Default)]
pub(crate) struct Memory {
    written: Option<Kept>,
    next_ns: i64,
    is_told: bool,
}

impl Memory {
    /// With what the process before knew; with nothing where `is_anew`, which forgets it.
    ///
    /// # Errors
    /// In words, what is wrong with the file.
    pub(crate) fn open(run: &RunContext, is_anew: bool) -> Result<(Self, Handed, Known), String> {
        if is_anew {
            run.forget_kept(OF).map_err(|error| error.to_string())?;
        }
        let bytes = run.kept(OF).map_err(|error| error.to_string())?;
        let kept = bytes.map(|bytes| serde_json::from_slice::<Kept>(&bytes)).transpose();
        let kept = kept.map_err(|error| format!("what the process before kept of the peer: {error}"))?;
        let kept = kept.filter(|kept| kept.epoch_ns == run.epoch_ns).unwrap_or_default();
        let law = kept.law.map(|law| HandedLaw {
            device_ns: law.device_ns,
            arrival_ns: law.arrival_ns,
            skew: law.skew,
        });
        let handed = Handed {
            law,
            waited_ns: kept.waited_ns,
        };
        Ok((Self::default(), handed, kept.peer))
    }

    /// Keeps what is known at `now_ns`: of the peer at once, of its clock twice a second. What is to be told: once, that it cannot be.
    pub(crate) fn keep(&mut self, run: &RunContext, now_ns: i64, handed: Handed, peer: Known) -> Option<String> {
        let is_news = self.written.as_ref().map_or(&Known::default(), |kept| &kept.peer) != &peer;
        if now_ns < self.next_ns && !is_news {
            return None;
        }
        self.next_ns = now_ns.saturating_add(EVERY_NS);
        let kept = Kept {
            epoch_ns: run.epoch_ns,
            waited_ns: handed.waited_ns,
            law: handed.law.map(|law| Law {
                device_ns: law.device_ns,
                arrival_ns: law.arrival_ns,
                skew: law.skew,
            }),
            peer,
        };
        if self.written.as_ref() == Some(&kept) {
            return None;
        }
        let written = serde_json::to_vec(&kept).map_err(|error| error.to_string());
        let written = written.and_then(|bytes| run.keep(OF, &bytes).map_err(|error| error.to_string()));
        match written {
            Ok(()) => {
                self.written = Some(kept);
                None
            }
            Err(why) => (!std::mem::replace(&mut self.is_told, true)).then(|| {
                format!("a process that follows on this one would not know of the peer what this one does: {why}")
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn known() -> (Handed, Known) {
        let law = HandedLaw {
            device_ns: 1_790_000_000_000_000_001,
            arrival_ns: 7,
            skew: 1.0 / 3.0e5,
        };
        let handed = Handed {
            law: Some(law),
            waited_ns: 600_000_001,
        };
        let tools = vec![b"Pointer".to_vec()];
        (handed, Known { tools, stated: vec![0] })
    }

    /// Another instrument was the tool, a status that had been stated was not asked for, and a queue was unknown, after a process had died.
    #[test]
    fn what_is_kept_comes_back_to_the_last_bit_unless_a_person_forgets_it() {
        let folder = tempfile::tempdir().unwrap();
        let run = RunContext::new(folder.path(), 42).unwrap();
        let open = |run: &RunContext, is_anew| Memory::open(run, is_anew).map(|(_, handed, peer)| (handed, peer));
        assert_eq!(open(&run, false), Ok((Handed::default(), Known::default())));
        let mut memory = Memory::default();
        let (handed, peer) = known();
        assert_eq!(memory.keep(&run, 0, handed, Known::default()), None);
        // A name is kept at once, a law not with each frame.
        assert_eq!(memory.keep(&run, 1, handed, peer.clone()), None);
        assert_eq!(memory.keep(&run, EVERY_NS, Handed::default(), peer), None);
        assert_eq!(open(&run, false), Ok(known()));
        let other = RunContext::new(folder.path(), 43).unwrap();
        assert_eq!(open(&other, false), Ok((Handed::default(), Known::default())));
        assert_eq!(open(&run, true), Ok((Handed::default(), Known::default())));
        assert_eq!(open(&run, false), Ok((Handed::default(), Known::default())));
        run.keep(OF, b"{\"epoch_ns\": 1}").unwrap();
        assert!(open(&run, false).unwrap_err().contains("missing field"));
        std::fs::remove_dir_all(folder.path()).unwrap();
        let mut nothing = |k: i64| memory.keep(&run, k * 2 * EVERY_NS, Handed::default(), Known::default());
        let told: Vec<String> = (1..9).filter_map(&mut nothing).collect();
        assert!(told.len() == 1 && told[0].contains("would not know"), "{told:?}");
    }
}
