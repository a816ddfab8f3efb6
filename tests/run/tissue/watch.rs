//! Every image of a run whose tube moves organs, held against the states that came: none may show tissue of another pose than its own.

use std::collections::BTreeMap;
use std::time::Duration;

use bus::Bus;
use bus::clock::monotonic_ns;
use bus::message::{FrameStamp, FrameState, TissueHeader, TissueShown, TissueState};
use bus::port::{HeadedSubscriber, Subscriber};
use bus::run::RunContext;
use bus::topic::{FRAME_STAMP, TISSUE};

use crate::support::{World, wait_for};

/// Of the scene here.
const VIEWS: [&str; 3] = ["view-axial", "view-frontal", "view-sagittal"];
/// To which states of it are in balance.
const TOLERANCE: f64 = 1e-3;

/// A state: its number, its pose's, and when that was captured. A model that is started again counts anew.
type Key = (u64, u64, i64);

pub(super) struct Watch {
    stamps: Vec<Subscriber<FrameStamp>>,
    states: HeadedSubscriber<TissueHeader, f32>,
    /// Each with the number of its coordinates.
    pub(super) came: BTreeMap<Key, (TissueHeader, usize)>,
    /// When it began: of poses before that, states may have been missed.
    since_ns: i64,
    /// Images so far, by what they show of the tissue.
    pub(super) shown: BTreeMap<&'static str, u64>,
}

impl Watch {
    pub(super) fn open(world: &World) -> Self {
        let context = wait_for("the run", || RunContext::load(&world.run_dir("default")).ok());
        let bus = Bus::join(&context).unwrap();
        let open = |view| Subscriber::open(&bus, &FRAME_STAMP, view, FRAME_STAMP.buffer).unwrap();
        let states = HeadedSubscriber::open(&bus, &TISSUE, TISSUE.buffer).unwrap();
        Self {
            stamps: VIEWS.map(open).into(),
            states,
            since_ns: bus.clock().now_ns(),
            came: BTreeMap::new(),
            shown: BTreeMap::new(),
        }
    }

    /// The stamps of all images since, each of which tells truly what it shows. Must be called again before a buffer is full.
    pub(super) fn images(&mut self) -> Vec<FrameStamp> {
        let mut all = Vec::new();
        for stamps in &self.stamps {
            let came: Vec<FrameStamp> = std::iter::from_fn(|| stamps.next().unwrap()).collect();
            // A full buffer may have lost some: then it is not known what they showed.
            assert!(came.len() < FRAME_STAMP.buffer, "the watch came too late");
            all.extend(came);
        }
        let mut count = 0;
        // A state is sent before its image, so that it is here by now.
        while let Some(state) = self.states.next().unwrap() {
            let header = *state.header();
            let key = (header.seq, header.pose_seq, header.t_capture_ns);
            self.came.insert(key, (header, state.values().len()));
            count += 1;
        }
        assert!(count < TISSUE.buffer, "the watch came too late");
        all.retain(|stamp| stamp.t_capture_ns >= self.since_ns);
        all.iter().for_each(|stamp| self.check(stamp));
        all
    }

    /// Watches until there is an image for which `wanted` holds.
    pub(super) fn until(
        &mut self,
        what: &str,
        wanted: impl Fn(&FrameStamp, Option<&TissueHeader>) -> bool,
    ) -> FrameStamp {
        wait_for(what, || {
            let images = self.images();
            images.into_iter().find(|stamp| wanted(stamp, self.state_of(stamp)))
        })
    }

    /// Watches for so long; the stamps.
    pub(super) fn during(&mut self, time: Duration) -> Vec<FrameStamp> {
        let (began_ns, mut all) = (monotonic_ns(), Vec::new());
        while monotonic_ns() - began_ns < bus::clock::ns(time) {
            std::thread::sleep(Duration::from_millis(10));
            all.extend(self.images());
        }
        all
    }

    pub(super) fn state_of(&self, stamp: &FrameStamp) -> Option<&TissueHeader> {
        let key = (stamp.tissue_seq, stamp.seq, stamp.t_capture_ns);
        self.came.get(&key).map(|(header, _)| header)
    }

    /// An image that has organs moved has the state of its own pose, which bears its certificate; any other has none.
    fn check(&mut self, stamp: &FrameStamp) {
        let shown = TissueShown::from_code(stamp.tissue).unwrap();
        assert!(shown != TissueShown::None, "an image that says nothing: {stamp:?}");
        *self.shown.entry(shown.word()).or_default() += 1;
        let wanted = match shown {
            TissueShown::Settled => TissueState::Settled,
            TissueShown::Approximate => TissueState::Approximate,
            TissueShown::Late => return assert_eq!(stamp.tissue_seq, 0, "{stamp:?}"),
            _ => return,
        };
        assert!(
            !matches!(stamp.frame_state(), Some(FrameState::Lost(_))),
            "tissue without a pose: {stamp:?}"
        );
        let state = self.state_of(stamp);
        let state = state.unwrap_or_else(|| panic!("no state of its pose came: {stamp:?}"));
        assert_eq!(state.state_of(), Ok(wanted), "{stamp:?}");
        assert_eq!(state.registration_id, stamp.registration_id, "{stamp:?}");
        assert_eq!(stamp.tissue_mesh.to_be_bytes()[..], state.mesh_id[..8], "{stamp:?}");
        assert!(state.certified(TOLERANCE).is_ok(), "{stamp:?}: {state:?}");
    }
}
